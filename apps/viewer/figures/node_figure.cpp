// Figure 2.5: the octree as a data structure, drawn from one that was built.
#include "proxima/mesh/sample_meshes.h"
#include "proxima/octree/build_octree.h"
#include "proxima/octree/statistics.h"
#include "viewer/figures/figure_colors.h"
#include "viewer/figures/octree_figures.h"

#include <array>
#include <fmt/core.h>
#include <optional>

namespace proxima {
namespace {

using namespace figure_colors;

const char* name_of(CellClass type)
{
    return type == CellClass::boundary ? "boundary" : type == CellClass::inner ? "inner" : "outer";
}

/// Draws nodes as boxes of text.
class NodeDrawing {
public:
    NodeDrawing(Figure& figure, const Octree& octree) : figure_(figure), octree_(octree) {}

    /// A square that stands for a node.
    void small(const Cell& cell, const Vec2& center)
    {
        box(center, {92, 44}, cell.type, name_of(cell.type));
    }

    /// A node with its five fields.
    void fields(const Cell& cell, const Vec2& upper_left)
    {
        constexpr Vec2::Scalar width = 345;
        constexpr Vec2::Scalar row = 34;
        const Box place = octree_.box(cell);
        const Vec3 center = place.center();
        const bool is_leaf = octree_.is_leaf(cell);
        const std::array<std::string, 5> rows = {
            fmt::format("type: {}", name_of(cell.type)), fmt::format("depth: {}", depth(cell.key)),
            fmt::format("center: {:.3g}, {:.3g}, {:.3g}", center.x(), center.y(), center.z()),
            is_leaf ? list_of(octree_.triangles(cell)) : "triangles: in its leaves",
            is_leaf ? "children: none" : fmt::format("children: 8, {} recorded", recorded(cell))};
        for (std::size_t i = 0; i < rows.size(); ++i) {
            const Vec2 at = upper_left + Vec2(0, row * static_cast<double>(i));
            figure_.boxes.push_back({at, at + Vec2(width, row), ink});
            figure_.boxes.push_back({at + Vec2(1.5, 1.5), at + Vec2(width - 1.5, row),
                                     i == 0 ? cell_color(cell.type) : 0xFFFFFFU});
            figure_.texts.push_back({at + Vec2(14, 23), rows[i], {14, ink}});
        }
        const Vec2 end = upper_left + Vec2(0, row * static_cast<double>(rows.size()));
        figure_.boxes.push_back({end, end + Vec2(width, 1.5), ink});
    }

    void link(const Vec2& from, const Vec2& to) { figure_.lines.push_back({from, to, faint, 2.0}); }

private:
    static std::string list_of(std::span<const TriangleId> triangles)
    {
        constexpr std::size_t shown = 4;
        if (triangles.empty()) return "triangles: none";
        std::string text = "triangles:";
        for (std::size_t i = 0; i < std::min(shown, triangles.size()); ++i)
            text += fmt::format("{} {}", i == 0 ? "" : ",", index(triangles[i]));
        if (triangles.size() > shown) text += fmt::format(", {} more", triangles.size() - shown);
        return text;
    }

    [[nodiscard]] int recorded(const Cell& cell) const
    {
        return std::popcount(octree_.nodes()[cell.node].recorded_mask());
    }

    void box(const Vec2& center, const Vec2& size, CellClass type, const std::string& words)
    {
        const Vec2 half = 0.5 * size;
        const Vec2 border(1.5, 1.5);
        figure_.boxes.push_back({center - half, center + half, ink});
        figure_.boxes.push_back({center - half + border, center + half - border, cell_color(type)});
        figure_.texts.push_back({center + Vec2(0, 6), words, {12, ink, TextAnchor::middle}});
    }

    Figure& figure_;
    const Octree& octree_;
};

/// The first child that has children of all three classes.
std::optional<int> colourful_child(const Octree& octree, const Cell& cell)
{
    for (int octant = 0; octant < 8; ++octant) {
        const Cell child = octree.child(cell, octant);
        if (octree.is_leaf(child)) continue;
        std::array<bool, 3> seen = {};
        for (int i = 0; i < 8; ++i) {
            const auto type = static_cast<std::size_t>(octree.child(child, i).type);
            if (type < seen.size()) seen[type] = true;
        }
        if (seen[0] && seen[1] && seen[2]) return octant;
    }
    return std::nullopt;
}

} // namespace

Result<FigureContent> figure_2_5(const FigureContext& context)
{
    const TriangleMesh mesh = make_icosphere(2);
    const auto octree = build_octree(mesh, {.max_depth = 2, .threads = context.threads});
    if (!octree) return tl::unexpected(octree.error());
    const auto shown = colourful_child(*octree, octree->root());
    if (!shown) return fail(ErrorCode::broken_invariant, "no child with cells of all classes");

    const std::uint64_t cells = octree_statistics(*octree).total;
    Figure figure{.width = 1200, .height = 700};
    NodeDrawing drawing(figure, *octree);
    const Cell root = octree->root();
    const Cell child = octree->child(root, *shown);
    const auto place = [](int octant, double y) -> Vec2 { return {110.0 + 140.0 * octant, y}; };
    const Vec2 top(600, 60);
    for (int i = 0; i < 8; ++i) drawing.link(top + Vec2(0, 22), place(i, 168) - Vec2(0, 22));
    for (int i = 0; i < 8; ++i) {
        drawing.link(place(*shown, 168) + Vec2(0, 22), place(i, 290) - Vec2(0, 22));
    }
    drawing.small(root, top);
    figure.texts.push_back({{600, 26}, "root", {14, ink, TextAnchor::middle}});
    std::array<std::optional<int>, 3> sample;
    for (int i = 0; i < 8; ++i) {
        drawing.small(octree->child(root, i), place(i, 168));
        const Cell grandchild = octree->child(child, i);
        drawing.small(grandchild, place(i, 290));
        const auto type = static_cast<std::size_t>(grandchild.type);
        if (!sample[type]) sample[type] = i;
    }
    double x = 60;
    for (const CellClass type : {CellClass::boundary, CellClass::inner, CellClass::outer}) {
        const int i = *sample[static_cast<std::size_t>(type)];
        drawing.link(place(i, 290) + Vec2(0, 22), {x + 172, 430});
        drawing.fields(octree->child(child, i), {x, 430});
        x += 372;
    }
    figure.texts.push_back(
        {{600, 650},
         fmt::format("{} cells, {} records of 8 bytes: empty leaves are a bit of their parent's",
                     cells, octree->nodes().size()),
         {15, ink, TextAnchor::middle}});
    FigureContent content;
    content.caption = fmt::format(
        "The octree as a data structure, read from one of a sphere of {} triangles, two levels "
        "deep: the root, its eight children, the eight children of one of them, and the fields of "
        "one leaf of each type. Only boundary leaves list triangles. The {} cells take {} records "
        "of 8 bytes and {} references of 4.",
        mesh.triangle_count(), cells, octree->nodes().size(), octree->references().size());
    content.drawing = std::move(figure);
    return content;
}

} // namespace proxima
