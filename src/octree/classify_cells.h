// Which empty leaves lie inside the surface, also where it has holes (thesis 2.1).
//
//     outside . . . . .|   1. Leaves that share a face form components: no triangle parts them.
//     . . +--------+ . |   2. Triangles that would close the holes (hole_caps.h) part them further,
//     . . | inside | . |      into regions with one whole winding number I each.
//     . . |  . .  cap  |   3. A leaf's winding number is I minus that of the caps, and inside
//     . . +---- ---+ . |      means 1/2 or more. A component with leaves of both kinds has leaked.
//
// I is 0 outside the root. From region to region it changes by the crossings of a ray, exactly
// (region_rays.h); only where no ray leads out are solid angles summed.
#pragma once

#include "proxima/execution.h"
#include "proxima/octree.h"
#include "proxima/result.h"
#include "proxima/triangle_mesh.h"

#include <span>

namespace proxima {

struct ClassifyOptions {
    Execution execution = {}; ///< budget: the copied nodes and scratch
};

/// A copy of the octree whose empty leaves are inner (winding number of the centre >= 1/2) or
/// outer; it shares the references. parameters().classification tells how many components leaked
/// through holes: those with leaves of both classes, or connected to the outside of the root and
/// yet with inner leaves. Empty cells of a uniform octree are classified as a whole, by the largest
/// cell that is empty. Same bits for any number of threads.
/// Errors: invalid_argument (another mesh's octree), invalid_mesh, budget_exceeded, limit_exceeded
/// (2^32 empty cells), cancelled. O(nodes) on a closed mesh, and a few rays per component that does
/// not reach the root's faces, or a winding number where the lists are not exact; more near large
/// holes.
[[nodiscard]] Result<Octree> classify_cells(const Octree& octree, const TriangleMesh& mesh,
                                            const ClassifyOptions& options = {});

/// Like classify_cells, into `nodes`, which may be those of the octree: for its builder, which need
/// not copy them. An error leaves them as they were.
/// \pre checked_bounding_box(mesh), whose extent is finite; `octree` was built from `mesh`, and
/// `nodes` equal its nodes but for inner octants, of which they have none
[[nodiscard]] Result<ClassificationSummary> classify_nodes(const Octree& octree,
                                                           std::span<OctreeNode> nodes,
                                                           const TriangleMesh& mesh,
                                                           const Execution& execution);

/// The parameters of an octree with these classes.
[[nodiscard]] inline OctreeParameters classified(OctreeParameters parameters,
                                                 const ClassificationSummary& summary)
{
    parameters.classified = true;
    parameters.classification = summary;
    return parameters;
}

} // namespace proxima
