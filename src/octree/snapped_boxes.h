// Which cells of one level the boxes of a mesh's triangles touch, in vector lanes.
#pragma once

#include "octree/snapped_overlap.h"

#include <array>
#include <cstddef>
#include <cstdint>

namespace proxima {

/// A mesh on the grid.
struct SnappedArrays {
    const SnappedPoint* vertices = nullptr;
    const std::array<std::uint32_t, 3>* corners = nullptr;
};

/// The inclusive range of cells at `depth` (7 at most) that the boxes of triangles [first, first +
/// count), grown by `margin` steps, touch: x | y << 8 | z << 16 of the lowest and the highest cell.
/// Both arrays have lane_padding elements to spare.
void find_cells_of_boxes(const SnappedArrays& mesh, std::size_t first, std::size_t count, int depth,
                         std::int32_t margin, std::uint32_t* lowest, std::uint32_t* highest);

} // namespace proxima
