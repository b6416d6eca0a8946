// A rank's part of an octree that lies in a file (.pxo), of proxima or of any number of ranks.
#pragma once

#include "distributed/octree_part.h"
#include "distributed/world.h"

#include <filesystem>

namespace proxima {

/// The octree's cells of depth `routing_depth` and leaves above it, shared by their references. Each
/// rank maps the file and copies its part; the first one reads all of it to compare the checksums.
/// Errors: those of load_octree, unsupported_format for uniform octrees. Collective.
[[nodiscard]] Result<OctreePart> load_part(const std::filesystem::path& path, int routing_depth,
                                           World& world);

} // namespace proxima
