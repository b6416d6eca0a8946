// Plain shapes that queries and builders speak of. All closed sets, all in the mesh's own units.
#pragma once

#include "geometry/vec.h"

#include <array>
#include <limits>

namespace proxima {

/// Axis-aligned box, closed. The default one is empty and grows by extend().
struct Box {
    Vec3 lower = Vec3::Constant(std::numeric_limits<double>::infinity());
    Vec3 upper = Vec3::Constant(-std::numeric_limits<double>::infinity());

    [[nodiscard]] bool empty() const noexcept { return !(lower.array() <= upper.array()).all(); }
    [[nodiscard]] Vec3 center() const noexcept { return 0.5 * lower + 0.5 * upper; }
    [[nodiscard]] Vec3 extent() const noexcept { return upper - lower; }
    void extend(const Vec3& point) noexcept
    {
        lower = lower.cwiseMin(point);
        upper = upper.cwiseMax(point);
    }
    [[nodiscard]] bool contains(const Vec3& point) const noexcept
    {
        return (lower.array() <= point.array()).all() && (point.array() <= upper.array()).all();
    }
};

/// Triangle by its corners; may be degenerate (a segment or a point).
struct Triangle {
    std::array<Vec3, 3> vertices;

    [[nodiscard]] const Vec3& operator[](int corner) const noexcept
    {
        return vertices[static_cast<std::size_t>(corner)];
    }
};

/// Tight box of a triangle.
[[nodiscard]] Box bounding_box(const Triangle& triangle) noexcept;

/// (b - a) x (c - a): twice the area long, counter-clockwise outward.
[[nodiscard]] Vec3 scaled_normal(const Triangle& triangle) noexcept;

} // namespace proxima
