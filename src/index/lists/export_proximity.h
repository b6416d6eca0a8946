// Closest-feature lists for ParaView: where lists are long.
//
//     .vtu   all leaves as voxels that share their corners       cell data: list_length, blocks,
//     .htg   VTK HyperTreeGrid 2.0, the tree itself              depth; both 0 for split cells
#pragma once

#include "index/lists/proximity_lists.h"
#include "proxima/octree_io.h"
#include "proxima/result.h"

#include <filesystem>

namespace proxima {

/// Writes the format that the extension names (upper or lower case), whole or not at all.
/// Coordinates are doubles. Errors: unsupported_format, file_not_writable, broken_invariant (lists
/// that check_structure refuses), cancelled. O(cells) memory; points cost a sort.
[[nodiscard]] Status export_proximity(const ProximityLists& lists,
                                      const std::filesystem::path& path,
                                      const ExportOptions& options = {});

} // namespace proxima
