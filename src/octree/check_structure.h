// Whether an octree's arrays form an octree at all: the part of the invariants that needs no mesh.
#pragma once

#include "proxima/execution.h"
#include "proxima/octree.h"
#include "proxima/result.h"

namespace proxima {

/// Checks that every traversal of the octree stays inside its arrays and ends: the frame and the
/// parameters are in range; records form one tree, each reached exactly once; no cell is deeper
/// than parameters().max_depth; lists ascend, name triangles of the mesh, and cover the references
/// exactly once; class bits say what parameters().classified and Subdivision allow.
/// Errors: broken_invariant naming the record; cancelled by `progress`, stage "checking the
/// octree". For any content of the arrays, also a crafted one. O(nodes + references), one bit of
/// scratch each.
[[nodiscard]] Status check_structure(const Octree& octree, Progress* progress = nullptr);

} // namespace proxima
