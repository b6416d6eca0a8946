// The mesh of a proximity octree, from the rows that it keeps: so that a saved octree is all that
// signs, rings and patches need.
//
//     auto mesh = mesh_of(*octree);
//     auto topology = build_topology(*mesh);
//     Status same = check_edges(*octree, *topology);   // its answers name edges of this topology
#pragma once

#include "index/lists/proximity_octree.h"
#include "proxima/result.h"
#include "proxima/topology.h"
#include "proxima/triangle_mesh.h"

namespace proxima {

/// The mesh that the octree was built of: positions bit for bit, triangles in their order. Vertices
/// that no triangle uses were not kept and stand at the root's centre. Error broken_invariant where
/// rows of a crafted file put a vertex at two places, or, all vertices being in use, are of another
/// mesh than the file says. O(triangles + vertices). \pre check_structure holds
[[nodiscard]] Result<TriangleMesh> mesh_of(const ProximityOctree& octree);

/// Whether edges of answers are edges of the topology. Error broken_invariant, naming a triangle.
/// O(triangles). \pre the topology is that of mesh_of(octree)
[[nodiscard]] Status check_edges(const ProximityOctree& octree, const Topology& topology);

} // namespace proxima
