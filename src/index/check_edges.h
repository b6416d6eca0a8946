// Whether edges of an index are numbered as a topology has them.
//
//     auto topology = build_topology(*mesh);
//     Status same = check_edges(*index, *topology); // its answers name edges of this topology
#pragma once

#include "proxima/mesh_index.h"
#include "proxima/result.h"
#include "proxima/topology.h"

namespace proxima {

/// Whether edges of answers are edges of the topology. Error broken_invariant, naming a triangle.
/// O(triangles). \pre the topology is that of mesh_of(index)
[[nodiscard]] Status check_edges(const MeshIndex& index, const Topology& topology);

} // namespace proxima
