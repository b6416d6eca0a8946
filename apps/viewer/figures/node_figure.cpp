// Figure 2.5: the octree as a data structure, drawn from one that was built.
#include "proxima/mesh/sample_meshes.h"
#include "proxima/octree/build_octree.h"
#include "proxima/octree/statistics.h"
#include "viewer/figures/figure_colors.h"
#include "viewer/figures/octree_figures.h"

#include <algorithm>
#include <array>
#include <bit>
#include <fmt/core.h>
#include <functional>

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

/// The cells from the root to the first that has children of all three types.
std::vector<Cell> path_to_all_types(const Octree& octree)
{
    struct Walk {
        const Octree& octree;
        std::vector<Cell> path;

        bool visit(const Cell& cell)
        {
            if (octree.is_leaf(cell)) return false;
            path.push_back(cell);
            std::array<bool, 3> seen = {};
            for (int i = 0; i < 8; ++i)
                seen[static_cast<std::size_t>(octree.child(cell, i).type)] = true;
            if (std::ranges::all_of(seen, std::identity())) return true;
            for (int i = 0; i < 8; ++i)
                if (visit(octree.child(cell, i))) return true;
            path.pop_back();
            return false;
        }
    };
    Walk walk{octree, {}};
    walk.visit(octree.root());
    return walk.path;
}

} // namespace

Result<FigureContent> figure_2_5(const FigureContext& context)
{
    const TriangleMesh mesh = make_torus(24, 12);
    const auto octree = build_octree(mesh, {.max_depth = 4, .threads = context.threads});
    if (!octree) return tl::unexpected(octree.error());
    const std::vector<Cell> path = path_to_all_types(*octree);
    if (path.empty()) return fail(ErrorCode::broken_invariant, "no cell with leaves of all types");

    constexpr double row = 108.0;
    const std::uint64_t cells = octree_statistics(*octree).total;
    const double fields_top = 90.0 + row * static_cast<double>(path.size()) + 90.0;
    Figure figure{.width = 1200, .height = static_cast<int>(fields_top) + 250};
    NodeDrawing drawing(figure, *octree);
    const auto place = [&](int octant, std::size_t level) -> Vec2 {
        return {110.0 + 140.0 * octant, 60.0 + row * static_cast<double>(level)};
    };
    const Vec2 half(0, 22);
    Vec2 above(600, 60);
    figure.texts.push_back({above - Vec2(0, 34), "root", {14, ink, TextAnchor::middle}});
    drawing.small(path.front(), above);
    std::array<int, 3> sample = {}; // octants of the last row, by type
    for (std::size_t level = 1; level <= path.size(); ++level) {
        Vec2 next = above;
        for (int i = 0; i < 8; ++i) {
            const Cell cell = octree->child(path[level - 1], i);
            drawing.link(above + half, place(i, level) - half);
            drawing.small(cell, place(i, level));
            if (level < path.size() && cell.key == path[level].key) next = place(i, level);
            if (level == path.size()) sample[static_cast<std::size_t>(cell.type)] = i;
        }
        above = next;
    }
    double x = 60;
    for (const CellClass type : {CellClass::boundary, CellClass::inner, CellClass::outer}) {
        const int i = sample[static_cast<std::size_t>(type)];
        drawing.link(place(i, path.size()) + half, {x + 172, fields_top});
        drawing.fields(octree->child(path.back(), i), {x, fields_top});
        x += 372;
    }
    FigureContent content;
    content.caption = fmt::format(
        "The octree as a data structure, read from one of a torus of {} triangles: the root, its "
        "eight children, and on from one of them to eight cells of all three types, with the "
        "fields "
        "of one of each. Only boundary leaves list triangles. The octree has {} cells; empty "
        "leaves "
        "are but a bit of their parent's record, so {} records of 8 bytes and {} references of 4 "
        "hold it.",
        mesh.triangle_count(), cells, octree->nodes().size(), octree->references().size());
    content.drawing = std::move(figure);
    return content;
}

} // namespace proxima
