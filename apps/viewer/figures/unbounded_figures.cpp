// Figures 4.7 to 4.9: Minkowski sums of unbounded Voronoi regions, cut, summed and opened again.
#include "proxima/convex_polyhedron.h"
#include "proxima/execution.h"
#include "thesis/minkowski_sums/planar_sum.h"
#include "thesis/proximity_octree/feature_regions.h"
#include "thesis/proximity_octree/unbounded_sum.h"
#include "viewer/figures/figure_colors.h"
#include "viewer/figures/minkowski_figures.h"
#include "viewer/figures/planar_panel.h"
#include "viewer/figures/scene_figure.h"
#include "viewer/figures/voronoi_figures.h"

#include <algorithm>
#include <array>
#include <fmt/core.h>

namespace proxima {
namespace {

using namespace figure_colors;

constexpr double square_half = 0.28;
constexpr double cut_length = 1.25;

Result<PlanarSum> cone_and_square()
{
    const std::array apex = {Vec2(0, 0)};
    const std::array rays = {Vec2(0.94, 0.35), Vec2(-0.25, 0.97)};
    const auto cone = convex_polygon(apex, rays);
    if (!cone) return tl::unexpected(cone.error());
    const std::array corners = {Vec2(-square_half, -square_half), Vec2(square_half, -square_half),
                                Vec2(square_half, square_half), Vec2(-square_half, square_half)};
    const auto square = convex_polygon(corners);
    if (!square) return tl::unexpected(square.error());
    return planar_sum(*cone, *square, {.cut_length = cut_length});
}

struct ConeDrawing {
    const PlanarSum& sum;
    PlanarPanel panel;

    void cone(bool unbounded)
    {
        const auto& corners = sum.a().corners;
        panel.fill(corners, blue_tint);
        panel.outline(corners, blue, 2.0);
        if (!unbounded) return;
        for (const std::size_t end : {std::size_t{1}, std::size_t{2}})
            panel.dashes(corners[end], 1.6 * corners[end], blue, 2.0);
    }
    void copies()
    {
        for (const Vec2& corner : sum.a().corners) {
            panel.fill_square(corner, square_half, yellow_tint);
            panel.square(corner, square_half, yellow, 1.5);
        }
    }
    void rays()
    {
        const auto& corners = sum.a().corners;
        for (const std::size_t end : {std::size_t{1}, std::size_t{2}}) {
            panel.arrow(corners[end], corners[end] + 0.62 * corners[end].normalized(), yellow, 3.5);
        }
    }
};

bool obstructs(const PushedLine& line)
{
    return line.spans_edge && line.edge < 0;
}

/// A pyramid's feature of each kind.
struct NamedFeature {
    Feature feature;
    const char* name;
    double length; ///< at which its region is cut
};

Result<std::array<NamedFeature, 3>> pyramid_features(const Topology& topology)
{
    const EdgeId edge = topology.find_edge(VertexId{1}, VertexId{4});
    return std::array{NamedFeature{{FeatureKind::face, 0}, "face", 1.0},
                      NamedFeature{{FeatureKind::edge, to_index(edge)}, "edge", 1.0},
                      NamedFeature{{FeatureKind::vertex, 4}, "vertex", 1.0}};
}

constexpr double cube_half = 0.22;
const OrbitCamera cut_camera = {.azimuth = 0.62, .elevation = 0.28};

/// Facets in different planes: where the cut's corners were rounded, one plane may come in pieces.
std::size_t planes_of(const MinkowskiSum& sum, std::span<const std::uint32_t> facets)
{
    std::vector<HalfSpace> planes;
    for (const std::uint32_t facet : facets) {
        const HalfSpace plane = sum.half_space(facet);
        const bool known = std::ranges::any_of(planes, [&](const HalfSpace& other) {
            return (plane.normal - other.normal).norm() < 1e-9;
        });
        if (!known) planes.push_back(plane);
    }
    return planes.size();
}

Box cube_at(const Vec3& center)
{
    return {center - Vec3::Constant(cube_half), center + Vec3::Constant(cube_half)};
}

} // namespace

Result<FigureContent> figure_4_7(const Execution& /*context*/)
{
    const auto sum = cone_and_square();
    if (!sum) return tl::unexpected(sum.error());
    Figure figure{.width = 1240, .height = 1120};
    const PlanarBox shown(Vec2(-1.1, -0.6), Vec2(2.3, 2.15));
    const std::array titles = {"(a) the region, cut", "(b) squares at its corners, and their sum",
                               "(c) edges that obstruct the rays", "(d) the unbounded sum"};
    std::size_t removed = 0;
    for (std::size_t i = 0; i < titles.size(); ++i) {
        const std::size_t row = i / 2;
        const double left = 20.0 + 610.0 * static_cast<double>(i % 2);
        const double top = 55.0 + 550.0 * static_cast<double>(row);
        ConeDrawing drawing = {*sum,
                               {figure, {Vec2(left, top), Vec2(left + 590, top + 490)}, shown}};
        PlanarPanel& panel = drawing.panel;
        panel.title(titles[i]);
        drawing.cone(i == 0);
        if (i > 0) drawing.copies();
        if (i > 0) panel.outline(sum->a().corners, blue, 1.5);
        for (const PushedLine& line : sum->lines()) {
            if (i == 0 || i == 3 || !line.spans_edge) continue;
            const auto ends = end_points(*sum, line);
            const Vec2& from = sum->points()[static_cast<std::size_t>(ends[0])];
            const Vec2& to = sum->points()[static_cast<std::size_t>(ends[1])];
            const bool red_one = i == 2 && obstructs(line);
            panel.line(from, to, red_one ? red : ink, red_one ? 4.5 : 3.0);
            if (!red_one) continue;
            ++removed;
            const Vec2 middle = 0.5 * (from + to);
            panel.arrow(middle, middle + 0.4 * line.normal, red, 3.0);
        }
        if (i >= 2) drawing.rays();
        if (i < 3) continue;
        for (const PlanarEdge& edge : sum->edges()) {
            const Vec2& from = sum->points()[static_cast<std::size_t>(edge.from)];
            const Vec2& to = sum->points()[static_cast<std::size_t>(edge.to)];
            const Vec2 along = Vec2(-edge.normal.y(), edge.normal.x());
            if (edge.from_infinity) panel.dashes(from, from - 0.7 * along, ink, 3.0);
            if (edge.to_infinity) panel.dashes(to, to + 0.7 * along, ink, 3.0);
            panel.line(from, to, ink, 4.0);
        }
    }
    FigureContent content;
    content.caption = fmt::format(
        "The Minkowski sum of an unbounded Voronoi region and a square. (a) The region of a corner "
        "is cut off; (b) the sum of what is left and the square has {} edges; (c) {} of them, red "
        "with their normals, lead along a ray (yellow) and obstruct it; (d) without them {} are "
        "left. Where the cut was does not matter.",
        std::ranges::count_if(sum->lines(), &PushedLine::spans_edge), removed, sum->edges().size());
    content.drawing = std::move(figure);
    return content;
}

Result<FigureContent> figure_4_8(const Execution& /*context*/)
{
    const TriangleMesh mesh = make_pyramid();
    const auto topology = build_topology(mesh);
    if (!topology) return tl::unexpected(topology.error());
    const auto features = pyramid_features(*topology);
    FigureContent content;
    content.caption = "The Voronoi regions of a face, an edge and a vertex of the pyramid, cut "
                      "off, with a copy of the cell at each of their corners:";
    for (const NamedFeature& shown : *features) {
        const auto region = voronoi_region_of(mesh, *topology, shown.feature);
        if (!region) return tl::unexpected(region.error());
        const auto cut = cut_rays(*region, shown.length);
        if (!cut) return tl::unexpected(cut.error());
        DrawnScene scene;
        Status status = add_polyhedron(
            scene, *cut, Vec3::Zero(),
            {.name = "region", .color = color_of(FacetOrigin::a), .opacity = 0.6F}, thin_edges);
        if (!status) return tl::unexpected(status.error());
        std::vector<Box> copies;
        for (const Vec3& corner : cut->points()) copies.push_back(cube_at(corner));
        for (const Box& copy : copies) {
            add_box(scene, copy,
                    {.name = "copy", .color = color_of(FacetOrigin::b), .opacity = 0.5F});
        }
        add_box_edges(scene, copies, thin_edges);
        content.caption += fmt::format(" {}: {} copies.", shown.name, copies.size());
        content.panels.emplace_back(scene_panel(fmt::format("region of the {}", shown.name),
                                                std::move(scene), cut_camera, one_of_some));
    }
    return content;
}

Result<FigureContent> figure_4_9(const Execution& /*context*/)
{
    const TriangleMesh mesh = make_pyramid();
    const auto topology = build_topology(mesh);
    if (!topology) return tl::unexpected(topology.error());
    const auto features = pyramid_features(*topology);
    const auto cube = polyhedron_of_box(cube_at(Vec3::Zero()));
    if (!cube) return tl::unexpected(cube.error());
    FigureContent content;
    content.caption = "The sums of cut regions and cell. Red: facets that a ray (yellow) leads "
                      "through, with their normals; without them the sum is the unbounded one.";
    for (const NamedFeature& shown : *features) {
        const auto region = voronoi_region_of(mesh, *topology, shown.feature);
        if (!region) return tl::unexpected(region.error());
        const auto sum = sum_by_cutting(*region, *cube, shown.length);
        if (!sum) return tl::unexpected(sum.error());
        const auto direct = minkowski_sum(*region, *cube);
        if (!direct) return tl::unexpected(direct.error());
        const auto surface = draw(sum->intermediate);
        if (!surface) return tl::unexpected(surface.error());
        DrawnScene scene;
        add_polygons(scene, *surface, sum->remaining,
                     {.name = "remaining", .color = srgb(0xC9D3E2)});
        add_polygons(scene, *surface, sum->obstructing,
                     {.name = "obstructing", .color = srgb(0xF0A9A6)});
        add_polygon_edges(scene, *surface, first_numbers(surface->polygon_count()), thin_edges);
        add_normals(scene, sum->intermediate, *surface, sum->obstructing, 0.45,
                    {.name = "normal", .color = srgb(red)});
        for (const PolyhedronEdge& edge : region->edges()) {
            if (!region->is_ray(edge.to)) continue;
            const Vec3 along = region->vertex(edge.to).stableNormalized();
            const Vec3 from = region->vertex(edge.from) + shown.length * along;
            add_arrow(scene, from, from + 0.85 * along, 0.03,
                      {.name = "ray", .color = srgb(yellow)});
        }
        content.panels.emplace_back(
            scene_panel(fmt::format("{}: {} of {} facets obstruct", shown.name,
                                    sum->obstructing.size(), sum->intermediate.facet_count()),
                        std::move(scene), cut_camera, one_of_some));
        content.caption +=
            fmt::format(" {}: {} facets, {} obstruct, {} in {} planes remain; the "
                        "sum by rays, without a cut, has {}.",
                        shown.name, sum->intermediate.facet_count(), sum->obstructing.size(),
                        sum->remaining.size(), planes_of(sum->intermediate, sum->remaining),
                        direct->facet_count());
    }
    return content;
}

} // namespace proxima
