// Brings a proximity octree up to date with a mesh of which some vertices moved.
//
//     auto moved = refit_proximity_octree(octree, mesh, topology);
//     // once statistics().stale_leaves has grown too much: build_proximity_octree again
//
// A leaf stays as it is where no triangle of its list moved and none that moved can come closer
// anywhere in it than what the list holds. All others give their lists up: their points are
// searched for in the tree over all triangles, which is made again, as are the rows. So answers are
// exact, and queries slower where the mesh moved, until the octree is built again.
#pragma once

#include "index/lists/proximity_octree.h"
#include "proxima/execution.h"
#include "proxima/result.h"
#include "proxima/topology.h"
#include "proxima/triangle_mesh.h"

namespace proxima {

struct RefitOptions {
    Execution execution = {};
};

/// The octree of `mesh`, which has the triangles of the octree's own mesh and vertices elsewhere;
/// `topology` is the same for both. Keeps nothing of mesh and topology; shares blocks with
/// `octree`, which stays as it was. statistics().stale_leaves counts the leaves that gave up their
/// lists. Errors: invalid_argument (other triangles or topology; a vertex left the root: build
/// again), invalid_mesh (NaN), cancelled. A copy of nodes and rows; about 2 us per triangle, and 5
/// us per leaf near triangles that moved.
[[nodiscard]] Result<ProximityOctree> refit_proximity_octree(const ProximityOctree& octree,
                                                             const TriangleMesh& mesh,
                                                             const Topology& topology,
                                                             const RefitOptions& options = {});

} // namespace proxima
