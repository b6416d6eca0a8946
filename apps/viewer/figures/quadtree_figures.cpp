// Figures 2.3 and 2.4: the quadtree of a circle, uniform and adaptive.
#include "proxima/execution.h"
#include "proxima/sample_meshes.h"
#include "viewer/figures/figure_colors.h"
#include "viewer/figures/octree_figures.h"
#include "viewer/figures/planar_panel.h"

#include <array>
#include <cmath>
#include <fmt/core.h>
#include <numbers>

namespace proxima {
namespace {

using namespace figure_colors;

constexpr int circle_edges = 96;
constexpr double circle_radius = 0.83; // of the root's half edge
constexpr std::array circle_depths = {2, 3, 4, 5};

struct LeafCounts {
    std::array<int, 3> by_type = {};

    [[nodiscard]] int of(CellClass type) const { return by_type[static_cast<std::size_t>(type)]; }
};

LeafCounts draw_cells(PlanarPanel& panel, const CurveQuadtree& tree)
{
    LeafCounts counts;
    for (const QuadtreeLeaf& leaf : tree.leaves) {
        const CellClass type = tree.type(leaf);
        ++counts.by_type[static_cast<std::size_t>(type)];
        panel.fill_square(leaf.center, leaf.half, cell_color(type));
        panel.square(leaf.center, leaf.half, faint, 1.0);
    }
    panel.outline(tree.curve.points(), ink, 2.5);
    return counts;
}

void draw_legend(Figure& figure, double y)
{
    constexpr std::array entries = {std::pair{boundary_cell, "boundary: meets the circle"},
                                    std::pair{inner_cell, "inner"}, std::pair{outer_cell, "outer"}};
    double x = 60.0;
    for (const auto& [color, words] : entries) {
        figure.boxes.push_back({{x, y}, {x + 26, y + 26}, faint});
        figure.boxes.push_back({{x + 1, y + 1}, {x + 25, y + 25}, color});
        figure.texts.push_back({{x + 38, y + 20}, words, {15, ink}});
        x += 38 + text_length(words, 15) + 44;
    }
}

Result<FigureContent> circle_figure(Subdivision subdivision)
{
    constexpr double edge = 340.0;
    constexpr double step = 360.0;
    FigureContent content;
    Figure figure{.width = 1480, .height = 470};
    std::string counts_text;
    for (std::size_t i = 0; i < circle_depths.size(); ++i) {
        const auto tree = circle_quadtree(circle_depths[i], subdivision);
        if (!tree) return tl::unexpected(tree.error());
        const double left = 30.0 + step * static_cast<double>(i);
        PlanarPanel panel(figure, {Vec2(left, 50), Vec2(left + edge, 50 + edge)},
                          {Vec2(-1, -1), Vec2(1, 1)});
        const LeafCounts counts = draw_cells(panel, *tree);
        panel.title(fmt::format("depth {}: {} leaves", circle_depths[i], tree->leaves.size()));
        counts_text += fmt::format("{}depth {}: {} leaves, {} of them boundary, {} inner, {} outer",
                                   i == 0 ? "" : "; ", circle_depths[i], tree->leaves.size(),
                                   counts.of(CellClass::boundary), counts.of(CellClass::inner),
                                   counts.of(CellClass::outer));
    }
    draw_legend(figure, 418);
    content.caption =
        subdivision == Subdivision::uniform
            ? "Uniform subdivision of a circle: every cell is split to the deepest level. "
            : "Adaptive subdivision of the same circle: only cells that its edge meets are split, "
              "so far fewer show the same boundary. ";
    content.caption += fmt::format("The circle has {} edges; whether a square meets one is asked "
                                   "of their Minkowski sum, tracked from depth to depth. {}.",
                                   circle_edges, counts_text);
    content.drawing = std::move(figure);
    return content;
}

} // namespace

CellClass CurveQuadtree::type(const QuadtreeLeaf& leaf) const
{
    if (!leaf.sets.empty()) return CellClass::boundary;
    return is_inside(curve, leaf.center) ? CellClass::inner : CellClass::outer;
}

Result<CurveQuadtree> circle_quadtree(int depth, Subdivision subdivision)
{
    std::vector<Vec2> corners;
    for (int i = 0; i < circle_edges; ++i) {
        const double angle = 2.0 * std::numbers::pi * (i + 0.5) / circle_edges;
        corners.emplace_back(circle_radius * std::cos(angle), circle_radius * std::sin(angle));
    }
    auto curve = convex_polygon(corners);
    if (!curve) return tl::unexpected(curve.error());
    const auto edges = edges_of(*curve);
    if (!edges) return tl::unexpected(edges.error());
    auto leaves = quadtree_leaves(*edges, {.max_depth = depth, .subdivision = subdivision});
    if (!leaves) return tl::unexpected(leaves.error());
    return CurveQuadtree{std::move(*curve), std::move(*leaves), depth};
}

Result<FigureContent> figure_2_3(const Execution& /*context*/)
{
    return circle_figure(Subdivision::uniform);
}

Result<FigureContent> figure_2_4(const Execution& /*context*/)
{
    return circle_figure(Subdivision::adaptive);
}

} // namespace proxima
