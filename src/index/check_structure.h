// Whether the arrays of a mesh index form one at all: the part of its invariants that needs no mesh.
#pragma once

#include "proxima/execution.h"
#include "proxima/mesh_index.h"
#include "proxima/result.h"

namespace proxima {

struct CheckStructureOptions {
    Execution execution = {}; ///< stage "checking the index", steps are bytes
};

/// Checks that every query stays inside the arrays, ends, and finds what there is, in as many steps
/// and blocks of lists as their statistics say.
///
///     frame    a finite center, a scale that is a power of two
///     rows     every triangle once, with the id in ids; vertices and edges that exist, no_edge
///              just where both ends are one vertex and one position; incidences name the lowest
///              triangle of each vertex and edge
///     blocks   one tree of at most max_levels levels, each block in it once, runs of rows in its
///              order; boxes hold what is below them, leaves have the corners of their rows, finite
///              and in the frame
///     lists    check_lists.h
///     slabs    one for each block, and seven
///     signs    check_signs.h
///
/// Errors: broken_invariant naming the first fault; cancelled. The same for any number of threads.
/// For any content of the arrays, also a crafted one, but aligned as their types want.
/// O(bytes), a byte of scratch per eight and 32 per block.
[[nodiscard]] Status check_structure(const MeshIndex& index,
                                     const CheckStructureOptions& options = {});

} // namespace proxima
