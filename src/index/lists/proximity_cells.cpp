#include "index/lists/proximity_cells.h"

#include "base/text.h"
#include "index/lists/block.h"

#include <algorithm>
#include <bit>
#include <cstring>

namespace proxima {

namespace {

/// Calls take(rank) for a block's triangles that are in the mask.
template <class Take>
void take_ranks(const ProximityArrays& arrays, std::uint32_t position, std::uint32_t mask,
                const Take& take) noexcept
{
    const std::byte* const begin = arrays.arena.data() + std::size_t{position} * block_alignment;
    BlockHeader header;
    std::memcpy(&header, begin, sizeof(header));
    const bool wide = header.wide != 0;
    const BlockLayout layout = block_layout(header.vertices, header.triangles, wide);
    for (; mask != 0; mask &= mask - 1) {
        const auto triangle = static_cast<std::size_t>(std::countr_zero(mask));
        std::uint32_t offset = 0;
        std::uint16_t narrow = 0;
        if (wide) {
            std::memcpy(&offset, begin + layout.ranks + 4 * triangle, 4);
        } else {
            std::memcpy(&narrow, begin + layout.ranks + 2 * triangle, 2);
            offset = narrow;
        }
        take(header.base + offset);
    }
}

/// Calls take(rank) for all of a leaf's list.
template <class Take>
void take_list(const ProximityArrays& arrays, std::uint64_t leaf, const Take& take) noexcept
{
    if (leaf == proximity_word::search) return;
    if (!proximity_word::is_run(leaf)) {
        take_ranks(arrays, proximity_word::position(leaf), proximity_word::mask(leaf), take);
        return;
    }
    const std::size_t begin = proximity_word::position(leaf);
    for (const RunEntry& entry : arrays.runs.subspan(begin + 1, arrays.runs[begin].position))
        take_ranks(arrays, entry.position, entry.mask, take);
}

} // namespace

Result<std::uint64_t> root_word(const ProximityArrays& arrays)
{
    const auto bad = [](std::string message, std::size_t node) {
        return fail(ErrorCode::broken_invariant, std::move(message), concat("node ", node));
    };
    const std::span<const std::uint64_t> nodes = arrays.nodes;
    if (nodes.size() % 8 != 0) return bad("nodes come by eight", nodes.size());
    if (nodes.empty()) {
        if (arrays.table.empty()) return bad("no cells at all", 0);
        if (!proximity_word::is_leaf(arrays.table[0])) return bad("children beyond the nodes", 0);
        return arrays.table[0];
    }
    std::vector<bool> named(nodes.size() / 8);
    std::size_t count = 0;
    for (std::size_t i = 0; i < nodes.size(); ++i) {
        const std::uint64_t word = nodes[i];
        if (proximity_word::is_leaf(word)) continue;
        if (word % 8 != 0 || word > nodes.size() - 8) return bad("children beyond the nodes", i);
        if (named[word / 8]) return bad("children of two cells", word);
        named[word / 8] = true;
        ++count;
    }
    if (count + 1 != named.size()) {
        return bad(concat(named.size() - count, " cells without a parent"), 0);
    }
    return 8 *
           static_cast<std::uint64_t>(std::find(named.begin(), named.end(), false) - named.begin());
}

std::uint32_t list_length(const ProximityArrays& arrays, std::uint64_t leaf) noexcept
{
    if (leaf == proximity_word::search) return 0;
    if (proximity_word::is_block(leaf))
        return static_cast<std::uint32_t>(std::popcount(proximity_word::mask(leaf)));
    const std::size_t begin = proximity_word::position(leaf);
    std::uint32_t length = 0;
    for (const RunEntry& entry : arrays.runs.subspan(begin + 1, arrays.runs[begin].position))
        length += static_cast<std::uint32_t>(std::popcount(entry.mask));
    return length;
}

void read_list(const ProximityArrays& arrays, std::uint64_t leaf, std::vector<std::uint32_t>& ranks)
{
    ranks.clear();
    ranks.reserve(list_length(arrays, leaf));
    take_list(arrays, leaf, [&](std::uint32_t rank) { ranks.push_back(rank); });
}

std::size_t read_list(const ProximityArrays& arrays, std::span<const TriangleId> ids,
                      std::uint64_t leaf, std::span<TriangleId> triangles) noexcept
{
    std::size_t count = 0;
    take_list(arrays, leaf, [&](std::uint32_t rank) {
        if (count < triangles.size()) triangles[count] = ids[rank];
        ++count;
    });
    return count;
}

void fill_table(std::uint64_t root, std::span<const std::uint64_t> nodes, int depth,
                std::span<std::uint64_t> table) noexcept
{
    const std::uint32_t edge = 1U << depth;
    for (std::uint32_t z = 0; z < edge; ++z) {
        for (std::uint32_t y = 0; y < edge; ++y) {
            for (std::uint32_t x = 0; x < edge; ++x) {
                std::uint64_t word = root;
                for (int level = depth - 1; level >= 0 && !proximity_word::is_leaf(word); --level) {
                    word = nodes[word + ((x >> level & 1U) | (y >> level & 1U) << 1U |
                                         (z >> level & 1U) << 2U)];
                }
                table[(std::size_t{z} << depth | y) << depth | x] = word;
            }
        }
    }
}

} // namespace proxima
