// Meshes that proxies are tried on, and paths of a hand over them.
#pragma once

#include "octree/small_meshes.h"
#include "proxima/sample_meshes.h"
#include "proxima/triangle_mesh.h"

#include <functional>
#include <random>
#include <string>
#include <vector>

namespace proxima::testing {

struct TouchMesh {
    std::string name;
    TriangleMesh mesh;
};

/// A bumpy square in [-1, 1]^2 with an edge all round: open.
inline TriangleMesh bumpy_sheet(std::uint32_t cells)
{
    std::vector<Vec3> positions;
    std::vector<TriangleCorners> triangles;
    for (std::uint32_t i = 0; i <= cells; ++i) {
        for (std::uint32_t j = 0; j <= cells; ++j) {
            const double x = 2.0 * i / cells - 1;
            const double y = 2.0 * j / cells - 1;
            positions.emplace_back(x, y, 0.15 * std::sin(5 * x) * std::cos(4 * y));
        }
    }
    const std::uint32_t row = cells + 1;
    for (std::uint32_t i = 0; i < cells; ++i) {
        for (std::uint32_t j = 0; j < cells; ++j) {
            const std::uint32_t a = i * row + j;
            triangles.push_back({a, a + row, a + row + 1});
            triangles.push_back({a, a + row + 1, a + 1});
        }
    }
    return mesh_of(std::move(positions), std::move(triangles));
}

/// A rectangle of (columns - 1) x (rows - 1) quads, each halved.
inline TriangleMesh grid_mesh(std::uint32_t columns, std::uint32_t rows,
                              const std::function<Vec3(double, double)>& at)
{
    std::vector<Vec3> positions;
    std::vector<TriangleCorners> triangles;
    for (std::uint32_t i = 0; i < columns; ++i) {
        for (std::uint32_t j = 0; j < rows; ++j)
            positions.push_back(at(i / (columns - 1.0), j / (rows - 1.0)));
    }
    for (std::uint32_t i = 0; i + 1 < columns; ++i) {
        for (std::uint32_t j = 0; j + 1 < rows; ++j) {
            const std::uint32_t a = i * rows + j;
            triangles.push_back({a, a + rows, a + rows + 1});
            triangles.push_back({a, a + rows + 1, a + 1});
        }
    }
    return mesh_of(std::move(positions), std::move(triangles));
}

/// Two skins a thousandth apart, joined at the rim: a plate.
inline TriangleMesh thin_plate()
{
    return moved(cube_mesh(Vec3::Zero(), 1.0),
                 [](const Vec3& p) { return Vec3(p[0], p[1], 0.0005 * p[2]); });
}

/// A thick plate, turned, with coordinates of six digits: rounding bends its flat faces.
inline TriangleMesh rounded_plate()
{
    const Mat3 turn =
        (Eigen::AngleAxisd(0.3, Vec3::UnitY()) * Eigen::AngleAxisd(0.7, Vec3::UnitZ()))
            .toRotationMatrix();
    const auto face = [&](double height, bool up) {
        return grid_mesh(13, 13, [=](double s, double t) {
            const Vec3 p = turn * Vec3(2 * (up ? s : t) - 1, 2 * (up ? t : s) - 1, height);
            return Vec3(1e-6 * (1e6 * p).array().round());
        });
    };
    return joined(face(0.2, true), face(-0.2, false));
}

/// The inside of a corner of three planes, and of one of three slanted ones.
inline TriangleMesh inner_corner(double slant)
{
    const Vec3 apex = Vec3::Zero();
    const std::vector<Vec3> ends = {Vec3(2, slant, slant), Vec3(slant, 2, slant),
                                    Vec3(slant, slant, 2)};
    std::vector<Vec3> positions = {apex, ends[0], ends[1], ends[2]};
    return mesh_of(std::move(positions), {{0, 1, 2}, {0, 2, 3}, {0, 3, 1}});
}

/// Triangles anywhere: they pass through each other, and nothing is closed.
inline TriangleMesh triangle_soup(std::uint32_t seed, std::uint32_t count)
{
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> place(-1, 1);
    std::vector<Vec3> positions;
    std::vector<TriangleCorners> triangles;
    for (std::uint32_t i = 0; i < count; ++i) {
        const Vec3 middle{place(random), place(random), place(random)};
        for (int k = 0; k < 3; ++k) {
            positions.emplace_back(middle +
                                   0.4 * Vec3{place(random), place(random), place(random)});
        }
        triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
    }
    return mesh_of(std::move(positions), std::move(triangles));
}

inline std::vector<TouchMesh> touch_meshes()
{
    const TriangleMesh sphere = *sample_mesh("sphere:30x30");
    return {
        {"cube", *sample_mesh("cube")},
        {"sphere", sphere},
        {"torus", *sample_mesh("torus:24x12")},
        {"sheet", bumpy_sheet(12)},
        {"plate", thin_plate()},
        {"rounded plate", rounded_plate()},
        {"corner", inner_corner(0)},
        {"slanted corner", inner_corner(-0.5)},
        {"bowl", without(sphere, [](std::size_t i) { return i % 900 < 300; })},
        {"soup", triangle_soup(3, 60)},
        {"far sphere", moved(*sample_mesh("sphere:12x12"),
                             [](const Vec3& p) { return Vec3(p + Vec3(1e4, -1e4, 1e4)); })},
        {"tiny cube", moved(*sample_mesh("cube"), [](const Vec3& p) { return Vec3(1e-6 * p); })},
        {"spaceship", *sample_mesh("spaceship:1300")}};
}

/// Steps about the surface: presses, strokes, hops and dashes, seeded. Lengths in the mesh's unit.
class HandPath {
public:
    HandPath(const TriangleMesh& mesh, std::uint32_t seed)
        : mesh_(mesh), size_(bounding_box(mesh).extent().maxCoeff()), random_(seed)
    {
        at_ = aim();
    }

    Vec3 next()
    {
        if (left_ == 0) {
            goal_ = aim();
            left_ = 1 + static_cast<int>(random_() % 60);
        }
        at_ += (goal_ - at_) / left_;
        --left_;
        return at_;
    }

private:
    double unit() { return std::uniform_real_distribution<double>(0, 1)(random_); }

    /// A point on or near the surface, often a little deep, sometimes far off.
    Vec3 aim()
    {
        const auto id = static_cast<std::uint32_t>(random_() % mesh_.triangle_count());
        const Triangle triangle = mesh_.triangle(TriangleId{id});
        const double u = unit();
        const double v = (1 - u) * unit();
        const Vec3 on =
            triangle[0] + u * (triangle[1] - triangle[0]) + v * (triangle[2] - triangle[0]);
        const Vec3 normal = scaled_normal(triangle).normalized();
        const Vec3 aside{unit() - 0.5, unit() - 0.5, unit() - 0.5}; // in this order
        const double far = random_() % 6 == 0 ? 1.5 : 0.05;
        return on + size_ * (0.1 * (unit() - 0.7) * normal + far * aside);
    }

    const TriangleMesh& mesh_;
    double size_;
    std::mt19937 random_;
    Vec3 at_;
    Vec3 goal_;
    int left_ = 0;
};

} // namespace proxima::testing
