// A ray: the points origin + t direction for t in a closed range.
#pragma once

#include "geometry/vec.h"

#include <cstdint>
#include <limits>

namespace proxima {

/// t counts in units of the direction, which may have any length; hits are told apart up to
/// t = 2^1020, 1e307 (farthest_hit, ray_triangle.h), which directions longer than 1e-300 times the
/// mesh's size keep far from. t_min may be negative and the
/// range without ends: then it is a line.
struct Ray {
    Vec3 origin = Vec3::Zero();
    Vec3 direction = Vec3::UnitZ();
    double t_min = 0;
    double t_max = std::numeric_limits<double>::infinity();

    [[nodiscard]] Vec3 at(double t) const noexcept { return origin + t * direction; }
};

/// Whether it is a ray at all: origin and direction finite, the direction not zero, the range not
/// empty and no end of it NaN. No other ray hits anything.
[[nodiscard]] inline bool is_valid(const Ray& ray) noexcept
{
    return ray.origin.allFinite() && ray.direction.allFinite() &&
           (ray.direction.array() != 0).any() && ray.t_min <= ray.t_max;
}

/// Which sides of triangles a ray meets. The front is the side from which the corners are seen
/// counter-clockwise. Triangles seen edge-on, and those without an area, show neither side: only
/// `both` meets them.
enum class Faces : std::uint8_t { both, front, back };

} // namespace proxima
