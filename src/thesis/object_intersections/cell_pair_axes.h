// Whether a cell of one octree meets a cell of another one that stands in some pose: 15 axes whose
// constants are found once per pose (thesis section 5.2).
//
//     axes L      3 across the faces of A's cells, 3 across those of B's, 9 across an edge of each
//     projection  L . (centre of B's cell - centre of A's cell): a child's differs by a constant
//     reach       alpha 2^-depth of A's cell + beta 2^-depth of B's cell
//
// Two cells are apart if and only if |projection| > reach on an axis. They are the facets of the
// Minkowski sum of the two root cells; that of any other two cells has the same ones, moved: the
// thesis's hundred sums of two octrees of depth ten are these 15 pairs of constants.
#pragma once

#include "proxima/geometry.h"
#include "proxima/octree.h"

#include <array>
#include <cmath>
#include <cstddef>

namespace proxima {

/// Immutable. Thread safe, no allocation.
class CellPairAxes {
public:
    static constexpr std::size_t axis_count = 15;

    /// One number per axis, and one to fill vector registers.
    using Values = std::array<double, axis_count + 1>;

    /// For cells of frame a as they are, and those of frame b moved by the pose.
    CellPairAxes(const OctreeFrame& a, const OctreeFrame& b, const RigidTransform& pose_b) noexcept;

    /// Of the two roots.
    [[nodiscard]] const Values& root_projections() const noexcept { return root_; }

    /// Of a child of a cell of A at this depth with the same cell of B, and the other way round.
    [[nodiscard]] Values child_of_a(const Values& projections, int depth, int octant) const noexcept
    {
        return shifted(projections, child_of_a_[static_cast<std::size_t>(octant)], depth);
    }
    [[nodiscard]] Values child_of_b(const Values& projections, int depth, int octant) const noexcept
    {
        return shifted(projections, child_of_b_[static_cast<std::size_t>(octant)], depth);
    }

    /// Whether the two closed cells have a point in common. True wherever they do; where they do
    /// not, false unless the gap is below some 1e-14 of the largest coordinate. The pose's matrix
    /// need not be a rotation to the last bit: cells of B are what it makes of them. About 20 ns.
    [[nodiscard]] bool meet(const Values& projections, int depth_a, int depth_b) const noexcept
    {
        const double scale_a = scale_at(depth_a);
        const double scale_b = scale_at(depth_b);
        bool apart = false;
        for (std::size_t i = 0; i < axis_count; ++i) {
            const double reach = alpha_[i] * scale_a + beta_[i] * scale_b + error_[i];
            apart |= std::abs(projections[i]) > reach;
        }
        return !apart;
    }

private:
    [[nodiscard]] static double scale_at(int depth) noexcept
    {
        return 1.0 / static_cast<double>(1U << static_cast<unsigned>(depth));
    }
    [[nodiscard]] static Values shifted(const Values& projections, const Values& step,
                                        int depth) noexcept
    {
        const double scale = scale_at(depth);
        Values result;
        for (std::size_t i = 0; i < result.size(); ++i)
            result[i] = projections[i] + step[i] * scale;
        return result;
    }

    Values root_{};
    Values alpha_{};
    Values beta_{};
    Values error_{};
    std::array<Values, 8> child_of_a_{}; ///< of the root; at depth d, 2^-d times as much
    std::array<Values, 8> child_of_b_{};
};

} // namespace proxima
