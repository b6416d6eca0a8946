// Where two triangles meet: a point, a segment, or in one plane a convex polygon.
//
//     meeting parts   side 1 of a, inside of b     corner 0 of a, side 2 of b     ...
//     position        one double per coordinate, computed from these parts alone
//
// Every end of the intersection lies in the interior of one part of a (a corner, a side, the
// inside) and of one part of b, and no other end does: the pair of parts names it. Neighbouring
// triangles share their parts, so ends of neighbouring pairs are joined by these names, never by
// coordinates. Which parts meet is decided exactly.
#pragma once

#include "geometry/closest_point.h"
#include "proxima/geometry.h"

#include <array>
#include <compare>
#include <cstddef>
#include <span>

namespace proxima {

[[nodiscard]] constexpr bool is_corner(TrianglePart part) noexcept
{
    return part <= TrianglePart::corner_2;
}
[[nodiscard]] constexpr bool is_side(TrianglePart part) noexcept
{
    return part >= TrianglePart::side_0 && part <= TrianglePart::side_2;
}
/// Of a corner or a side: which one. Side k joins corner k and corner k + 1.
[[nodiscard]] constexpr int number_of(TrianglePart part) noexcept
{
    return static_cast<int>(part) % 3;
}

/// A part of one triangle and a part of another one, whose interiors have one point in common.
struct MeetingParts {
    TrianglePart of_a{};
    TrianglePart of_b{};
    friend constexpr bool operator==(const MeetingParts&, const MeetingParts&) = default;
    friend constexpr std::strong_ordering operator<=>(       // no pointer is compared:
        const MeetingParts&, const MeetingParts&) = default; // NOLINT(modernize-use-nullptr)
};

/// The ends of an intersection: none, one (a point), two (a segment), or three to six (a polygon,
/// in the order around it, either way round).
class TriangleIntersection {
public:
    [[nodiscard]] std::span<const MeetingParts> ends() const& noexcept
    {
        return std::span(ends_).first(count_);
    }
    /// Of a temporary they would dangle.
    [[nodiscard]] std::span<const MeetingParts> ends() const&& = delete;
    [[nodiscard]] bool empty() const noexcept { return count_ == 0; }
    [[nodiscard]] std::size_t size() const noexcept { return count_; }

private:
    friend class IntersectionFinder;

    std::array<MeetingParts, 6> ends_{};
    std::size_t count_ = 0;
};

/// The intersection of two closed triangles. A degenerate one is the segment or the point that it
/// is: its parts are then the lowest of its corners at each end, and the side between these; a
/// corner in between is no part. Polygons with an area come from triangles in one plane only.
/// Exact. \pre finite. Thread safe, no allocation; 0.2 to 2 us, more where rounding could decide.
[[nodiscard]] TriangleIntersection intersect(const Triangle& a, const Triangle& b) noexcept;

/// Where the two parts meet: exactly at a corner, else rounded, off by a few ulps of the largest
/// coordinate of the side. It depends on the two parts alone: neighbours that share them, with
/// whatever order of a side's corners, find the same bits. \pre from intersect(a, b), finite;
/// differences of coordinates are finite. Thread safe, no allocation; 1 to 5 us.
[[nodiscard]] Vec3 meeting_point(const Triangle& a, const Triangle& b,
                                 const MeetingParts& parts) noexcept;

} // namespace proxima
