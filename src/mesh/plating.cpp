#include "mesh/plating.h"

#include "base/check.h"
#include "base/progress.h"
#include "geometry/length.h"

#include <algorithm>
#include <cmath>
#include <queue>

namespace proxima::detail {

namespace {

using Corners = std::array<std::uint32_t, 4>;

// The order of operations is explicit, so that sizes have the same bits everywhere.
Vec3 cross(const Vec3& a, const Vec3& b) noexcept
{
    return {a.y() * b.z() - a.z() * b.y(), a.z() * b.x() - a.x() * b.z(),
            a.x() * b.y() - a.y() * b.x()};
}

// The frame of a quad, for the shapes that grow on it.
struct Patch {
    std::array<Vec3, 4> corners;
    Vec3 center;
    Vec3 normal;   ///< length 1
    double width;  ///< mean length of sides 0-1 and 2-3
    double height; ///< mean length of sides 1-2 and 3-0
};

class Plater {
public:
    Plater(QuadSurface& surface, std::size_t triangles, Dice dice)
        : surface_(surface), triangles_(triangles), dice_(dice)
    {}

    bool grow(StageSteps& steps)
    {
        for (std::size_t quad = 0; quad < surface_.quads.size(); ++quad) {
            enqueue(quad);
            if (!steps.done(1)) return false;
        }
        surface_.positions.reserve(triangles_ / 2 + surface_.positions.size());
        while (surface_.triangle_count() < triangles_) {
            PROXIMA_CHECK(!queue_.empty());
            const std::uint32_t quad = queue_.top().quad;
            queue_.pop();
            const std::size_t before = surface_.triangle_count();
            grow_on(quad, triangles_ - before);
            if (!steps.done(surface_.triangle_count() - before)) return false;
        }
        return true;
    }

private:
    struct Entry {
        double priority;
        std::uint32_t quad;
        friend bool operator<(const Entry& a, const Entry& b) noexcept
        {
            return a.priority != b.priority ? a.priority < b.priority : a.quad > b.quad;
        }
    };

    void enqueue(std::size_t quad)
    {
        const auto& [corners, detail] = surface_.quads[quad];
        if (detail <= 0.0) return;
        const Vec3 diagonal = surface_.positions[corners[2]] - surface_.positions[corners[0]];
        const Vec3 other = surface_.positions[corners[3]] - surface_.positions[corners[1]];
        queue_.push({detail * length_of(cross(diagonal, other)), static_cast<std::uint32_t>(quad)});
    }

    void grow_on(std::uint32_t quad, std::size_t most)
    {
        const Patch patch = patch_of(surface_.quads[quad].corners);
        const std::uint64_t choice = dice_.next() % 8;
        const double small_side = std::min(patch.width, patch.height);
        const auto columns = cells(patch.width, small_side);
        const auto rows = cells(patch.height, small_side);
        const std::size_t grid_growth = 2 * (columns + rows + columns * rows) + 2;
        if (choice < 4 && most >= grid_growth) {
            grow_grid(quad, patch, columns, rows);
        } else if (choice < 7 && most >= 16) {
            grow_box(quad, patch, small_side * dice_.between(0.08, 0.5));
        } else if (most >= 8) {
            grow_plate(quad, patch, small_side * dice_.between(0.01, 0.05));
        } else {
            grow_pyramid(quad, patch, small_side * dice_.between(0.05, 0.2));
        }
    }

    // The number of cells along a side that makes them roughly square, at random one more.
    std::size_t cells(double side, double small_side) noexcept
    {
        const double ratio = std::min(side / small_side, 5.0);
        return static_cast<std::size_t>(std::lround(ratio)) + dice_.next() % 2;
    }

    [[nodiscard]] Patch patch_of(const Corners& quad) const noexcept
    {
        Patch patch{};
        for (std::size_t k = 0; k < 4; ++k) patch.corners[k] = surface_.positions[quad[k]];
        const auto& [a, b, c, d] = patch.corners;
        patch.center = ((a + b) + (c + d)) * 0.25;
        const Vec3 normal = cross(c - a, d - b);
        patch.normal = normal / length_of(normal);
        patch.width = 0.5 * (length_of(b - a) + length_of(d - c));
        patch.height = 0.5 * (length_of(c - b) + length_of(a - d));
        return patch;
    }

    std::uint32_t add(const Vec3& position)
    {
        surface_.positions.push_back(position);
        return static_cast<std::uint32_t>(surface_.positions.size() - 1);
    }

    // The patch's corners, moved a part of the way towards its centre and lifted.
    Corners add_ring(const Patch& patch, double inset, double height)
    {
        Corners ring{};
        for (std::size_t k = 0; k < 4; ++k) {
            const Vec3& corner = patch.corners[k];
            ring[k] = add(corner + (patch.center - corner) * inset + patch.normal * height);
        }
        return ring;
    }

    void add_band(const Corners& outer, const Corners& inner)
    {
        for (std::size_t k = 0; k < 4; ++k) {
            const std::size_t next = (k + 1) % 4;
            surface_.quads.push_back({{outer[k], outer[next], inner[next], inner[k]}, 0.0});
        }
    }

    // The quad's record becomes that of the shape's top.
    void retop(std::uint32_t quad, const Corners& top, double detail_factor)
    {
        surface_.quads[quad].corners = top;
        surface_.quads[quad].detail *= detail_factor;
        enqueue(quad);
    }

    void grow_plate(std::uint32_t quad, const Patch& patch, double height)
    {
        const Corners base = surface_.quads[quad].corners;
        const Corners top = add_ring(patch, dice_.between(0.1, 0.25), height);
        add_band(base, top);
        retop(quad, top, dice_.between(0.2, 1.0));
    }

    void grow_box(std::uint32_t quad, const Patch& patch, double height)
    {
        const Corners base = surface_.quads[quad].corners;
        const double inset = dice_.between(0.12, 0.4);
        const Corners foot = add_ring(patch, inset, 0.0);
        const Corners top = add_ring(patch, inset + dice_.between(0.0, 0.08), height);
        add_band(base, foot);
        add_band(foot, top);
        retop(quad, top, dice_.between(0.1, 1.0));
    }

    void grow_pyramid(std::uint32_t quad, const Patch& patch, double height)
    {
        const Corners base = surface_.quads[quad].corners;
        const std::uint32_t tip = add(patch.center + patch.normal * height);
        surface_.triangles.push_back({base[0], base[1], tip});
        surface_.triangles.push_back({base[1], base[2], tip});
        surface_.quads[quad] = {{base[2], base[3], base[0], tip}, 0.0};
    }

    // A rim, and inside it columns x rows quads that grow on by themselves.
    void grow_grid(std::uint32_t quad, const Patch& patch, std::size_t columns, std::size_t rows)
    {
        const Corners base = surface_.quads[quad].corners;
        const double detail = surface_.quads[quad].detail;
        const double inset = dice_.between(0.05, 0.15);
        const auto first = static_cast<std::uint32_t>(surface_.positions.size());
        std::array<Vec3, 4> rim;
        for (std::size_t k = 0; k < 4; ++k) {
            rim[k] = patch.corners[k] + (patch.center - patch.corners[k]) * inset;
        }
        for (std::size_t row = 0; row <= rows; ++row) {
            const double v = static_cast<double>(row) / static_cast<double>(rows);
            const Vec3 left = rim[0] + (rim[3] - rim[0]) * v;
            const Vec3 right = rim[1] + (rim[2] - rim[1]) * v;
            for (std::size_t column = 0; column <= columns; ++column) {
                const double u = static_cast<double>(column) / static_cast<double>(columns);
                add(left + (right - left) * u);
            }
        }
        const auto at = [&](std::size_t column, std::size_t row) {
            return first + static_cast<std::uint32_t>(row * (columns + 1) + column);
        };
        fan_side(base[0], base[1], columns, [&](std::size_t k) { return at(k, 0); });
        fan_side(base[1], base[2], rows, [&](std::size_t k) { return at(columns, k); });
        fan_side(base[2], base[3], columns, [&](std::size_t k) { return at(columns - k, rows); });
        fan_side(base[3], base[0], rows, [&](std::size_t k) { return at(0, rows - k); });
        for (std::size_t row = 0; row < rows; ++row) {
            for (std::size_t column = 0; column < columns; ++column) {
                const Corners cell = {at(column, row), at(column + 1, row), at(column + 1, row + 1),
                                      at(column, row + 1)};
                const bool is_first = row == 0 && column == 0;
                const std::size_t slot = is_first ? quad : surface_.quads.size();
                if (!is_first) surface_.quads.emplace_back();
                surface_.quads[slot] = {cell, detail * dice_.between(0.05, 2.0)};
                enqueue(slot);
            }
        }
    }

    // Triangles between the edge from-to and the line of `parts` segments above it.
    template <class Line>
    void fan_side(std::uint32_t from, std::uint32_t to, std::size_t parts, const Line& line)
    {
        const std::size_t middle = parts / 2;
        for (std::size_t k = 0; k < parts; ++k) {
            surface_.triangles.push_back({k < middle ? from : to, line(k + 1), line(k)});
        }
        surface_.triangles.push_back({from, to, line(middle)});
    }

    QuadSurface& surface_;
    std::size_t triangles_;
    Dice dice_;
    std::priority_queue<Entry> queue_;
};

} // namespace

bool grow_plating(QuadSurface& surface, std::size_t triangles, Dice dice, StageSteps& steps)
{
    PROXIMA_CHECK_GE(triangles, surface.triangle_count());
    PROXIMA_CHECK_EQ(triangles % 2, surface.triangle_count() % 2);
    return Plater(surface, triangles, dice).grow(steps);
}

} // namespace proxima::detail
