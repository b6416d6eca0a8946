// Builds octrees from meshes (thesis 2.1). The overlap tests of thesis chapter 3 build the same ones
// with build_octree_by of the thesis layer.
//
//     auto octree = build_octree(mesh, {.max_depth = 8, .threshold = 8});
//     if (!octree) { std::cerr << describe(octree.error()); return 1; }
#pragma once

#include "base/memory_budget.h"
#include "base/parallel.h"
#include "base/progress.h"
#include "base/result.h"
#include "mesh/triangle_mesh.h"
#include "octree/octree.h"

#include <cstdint>
#include <optional>

namespace proxima {

enum class RootShape : std::uint8_t { cube, box };

/// Whether empty leaves are found to be inner or outer (costs winding numbers).
enum class Classification : std::uint8_t { inner_outer, none };

struct OctreeOptions {
    int max_depth = 5;           ///< 0 to max_octree_depth; the root is depth 0
    std::uint32_t threshold = 1; ///< a cell splits iff it has more triangles and may be deeper
    Subdivision subdivision = Subdivision::adaptive;
    RootShape root_shape = RootShape::cube; ///< tight on the bounding box: cube or box of its shape
    std::optional<OctreeFrame> root = {};   ///< this root instead; must contain the mesh
    Classification classification = Classification::inner_outer;
    MemoryBudget budget = {}; ///< result and scratch, without the mesh
    Threads threads = {};
    Progress* progress = nullptr; ///< watched and obeyed where given
};

/// Builds the octree; the same bits for any number of threads and any instruction set.
/// Errors: invalid_argument (depth, root), invalid_mesh (empty, NaN), budget_exceeded,
/// limit_exceeded (2^31 references), cancelled. Leaves list exactly the triangles that touch the
/// closed cell. Cost: linear in the references, a few tens of nanoseconds each: `scripts/bench
/// octree` measures it.
[[nodiscard]] Result<Octree> build_octree(const TriangleMesh& mesh,
                                          const OctreeOptions& options = {});

/// The root that build_octree uses when none is given: centred on the mesh's bounding box and
/// containing it exactly. \pre !box.empty(), finite
[[nodiscard]] OctreeFrame tight_root(const Box& box, RootShape shape) noexcept;

} // namespace proxima
