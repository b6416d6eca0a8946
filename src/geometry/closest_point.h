// The points of segments and triangles closest to a point or to each other ([ericson-2005] 5.1).
//
//     on a segment    0 ---- t ---- 1
//     on a triangle   the side, corner or inside whose Voronoi region holds the point
//
// Degenerate ones need no case of their own: a segment may be a point, a triangle a segment or a
// point. Points returned are always on the shape, up to rounding; what is in doubt, where shapes
// are all but degenerate or parallel, is settled by comparing the distances of all candidates, so
// that distances are never far off: by a few roundings of the largest difference of coordinates.
// All noexcept, without allocation, from any thread.
// \pre for all: finite; differences of coordinates below 1e150. Below 1e-150 they count as none.
#pragma once

#include "proxima/geometry.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

namespace proxima {

struct Segment {
    Vec3 from = Vec3::Zero();
    Vec3 to = Vec3::Zero();

    /// The point at a parameter in [0, 1].
    [[nodiscard]] Vec3 at(double t) const noexcept;
};

/// A point of a segment: at(t), 0 <= t <= 1.
struct SegmentPoint {
    Vec3 point = Vec3::Zero();
    double t = 0;
};

/// The point of the segment closest to p. About 15 ns.
[[nodiscard]] SegmentPoint closest_point(const Segment& segment, const Vec3& p) noexcept;

/// A point of a triangle: the sum of its corners times the weights, which are in [0, 1] and add up
/// to 1.
struct TrianglePoint {
    Vec3 point = Vec3::Zero();
    std::array<double, 3> weights = {};
    TrianglePart part = TrianglePart::corner_0;
};

/// The point of side i, from corner i to i + 1 mod 3, as one of the triangle. \pre side < 3
[[nodiscard]] TrianglePoint point_of_side(std::size_t side, const SegmentPoint& point) noexcept;

/// The point of the triangle closest to p. About 0.1 us. Where a side or corner is as close as the
/// inside, up to rounding, it may be named instead.
[[nodiscard]] TrianglePoint closest_point(const Triangle& triangle, const Vec3& p) noexcept;

/// The point of the inside closest to p where that is p's foot on the triangle's plane; nothing
/// where the foot is on a side or outside, or the triangle has no area. About 30 ns.
[[nodiscard]] std::optional<TrianglePoint> closest_point_inside(const Triangle& triangle,
                                                                const Vec3& p) noexcept;

/// Two points, one on each of two segments.
struct SegmentPair {
    SegmentPoint first;
    SegmentPoint second;
};

/// The closest points of two segments; any where they are parallel and many are. About 0.1 us.
[[nodiscard]] SegmentPair closest_points(const Segment& first, const Segment& second) noexcept;

} // namespace proxima
