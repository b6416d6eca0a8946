#include "viewer/panels/cell_shapes.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

namespace proxima {
namespace {

/// One edge of a leaf. Equal keys are equal edges.
struct LeafEdge {
    std::uint64_t key = 0;
    std::uint32_t leaf = 0;
    std::uint8_t from = 0;
    std::uint8_t to = 0;
};

LeafEdge edge_of(const LeafBox& box, std::uint32_t leaf, unsigned axis, unsigned from)
{
    std::uint64_t key = 0;
    for (unsigned k = 0; k < 3; ++k) // 20 bits an axis: lattices are at most 2^19 wide
        key = key << 20U | (box.lower[k] + ((from >> k & 1U) != 0 ? box.size : 0U));
    key = key << 2U | axis;
    // Edges of two sizes that begin at one point differ in their leaves' size.
    return {key, leaf, static_cast<std::uint8_t>(from),
            static_cast<std::uint8_t>(from | 1U << axis)};
}

} // namespace

Color ramp_color(double part)
{
    constexpr std::array stops = {0x2F62B5U, 0x2BA5A0U, 0x57B557U, 0xE8B800U, 0xE07B28U, 0xC8373FU};
    const double at = std::clamp(part, 0.0, 1.0) * (stops.size() - 1);
    const auto below = std::min(static_cast<std::size_t>(at), stops.size() - 2);
    const auto rest = static_cast<float>(at - static_cast<double>(below));
    return (1.0F - rest) * srgb(stops[below]) + rest * srgb(stops[below + 1]);
}

Color class_color(CellClass type)
{
    switch (type) {
    case CellClass::boundary:
        return srgb(0xD07A00);
    case CellClass::inner:
        return srgb(0x2E8B57);
    case CellClass::outer:
        return srgb(0x8FA3BC);
    case CellClass::unclassified:
        break;
    }
    return srgb(0x777777);
}

void add_leaf_edges(DrawnScene& scene, const Octree& octree, std::span<const LeafBox> leaves,
                    const EdgeStyle& style)
{
    std::vector<LeafEdge> edges;
    edges.reserve(12 * leaves.size());
    for (std::uint32_t i = 0; i < leaves.size(); ++i) {
        for (unsigned axis = 0; axis < 3; ++axis) {
            const unsigned b = 1U << (axis + 1) % 3;
            const unsigned c = 1U << (axis + 2) % 3;
            for (const unsigned from : {0U, b, c, b | c})
                edges.push_back(edge_of(leaves[i], i, axis, from));
        }
    }
    const auto size = [&](const LeafEdge& edge) { return leaves[edge.leaf].size; };
    std::ranges::sort(edges, [&](const LeafEdge& one, const LeafEdge& other) {
        if (one.key != other.key) return one.key < other.key;
        if (size(one) != size(other)) return size(one) < size(other);
        return one.leaf < other.leaf;
    });
    const auto are_one = [&](const LeafEdge& one, const LeafEdge& other) {
        return one.key == other.key && size(one) == size(other);
    };
    edges.erase(std::unique(edges.begin(), edges.end(), are_one), edges.end());
    SceneLines lines{style.name, {}, style.color, style.width, style.opacity};
    lines.segments.reserve(edges.size());
    for (const LeafEdge& edge : edges) {
        const LeafBox& leaf = leaves[edge.leaf];
        lines.segments.push_back(
            {corner_position(octree, leaf, edge.from), corner_position(octree, leaf, edge.to)});
    }
    scene.lines.push_back(std::move(lines));
}

Box slice_of(const Octree& octree, const LeafBox& leaf, const AxisPlane& plane)
{
    Box box = {corner_position(octree, leaf, 0), corner_position(octree, leaf, 7)};
    const Box root = octree.box(octree.root());
    const int axis = plane.axis;
    const bool is_below = plane.at < box.lower[axis] && box.lower[axis] > root.lower[axis];
    const bool is_above = plane.at >= box.upper[axis] && box.upper[axis] < root.upper[axis];
    if (is_below || is_above) return {};
    box.lower[axis] = box.upper[axis] = plane.at;
    return box;
}

void add_slices(DrawnScene& scene, std::span<const Box> slices, int axis, const ShapeStyle& style)
{
    SceneSurface surface;
    surface.name = style.name;
    surface.color = style.color;
    surface.opacity = style.opacity;
    surface.lighting = style.lighting;
    surface.lift = style.lift;
    const int b = (axis + 1) % 3;
    const int c = (axis + 2) % 3;
    for (const Box& slice : slices) {
        const auto first = static_cast<std::uint32_t>(surface.positions.size());
        for (const auto& [upper_b, upper_c] :
             {std::pair{false, false}, {true, false}, {true, true}, {false, true}}) {
            Vec3 corner = slice.lower;
            if (upper_b) corner[b] = slice.upper[b];
            if (upper_c) corner[c] = slice.upper[c];
            surface.positions.push_back(corner);
        }
        surface.triangles.push_back({first, first + 1, first + 2});
        surface.triangles.push_back({first, first + 2, first + 3});
    }
    scene.surfaces.push_back(std::move(surface));
}

} // namespace proxima
