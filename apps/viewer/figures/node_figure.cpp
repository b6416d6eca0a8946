// Figure 2.5: the octree as a data structure, drawn from one that was built.
#include "proxima/execution.h"
#include "proxima/octree.h"
#include "proxima/sample_meshes.h"
#include "viewer/figures/figure_colors.h"
#include "viewer/figures/octree_figures.h"

#include <array>
#include <bit>
#include <fmt/core.h>
#include <optional>

namespace proxima {
namespace {

using namespace figure_colors;

const char* name_of(CellClass type)
{
    return type == CellClass::boundary ? "boundary" : type == CellClass::inner ? "inner" : "outer";
}

int octant_of(const Cell& cell)
{
    return octant(cell.key);
}

/// Draws nodes as boxes of text.
class NodeDrawing {
public:
    NodeDrawing(Figure& figure, const Octree& octree) : figure_(figure), octree_(octree) {}

    /// A box that stands for a node, with its type.
    void named(const Cell& cell, const Vec2& center)
    {
        box(center, {98, 44}, cell.type, name_of(cell.type));
    }

    /// The same, narrow.
    void lettered(const Cell& cell, const Vec2& center)
    {
        const char* const letter = cell.type == CellClass::boundary ? "B"
                                   : cell.type == CellClass::inner  ? "I"
                                                                    : "O";
        box(center, {48, 44}, cell.type, letter);
    }

    /// A node with its five fields.
    void fields(const Cell& cell, const Vec2& upper_left)
    {
        constexpr Vec2::Scalar width = 345;
        constexpr Vec2::Scalar row = 34;
        const Box bounds = octree_.box(cell);
        const Vec3 center = bounds.center();
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
            text += fmt::format("{} {}", i == 0 ? "" : ",", to_index(triangles[i]));
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

/// The first child of the cell that is a leaf of this type.
std::optional<int> leaf_of_type(const Octree& octree, const Cell& cell, CellClass type)
{
    for (int octant = 0; octant < 8; ++octant) {
        const Cell child = octree.child(cell, octant);
        if (octree.is_leaf(child) && child.type == type) return octant;
    }
    return std::nullopt;
}

} // namespace

Result<FigureContent> figure_2_5(const Execution& context)
{
    // No cell has both inner and outer children, as all eight meet in its middle: two are opened.
    const TriangleMesh mesh = make_icosphere(2);
    const OctreeFrame root_frame = {Vec3::Constant(-1.2), Vec3::Constant(2.8)};
    const auto octree = build_octree(
        mesh, {.max_depth = 2, .root = root_frame, .execution = {.threads = context.threads}});
    if (!octree) return tl::unexpected(octree.error());
    const Cell root = octree->root();
    const std::array opened = {octree->child(root, 0), octree->child(root, 7)};
    struct Sample {
        Cell parent;
        CellClass type;
        double left;
    };
    const std::array samples = {Sample{opened[0], CellClass::inner, 40.0},
                                Sample{opened[1], CellClass::boundary, 427.0},
                                Sample{opened[1], CellClass::outer, 814.0}};

    Figure figure{.width = 1200, .height = 632};
    NodeDrawing drawing(figure, *octree);
    const Vec2 half(0, 22);
    const Vec2 top(600, 70);
    const auto child_position = [](int octant) -> Vec2 { return {110.0 + 140.0 * octant, 190.0}; };
    const auto leaf_position = [](const Cell& parent, int octant) -> Vec2 {
        return {(octant_of(parent) == 0 ? 50.0 : 660.0) + 70.0 * octant, 320.0};
    };
    figure.texts.push_back({top - Vec2(0, 34), "root", {14, ink, TextAnchor::middle}});
    for (int i = 0; i < 8; ++i) {
        drawing.link(top + half, child_position(i) - half);
        drawing.named(octree->child(root, i), child_position(i));
    }
    drawing.named(root, top);
    for (const Cell& parent : opened) {
        for (int i = 0; i < 8; ++i) {
            drawing.link(child_position(octant_of(parent)) + half, leaf_position(parent, i) - half);
            drawing.lettered(octree->child(parent, i), leaf_position(parent, i));
        }
    }
    for (const auto& [parent, type, left] : samples) {
        const auto octant = leaf_of_type(*octree, parent, type);
        if (!octant)
            return fail(ErrorCode::broken_invariant, "no leaf of this type", name_of(type));
        drawing.link(leaf_position(parent, *octant) + half, {left + 172, 440});
        drawing.fields(octree->child(parent, *octant), {left, 440});
    }
    FigureContent content;
    content.caption = fmt::format(
        "The octree as a data structure, read from one of a sphere of {} triangles in a root that "
        "is not centred on it: the root, its eight children, the children of two of them (B "
        "boundary, I inner, O outer) and the fields of a leaf of each type. Only boundary leaves "
        "list triangles. The octree has {} cells; empty leaves are but a bit of their parent's "
        "record, so {} records of 8 bytes and {} references of 4 hold it.",
        mesh.triangle_count(), octree_statistics(*octree).total, octree->nodes().size(),
        octree->references().size());
    content.drawing = std::move(figure);
    return content;
}

} // namespace proxima
