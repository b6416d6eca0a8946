#include "cli/intersection_picture.h"

#include "base/progress.h"
#include "cli/canvas.h"
#include "cli/legend.h"
#include "cli/picture_scene.h"

#include <algorithm>
#include <array>

namespace proxima {

namespace {

BoxCorners corners_of(const Box& box, const RigidTransform& pose)
{
    BoxCorners moved = corners(box);
    for (Vec3& corner : moved) corner = pose(corner);
    return moved;
}

constexpr unsigned a_color = 0xC62828;
constexpr unsigned b_color = 0x2E7D32;
constexpr unsigned triangle_color = 0xF2C81E;
constexpr unsigned contour_color = 0x102A6B;

TriangleMesh moved(const TriangleMesh& mesh, const RigidTransform& pose)
{
    std::vector<Vec3> positions;
    positions.reserve(mesh.vertex_count());
    for (const Vec3& position : mesh.positions()) positions.push_back(pose(position));
    return make_triangle_mesh(std::move(positions),
                              {mesh.triangles().begin(), mesh.triangles().end()})
        .value();
}

/// Yellow for these triangles, else the mesh's own colour.
SurfaceColor marking(const std::vector<TriangleId>& marked, const Color& plain)
{
    return [&marked, plain](TriangleId id) {
        return std::ranges::binary_search(marked, id) ? srgb(triangle_color) : plain;
    };
}

/// The boxes of one octree's leaves, each once.
std::vector<BoxCorners> boxes_of(const Octree& octree, const std::vector<LeafPair>& pairs,
                                 Cell LeafPair::*side, const RigidTransform& pose)
{
    std::vector<Cell> cells;
    cells.reserve(pairs.size());
    for (const LeafPair& pair : pairs) cells.push_back(pair.*side);
    std::ranges::sort(cells, {}, &Cell::key);
    const auto are_same = [](const Cell& one, const Cell& other) { return one.key == other.key; };
    cells.erase(std::unique(cells.begin(), cells.end(), are_same), cells.end());
    std::vector<BoxCorners> boxes;
    boxes.reserve(cells.size());
    for (const Cell& cell : cells) boxes.push_back(corners_of(octree.box(cell), pose));
    return boxes;
}

void draw_contour(Canvas& canvas, const View& view, const IntersectionContour& contour)
{
    constexpr LineStyle style{.width = 4.0, .opacity = 1.0F, .lift = 6e-3};
    for (const ContourLine& line : contour.lines) {
        const auto along = contour.points_of(line);
        for (std::size_t i = line.closed ? 0 : 1; i < along.size(); ++i) {
            const Vec3& before = along[(i + along.size() - 1) % along.size()].position;
            draw_segment(canvas, view, before, along[i].position, srgb(contour_color), style);
        }
    }
}

Legend legend_of(const IntersectionScene& scene)
{
    if (scene.leaves.empty()) return {};
    Legend legend;
    legend.entries = {{a_color, "leaves of A that meet B's"},
                      {b_color, "leaves of B that meet A's"},
                      {triangle_color, "triangles in them"}};
    if (!scene.contour.lines.empty()) legend.entries.push_back({contour_color, "contour"});
    return legend;
}

} // namespace

Result<Image> draw_intersection(const IntersectionScene& scene, const PictureOptions& options)
{
    const ViewSize size = options.view.size;
    auto drawn = make_canvas(size.width, size.height, {srgb(0xFBFCFE), srgb(0xE3E8EF)},
                             options.execution.progress, options.execution.budget);
    if (!drawn) return tl::unexpected(drawn.error());
    Canvas& canvas = *drawn;
    const TriangleMesh mesh_b = moved(scene.mesh_b, scene.pose_b);
    const std::vector<BoxCorners> boxes_a =
        boxes_of(scene.octree_a, scene.leaves, &LeafPair::a, {});
    const std::vector<BoxCorners> boxes_b =
        boxes_of(scene.octree_b, scene.leaves, &LeafPair::b, scene.pose_b);

    std::vector<Vec3> seen = points_to_frame(scene.mesh_a);
    for (const Vec3& point : points_to_frame(mesh_b)) seen.push_back(point);
    const auto camera = placed_camera(options.view, seen);
    if (!camera) return tl::unexpected(camera.error());
    const View view(*camera, size);

    const auto candidates = candidate_triangles(scene.octree_a, scene.octree_b, scene.leaves,
                                                options.execution.progress);
    if (!candidates) return tl::unexpected(candidates.error());
    draw_mesh(canvas, view, scene.mesh_a, marking(candidates->a, srgb(0xEBD9D5)),
              options.execution.progress);
    draw_mesh(canvas, view, mesh_b, marking(candidates->b, srgb(0xD6E6D6)),
              options.execution.progress);
    canvas.darken_creases(14.0, 0.45F);
    draw_contour(canvas, view, scene.contour);
    for (const auto* boxes : {&boxes_a, &boxes_b}) {
        for (const BoxCorners& box : *boxes) hide_lines_behind(canvas, view, box);
    }
    constexpr LineStyle edges{.width = 1.4, .opacity = 0.8F, .lift = 2e-3};
    for (const BoxCorners& box : boxes_a) draw_box_edges(canvas, view, box, srgb(a_color), edges);
    for (const BoxCorners& box : boxes_b) draw_box_edges(canvas, view, box, srgb(b_color), edges);
    Image image = canvas.image();
    if (is_cancelled(options.execution.progress)) return cancelled("drawing");
    if (options.with_legend) draw_legend(image, legend_of(scene));
    return image;
}

} // namespace proxima
