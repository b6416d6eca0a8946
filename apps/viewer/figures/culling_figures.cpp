// Figures 5.7 and 5.8: culling by a view volume.
#include "proxima/cull.h"
#include "proxima/execution.h"
#include "proxima/mesh_repair.h"
#include "proxima/octree.h"
#include "proxima/sample_meshes.h"
#include "viewer/figures/figure_colors.h"
#include "viewer/figures/query_figures.h"
#include "viewer/figures/scene_figure.h"
#include "viewer/query_shapes.h"

#include <algorithm>
#include <array>
#include <fmt/core.h>
#include <numbers>

namespace proxima {
namespace {

DrawnScene culling_scene(const CulledShip& ship)
{
    DrawnScene scene;
    std::vector<TriangleId> hidden;
    for (std::uint32_t i = 0; i < ship.mesh.triangle_count(); ++i) {
        if (!std::ranges::binary_search(ship.triangles, TriangleId{i}))
            hidden.push_back(TriangleId{i});
    }
    if (!hidden.empty())
        add_mesh(scene, sub_mesh(ship.mesh, hidden), {.name = "culled", .color = srgb(0x8D99A8)});
    add_mesh(scene, sub_mesh(ship.mesh, ship.triangles),
             {.name = "visible", .color = srgb(0xF2D9A0)});
    std::vector<Box> boxes;
    for (const Cell& cell : ship.cells) boxes.push_back(ship.octree.box(cell));
    add_box_edges(scene, boxes,
                  {.name = "cells", .color = srgb(figure_colors::green), .opacity = 0.75F});
    add_frustum(scene, ship.camera,
                {.name = "frustum", .color = srgb(figure_colors::red), .width = 2.5});
    return scene;
}

std::string culling_words(const CulledShip& ship)
{
    return fmt::format(
        "A camera's volume (red) and a ship of {} triangles. {} leaves of its octree that hold "
        "triangles are not outside of the volume (green); they hold {} triangles (light), {:.0f} % "
        "of all, and only these need to be drawn.",
        ship.mesh.triangle_count(), ship.cells.size(), ship.triangles.size(),
        100.0 * static_cast<double>(ship.triangles.size()) /
            static_cast<double>(ship.mesh.triangle_count()));
}

} // namespace

Result<CulledShip> culled_ship(const Execution& context)
{
    auto mesh = make_spaceship(33000, {.execution = {.progress = context.progress}});
    if (!mesh) return tl::unexpected(mesh.error());
    auto octree = build_octree(*mesh, {.max_depth = 5, .threshold = 40, .execution = context});
    if (!octree) return tl::unexpected(octree.error());
    const PerspectiveCamera camera = {.eye = Vec3(0.6, -2.2, 0.9),
                                      .forward = Vec3(-0.12, 0.95, -0.33),
                                      .up = Vec3::UnitZ(),
                                      .field_of_view = 0.42,
                                      .aspect = 1.3,
                                      .near = 0.5,
                                      .far = 4.0};
    auto volume = make_perspective_volume(camera);
    if (!volume) return tl::unexpected(volume.error());
    CulledShip ship{std::move(*mesh), std::move(*octree), camera, std::move(*volume), {}, {}};
    for (const VisibleCell& visible : visible_cells(ship.octree, ship.volume)) {
        const auto held = ship.octree.triangles(visible.cell);
        if (held.empty()) continue;
        ship.cells.push_back(visible.cell);
        ship.triangles.insert(ship.triangles.end(), held.begin(), held.end());
    }
    std::ranges::sort(ship.triangles);
    ship.triangles.erase(std::unique(ship.triangles.begin(), ship.triangles.end()),
                         ship.triangles.end());
    return ship;
}

Result<FigureContent> figure_5_7(const Execution& context)
{
    const auto ship = culled_ship(context);
    if (!ship) return tl::unexpected(ship.error());
    FigureContent content;
    content.caption = culling_words(*ship);
    const OrbitCamera isometric = {.azimuth = 0.25 * std::numbers::pi, .elevation = 0.6155};
    content.panels.emplace_back(
        scene_panel(fmt::format("{} of {} triangles are left", ship->triangles.size(),
                                ship->mesh.triangle_count()),
                    culling_scene(*ship), isometric, single_panel));
    return content;
}

Result<FigureContent> figure_5_8(const Execution& context)
{
    const auto ship = culled_ship(context);
    if (!ship) return tl::unexpected(ship.error());
    FigureContent content;
    content.caption = culling_words(*ship) + " The same seen along the axes.";
    struct Side {
        const char* title;
        double azimuth;
        double elevation;
    };
    for (const auto& [title, azimuth, elevation] :
         {Side{"along y", 0.0, 0.0}, Side{"along x", 0.5 * std::numbers::pi, 0.0},
          Side{"along z, from above", 0.0, 0.5 * std::numbers::pi}}) {
        content.panels.emplace_back(scene_panel(title, culling_scene(*ship),
                                                {.azimuth = azimuth, .elevation = elevation},
                                                one_of_some));
    }
    return content;
}

} // namespace proxima
