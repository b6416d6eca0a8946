// Whether the blocks of a mesh index are one tree over its rows.
#pragma once

#include "index/check_work.h"
#include "index/index_parts.h"
#include "proxima/mesh_index.h"
#include "proxima/result.h"

namespace proxima {

/// Errors: broken_invariant, naming a block; cancelled. See check_structure.h.
/// \pre there are as many ids as rows, at least one; the frame is finite
[[nodiscard]] Status check_blocks(const IndexParts& index, const CheckWork& work);

} // namespace proxima
