// Mesh indexes in files (.pxi): a second start takes no build.
//
//     if (Status saved = save_index(*index, "dragon.pxi"); !saved) ...
//     auto loaded = load_index("dragon.pxi");          // with its additions
//     auto mesh = mesh_of(*loaded);                    // the mesh is in it, too
//
// docs/file_format.md describes every byte.
#pragma once

#include "proxima/execution.h"
#include "proxima/export.h"
#include "proxima/mesh_index.h"
#include "proxima/octree_io.h"
#include "proxima/result.h"

#include <cstddef>
#include <filesystem>
#include <memory>
#include <span>
#include <string>

namespace PROXIMA_EXPORT proxima {

/// Writes the index whole or not at all. The same index gives the same bytes. Errors:
/// invalid_argument (no triangles; lists that lost leaves in a refit: build them again), file_not_writable, cancelled. O(bytes).
[[nodiscard]] Status save_index(const MeshIndex& index, const std::filesystem::path& path,
                                const SaveOptions& options = {});

/// The index of a file, which is read or, on request, mapped: single closest features of a mesh of
/// 871,000 triangles take 0.8 to 0.9 of the time by lists that were read. Whatever `options.verify`,
/// the structure is checked, so that no content of a file can lead a query out of its arrays;
/// check_same_mesh tells whether it is the index of a given mesh. Errors:
/// file_not_found, unsupported_format (foreign file, newer version, other byte order),
/// malformed_file (truncated, damaged, contradicting itself), budget_exceeded, cancelled. O(bytes),
/// about 1 ms per MB on one thread.
[[nodiscard]] Result<MeshIndex> load_index(const std::filesystem::path& path,
                                           const LoadOptions& options = {});

/// Loads an index from a file's bytes in memory, aligned to 128, which `storage` keeps alive. One error
/// more: invalid_argument (bytes that are not aligned).
[[nodiscard]] Result<MeshIndex> load_index(std::span<const std::byte> bytes,
                                           std::shared_ptr<const void> storage,
                                           const std::string& name,
                                           const LoadOptions& options = {});

} // namespace proxima
