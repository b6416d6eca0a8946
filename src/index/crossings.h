// Where rays along x cross the surface, exactly: which of two sides a point is on, by counting.
#pragma once

#include "index/index_parts.h"
#include "index/visit_rows.h"
#include "proxima/function_ref.h"
#include "proxima/geometry.h"

#include <cstdint>

namespace proxima {

/// How the ray along x crosses the triangle from the point, shifted to larger y and much less to
/// larger z: +1 outwards, -1 inwards, 0 not at all. So it meets no vertex and no edge, and an edge
/// that two triangles share is crossed in one of them. Exact. \pre all finite
[[nodiscard]] int crossing_ahead(const Triangle& triangle, const Vec3& point) noexcept;

/// The turn that takes x to y, y to z and z to x so often that this axis comes to lie along x.
/// Moving by it rounds nothing. \pre axis in [0, 3)
[[nodiscard]] RigidTransform turn_to_x(int axis) noexcept;

/// The boxes of an index, moved by a pose and seen from a point: which of them the ray from there
/// along x may meet.
class PROXIMA_HIDDEN RayAlongX {
public:
    RayAlongX(const IndexParts& index, const Box& bounds, const RigidTransform& pose,
              const Vec3& point) noexcept;

    /// In the index's frame. True where a number is not finite.
    [[nodiscard]] bool may_meet(const Vec3& lower, const Vec3& upper) const noexcept
    {
        const Vec3 middle = turn_ * (0.5 * (lower + upper)) + from_point_;
        const Vec3 reach = turn_.cwiseAbs() * (0.5 * (upper - lower));
        const auto beyond = [&](int axis) { return std::abs(middle[axis]) > reach[axis] + slack_; };
        return !(beyond(1) || beyond(2) || middle.x() + reach.x() < -slack_);
    }

private:
    Mat3 turn_;
    Vec3 from_point_;
    double slack_;
};

/// Calls visit(row, crossing) for every triangle that the ray along x from the point crosses, as
/// crossing_ahead of the triangle moved by the pose, in no particular order. Where every edge has as
/// many triangles each way, the crossings sum to the winding number at the point, unless it is on
/// the surface. `bounds` are those of the mesh. No allocation, thread safe. About 1 us.
template <class Visit>
void visit_crossings(const IndexParts& index, const Box& bounds, const RigidTransform& pose,
                     const Vec3& point, const Visit& visit)
{
    const RayAlongX ray(index, bounds, pose, point);
    visit_rows(
        index, [&](const Vec3& lower, const Vec3& upper) { return ray.may_meet(lower, upper); },
        [&](std::uint32_t row) {
            const int crossing = crossing_ahead(pose(index.triangle(row)), point);
            if (crossing != 0) visit(row, crossing);
            return Flow::proceed;
        });
}

} // namespace proxima
