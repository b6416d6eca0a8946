// Figures 5.2 and 5.4: what lies near a cursor, and where two meshes meet.
#include "proxima/execution.h"
#include "proxima/neighbourhood.h"
#include "proxima/octree.h"
#include "proxima/sample_meshes.h"
#include "thesis/proximity_octree/thesis_closest.h"
#include "viewer/figures/figure_colors.h"
#include "viewer/figures/query_figures.h"
#include "viewer/figures/scene_figure.h"
#include "viewer/query_shapes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/core.h>
#include <numbers>

namespace proxima {
namespace {

const OrbitCamera contact_camera = {.azimuth = 0.5, .elevation = 0.32};

/// A little above the middle of the triangle that faces the camera most, somewhat to the right.
Vec3 point_above_a_triangle(const TriangleMesh& mesh)
{
    constexpr double height = 0.17;
    const Vec3 wanted = Vec3(0.66, -0.58, 0.45).normalized();
    Vec3 best = Vec3::Zero();
    double nearest = -1.0;
    for (std::uint32_t i = 0; i < mesh.triangle_count(); ++i) {
        const Triangle triangle = mesh.triangle(TriangleId{i});
        const Vec3 normal = scaled_normal(triangle).stableNormalized();
        if (normal.dot(wanted) <= nearest) continue;
        nearest = normal.dot(wanted);
        best = (triangle[0] + triangle[1] + triangle[2]) / 3.0 + height * normal;
    }
    return best;
}

} // namespace

Result<TouchedFeature> touched_feature(const Execution& context)
{
    TriangleMesh mesh = make_sphere(20, 24);
    const auto topology = build_topology(mesh, {.execution = {.threads = context.threads}});
    if (!topology) return tl::unexpected(topology.error());
    const auto octree = build_thesis_proximity_octree(
        mesh, *topology,
        {.max_depth = 4, .thresholds = {4, 6, 6}, .execution = {.threads = context.threads}});
    if (!octree) return tl::unexpected(octree.error());
    const Vec3 cursor = point_above_a_triangle(mesh);
    const auto cell = octree->locate(cursor);
    const auto closest = closest_feature(*octree, mesh, *topology, cursor);
    if (!cell || !closest)
        return fail(ErrorCode::broken_invariant, "the cursor is not outside the sphere");
    NeighbourhoodScratch scratch(mesh);
    std::vector<TriangleId> rings(mesh.triangle_count());
    const auto near = collect_rings(mesh, *topology, closest->feature, 1, scratch, rings);
    rings.resize(near.written);
    std::erase(rings, closest->triangle);
    std::ranges::sort(rings);
    return TouchedFeature{std::move(mesh), cursor, *closest, std::move(rings), octree->box(*cell)};
}

Result<FigureContent> figure_5_2(const Execution& context)
{
    const auto touched = touched_feature(context);
    if (!touched) return tl::unexpected(touched.error());
    if (touched->closest.feature.kind != FeatureKind::face)
        return fail(ErrorCode::broken_invariant, "the cursor is not closest to a triangle");
    std::vector<TriangleId> marked = touched->around;
    marked.push_back(touched->closest.triangle);
    std::ranges::sort(marked);
    DrawnScene scene;
    add_part(scene, touched->mesh, all_but(touched->mesh, marked), {.name = "mesh"});
    add_part(scene, touched->mesh, touched->around,
             {.name = "around", .color = srgb(figure_colors::blue)});
    add_part(scene, touched->mesh, std::array{touched->closest.triangle},
             {.name = "closest", .color = srgb(figure_colors::red)});
    add_mesh_edges(scene, touched->mesh, {.color = srgb(0x8A8172), .width = 1.0, .opacity = 0.7F});
    add_box(scene, touched->leaf,
            {.name = "leaf", .color = srgb(figure_colors::green), .opacity = 0.22F});
    add_box_edges(scene, std::array{touched->leaf},
                  {.color = srgb(figure_colors::green), .width = 2.5});
    add_ball(scene, touched->cursor, 0.035, {.name = "cursor", .color = srgb(0x222222)});
    scene.lines.push_back(
        {"distance", {{touched->cursor, touched->closest.point}}, srgb(0x222222), 2.0});
    FigureContent content;
    content.caption = fmt::format(
        "A cursor (the ball) {:.4f} from the surface of a sphere of {} triangles: the feature "
        "closest to it, triangle {}, in red, the {} triangles adjacent to that in blue, and the "
        "leaf of the proximity octree that holds the cursor in green.",
        std::sqrt(touched->closest.squared_distance), touched->mesh.triangle_count(),
        touched->closest.feature.id, touched->around.size());
    content.panels.emplace_back(scene_panel("closest feature, its neighbours and the leaf",
                                            std::move(scene), contact_camera, single_panel));
    return content;
}

Result<MeetingSpheres> meeting_spheres(const Execution& context)
{
    TriangleMesh a = make_sphere(30, 30);
    const OctreeOptions options = {.max_depth = 4, .threshold = 4, .execution = context};
    auto octree = build_octree(a, options);
    if (!octree) return tl::unexpected(octree.error());
    RigidTransform pose;
    pose.rotation =
        Eigen::AngleAxisd(0.2 * std::numbers::pi, Vec3(1, 2, 0.5).normalized()).toRotationMatrix();
    pose.translation = Vec3(1.1, 0.55, 0.25);
    std::vector<Vec3> moved;
    for (const Vec3& position : a.positions()) moved.push_back(pose(position));
    auto b = make_triangle_mesh(std::move(moved), {a.triangles().begin(), a.triangles().end()});
    if (!b) return tl::unexpected(b.error());
    auto leaves = intersecting_leaves(*octree, *octree, pose);
    auto candidates = candidate_triangles(*octree, *octree, leaves, context.progress);
    if (!candidates) return tl::unexpected(candidates.error());
    return MeetingSpheres{std::move(a),      std::move(*b),         pose, *octree, *octree,
                          std::move(leaves), *std::move(candidates)};
}

Result<FigureContent> figure_5_4(const Execution& context)
{
    const auto spheres = meeting_spheres(context);
    if (!spheres) return tl::unexpected(spheres.error());
    DrawnScene scene;
    const Color yellow = srgb(0xF2C81E);
    constexpr float glass = 0.85F; // boxes are seen through it, whole
    const auto add_sphere = [&](const TriangleMesh& mesh, const std::vector<TriangleId>& marked,
                                unsigned color) {
        add_part(scene, mesh, all_but(mesh, marked),
                 {.name = "rest", .color = srgb(color), .opacity = glass});
        add_part(scene, mesh, marked, {.name = "candidates", .color = yellow, .opacity = glass});
        add_mesh_edges(scene, mesh, {.color = srgb(0x8A8172), .width = 0.8, .opacity = 0.5F});
    };
    add_sphere(spheres->a, spheres->candidates.a, 0xEBD9D5);
    add_sphere(spheres->b, spheres->candidates.b, 0xD6E6D6);
    const auto boxes_a = boxes_of_leaves(spheres->octree_a, spheres->leaves, &LeafPair::a);
    const auto boxes_b = boxes_of_leaves(spheres->octree_b, spheres->leaves, &LeafPair::b);
    add_box_edges(scene, boxes_a, {.name = "leaves of A", .color = srgb(0xC62828), .width = 1.4});
    add_box_edges(scene, boxes_b, {.name = "leaves of B", .color = srgb(0x2E7D32), .width = 1.4});
    for (auto& segment : scene.lines.back().segments)
        for (Vec3& end : segment) end = spheres->pose_b(end);
    FigureContent content;
    content.caption = fmt::format(
        "Two spheres of {} triangles each, the second turned and moved. Of their octrees {} leaves "
        "of the first (red) and {} of the second (green) meet; they hold {} and {} triangles "
        "(yellow), {:.0f} % of all: only these can intersect. The spheres are glass, so that boxes "
        "are seen whole.",
        spheres->a.triangle_count(), boxes_a.size(), boxes_b.size(), spheres->candidates.a.size(),
        spheres->candidates.b.size(),
        100.0 * static_cast<double>(spheres->candidates.a.size() + spheres->candidates.b.size()) /
            static_cast<double>(spheres->a.triangle_count() + spheres->b.triangle_count()));
    content.panels.emplace_back(scene_panel("leaves that meet and the triangles that they hold",
                                            std::move(scene), contact_camera, single_panel));
    return content;
}

} // namespace proxima
