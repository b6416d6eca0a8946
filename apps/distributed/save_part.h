// An octree that is spread over the ranks, in one file (.pxo) as proxima writes it.
//
//     nodes       root, upper levels | below rank 0's cells | below rank 1's cells | ...
//     references                     | rank 0's lists       | rank 1's lists       | ...
#pragma once

#include "distributed/octree_part.h"
#include "distributed/world.h"

#include <filesystem>

namespace proxima {

/// Writes the whole octree through the first rank, which has a few MB of it at a time; whole or not
/// at all. Errors: limit_exceeded (2^31 triangles, 2^32 nodes or references), file_not_writable,
/// cancelled. Collective.
[[nodiscard]] Status save_part(const OctreePart& part, const std::filesystem::path& path,
                               World& world);

} // namespace proxima
