#include "viewer/figures/ray_figures.h"

#include "proxima/execution.h"
#include "proxima/mesh_repair.h"
#include "proxima/octree.h"
#include "proxima/sample_meshes.h"
#include "viewer/figures/figure_colors.h"
#include "viewer/figures/scene_figure.h"
#include "viewer/query_shapes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/core.h>

namespace proxima {
namespace {

const OrbitCamera ray_camera = {.azimuth = 0.5, .elevation = 0.34};

Result<LitCells> lit_cells(TriangleMesh mesh, const Ray& ray, const OctreeOptions& options)
{
    auto octree = build_octree(mesh, options);
    if (!octree) return tl::unexpected(octree.error());
    auto cells = cells_along_ray(*octree, ray);
    return LitCells{std::move(mesh), std::move(*octree), ray, std::move(cells)};
}

/// The part of the mesh behind the ray, seen by the camera: in front of it the cells are.
TriangleMesh far_half(const TriangleMesh& mesh, const Ray& ray)
{
    const Vec3 along = ray.direction.stableNormalized();
    const Vec3 to_eye = Vec3(std::sin(ray_camera.azimuth), -std::cos(ray_camera.azimuth), 0);
    const Vec3 across = to_eye - to_eye.dot(along) * along;
    std::vector<TriangleId> kept;
    for (std::uint32_t i = 0; i < mesh.triangle_count(); ++i) {
        const Triangle triangle = mesh.triangle(TriangleId{i});
        const Vec3 middle = (triangle[0] + triangle[1] + triangle[2]) / 3.0;
        if (across.dot(middle - ray.origin) < 0.0) kept.push_back(TriangleId{i});
    }
    return sub_mesh(mesh, kept);
}

template <class Weight>
ScenePanel lit_panel(std::string title, const LitCells& lit, const Weight& weight, ViewSize size)
{
    DrawnScene scene;
    const TriangleMesh shell = far_half(lit.mesh, lit.ray);
    add_mesh(scene, shell, {.name = "mesh", .color = srgb(0xB9C6D6)});
    add_mesh_edges(scene, shell, {.color = srgb(0x8FA0B4), .width = 0.8});
    const Cell root = lit.octree.root();
    add_box_edges(scene, std::array{lit.octree.box(root)}, {.color = srgb(0x6B7785), .width = 1.2});
    std::vector<Box> boxes;
    for (const CellOnRay& at : lit.cells) {
        const Box box = lit.octree.box(at.cell);
        boxes.push_back(box);
        add_box(scene, box,
                {.name = "cell", .color = intensity_color(weight(at)), .lighting = Lighting::flat});
    }
    add_box_edges(scene, boxes, {.color = srgb(0x7A7A7A), .width = 1.4});
    const Vec3 along = lit.ray.direction.stableNormalized();
    const double enter = lit.cells.front().enter * lit.ray.direction.norm();
    const double exit = lit.cells.back().exit * lit.ray.direction.norm();
    const auto at = [&](double length) -> Vec3 { return lit.ray.origin + length * along; };
    const ShapeStyle arrow = {.name = "ray", .color = srgb(figure_colors::red)};
    add_arrow(scene, at(enter - 0.75), at(enter - 0.01), 0.022, arrow);
    add_arrow(scene, at(exit + 0.01), at(exit + 0.55), 0.022, arrow);
    return scene_panel(std::move(title), std::move(scene), ray_camera, size);
}

} // namespace

Result<LitCells> fully_lit_cells(const Execution& context)
{
    // Depth 3: eight cells across [-1, 1]; the ray runs through the middle of a column.
    const Ray ray = {.origin = Vec3(-3, -0.375, 0.125), .direction = Vec3(1, 0, 0)};
    return lit_cells(make_icosphere(3), ray,
                     {.max_depth = 3,
                      .subdivision = Subdivision::uniform,
                      .root = OctreeFrame{Vec3::Constant(-1), Vec3::Constant(2)},
                      .execution = context});
}

Result<LitCells> variously_lit_cells(const Execution& context)
{
    const Ray ray = {.origin = Vec3(-2.738, -1.524, 0.298), .direction = Vec3(1, 0.49, -0.189)};
    return lit_cells(make_icosphere(3), ray,
                     {.max_depth = 4,
                      .threshold = 4,
                      .root = OctreeFrame{Vec3::Constant(-1), Vec3::Constant(2)},
                      .execution = context});
}

Result<FigureContent> figure_5_5(const Execution& context)
{
    const auto lit = fully_lit_cells(context);
    if (!lit) return tl::unexpected(lit.error());
    const auto weight = [](const CellOnRay& at) { return at.penetration; };
    const auto [least, most] = std::ranges::minmax(lit->cells, {}, weight);
    FigureContent content;
    content.caption = fmt::format(
        "A ray along an axis goes through the middle of the {} cells that it meets in a uniform "
        "octree of depth {}: all have the full weight (penetration from {:.3f} to {:.3f}) and are "
        "bright. Behind them the far part of the sphere of {} triangles.",
        lit->cells.size(), lit->octree.parameters().max_depth, least.penetration, most.penetration,
        lit->mesh.triangle_count());
    content.panels.emplace_back(lit_panel(fmt::format("{} cells of full weight", lit->cells.size()),
                                          *lit, weight, single_panel));
    return content;
}

Result<FigureContent> figure_5_6(const Execution& context)
{
    const auto lit = variously_lit_cells(context);
    if (!lit) return tl::unexpected(lit.error());
    const auto penetration = [](const CellOnRay& at) { return at.penetration; };
    const double longest =
        std::ranges::max(lit->cells, {}, [](const CellOnRay& at) { return at.chord; }).chord;
    const auto chord = [&](const CellOnRay& at) { return at.chord / longest; };
    const auto by_depth = std::ranges::minmax(lit->cells, {}, penetration);
    const auto by_chord = std::ranges::minmax(lit->cells, {}, chord);
    FigureContent content;
    content.columns = 2;
    content.caption = fmt::format(
        "A slanted ray meets {} leaves of an adaptive octree. Left, the thesis's weight: how deep "
        "the ray goes into a cell, over the most possible, from {:.3f} (black: it passes along the "
        "border) to {:.3f} (yellow). Right, the chord: the ray's length in the cell over that in "
        "the cell where it is longest, from {:.3f} to 1. It tells large cells from small ones, the "
        "thesis's weight does not: it tells where in a cell the ray is.",
        lit->cells.size(), by_depth.min.penetration, by_depth.max.penetration, chord(by_chord.min));
    constexpr ViewSize size = {.width = 760, .height = 660};
    content.panels.emplace_back(
        lit_panel(fmt::format("{} cells by penetration: black 0, yellow 1", lit->cells.size()),
                  *lit, penetration, size));
    content.panels.emplace_back(
        lit_panel(fmt::format("the same cells by chord: black 0, yellow {:.2f}", longest), *lit,
                  chord, size));
    return content;
}

} // namespace proxima
