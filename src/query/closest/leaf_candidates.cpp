#include "query/closest/leaf_candidates.h"

#include "index/index_parts.h"
#include "index/lists/proximity_cells.h"
#include "index/lists/proximity_lists.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

namespace proxima {

namespace {

using Coordinates = std::array<std::uint32_t, 3>;

std::uint64_t table_word(const ProximityLists& lists, const Coordinates& at) noexcept
{
    const int depth = lists.table_depth();
    return lists.arrays().table[(std::size_t{at[2]} << depth | at[1]) << depth | at[0]];
}

/// Whether all cells of the table below a cell of a level above it are the same leaf's.
bool is_one_leaf(const ProximityLists& lists, std::uint64_t word, int depth, const Coordinates& at)
{
    const int below = lists.table_depth() - depth;
    const std::uint32_t edge = 1U << below;
    for (std::uint32_t z = 0; z < edge; ++z) {
        for (std::uint32_t y = 0; y < edge; ++y) {
            for (std::uint32_t x = 0; x < edge; ++x) {
                if (table_word(lists, {(at[0] << below) + x, (at[1] << below) + y,
                                       (at[2] << below) + z}) != word)
                    return false;
            }
        }
    }
    return true;
}

} // namespace

std::optional<LeafCandidates> leaf_candidates(const IndexParts& index, const Vec3& p,
                                              std::span<TriangleId> triangles) noexcept
{
    if (index.lists() == nullptr) return std::nullopt;
    const ProximityLists& lists = *index.lists();
    const RootFrame& frame = lists.frame();
    const ProximityArrays& arrays = lists.arrays();
    std::array<std::uint32_t, 3> at{};
    if (!lists.locate(frame.to_frame(p), at)) return std::nullopt;

    // Down from the table.
    const auto bits = static_cast<int>(ProximityLists::location_bits);
    const auto cell = [&](int depth) {
        return Coordinates{at[0] >> (bits - depth), at[1] >> (bits - depth),
                           at[2] >> (bits - depth)};
    };
    int depth = lists.table_depth();
    std::uint64_t word = table_word(lists, cell(depth));
    if (proximity_word::is_leaf(word)) {
        while (depth > 0 && is_one_leaf(lists, word, depth - 1, cell(depth - 1))) --depth;
    }
    while (!proximity_word::is_leaf(word)) {
        const Coordinates child = cell(++depth);
        word =
            arrays.nodes[word + ((child[0] & 1U) | (child[1] & 1U) << 1U | (child[2] & 1U) << 2U)];
    }

    const Coordinates coordinates = cell(depth);
    LeafCandidates leaf;
    leaf.depth = depth;
    const double edge = std::ldexp(frame.half, 1 - depth);
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto k = static_cast<Eigen::Index>(axis);
        leaf.box.lower[k] = frame.center[k] + (coordinates[axis] * edge - frame.half);
        leaf.box.upper[k] = frame.center[k] + ((coordinates[axis] + 1.0) * edge - frame.half);
    }
    leaf.has_list = word != proximity_word::search;
    leaf.count = read_list(arrays, index.ids(), word, triangles);
    std::ranges::sort(triangles.first(std::min(leaf.count, triangles.size())));
    return leaf;
}

} // namespace proxima
