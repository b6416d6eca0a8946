// Figures 4.3 to 4.6: Voronoi regions of the features of convex bodies.
#include "viewer/figures/voronoi_figures.h"

#include "proxima/execution.h"
#include "proxima/sample_meshes.h"
#include "thesis/proximity_octree/feature_regions.h"
#include "viewer/figures/figure_colors.h"
#include "viewer/figures/scene_figure.h"
#include "viewer/query_shapes.h"

#include <array>
#include <fmt/core.h>

namespace proxima {
namespace {

const OrbitCamera region_camera = {.azimuth = 0.62, .elevation = 0.32};

Color color_of(FeatureKind kind)
{
    return kind == FeatureKind::vertex ? srgb(0x4A7FD0)
           : kind == FeatureKind::edge ? srgb(0x57B57A)
                                       : srgb(0xEBC23B);
}

const char* name_of(FeatureKind kind)
{
    return kind == FeatureKind::vertex ? "vertex" : kind == FeatureKind::edge ? "edge" : "face";
}

/// The facets of a region that bound it to the side, all but the feature itself.
std::vector<std::uint32_t> side_facets(const ConvexPolyhedron& region)
{
    std::vector<std::uint32_t> sides;
    for (std::uint32_t f = 0; f < region.facet_count(); ++f) {
        for (const std::uint32_t vertex : region.facet_loop(f)) {
            if (!region.is_ray(vertex)) continue;
            sides.push_back(f);
            break;
        }
    }
    return sides;
}

/// The pyramid, one feature's region, the normals of its planes and its rays.
Result<FigureContent> pyramid_figure(Feature feature, const char* words, const OrbitCamera& camera)
{
    constexpr double length = 1.1;
    const TriangleMesh mesh = make_pyramid();
    const auto topology = build_topology(mesh);
    if (!topology) return tl::unexpected(topology.error());
    const auto region = voronoi_region_of(mesh, *topology, feature);
    if (!region) return tl::unexpected(region.error());
    const auto surface = draw(*region, length);
    if (!surface) return tl::unexpected(surface.error());
    DrawnScene scene;
    std::vector<TriangleId> marked;
    if (feature.kind == FeatureKind::face) marked.push_back(TriangleId{feature.id});
    add_part(scene, mesh, all_but(mesh, marked), {.name = "pyramid"});
    add_mesh_edges(scene, mesh, thin_edges);
    const auto sides = side_facets(*region);
    const Color color = color_of(feature.kind);
    // Unshaded: glass in the colour of its kind, whichever way it faces.
    add_polygons(scene, *surface, sides,
                 {.name = "region", .color = color, .opacity = 0.5F, .lighting = Lighting::flat});
    add_part(scene, mesh, marked, {.name = "feature", .color = 0.8F * color});
    add_polygon_edges(scene, *surface, sides, {.color = 0.35F * color, .width = 2.0});
    for (const std::uint32_t side : sides) {
        const Vec3 from = middle_of(*surface, side);
        add_arrow(scene, from, from + 0.38 * region->half_space(side).normal, 0.014,
                  {.name = "normal", .color = srgb(figure_colors::red)});
    }
    int endless = 0;
    for (const PolyhedronEdge& edge : region->edges()) {
        if (!region->is_ray(edge.to)) continue;
        ++endless;
        const Vec3 from =
            region->vertex(edge.from) + length * region->vertex(edge.to).stableNormalized();
        add_arrow(scene, from, from + 0.3 * region->vertex(edge.to).stableNormalized(), 0.014,
                  {.name = "ray", .color = srgb(0x555555)});
    }
    FigureContent content;
    content.caption = fmt::format(
        "The Voronoi region of {} {} of a pyramid: {}. {} planes with red outward normals "
        "bound it to the side; {} half-lines go on forever (gray).",
        name_of(feature.kind), feature.id, words, sides.size(), endless);
    content.panels.emplace_back(
        scene_panel(fmt::format("Voronoi region of {} {}", name_of(feature.kind), feature.id),
                    std::move(scene), camera, single_panel));
    return content;
}

/// All regions of a body that are no line or plane, a little long.
Result<ScenePanel> all_regions(const TriangleMesh& mesh, const char* name, double length,
                               std::array<std::size_t, 3>& counts)
{
    const auto topology = build_topology(mesh);
    if (!topology) return tl::unexpected(topology.error());
    DrawnScene scene;
    const auto add = [&](Feature feature) -> Status {
        const auto region = voronoi_region_of(mesh, *topology, feature);
        if (!region) return tl::unexpected(region.error());
        if (region->dimension() < 3) return {}; // an edge within a flat part
        ++counts[static_cast<std::size_t>(feature.kind)];
        const auto shape = voronoi_region_mesh(mesh, *topology, feature, length);
        if (!shape) return tl::unexpected(shape.error());
        add_mesh(scene, *shape, {.name = name_of(feature.kind), .color = color_of(feature.kind)});
        add_mesh_edges(scene, *shape, {.color = srgb(0x333333), .width = 1.2});
        return {};
    };
    Status status;
    for (std::uint32_t v = 0; status && v < mesh.vertex_count(); ++v)
        status = add({FeatureKind::vertex, v});
    for (std::uint32_t e = 0; status && e < topology->edge_count(); ++e)
        status = add({FeatureKind::edge, e});
    for (std::uint32_t f = 0; status && f < mesh.triangle_count(); ++f)
        status = add({FeatureKind::face, f});
    if (!status) return tl::unexpected(status.error());
    return scene_panel(
        fmt::format("{}: {} vertices, {} edges, {} faces", name, counts[0], counts[1], counts[2]),
        std::move(scene), region_camera, one_of_some);
}

} // namespace

TriangleMesh make_pyramid()
{
    return *make_triangle_mesh(
        {Vec3(-1, -1, 0), Vec3(1, -1, 0), Vec3(1, 1, 0), Vec3(-1, 1, 0), Vec3(0, 0, 1.5)},
        {{0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}, {0, 2, 1}, {0, 3, 2}});
}

Result<FigureContent> figure_4_3(const Execution& /*context*/)
{
    return pyramid_figure({FeatureKind::face, 0},
                          "the triangle moved along its normal, a prism without an end",
                          {.azimuth = 1.15, .elevation = 0.2});
}

Result<FigureContent> figure_4_4(const Execution& /*context*/)
{
    const auto topology = build_topology(make_pyramid());
    if (!topology) return tl::unexpected(topology.error());
    const EdgeId edge = topology->find_edge(VertexId{1}, VertexId{4});
    return pyramid_figure({FeatureKind::edge, to_index(edge)},
                          "a wedge between the regions of its two triangles", region_camera);
}

Result<FigureContent> figure_4_5(const Execution& /*context*/)
{
    return pyramid_figure({FeatureKind::vertex, 4},
                          "a cone between the regions of the edges that meet there", region_camera);
}

Result<FigureContent> figure_4_6(const Execution& /*context*/)
{
    struct Body {
        const char* name;
        TriangleMesh mesh;
        double length;
    };
    const std::array bodies = {
        Body{"cube", make_cube(), 0.6}, Body{"octahedron", make_octahedron(), 0.4},
        Body{"pyramid", make_pyramid(), 0.5}, Body{"icosahedron", make_icosphere(0), 0.45}};
    FigureContent content;
    content.columns = 2;
    content.caption = "All Voronoi regions of convex bodies, cut off at a length: yellow those of "
                      "faces, green of edges, blue of vertices.";
    for (const Body& body : bodies) {
        std::array<std::size_t, 3> counts = {};
        auto panel = all_regions(body.mesh, body.name, body.length, counts);
        if (!panel) return tl::unexpected(panel.error());
        content.panels.emplace_back(std::move(*panel));
        content.caption +=
            fmt::format(" {}: {} regions.", body.name, counts[0] + counts[1] + counts[2]);
    }
    content.caption += " Edges within a flat face have none of their own.";
    return content;
}

} // namespace proxima
