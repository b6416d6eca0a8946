// Figures 3.7 to 3.11: the Minkowski sum of a cube and an octahedron, facets by where they come
// from.
#include "proxima/convex_polyhedron.h"
#include "proxima/execution.h"
#include "proxima/sample_meshes.h"
#include "viewer/figures/figure_colors.h"
#include "viewer/figures/minkowski_figures.h"
#include "viewer/figures/scene_figure.h"
#include "viewer/query_shapes.h"

#include <array>
#include <fmt/core.h>

namespace proxima {
namespace {

constexpr double octahedron_size = 0.55; // the cube's half edge is 1
const OrbitCamera sum_camera = {.azimuth = 0.55, .elevation = 0.42};

/// A copy of B at each corner of A.
Status add_copies(DrawnScene& scene, const MinkowskiSum& sum, float opacity)
{
    for (const Vec3& corner : sum.a().points()) {
        Status status = add_polyhedron(
            scene, sum.b(), corner,
            {.name = "copy of B", .color = color_of(FacetOrigin::b), .opacity = opacity},
            {.color = srgb(0x24406F), .width = 1.5, .opacity = opacity});
        if (!status) return status;
    }
    return {};
}

Result<FigureContent> origin_figure(FacetOrigin origin, const char* words)
{
    const auto sum = explained_sum();
    if (!sum) return tl::unexpected(sum.error());
    const auto surface = draw(*sum);
    if (!surface) return tl::unexpected(surface.error());
    DrawnScene scene;
    if (Status status = add_copies(scene, *sum, 0.22F); !status)
        return tl::unexpected(status.error());
    const auto all = first_numbers(surface->polygon_count());
    const auto facets = facets_of(*sum, origin);
    add_polygon_edges(scene, *surface, all, {.color = srgb(0x9AA3AF), .width = 1.0});
    add_polygons(scene, *surface, facets, {.name = "facets", .color = color_of(origin)});
    add_polygon_edges(scene, *surface, facets, thin_edges);
    add_normals(scene, *sum, *surface, facets, 0.5, {.name = "normal", .color = color_of(origin)});
    FigureContent content;
    content.caption = fmt::format("The {} of the {} facets of the sum that {}, with their normals.",
                                  facets.size(), sum->facet_count(), words);
    content.panels.emplace_back(scene_panel(fmt::format("{} facets that {}", facets.size(), words),
                                            std::move(scene), sum_camera, single_panel));
    return content;
}

} // namespace

Result<MinkowskiSum> explained_sum()
{
    const auto cube = polyhedron_of_mesh(make_cube());
    if (!cube) return tl::unexpected(cube.error());
    const TriangleMesh unit = make_octahedron();
    std::vector<Vec3> corners;
    for (const Vec3& position : unit.positions()) corners.emplace_back(octahedron_size * position);
    const auto octahedron = convex_hull(corners);
    if (!octahedron) return tl::unexpected(octahedron.error());
    return minkowski_sum(*cube, *octahedron);
}

Result<FigureContent> figure_3_7(const Execution& /*context*/)
{
    const auto sum = explained_sum();
    if (!sum) return tl::unexpected(sum.error());
    DrawnScene scene;
    Status status = add_polyhedron(scene, sum->a(), Vec3::Zero(),
                                   {.name = "A", .color = color_of(FacetOrigin::a)}, thin_edges);
    if (status) status = add_copies(scene, *sum, 1.0F);
    if (!status) return tl::unexpected(status.error());
    const std::size_t copies = sum->a().points().size();
    FigureContent content;
    content.caption = fmt::format(
        "A copy of the octahedron B (blue) at each of the {} corners of the cube A (red): {} x {} "
        "= {} points, whose convex hull is the sum.",
        copies, copies, sum->b().points().size(), copies * sum->b().points().size());
    content.panels.emplace_back(
        scene_panel("A (red) and copies of B (blue)", std::move(scene), sum_camera, single_panel));
    return content;
}

Result<FigureContent> figure_3_8(const Execution& /*context*/)
{
    return origin_figure(FacetOrigin::a, "are parallel to facets of the cube A");
}

Result<FigureContent> figure_3_9(const Execution& /*context*/)
{
    return origin_figure(FacetOrigin::b, "are parallel to facets of the octahedron B");
}

Result<FigureContent> figure_3_10(const Execution& /*context*/)
{
    return origin_figure(FacetOrigin::swept, "edges of B sweep out along edges of A");
}

Result<FigureContent> figure_3_11(const Execution& /*context*/)
{
    const auto sum = explained_sum();
    if (!sum) return tl::unexpected(sum.error());
    const auto surface = draw(*sum);
    if (!surface) return tl::unexpected(surface.error());
    DrawnScene scene;
    std::array<std::size_t, 4> counts = {};
    for (const FacetOrigin origin :
         {FacetOrigin::a, FacetOrigin::b, FacetOrigin::both, FacetOrigin::swept}) {
        const auto facets = facets_of(*sum, origin);
        counts[static_cast<std::size_t>(origin)] = facets.size();
        if (facets.empty()) continue;
        add_polygons(scene, *surface, facets, {.name = "facets", .color = color_of(origin)});
        add_polygon_edges(scene, *surface, facets, thin_edges);
        add_normals(scene, *sum, *surface, facets, 0.5,
                    {.name = "normal", .color = color_of(origin)});
    }
    FigureContent content;
    content.caption = fmt::format(
        "The whole Minkowski sum: {} facets, {} with normals of A (red), {} of B (blue) and {} "
        "swept by an edge of B along one of A (green); {} corners of the {} points are left.",
        sum->facet_count(), counts[0], counts[1], counts[3], sum->point_count(),
        sum->a().points().size() * sum->b().points().size());
    content.panels.emplace_back(scene_panel("A + B", std::move(scene), sum_camera, single_panel));
    return content;
}

} // namespace proxima
