// Figures 4.1, 4.2 and 5.3: proximity quadtrees and octrees, and their lists.
#include "cli/list_histogram.h"
#include "proxima/execution.h"
#include "proxima/sample_meshes.h"
#include "thesis/proximity_octree/feature_regions.h"
#include "thesis/proximity_octree/list_statistics.h"
#include "viewer/figures/figure_colors.h"
#include "viewer/figures/planar_panel.h"
#include "viewer/figures/scene_figure.h"
#include "viewer/figures/voronoi_figures.h"

#include <algorithm>
#include <array>
#include <fmt/core.h>
#include <optional>

namespace proxima {
namespace {

using namespace figure_colors;

/// "c1", "e0 c1", ...: what a leaf lists.
std::string names_of(const std::vector<int>& sets, int corners)
{
    std::string names;
    for (const int set : sets) {
        names += fmt::format("{}{}{}", names.empty() ? "" : " ", set < corners ? 'c' : 'e',
                             set < corners ? set : set - corners);
    }
    return names;
}

/// How far a ray from a point within the root goes until it leaves it.
double length_in_root(const Vec2& from, const Vec2& along, double half)
{
    double length = 1e300;
    for (int axis = 0; axis < 2; ++axis) {
        if (along[axis] == 0.0) continue;
        const double side = along[axis] > 0.0 ? half : -half;
        length = std::min(length, (side - from[axis]) / along[axis]);
    }
    return length;
}

/// What a leaf lists, where there is space for it in the leaf: as near to its middle as can be, and
/// outside of the polygon if that can be.
void name_leaf(PlanarPanel& panel, const ProximityQuadtree& tree, const QuadtreeLeaf& leaf)
{
    const std::size_t listed = leaf.sets.size();
    if (listed == 0) return;
    const std::string names =
        listed > 2 ? fmt::format("{}", listed)
                   : names_of(leaf.sets, static_cast<int>(tree.polygon.points().size()));
    const unsigned color = listed > 2 ? red : ink;
    constexpr int steps = 8; // from the middle to each side
    struct Try {
        double share; // of the leaf: how high the words are
        double clear; // pixels
    };
    constexpr std::array<Try, 4> tries = {{{0.17, 5.0}, {0.13, 4.0}, {0.11, 3.0}, {0.09, 2.0}}};
    for (const Try& now : tries) {
        const double size = std::min(15.0, now.share * 2.0 * panel.scale() * leaf.half);
        std::optional<Vec2> best;
        double least = 0.0;
        for (int x = -steps; x <= steps; ++x) {
            for (int y = -steps; y <= steps; ++y) {
                const Vec2 step = leaf.half / steps * Vec2(x, y);
                const double price =
                    step.norm() +
                    (is_inside(tree.polygon, leaf.center + step) ? 4.0 * leaf.half : 0.0);
                if (best && price >= least) continue;
                if (!panel.has_space(leaf.center, names, panel.scale() * step, size, now.clear))
                    continue;
                best = panel.scale() * step;
                least = price;
            }
        }
        if (!best) continue;
        panel.words(leaf.center, names, *best, size, color);
        return;
    }
}

/// The polygon's own names, inside of it.
void name_polygon(PlanarPanel& panel, const ConvexPolygon& polygon)
{
    const auto corners = polygon.points();
    for (std::size_t i = 0; i < corners.size(); ++i) {
        const Vec2& at = corners[i];
        panel.words(at, fmt::format("c{}", i), -36.0 * Vec2(at.normalized()), 16, blue);
        const Vec2 middle = 0.5 * (at + corners[(i + 1) % corners.size()]);
        panel.words(middle, fmt::format("e{}", i), -30.0 * Vec2(middle.normalized()), 18, red);
    }
}

void draw_regions(PlanarPanel& panel, const ConvexPolygon& polygon, double half)
{
    const auto corners = polygon.points();
    for (std::size_t i = 0; i < corners.size(); ++i) {
        const Vec2& next = corners[(i + 1) % corners.size()];
        const Vec2 along = next - corners[i];
        const Vec2 outward = Vec2(along.y(), -along.x()).normalized();
        for (const Vec2& end : {corners[i], next})
            panel.dashes(end, end + length_in_root(end, outward, half) * outward, green, 1.6);
    }
}

} // namespace

Result<ProximityQuadtree> proximity_quadtree()
{
    const std::array corners = {Vec2(-0.52, -0.38), Vec2(0.41, -0.47), Vec2(0.58, 0.21),
                                Vec2(-0.13, 0.53)};
    auto polygon = convex_polygon(corners);
    if (!polygon) return tl::unexpected(polygon.error());
    const auto regions = voronoi_regions_of(*polygon);
    if (!regions) return tl::unexpected(regions.error());
    constexpr double half = 1.0;
    auto leaves = quadtree_leaves(*regions, {.half = half, .max_depth = 4, .threshold = 1});
    if (!leaves) return tl::unexpected(leaves.error());
    return ProximityQuadtree{std::move(*polygon), std::move(*leaves), half};
}

Result<FigureContent> figure_4_1(const Execution& /*context*/)
{
    const auto tree = proximity_quadtree();
    if (!tree) return tl::unexpected(tree.error());
    const int corners = static_cast<int>(tree->polygon.points().size());
    Figure figure{.width = 1120, .height = 1120};
    PlanarPanel panel(figure, {Vec2(20, 20), Vec2(1100, 1100)},
                      {Vec2(-tree->half, -tree->half), Vec2(tree->half, tree->half)});
    std::array<std::size_t, 4> counts = {};
    for (const QuadtreeLeaf& leaf : tree->leaves) {
        const std::size_t listed = leaf.sets.size();
        ++counts[std::min<std::size_t>(listed, 3)];
        const unsigned color = listed == 0   ? inner_cell
                               : listed == 1 ? (leaf.sets[0] < corners ? blue_tint : yellow_tint)
                                             : red_tint;
        panel.fill_square(leaf.center, leaf.half, color);
        panel.square(leaf.center, leaf.half, faint, 1.0);
    }
    const auto points = tree->polygon.points();
    panel.outline(points, ink, 4.0);
    for (const Vec2& at : points) panel.dot(at, 12, ink);
    name_polygon(panel, tree->polygon);
    for (const QuadtreeLeaf& leaf : tree->leaves) name_leaf(panel, *tree, leaf);
    draw_regions(panel, tree->polygon, tree->half);
    FigureContent content;
    content.caption = fmt::format(
        "The quadtree of a polygon's exterior Voronoi regions (dashed borders), split while a cell "
        "lists more than one feature, to depth 4: each leaf is marked with the corners (c) and "
        "edges (e) that its points outside can be closest to. {} leaves: {} list one feature "
        "(blue: a corner, yellow: an edge), {} two and {} more (their number is shown), {} lie "
        "inside and list none (green).",
        tree->leaves.size(), counts[1], counts[2], counts[3], counts[0]);
    content.drawing = std::move(figure);
    return content;
}

Result<ListedFeature> sphere_with_listed_feature(const Execution& context)
{
    TriangleMesh mesh = make_sphere(12, 16);
    const auto topology = build_topology(mesh, {.execution = {.threads = context.threads}});
    if (!topology) return tl::unexpected(topology.error());
    auto octree = build_thesis_proximity_octree(mesh, *topology,
                                                {.max_depth = 4,
                                                 .thresholds = {6, 12, 8},
                                                 .margin = 0.8,
                                                 .execution = {.threads = context.threads}});
    if (!octree) return tl::unexpected(octree.error());
    // A vertex that faces the camera: the cone of its region is seen from the side.
    std::uint32_t best = 0;
    const Vec3 wanted = Vec3(0.75, -0.25, 0.6).normalized();
    for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v) {
        if (mesh.positions()[v].dot(wanted) > mesh.positions()[best].dot(wanted)) best = v;
    }
    ListedFeature result{std::move(mesh), std::move(*octree), {FeatureKind::vertex, best}, {}, {}};
    result.octree.for_each_leaf([&](const ThesisCell& cell) {
        if (result.octree.type(cell) != CellClass::outer) return;
        result.outer.push_back(cell);
        const auto listed = result.octree.closest(cell, result.feature.kind);
        if (std::ranges::find(listed, best) != listed.end()) result.listing.push_back(cell);
    });
    return result;
}

Result<FigureContent> figure_4_2(const Execution& context)
{
    const auto shown = sphere_with_listed_feature(context);
    if (!shown) return tl::unexpected(shown.error());
    const auto topology = build_topology(shown->mesh);
    if (!topology) return tl::unexpected(topology.error());
    const auto region = voronoi_region_mesh(shown->mesh, *topology, shown->feature, 1.1);
    if (!region) return tl::unexpected(region.error());
    const ShapeStyle sphere = {.name = "mesh"};
    const EdgeStyle mesh_edges = {.color = srgb(0x8A8172), .width = 1.0, .opacity = 0.7F};
    const OrbitCamera camera = {.azimuth = 0.35, .elevation = 0.3};

    // Of the outer leaves the layer just behind the middle, brighter where lists are short.
    DrawnScene left;
    add_mesh(left, shown->mesh, sphere);
    add_mesh_edges(left, shown->mesh, mesh_edges);
    std::vector<Box> layer;
    std::uint32_t longest = 0;
    for (const ThesisCell& cell : shown->outer)
        longest = std::max(longest, shown->octree.list_length(cell));
    for (const ThesisCell& cell : shown->outer) {
        const Box box = shown->octree.box(cell);
        if (box.lower.y() > 1e-9 || box.upper.y() < 1e-6) continue;
        layer.push_back(box);
        const double part = static_cast<double>(shown->octree.list_length(cell)) / longest;
        const auto bright = static_cast<float>(1.0 - part);
        add_box(left, box,
                {.name = "layer",
                 .color = bright * srgb(0xDCEBFA) + (1.0F - bright) * srgb(0x0E3A75),
                 .lighting = Lighting::flat});
    }
    add_box_edges(left, layer, {.color = srgb(0x2F62B5), .width = 1.0});

    DrawnScene right;
    add_mesh(right, shown->mesh, sphere);
    add_mesh_edges(right, shown->mesh, mesh_edges);
    std::vector<Box> listing;
    for (const ThesisCell& cell : shown->listing) listing.push_back(shown->octree.box(cell));
    for (const Box& box : listing)
        add_box(right, box, {.name = "cell", .color = srgb(0x66AA77), .opacity = 0.16F});
    add_box_edges(right, listing, {.color = srgb(0x1F7A44), .width = 1.3});
    add_mesh(right, *region, {.name = "region", .color = srgb(0xE8B800), .opacity = 0.6F});
    add_mesh_edges(right, *region, {.color = srgb(0x7A5F00), .width = 2.0});

    FigureContent content;
    content.columns = 2;
    content.caption = fmt::format(
        "Left: of the {} outer leaves of the proximity octree of a sphere of {} triangles the {} "
        "just behind the middle, the darker the more features they list, {} at most. Right: the "
        "Voronoi region of vertex {} (yellow, it has no end and is cut for the picture) and the {} "
        "outer leaves that list the vertex: those that its region meets.",
        shown->outer.size(), shown->mesh.triangle_count(), layer.size(), longest, shown->feature.id,
        listing.size());
    constexpr ViewSize size = {.width = 760, .height = 700};
    content.panels.emplace_back(
        scene_panel(fmt::format("{} of {} outer leaves", layer.size(), shown->outer.size()),
                    std::move(left), camera, size));
    content.panels.emplace_back(
        scene_panel(fmt::format("a Voronoi region and its {} outer leaves", listing.size()),
                    std::move(right), camera, size));
    return content;
}

Result<FigureContent> figure_5_3(const Execution& context)
{
    constexpr std::array depths = {2, 3, 4, 5};
    const auto mesh = sample_mesh("sphere:50x50", {.execution = {.progress = context.progress}});
    if (!mesh) return tl::unexpected(mesh.error());
    const auto topology = build_topology(*mesh, {.execution = context});
    if (!topology) return tl::unexpected(topology.error());
    std::vector<HistogramSeries> series;
    std::string means;
    for (const int depth : depths) {
        const auto octree = build_thesis_proximity_octree(
            *mesh, *topology, {.max_depth = depth, .execution = context});
        if (!octree) return tl::unexpected(octree.error());
        series.push_back(
            {depth, list_statistics(outer_list_lengths(*octree, circumscribed_sphere(*mesh)))});
        const ListStatistics& lists = series.back().lists;
        means +=
            fmt::format("{}depth {}: {:.1f} features in {} cells, {:.1f} % of the lists have 16 "
                        "or fewer",
                        means.empty() ? "" : "; ", depth, lists.mean, lists.cells,
                        100.0 * lists.share_up_to(16));
    }
    FigureContent content;
    content.drawing = histogram_figure(series, HistogramOf::outer_cells, {});
    content.caption = fmt::format(
        "How many features the outer cells of the proximity octree of a sphere of {} vertices, {} "
        "edges and {} triangles list, by depth (the root is 1.5 times the tight cube, thresholds "
        "are "
        "1). The histogram moves to the left as cells get smaller. On average {}.",
        mesh->vertex_count(), topology->edge_count(), mesh->triangle_count(), means);
    return content;
}

} // namespace proxima
