// The mesh of an index, from the rows that it keeps: so that a saved index is all that lists, signs,
// rings and patches need.
//
//     auto mesh = mesh_of(*index);
//     auto topology = build_topology(*mesh);
//     Status same = check_edges(*index, *topology);   // its answers name edges of this topology
#pragma once

#include "base/result.h"
#include "index/mesh_index.h"
#include "mesh/topology.h"
#include "mesh/triangle_mesh.h"

namespace proxima {

/// The mesh that the index was built of: positions bit for bit, triangles in their order. Vertices
/// that no triangle uses were not kept and stand at the index's center. Error broken_invariant
/// where rows of a crafted file put a vertex at two positions, or, all vertices being in use, are of
/// another mesh than the file says. O(triangles + vertices). \pre check_structure holds
[[nodiscard]] Result<TriangleMesh> mesh_of(const MeshIndex& index);

/// Whether edges of answers are edges of the topology. Error broken_invariant, naming a triangle.
/// O(triangles). \pre the topology is that of mesh_of(index)
[[nodiscard]] Status check_edges(const MeshIndex& index, const Topology& topology);

/// Whether the index was built of this mesh: same positions and triangles, in the same order.
/// Error invalid_argument, naming both. O(mesh).
[[nodiscard]] Status check_same_mesh(const MeshIndex& index, const TriangleMesh& mesh);

} // namespace proxima
