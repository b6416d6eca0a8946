// A rank's part of an octree that is spread over the ranks.
#pragma once

#include "proxima/octree.h"

#include <cstdint>
#include <vector>

namespace proxima {

struct OctreePart {
    /// Records before upper_records are those of the cells and of what is above them, if that is
    /// there; all others are below cells. Only what is in or below cells is to be used.
    Octree octree;
    std::uint32_t upper_records = 0;
    std::vector<Cell> cells;           ///< this rank's, in Morton order
    std::uint64_t whole_triangles = 0; ///< of the whole mesh
    std::uint64_t split_pairs = 0; ///< as GrownPart::split_pairs; 0 of an octree that was loaded
    double work_seconds = 0; ///< processor time to build or load it, without messages and waiting
    std::vector<std::uint64_t> triangles; ///< the whole mesh's id of each; none: lists have those

    [[nodiscard]] std::uint64_t whole_id(TriangleId id) const noexcept
    {
        return triangles.empty() ? to_index(id) : triangles[to_index(id)];
    }
};

} // namespace proxima
