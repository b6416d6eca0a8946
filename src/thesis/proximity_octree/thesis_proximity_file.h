// The thesis's proximity octree in a file (.pxv): written whole or not at all, checked when opened.
//
//     sections of base/binary_file.h:  1 header | 2 nodes | 3 leaves | 4 labels
//
// The file does not hold the mesh: queries take it beside the octree.
#pragma once

#include "proxima/execution.h"
#include "proxima/result.h"
#include "thesis/proximity_octree/thesis_proximity_octree.h"

#include <cstddef>
#include <filesystem>
#include <memory>
#include <span>
#include <string>

namespace proxima {

inline constexpr const char* thesis_proximity_extension = ".pxv";

/// The same octree gives the same bytes. Errors: file_not_writable, cancelled. O(bytes).
[[nodiscard]] Status save_thesis_proximity_octree(const ThesisProximityOctree& octree,
                                                  const std::filesystem::path& path,
                                                  Progress* progress = nullptr);

/// Reads the octree into memory. Checksums and structure are checked, so that no content of a file
/// can lead a query out of its arrays. Errors: file_not_found, unsupported_format, malformed_file,
/// cancelled. O(bytes).
[[nodiscard]] Result<ThesisProximityOctree>
load_thesis_proximity_octree(const std::filesystem::path& path, Progress* progress = nullptr);

/// Like load_thesis_proximity_octree, from a file's bytes in memory, aligned to 128, which `storage`
/// keeps alive. `name` stands for the path in messages.
[[nodiscard]] Result<ThesisProximityOctree>
load_thesis_proximity_octree(std::span<const std::byte> bytes, std::shared_ptr<const void> storage,
                             const std::string& name, Progress* progress = nullptr);

} // namespace proxima
