// Meshes that break mesh software: slivers, duplicates, T-junctions, one-sided surfaces, surfaces
// through themselves, turned inside out or nested, needles, and many triangles round one vertex; each at
// scales from 1e-30 to 1e30, and 1e9 away from the origin.
#pragma once

#include "proxima/triangle_mesh.h"

#include <cmath>
#include <cstdint>
#include <functional>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

namespace proxima::oracle {

struct NastyMesh {
    std::string name;
    TriangleMesh mesh;
    /// Every edge has as many triangles one way as the other: the surface winds round every point off
    /// it a whole number of times.
    bool is_closed = false;
};

/// Collects triangles for a NastyMesh.
class NastyShape {
public:
    std::uint32_t vertex(const Vec3& p)
    {
        positions_.push_back(p);
        return static_cast<std::uint32_t>(positions_.size() - 1);
    }
    void triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c)
    {
        triangles_.push_back({a, b, c});
    }
    void quad(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d)
    {
        triangle(a, b, c);
        triangle(a, c, d);
    }

    /// A surface over a grid of rows x columns vertices, at point(row, column). `wrap(row, column)`
    /// is the vertex of a position one beyond the last row or column.
    void grid(std::uint32_t rows, std::uint32_t columns,
              const std::function<Vec3(double, double)>& point,
              const std::function<std::pair<std::uint32_t, std::uint32_t>(std::uint32_t,
                                                                          std::uint32_t)>& wrap,
              bool is_inverted = false)
    {
        const auto first = static_cast<std::uint32_t>(positions_.size());
        for (std::uint32_t i = 0; i < rows; ++i)
            for (std::uint32_t j = 0; j < columns; ++j) vertex(point(i, j));
        const auto at = [&](std::uint32_t i, std::uint32_t j) {
            const auto [row, column] = wrap(i, j);
            return first + row * columns + column;
        };
        for (std::uint32_t i = 0; i < rows; ++i) {
            for (std::uint32_t j = 0; j < columns; ++j) {
                if (is_inverted) {
                    quad(at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j));
                } else {
                    quad(at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
                }
            }
        }
    }

    /// The double cone over a polygon of `count` corners: all triangles meet at two vertices.
    void spindle(std::uint32_t count, double radius, double height)
    {
        const std::uint32_t top = vertex(Vec3(0, 0, height));
        const std::uint32_t bottom = vertex(Vec3(0, 0, -height));
        const auto first = static_cast<std::uint32_t>(positions_.size());
        for (std::uint32_t i = 0; i < count; ++i) {
            const double angle = 2 * std::numbers::pi * i / count;
            vertex(radius * Vec3(std::cos(angle), std::sin(angle), 0));
        }
        for (std::uint32_t i = 0; i < count; ++i) {
            const std::uint32_t from = first + i;
            const std::uint32_t to = first + (i + 1) % count;
            triangle(top, from, to);
            triangle(bottom, to, from);
        }
    }

    /// A torus, whose normals point outward, or inward.
    void torus(const Vec3& center, double major, double minor, bool is_inverted = false)
    {
        constexpr std::uint32_t rows = 12;
        constexpr std::uint32_t columns = 8;
        grid(
            rows, columns,
            [&](double i, double j) {
                const double u = 2 * std::numbers::pi * i / rows;
                const double v = 2 * std::numbers::pi * j / columns;
                const double r = major + minor * std::cos(v);
                return Vec3(center + Vec3(r * std::cos(u), r * std::sin(u), minor * std::sin(v)));
            },
            [](std::uint32_t i, std::uint32_t j) { return std::pair(i % rows, j % columns); },
            is_inverted);
    }

    /// The surface of a box; `cut` cuts one of its sides where its neighbours have no vertex.
    void box(const Vec3& lower, const Vec3& upper, bool cut = false)
    {
        const auto first = static_cast<std::uint32_t>(positions_.size());
        for (std::uint32_t i = 0; i < 8; ++i) {
            vertex(Vec3((i & 1U) != 0 ? upper.x() : lower.x(),
                        (i & 2U) != 0 ? upper.y() : lower.y(),
                        (i & 4U) != 0 ? upper.z() : lower.z()));
        }
        const auto side = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
            quad(first + a, first + b, first + c, first + d);
        };
        side(0, 4, 6, 2);
        side(1, 3, 7, 5);
        side(0, 1, 5, 4);
        side(2, 6, 7, 3);
        side(0, 2, 3, 1);
        if (!cut) return side(4, 5, 7, 6);
        const auto middle = [&](std::uint32_t a, std::uint32_t b) {
            return vertex(0.5 * (positions_[first + a] + positions_[first + b]));
        };
        const std::uint32_t low = middle(4, 5);
        const std::uint32_t high = middle(6, 7);
        quad(first + 4, low, high, first + 6);
        quad(low, first + 5, first + 7, high);
    }

    void repeat_triangles(bool turned)
    {
        const std::vector<TriangleCorners> once = triangles_;
        for (const TriangleCorners& t : once)
            turned ? triangle(t[0], t[2], t[1]) : triangle(t[0], t[1], t[2]);
    }

    [[nodiscard]] TriangleMesh mesh(double scale, const Vec3& offset) const
    {
        std::vector<Vec3> positions = positions_;
        for (Vec3& p : positions) p = scale * p + offset;
        return make_triangle_mesh(std::move(positions), triangles_).value();
    }

private:
    std::vector<Vec3> positions_;
    std::vector<TriangleCorners> triangles_;
};

struct NamedShape {
    std::string name;
    NastyShape shape;
    bool is_closed = false;
};

/// The shapes at their own size, about 1. `round_one_vertex` triangles meet at a vertex of the last one.
inline std::vector<NamedShape> nasty_shapes(std::uint32_t round_one_vertex)
{
    constexpr double pi = std::numbers::pi;
    std::vector<NamedShape> shapes;
    const auto add = [&](const char* name, bool is_closed) -> NastyShape& {
        shapes.push_back({name, {}, is_closed});
        return shapes.back().shape;
    };
    const Vec3 one = Vec3::Ones();
    {
        NastyShape& strip = add("slivers of 1e-12", false);
        const Vec3 along = Vec3(1, 2, 3).normalized();
        const Vec3 across = 1e-12 * along.cross(Vec3::UnitX()).normalized();
        for (std::uint32_t i = 0; i < 40; ++i) {
            strip.vertex(along * (i % 2) + across * i);
            if (i >= 2) strip.triangle(i - 2, i - 1, i);
        }
    }
    add("box of 1e-12", true).box(-one, Vec3(1, 1, -1 + 1e-12));
    for (const bool turned : {false, true}) {
        NastyShape& twice = add(turned ? "twice, turned" : "twice", true);
        twice.box(-one, one);
        twice.repeat_triangles(turned);
    }
    add("T-junctions", false).box(-one, one, true);
    {
        constexpr std::uint32_t rows = 24;
        constexpr std::uint32_t columns = 3;
        NastyShape& strip = add("Moebius strip", false);
        // A grid without the columns beyond the last.
        const auto point = [&](std::uint32_t i, std::uint32_t j) {
            const double u = 2 * pi * i / rows;
            const double v = 0.3 * (static_cast<double>(j) - 1);
            const double r = 1 + v * std::cos(u / 2);
            return Vec3(r * std::cos(u), r * std::sin(u), v * std::sin(u / 2));
        };
        for (std::uint32_t i = 0; i < rows; ++i)
            for (std::uint32_t j = 0; j < columns; ++j) strip.vertex(point(i, j));
        const auto at = [&](std::uint32_t i, std::uint32_t j) {
            return i < rows ? i * columns + j : columns - 1 - j; // comes back upside down
        };
        for (std::uint32_t i = 0; i < rows; ++i) {
            for (std::uint32_t j = 0; j + 1 < columns; ++j)
                strip.quad(at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
        }
    }
    {
        constexpr std::uint32_t rows = 20;
        constexpr std::uint32_t columns = 12;
        // The figure-eight immersion: through itself along a circle, and with one side alone.
        add("Klein bottle", false)
            .grid(
                rows, columns,
                [](double i, double j) {
                    const double u = 2 * std::numbers::pi * i / rows;
                    const double v = 2 * std::numbers::pi * j / columns;
                    const double r =
                        2 + std::cos(u / 2) * std::sin(v) - std::sin(u / 2) * std::sin(2 * v);
                    return Vec3(r * std::cos(u), r * std::sin(u),
                                std::sin(u / 2) * std::sin(v) + std::cos(u / 2) * std::sin(2 * v));
                },
                [](std::uint32_t i, std::uint32_t j) {
                    return i < rows ? std::pair(i, j % columns)
                                    : std::pair(0U, (columns - j % columns) % columns);
                });
    }
    add("inside out", true).torus(Vec3::Zero(), 1, 0.4, true);
    {
        NastyShape& nested = add("nested", true);
        nested.torus(Vec3::Zero(), 1, 0.4);
        nested.torus(Vec3::Zero(), 1, 0.2, true);
        nested.torus(Vec3::Zero(), 1, 0.1);
    }
    {
        NastyShape& crossed = add("through each other", true);
        crossed.torus(Vec3::Zero(), 1, 0.4);
        crossed.torus(Vec3(0.5, 0.1, 0.2), 1, 0.4);
        crossed.box(-0.5 * one, Vec3(2, 0.3, 0.4));
    }
    add("needle", true).spindle(5, 1e-6, 1);
    add("plate", true).spindle(24, 1, 1e-6);
    {
        NastyShape& book = add("pages of one edge", false);
        book.vertex(Vec3::Zero());
        book.vertex(Vec3::UnitZ());
        for (std::uint32_t i = 0; i < 9; ++i) {
            book.vertex(Vec3(std::cos(0.7 * i), std::sin(0.7 * i), 0.5));
            book.triangle(0, 1, i + 2);
        }
    }
    {
        NastyShape& flat = add("points and segments", false);
        for (std::uint32_t i = 0; i < 6; ++i) flat.vertex(Vec3(i, i / 2, 0));
        flat.triangle(0, 0, 0);
        flat.triangle(1, 2, 1);
        flat.triangle(0, 2, 4); // three points of a line
        flat.triangle(0, 1, 2);
        flat.triangle(3, 4, 5);
        flat.triangle(0, 3, 5);
    }
    add("round one vertex", true).spindle(round_one_vertex, 1, 1);
    return shapes;
}

/// All shapes at all places and sizes. `round_one_vertex` is how many triangles meet at one vertex.
inline std::vector<NastyMesh> nasty_corpus(std::uint32_t round_one_vertex)
{
    struct Place {
        const char* name;
        double scale;
        Vec3 offset;
    };
    const Place places[] = {{"", 1, Vec3::Zero()},
                            {", times 1e-30", 1e-30, Vec3::Zero()},
                            {", times 1e30", 1e30, Vec3::Zero()},
                            {", 1e9 away", 1, Vec3(1e9, -1e9, 5e8)},
                            {", times 1e-30, 1e-21 away", 1e-30, Vec3(1e-21, 0, -1e-21)}};
    std::vector<NastyMesh> meshes;
    for (const NamedShape& shape : nasty_shapes(round_one_vertex)) {
        for (const Place& place : places) {
            meshes.push_back({shape.name + place.name, shape.shape.mesh(place.scale, place.offset),
                              shape.is_closed});
        }
    }
    return meshes;
}

} // namespace proxima::oracle
