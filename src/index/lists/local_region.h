// Which children of a cell meet a feature's local region.
//
// A region and a cube meet iff the cube's centre is in their Minkowski sum (thesis 4.3.3). Its
// facets are the region's own planes, moved out by h |n|_1, those of the cube, and one for every
// pair of an edge of the region and an edge of the cube. The last ones come from pairs of planes:
// with normals of opposite signs on axis k, y = |n_jk| n_i + |n_ik| n_j has no component there
// (Fourier and Motzkin's elimination of one variable), and its half-space holds the region. Own
// planes and pairs, for all eight children at once; the few that these let through cost a list
// entry, never an answer.
#pragma once

#include "index/lists/local_features.h"

#include <cstdint>
#include <span>

namespace proxima {

/// A cube in the root's frame.
struct FrameCell {
    float center[3] = {};
    float half = 1;
};

/// The child of a cell in an octant.
[[nodiscard]] inline FrameCell child(const FrameCell& cell, int octant) noexcept
{
    FrameCell result;
    result.half = 0.5F * cell.half;
    for (int axis = 0; axis < 3; ++axis) {
        result.center[axis] =
            cell.center[axis] + ((octant >> axis & 1) != 0 ? result.half : -result.half);
    }
    return result;
}

/// Bit i of masks[k] is set unless the region of feature list[k] is apart from child i. About 30 ns
/// each. \pre masks is as long as the list
void find_children_in_reach(const LocalFeatures& features, std::span<const std::uint32_t> list,
                            const FrameCell& cell, std::uint8_t* masks);

} // namespace proxima
