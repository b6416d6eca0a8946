// Features that are nowhere in a cell the closest.
//
// Let n be a unit vector, and L_f(x) the least n . (p - x) over the points p of feature f: no point
// of f is nearer to x. For another feature g, d(x, g) - L_f(x) is convex in x, so its greatest
// value over a cell is at a corner: if d(x, g) < L_f(x) at all eight corners, then g is nearer than
// f everywhere in the cell, and f is dropped. As n serves the direction from the cell's centre to
// f, as g each feature that is closest to the centre or to a corner. Before that: whatever is
// farther from the centre than the closest one by more than the cell's diameter.
//
// Any point of g gives an upper bound and any n a lower one, so bad directions of slivers only keep
// features that could go.
#pragma once

#include "index/lists/local_features.h"
#include "index/lists/local_region.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace proxima {

/// Scratch of drop_dominated, to be reused. Four floats per feature.
struct DominationScratch {
    std::vector<float> bounds; ///< per feature: n 3 | L_f at the centre
};

/// Keeps those of `list` that no other one dominates in the cell, in their order. Returns how many.
/// About 20 ns per feature.
[[nodiscard]] std::size_t drop_dominated(const LocalFeatures& features, std::uint32_t* list,
                                         std::size_t count, const FrameCell& cell,
                                         DominationScratch& scratch);

} // namespace proxima
