#include "cli/intersection_picture.h"

#include "base/progress.h"
#include "cli/canvas.h"
#include "cli/picture_scene.h"

#include <algorithm>
#include <array>

namespace proxima {

namespace {

using Corners = std::array<Vec3, 8>; // bits of the number: x, y, z

Corners corners_of(const Box& box, const RigidTransform& pose)
{
    Corners corners;
    for (unsigned bits = 0; bits < 8; ++bits) {
        corners[bits] = pose(Vec3((bits & 1U) != 0 ? box.upper.x() : box.lower.x(),
                                  (bits & 2U) != 0 ? box.upper.y() : box.lower.y(),
                                  (bits & 4U) != 0 ? box.upper.z() : box.lower.z()));
    }
    return corners;
}

/// Whether the eye sees the side of the box across an axis, the lower or the upper one.
bool is_seen(const Corners& corners, unsigned axis, bool upper, const Vec3& eye)
{
    const Vec3& at = corners[upper ? 1U << axis : 0U];
    const Vec3 outward = corners[1U << axis] - corners[0];
    return (eye - at).dot(upper ? outward : Vec3(-outward)) > 0;
}

void draw_box(Canvas& canvas, const Camera& camera, const Corners& corners, const Color& color)
{
    constexpr LineStyle style{.width = 1.4, .opacity = 0.8F, .lift = 2e-3};
    for (unsigned axis = 0; axis < 3; ++axis) {
        const unsigned b = (axis + 1) % 3;
        const unsigned c = (axis + 2) % 3;
        for (const bool upper_b : {false, true}) {
            for (const bool upper_c : {false, true}) {
                if (!is_seen(corners, b, upper_b, camera.eye()) &&
                    !is_seen(corners, c, upper_c, camera.eye()))
                    continue;
                const unsigned bits = (upper_b ? 1U << b : 0U) | (upper_c ? 1U << c : 0U);
                canvas.draw_line(camera.project(corners[bits]),
                                 camera.project(corners[bits | 1U << axis]), color, style);
            }
        }
    }
}

void hide_lines_behind(Canvas& canvas, const Camera& camera, const Corners& corners)
{
    for (unsigned axis = 0; axis < 3; ++axis) {
        const unsigned b = 1U << (axis + 1) % 3;
        const unsigned c = 1U << (axis + 2) % 3;
        for (const bool upper : {false, true}) {
            if (!is_seen(corners, axis, upper, camera.eye())) continue;
            const unsigned fixed = upper ? 1U << axis : 0U;
            const auto at = [&](unsigned bits) { return camera.project(corners[fixed | bits]); };
            canvas.hide_lines_behind({at(0), at(b), at(b | c)});
            canvas.hide_lines_behind({at(0), at(b | c), at(c)});
        }
    }
}

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
        return std::ranges::binary_search(marked, id) ? srgb(0xF2C81E) : plain;
    };
}

/// The boxes of one octree's leaves, each once.
std::vector<Corners> boxes_of(const Octree& octree, const std::vector<LeafPair>& pairs,
                              Cell LeafPair::*side, const RigidTransform& pose)
{
    std::vector<Cell> cells;
    cells.reserve(pairs.size());
    for (const LeafPair& pair : pairs) cells.push_back(pair.*side);
    std::ranges::sort(cells, {}, &Cell::key);
    const auto are_same = [](const Cell& one, const Cell& other) { return one.key == other.key; };
    cells.erase(std::unique(cells.begin(), cells.end(), are_same), cells.end());
    std::vector<Corners> boxes;
    boxes.reserve(cells.size());
    for (const Cell& cell : cells) boxes.push_back(corners_of(octree.box(cell), pose));
    return boxes;
}

void draw_contour(Canvas& canvas, const Camera& camera, const IntersectionContour& contour)
{
    constexpr LineStyle style{.width = 4.0, .opacity = 1.0F, .lift = 6e-3};
    for (const ContourLine& line : contour.lines) {
        const auto along = contour.points_of(line);
        for (std::size_t i = line.closed ? 0 : 1; i < along.size(); ++i) {
            const Vec3& before = along[(i + along.size() - 1) % along.size()].position;
            canvas.draw_line(camera.project(before), camera.project(along[i].position),
                             srgb(0x102A6B), style);
        }
    }
}

} // namespace

Result<Image> draw_intersection(const IntersectionScene& scene, const PictureOptions& options)
{
    Canvas canvas(options.width, options.height, options.execution.progress);
    canvas.fill_background(srgb(0xFBFCFE), srgb(0xE3E8EF));
    const TriangleMesh mesh_b = moved(scene.mesh_b, scene.pose_b);
    const std::vector<Corners> boxes_a = boxes_of(scene.octree_a, scene.leaves, &LeafPair::a, {});
    const std::vector<Corners> boxes_b =
        boxes_of(scene.octree_b, scene.leaves, &LeafPair::b, scene.pose_b);

    Box shown = bounding_box(scene.mesh_a);
    const Box box_b = bounding_box(mesh_b);
    shown.extend(box_b.lower);
    shown.extend(box_b.upper);
    Camera camera(shown, options.up);
    std::vector<Vec3> seen(scene.mesh_a.positions().begin(), scene.mesh_a.positions().end());
    seen.insert(seen.end(), mesh_b.positions().begin(), mesh_b.positions().end());
    camera.fit(seen, options.width, options.height);

    const CandidateTriangles candidates =
        candidate_triangles(scene.octree_a, scene.octree_b, scene.leaves);
    draw_mesh(canvas, camera, scene.mesh_a, marking(candidates.a, srgb(0xEBD9D5)),
              options.execution.progress);
    draw_mesh(canvas, camera, mesh_b, marking(candidates.b, srgb(0xD6E6D6)),
              options.execution.progress);
    canvas.darken_creases(14.0, 0.45F);
    draw_contour(canvas, camera, scene.contour);
    for (const auto* boxes : {&boxes_a, &boxes_b}) {
        for (const Corners& box : *boxes) hide_lines_behind(canvas, camera, box);
    }
    for (const Corners& box : boxes_a) draw_box(canvas, camera, box, srgb(0xC62828));
    for (const Corners& box : boxes_b) draw_box(canvas, camera, box, srgb(0x2E7D32));
    Image image = canvas.image();
    if (is_cancelled(options.execution.progress)) return cancelled("drawing");
    return image;
}

} // namespace proxima
