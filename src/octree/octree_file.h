// Octrees in files (.pxo): written whole or not at all, used in place when loaded.
//
//     sections of base/binary_file.h:  1 OctreeFileHeader | 2 nodes | 3 references
//
// docs/file_format.md describes every byte.
#pragma once

#include "base/binary_file.h"
#include "base/result.h"
#include "octree/octree.h"

#include <cstddef>
#include <filesystem>
#include <memory>
#include <span>
#include <string>

namespace proxima {

struct LoadOptions {
    /// `full` also compares the checksums, so that any damage is found. Both check the structure
    /// (check_structure.h), so that no content of a file can lead a query out of its arrays.
    Verification verify = Verification::full;
    Progress* progress = nullptr; ///< stages "checksums" (bytes) and "checking the octree" (nodes)
};

struct SaveOptions {
    Progress* progress = nullptr; ///< stages "checksums" and "writing", steps are bytes
};

/// The same octree gives the same bytes. Errors: file_not_writable, cancelled. O(bytes).
[[nodiscard]] Status save_octree(const Octree& octree, const std::filesystem::path& path,
                                 const SaveOptions& options = {});

/// The octree on the memory-mapped file, which must not change while the octree lives. Errors:
/// file_not_found, unsupported_format (foreign file, newer version, other byte order),
/// malformed_file (truncated, damaged, contradicting itself), cancelled. O(nodes + references).
[[nodiscard]] Result<Octree> load_octree(const std::filesystem::path& path,
                                         const LoadOptions& options = {});

/// The same from a file's bytes in memory, aligned to 64, which `storage` keeps alive.
[[nodiscard]] Result<Octree> load_octree(std::span<const std::byte> bytes,
                                         std::shared_ptr<const void> storage,
                                         const std::string& name, const LoadOptions& options = {});

} // namespace proxima
