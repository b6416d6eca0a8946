// What rounding may do to an overlap test, so that it can say which of its answers are certain.
//
// A test is given a rounded centre c and a half size h that stands for all cells of a depth. The
// cell's own box lies between planes lower + part * edge of the root, each off by at most
// u (edge + |plane|) from its ideal position (u = 2^-53). Centre and half size together are thus off
// by at most five such errors per axis: one for each plane, as many where h is another cell's, and
// their own rounding. `slack` is eight.
//
// A half-space m . x <= o of a Minkowski sum, or a separating axis m, is evaluated by three-term
// products of terms that are bounded by |m_k| times a length, with eight roundings or fewer each,
// on two sides: its error is below sum_k |m_k| (32 u length_k + slack_k), where |m_k| bounds the
// component before cancellation. This is `tolerance`. A component that is exactly zero adds none,
// so degenerate triangles parallel to an axis stay certain.
//
// Lengths are bounded near the triangle only, for centres within four half sizes of its box, as all
// children of cells that meet it are. Farther away cells are disjoint with three half sizes to
// spare. Where a half size is not above its slack, or coordinates are so large or small that
// products could overflow or underflow, nothing is certain.
#pragma once

#include "proxima/geometry.h"
#include "thesis/minkowski_sums/geometric_method.h"
#include "thesis/octree_generation/overlap_tests.h"

#include <optional>

namespace proxima {

/// The centres of one depth for which the bounds hold, and what is certain elsewhere.
struct BoundedCentres {
    Box near;
    bool bounded = false; ///< false: nothing is certain

    /// The final answer for a centre, given what the test found there.
    [[nodiscard]] Overlap judge(const Overlap& found, const Vec3& centre) const noexcept
    {
        if (near.contains(centre)) return {found.overlaps, bounded && found.certain};
        return {found.overlaps, bounded && !found.overlaps};
    }
};

/// Bounds for one triangle and the cells of one depth.
struct RoundingBounds {
    BoundedCentres centres;
    Vec3 slack = Vec3::Zero();  ///< centre and half size are off by less, together
    Vec3 reach = Vec3::Zero();  ///< bounds |coordinates| of triangle, centres and cells
    Vec3 spread = Vec3::Zero(); ///< bounds |centre - any vertex|, and a cell's edge

    /// The error of sums of products of the magnitude with lengths: reach or spread.
    [[nodiscard]] double tolerance(const Vec3& magnitude, const Vec3& length) const noexcept
    {
        return magnitude.dot(32 * unit_roundoff * length + slack);
    }
};

/// Makes the bounds of one triangle, depth by depth.
class RoundingBoundsMaker {
public:
    explicit RoundingBoundsMaker(const Triangle& triangle) noexcept;

    /// \pre half sizes descend, the first one is that of the root or of its children
    [[nodiscard]] RoundingBounds next(const Vec3& half_size) noexcept;

private:
    Box box_;
    bool in_range_ = false;
    std::optional<Vec3> root_edge_; ///< of the root, at most
};

} // namespace proxima
