// Parts of an octree: what build_octree has below some of its cells, from the triangles there.
//
//     // On each process: the cells that it owns, and the part of the mesh that touches them.
//     auto part = grow_cells(piece, frame_of_the_whole, cells, {.max_depth = 10, .threshold = 8});
//     for (const Cell& cell : part->cells) traverse_below(part->octree, cell, visitor);
//
// For programs that spread an octree over processes or build it piece by piece.
#pragma once

#include "proxima/execution.h"
#include "proxima/export.h"
#include "proxima/octree.h"
#include "proxima/result.h"
#include "proxima/triangle_mesh.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace PROXIMA_EXPORT proxima {

/// A cell, and the triangles of a mesh that touch it.
struct CellTriangles {
    CellKey key;
    std::span<const TriangleId> triangles; ///< ascending
};

struct GrowCellsOptions {
    int max_depth = 5; ///< 0 to max_octree_depth, of the whole octree: the root is depth 0
    std::uint32_t threshold = 1; ///< a cell splits iff it has more triangles and may be deeper
    Execution execution = {};    ///< budget: result and scratch, without the mesh
};

/// Some cells of an octree and all that is below them. Immutable, copies share the storage.
struct GrownCells {
    /// Split from the root down to the cells. Every other cell is an empty leaf here, whatever it
    /// is in the whole octree. Not classified.
    Octree octree;
    std::vector<Cell> cells; ///< in the octree, one per cell that was given, in that order
};

/// Grows cells of the octree whose root is `frame`. The leaves and lists below each cell are those
/// that build_octree has there for any mesh with exactly these triangles touching the cell: a part
/// of a mesh will do, with ids of its own in the order of the whole. Subdivision is adaptive. The
/// mesh may be empty if all lists are. Works on the calling thread.
/// Errors: invalid_argument (depth, frame; cells that overlap, are not in Morton order or are deeper
/// than max_depth; ids out of range or not ascending), invalid_mesh (NaN, outside of the frame,
/// beyond 1e100), budget_exceeded, limit_exceeded (2^31 references), cancelled. Cost: linear in the
/// vertices, triangles and references, as build_octree.
/// \pre each triangle that is listed touches its closed cell
[[nodiscard]] Result<GrownCells> grow_cells(const TriangleMesh& mesh, const OctreeFrame& frame,
                                            std::span<const CellTriangles> cells,
                                            const GrowCellsOptions& options = {});

} // namespace proxima
