// The mesh and the edges of its boundary leaves as binary glTF.
#include "base/progress.h"
#include "base/text.h"
#include "mesh/io/glb_file.h"
#include "octree/leaf_boxes.h"
#include "proxima/octree_io.h"

#include <array>
#include <limits>
#include <utility>

namespace proxima {

namespace {

/// Pairs of corners that an edge joins.
constexpr std::array<std::uint8_t, 24> edges = {0, 1, 2, 3, 4, 5, 6, 7, 0, 2, 1, 3,
                                                4, 6, 5, 7, 0, 4, 1, 5, 2, 6, 3, 7};

/// The mesh's vertices that triangles use, in order of first use.
Result<GlbPart> mesh_geometry(const TriangleMesh& mesh, const Vec3& origin, Progress* progress)
{
    StageSteps steps(progress, "collecting triangles", mesh.triangle_count());
    constexpr std::uint32_t unused = std::numeric_limits<std::uint32_t>::max();
    std::vector<std::uint32_t> number(mesh.vertex_count(), unused);
    GlbPart geometry;
    geometry.name = "mesh";
    geometry.colour = {0.8, 0.8, 0.78};
    for (const TriangleCorners& corners : mesh.triangles()) {
        for (const std::uint32_t corner : corners) {
            if (number[corner] == unused) {
                number[corner] = static_cast<std::uint32_t>(geometry.points.size());
                geometry.add_point(mesh.positions()[corner], origin);
            }
            geometry.indices.push_back(number[corner]);
        }
        if (!steps.done(1)) return cancelled("the export");
    }
    return geometry;
}

Result<GlbPart> box_geometry(const Octree& octree, const Vec3& origin, Progress* progress)
{
    const auto leaves = leaf_boxes(octree, LeafChoice::boundary, progress);
    if (!leaves) return tl::unexpected(leaves.error());
    const auto corners = LeafCorners::find(*leaves, progress);
    if (!corners) return tl::unexpected(corners.error());
    StageSteps steps(progress, "arranging boxes", corners->size() + 24 * leaves->size());
    GlbPart geometry;
    geometry.name = "boundary leaves";
    geometry.mode = GlbPart::Mode::lines;
    geometry.colour = {0.6, 0.1, 0.1};
    for (std::size_t i = 0; i < corners->size(); ++i) {
        geometry.add_point(corners->position(octree.frame(), octree.parameters().max_depth, i),
                           origin);
        if (!steps.done(1)) return cancelled("the export");
    }
    for (const LeafBox& leaf : *leaves) {
        for (const std::uint8_t corner : edges) {
            geometry.indices.push_back(static_cast<std::uint32_t>(corners->number(leaf, corner)));
        }
        if (!steps.done(24)) return cancelled("the export");
    }
    return geometry;
}

} // namespace

Status export_glb(const Octree& octree, const TriangleMesh& mesh, const std::filesystem::path& path,
                  const ExportOptions& options)
{
    const Vec3 origin = octree.box(octree.root()).center();
    auto surface = mesh_geometry(mesh, origin, options.execution.progress);
    if (!surface) return tl::unexpected(surface.error());
    auto boxes = box_geometry(octree, origin, options.execution.progress);
    if (!boxes) return tl::unexpected(boxes.error());
    return write_glb(std::array{std::move(*surface), std::move(*boxes)}, origin, path,
                     options.execution.progress);
}

} // namespace proxima
