// Whether the signs of a mesh index are sound.
#pragma once

#include "index/check_work.h"
#include "index/index_parts.h"
#include "proxima/result.h"

namespace proxima {

/// Checks that every query of signs stays inside the arrays and ends.
///
///     rows      each triangle's is the one that has its id
///     sides     of all rows, vertices and edges, or of none; values that exist
///     edges     a row that has the edge, or a list; lists one behind the other, in the order of the
///               edges, of rows that have the edge
///     clusters  one tree, parents first; leaves part the order, which has each row once
///
/// Errors: broken_invariant; cancelled. \pre the index has signs, its rows are sound
[[nodiscard]] Status check_signs(const IndexParts& index, const CheckWork& work);

} // namespace proxima
