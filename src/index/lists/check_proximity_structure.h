// Whether the arrays of a proximity octree form one at all: the part of its invariants that needs
// no mesh.
#pragma once

#include "index/lists/proximity_octree.h"
#include "proxima/execution.h"
#include "proxima/result.h"

namespace proxima {

struct CheckStructureOptions {
    Execution execution = {}; ///< stage "checking the octree", steps are bytes
};

/// Checks that every query stays inside the arrays and ends, in as many steps and blocks as the
/// statistics say.
///
///     frame    a finite cube, its scale the power of two that make_root_frame gives
///     rows     finite and in the root; every triangle once; vertices and edges that exist, no_edge
///              just where both ends are one vertex and one place
///     arena    blocks one behind the other, zeros between; places of vertices and ranks exist
///     nodes    one tree of at most max_proximity_depth levels, each node in it once; the table is
///              its level
///     leaves   name blocks where blocks are, of their triangles 1 to 16; each block and each run
///              belongs to some leaf, a run to one; a run's bounds are finite and ascend
///     numbers  statistics are those of what is found, but for expected_list
///
/// Errors: broken_invariant naming the first place; cancelled. The same for any number of threads.
/// For any content of the arrays, also a crafted one, but aligned as their types want.
/// O(bytes), a byte of scratch per eight.
[[nodiscard]] Status check_structure(const ProximityOctree& octree,
                                     const CheckStructureOptions& options = {});

} // namespace proxima
