// Mesh indexes in files (.pxi), with the shelves that they have: written whole or not at all, used
// in place when loaded, so that a second start takes no build.
//
//     sections of base/binary_file.h:  1 header | 2 blocks | 3 rows of floats | 4 rows of doubles |
//                                      5 ids | 6 vertex places | 7 edge places
//         lists, where there are any:  8 header | 9 table | 10 nodes | 11 runs | 12 arena
//         slabs, where there are any:  13 slabs
//
// Sections of shelves that the index has not are empty. docs/file_format.md describes every byte.
#pragma once

#include "base/binary_file.h"
#include "base/parallel.h"
#include "base/progress.h"
#include "base/result.h"
#include "index/mesh_index.h"
#include "octree/octree_file.h"

#include <cstddef>
#include <filesystem>
#include <memory>
#include <span>
#include <string>

namespace proxima {

struct IndexLoadOptions {
    /// As LoadOptions has it.
    Verification verify = Verification::full;
    Progress* progress = nullptr; ///< stages "checksums" and "checking the index", in bytes
    Threads threads = {};         ///< that check
};

/// The same index gives the same bytes. Errors: invalid_argument (refitted lists: build them
/// again), file_not_writable, cancelled. O(bytes).
[[nodiscard]] Status save_index(const MeshIndex& index, const std::filesystem::path& path,
                                const SaveOptions& options = {});

/// The index on the memory-mapped file, which must not change while the index lives. Whatever
/// `options.verify`, the structure is checked (check_structure.h), so that no content of a file can
/// lead a query out of its arrays; whether it is the index of a mesh, check_same_mesh tells.
/// Errors: file_not_found, unsupported_format (foreign file, newer version, other byte order),
/// malformed_file (truncated, damaged, contradicting itself), cancelled. O(bytes), about 1 ms per
/// MB on one thread.
[[nodiscard]] Result<MeshIndex> load_index(const std::filesystem::path& path,
                                           const IndexLoadOptions& options = {});

/// The index in a file's bytes in memory, aligned to section_alignment, which `storage` keeps
/// alive.
[[nodiscard]] Result<MeshIndex> load_index(std::span<const std::byte> bytes,
                                           std::shared_ptr<const void> storage,
                                           const std::string& name,
                                           const IndexLoadOptions& options = {});

} // namespace proxima
