// Like grow_cells, with nodes that can be changed and that tell empty cells from cells elsewhere.
#pragma once

#include "octree/distribute_children.h"
#include "proxima/grow_cells.h"

#include <cstdint>
#include <vector>

namespace proxima {

/// How cells are written that neither are nor contain one of the cells that were given.
enum class CellsElsewhere : std::uint8_t {
    unrecorded, ///< as empty leaves; so are cells without triangles, or larger ones that hold them
    /// As leaves with a record and without triangles; cells without triangles are empty leaves. The
    /// octree is not valid by itself: code for whole octrees takes the records for boundary leaves.
    recorded
};

struct GrownPart {
    OctreeOutput arrays;
    std::vector<Cell> cells; ///< as GrownCells::cells
    /// Records before it are those of the cells and of what is above them, the others are below.
    std::uint32_t upper_records = 0;
    std::uint64_t split_pairs = 0; ///< of a triangle and a cell that was split
};

/// As grow_cells.
[[nodiscard]] Result<GrownPart> grow_part(const TriangleMesh& mesh, const OctreeFrame& frame,
                                          std::span<const CellTriangles> cells,
                                          CellsElsewhere elsewhere,
                                          const GrowCellsOptions& options = {});

/// Of octrees of grow_part that are not classified yet.
[[nodiscard]] inline OctreeParameters part_parameters(const GrowCellsOptions& options) noexcept
{
    return {.max_depth = options.max_depth, .threshold = options.threshold, .exact = true};
}

} // namespace proxima
