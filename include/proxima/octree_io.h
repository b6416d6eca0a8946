// Octrees in files: saved and loaded again (.pxo), or exported to other programs.
//
//     .pxo   the octree itself: written whole or not at all, used in place when loaded
//     .vtu   all leaves as voxels that share their corners     cell data: class, depth, triangles
//     .htg   VTK HyperTreeGrid 2.0, the tree itself            the same, inner cells included
//     .ply   all leaves as boxes of six quads                  colours by class, and class, depth
//     .glb   the mesh and its boundary leaves' edges           glTF 2.0, with materials
//
// "class" is the number of CellClass: 0 outer, 1 inner, 2 boundary, 3 unclassified.
// docs/file_format.md describes every byte of .pxo; ParaView, MeshLab, Blender and web viewers read
// the others.
#pragma once

#include "proxima/execution.h"
#include "proxima/export.h"
#include "proxima/octree.h"
#include "proxima/result.h"
#include "proxima/triangle_mesh.h"

#include <cstddef>
#include <filesystem>
#include <memory>
#include <span>
#include <string>

namespace PROXIMA_EXPORT proxima {

/// Of octrees and indexes.
struct LoadOptions {
    Verification verify = Verification::full;
    FileAccess access = FileAccess::read;
    /// Stages "loading file" and "checksums" (bytes), then "checking the octree" (nodes) or
    /// "checking the index" (bytes). The budget is of a file that is read, the threads are of
    /// "checking the index"; octrees are checked on one.
    Execution execution = {};
};

struct SaveOptions {
    Execution execution = {}; ///< stages "checksums" and "writing", steps are bytes
};

/// Equal octrees give equal bytes. Errors: invalid_argument (no nodes), file_not_writable, cancelled.
/// O(bytes).
[[nodiscard]] Status save_octree(const Octree& octree, const std::filesystem::path& path,
                                 const SaveOptions& options = {});

/// The octree of a file, which is read or, on request, mapped. Whatever `options.verify`, the
/// structure is checked, so that no content of a file can lead a query out of its arrays. Errors:
/// file_not_found, unsupported_format (foreign file, newer version, other byte order),
/// malformed_file (truncated, damaged, contradicting itself), budget_exceeded, cancelled.
/// O(nodes + references).
[[nodiscard]] Result<Octree> load_octree(const std::filesystem::path& path,
                                         const LoadOptions& options = {});

/// Loads an octree from a file's bytes in memory, aligned to 128, which `storage` keeps alive. One error
/// more: invalid_argument (bytes that are not aligned).
[[nodiscard]] Result<Octree> load_octree(std::span<const std::byte> bytes,
                                         std::shared_ptr<const void> storage,
                                         const std::string& name, const LoadOptions& options = {});

struct ExportOptions {
    Execution execution = {}; ///< several stages, the last one "writing"
};

/// Writes the format that the extension names (upper or lower case), whole or not at all.
/// Coordinates are doubles, the octree's exact planes, except in .glb: floats relative to the
/// root's centre, which is the nodes' translation. `mesh` is used by .glb only.
/// Errors: unsupported_format, file_not_writable, limit_exceeded (a .glb beyond 4 GB or
/// coordinates beyond float), cancelled. O(leaves) memory; points cost a sort.
[[nodiscard]] Status export_octree(const Octree& octree, const TriangleMesh& mesh,
                                   const std::filesystem::path& path,
                                   const ExportOptions& options = {});

// One function per format, for any extension.
[[nodiscard]] Status export_vtu(const Octree& octree, const std::filesystem::path& path,
                                const ExportOptions& options = {});
[[nodiscard]] Status export_htg(const Octree& octree, const std::filesystem::path& path,
                                const ExportOptions& options = {});
[[nodiscard]] Status export_ply(const Octree& octree, const std::filesystem::path& path,
                                const ExportOptions& options = {});
[[nodiscard]] Status export_glb(const Octree& octree, const TriangleMesh& mesh,
                                const std::filesystem::path& path,
                                const ExportOptions& options = {});

} // namespace proxima
