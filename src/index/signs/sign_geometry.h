// What building signs and queries of signs both measure.
#pragma once

#include "geometry/exact_predicates.h"
#include "index/signs/sign_parts.h"
#include "proxima/geometry.h"

#include <algorithm>
#include <cmath>

namespace proxima {

/// The normal of length 1, to the side that the triangle faces.
[[nodiscard]] inline Vec3 unit_normal_of(const Triangle& triangle) noexcept
{
    return unit_normal({triangle[0], triangle[1]}, {triangle[0], triangle[2]});
}

/// What the sides of several triangles say together.
class CommonSides {
public:
    void add(SurfaceSides sides) noexcept
    {
        common_ = first_ || common_ == sides ? sides : SurfaceSides::doubtful;
        first_ = false;
    }
    [[nodiscard]] SurfaceSides result() const noexcept { return common_; }

private:
    SurfaceSides common_ = SurfaceSides::doubtful;
    bool first_ = true;
};

/// The least height of a triangle; 0 where it has no area.
[[nodiscard]] inline double height_of(const Triangle& triangle, double unit) noexcept
{
    const Vec3 a = (triangle[1] - triangle[0]) * unit;
    const Vec3 b = (triangle[2] - triangle[0]) * unit;
    const double longest =
        std::sqrt(std::max({a.squaredNorm(), b.squaredNorm(), (b - a).squaredNorm()}));
    return longest > 0 ? a.cross(b).norm() / longest / unit : 0;
}

} // namespace proxima
