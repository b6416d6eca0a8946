// Proximity octrees in files (.pxp): written whole or not at all, used in place when loaded, so
// that a second start takes no build.
//
//     sections of base/binary_file.h:  1 header | 2 table | 3 nodes | 4 runs | 5 arena |
//                                      6 rows of floats | 7 rows of doubles | 8 rows of vertices |
//                                      9 rows of edges | 10 boxes over the rows
//
// docs/file_format.md describes every byte.
#pragma once

#include "base/binary_file.h"
#include "index/lists/proximity_octree.h"
#include "proxima/execution.h"
#include "proxima/octree_io.h"
#include "proxima/result.h"
#include "proxima/triangle_mesh.h"

#include <cstddef>
#include <filesystem>
#include <memory>
#include <span>
#include <string>

namespace proxima {

struct ProximityLoadOptions {
    /// As LoadOptions has it.
    Verification verify = Verification::full;
    /// Stages "checksums" and "checking the octree", in bytes; threads: that check.
    Execution execution = {};
};

/// The same octree gives the same bytes. Errors: invalid_argument (a refitted octree: build it
/// again), file_not_writable, cancelled. O(bytes).
[[nodiscard]] Status save_proximity_octree(const ProximityOctree& octree,
                                           const std::filesystem::path& path,
                                           const SaveOptions& options = {});

/// The octree on the memory-mapped file, which must not change while the octree lives. Whatever
/// `options.verify`, the structure is checked (check_proximity_structure.h), so that no content of
/// a file can lead a query out of its arrays; whether it is the octree of a mesh, check_same_mesh
/// tells. Errors: file_not_found, unsupported_format (foreign file, newer version, other byte
/// order), malformed_file (truncated, damaged, contradicting itself), cancelled. O(bytes), about
/// 1 ms per MB on one thread.
[[nodiscard]] Result<ProximityOctree>
load_proximity_octree(const std::filesystem::path& path, const ProximityLoadOptions& options = {});

/// The same from a file's bytes in memory, aligned to 64, which `storage` keeps alive.
[[nodiscard]] Result<ProximityOctree>
load_proximity_octree(std::span<const std::byte> bytes, std::shared_ptr<const void> storage,
                      const std::string& name, const ProximityLoadOptions& options = {});

/// Whether the octree was built of this mesh: same positions and triangles, in the same order.
/// Error invalid_argument, naming both. O(mesh).
[[nodiscard]] Status check_same_mesh(const ProximityOctree& octree, const TriangleMesh& mesh);

} // namespace proxima
