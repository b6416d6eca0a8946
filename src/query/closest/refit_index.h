// Brings a mesh index up to date with a mesh of which some vertices moved.
//
//     auto moved = refit_index(index, mesh, topology);
//     // once queries have slowed down too much: build_mesh_index, with_lists again
//
// Boxes of the tree are drawn about where vertices are now (refit_tree.h). A leaf of the lists stays
// as it is where no triangle of its list moved and none that moved can come closer anywhere in it
// than what the list holds. All others give their lists up: their points are searched for in the
// tree. So answers are exact, and queries slower where the mesh moved, until the index is built
// again.
#pragma once

#include "base/parallel.h"
#include "base/progress.h"
#include "base/result.h"
#include "index/mesh_index.h"
#include "mesh/topology.h"
#include "mesh/triangle_mesh.h"

namespace proxima {

struct RefitOptions {
    Threads threads = {};
    Progress* progress = nullptr;
};

/// The index of `mesh`, which has the triangles of the index's own mesh and vertices elsewhere, with
/// lists where `index` has some, without its other shelves; `topology` is the same for both. Keeps
/// nothing of mesh and topology; shares blocks of lists with `index`, which stays as it was.
/// lists()->statistics().stale_leaves counts the leaves that gave up their lists. Errors:
/// invalid_argument (other triangles or topology; a vertex left the root of the lists: build
/// again), invalid_mesh (NaN), cancelled. A copy of blocks, nodes and rows; about 1 us per triangle,
/// with lists 2 us, and 5 us per leaf near triangles that moved.
[[nodiscard]] Result<MeshIndex> refit_index(const MeshIndex& index, const TriangleMesh& mesh,
                                            const Topology& topology,
                                            const RefitOptions& options = {});

} // namespace proxima
