// The exact child test in vector lanes, for whoever grows subtrees.
#pragma once

#include "octree/grow_subtree.h"

#include <cstdint>

namespace proxima {

/// Vector lanes on the snapped grid.
class FastChildTest final : public ChildTest {
public:
    explicit FastChildTest(const SnappedMesh& mesh) noexcept : mesh_(mesh) {}

    void begin(const Subtree& subtree) override
    {
        mesh_.load(subtree.triangles, subtree.lower, local_);
    }

    void find_touched(const SplitLevel& level, int depth, std::uint32_t* masks) override
    {
        mesh_.find_touched(local_,
                           {.pairs = level.pairs(),
                            .half = 1 << (snapped_bits - depth - 1),
                            .child_depth = depth + 1},
                           scratch_, masks);
    }

private:
    const SnappedMesh& mesh_;
    LocalTriangles local_;
    SnappedScratch scratch_;
};

/// The lower corner of a cell, in grid steps.
[[nodiscard]] inline GridPoint grid_corner(CellKey key) noexcept
{
    const auto coordinates = cell_coordinates(key);
    const int shift = snapped_bits - depth(key);
    return {static_cast<std::int32_t>(coordinates[0] << shift),
            static_cast<std::int32_t>(coordinates[1] << shift),
            static_cast<std::int32_t>(coordinates[2] << shift)};
}

} // namespace proxima
