// Octrees for other programs: ParaView, MeshLab, Blender and web viewers.
//
//     .vtu   all leaves as voxels that share their corners        cell data: class, depth,
//     triangles .htg   VTK HyperTreeGrid 2.0, the tree itself                the same, inner cells
//     included .ply   all leaves as boxes of six quads                      colours by class, and
//     class, depth .glb   the mesh and its boundary leaves' edges, glTF 2.0     materials
//
// "class" is the number of CellClass: 0 outer, 1 inner, 2 boundary, 3 unclassified.
#pragma once

#include "base/progress.h"
#include "base/result.h"
#include "mesh/triangle_mesh.h"
#include "octree/octree.h"

#include <filesystem>

namespace proxima {

struct ExportOptions {
    Progress* progress = nullptr; ///< several stages, the last one "writing"
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
