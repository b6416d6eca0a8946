// Whether the arrays of closest-feature lists form some.
#pragma once

#include "index/check_work.h"
#include "index/index_parts.h"
#include "proxima/mesh_index.h"
#include "proxima/result.h"

namespace proxima {

/// Checks that every query of the lists stays inside the arrays and ends, in as many steps and
/// blocks as the statistics say.
///
///     frame    a finite cube, its scale the power of two that make_root_frame gives; rows are in it
///     arena    blocks one behind the other, zeros between; positions of vertices and ranks exist
///     nodes    one tree of at most max_list_depth levels, each node in it once; the table is
///              its level
///     leaves   name blocks where blocks are, of their triangles 1 to 16; each block and each run
///              belongs to some leaf, a run to one; a run's bounds are finite and ascend
///     numbers  statistics are those of what is found, but for expected_list
///
/// Errors: broken_invariant; cancelled. \pre the index has lists, its rows and blocks are sound
[[nodiscard]] Status check_lists(const IndexParts& index, const CheckWork& work);

/// Whether the scale of a frame, which must be one, is a power of two.
[[nodiscard]] bool is_power_of_two(double value) noexcept;

} // namespace proxima
