// The leaves of an octree that is spread over the ranks, for ParaView.
//
//     leaves.pvtu      names the pieces, written last
//     leaves_0.vtu     the leaves of rank 0, as export_vtu writes those of a whole octree
//     leaves_1.vtu     ...
#pragma once

#include "distributed/octree_part.h"
#include "distributed/world.h"

#include <filesystem>

namespace proxima {

/// Writes path, which ends with .pvtu, and beside it a piece for each rank that has leaves. An older
/// file of that name is removed first: what is there is always of one run. Errors:
/// file_not_writable, cancelled. Collective.
[[nodiscard]] Status export_part(const OctreePart& part, const std::filesystem::path& path,
                                 World& world);

} // namespace proxima
