#include "proxima/query/ray_block_rows.h"

#include <algorithm>
#include <array>
#include <cstddef>

namespace proxima {

namespace {

constexpr std::uint32_t place_of(std::uint32_t reference) noexcept
{
    return reference & ~ray_leaf_bit;
}

} // namespace

std::vector<RayBlockRows> rows_of_blocks(std::span<const RayBlock> blocks, std::uint32_t root)
{
    std::vector<RayBlockRows> rows(blocks.size());
    std::vector<bool> is_node(blocks.size());
    is_node[place_of(root)] = (root & ray_leaf_bit) == 0;
    for (std::size_t i = 0; i < blocks.size(); ++i) {
        if (!is_node[i]) {
            rows[i].first = blocks[i].leaf.first_row;
            continue;
        }
        for (const std::uint32_t child : blocks[i].node.children)
            is_node[place_of(child)] = (child & ray_leaf_bit) == 0;
    }
    for (std::size_t i = blocks.size(); i-- > 0;) {
        if (!is_node[i]) continue;
        struct Child {
            std::uint32_t first;
            std::uint32_t place;
        };
        std::array<Child, 8> children{};
        std::uint32_t count = 0;
        for (std::uint32_t place = 0; place < 8; ++place) {
            const std::uint32_t child = place_of(blocks[i].node.children[place]);
            // Unused places refer to a leaf of nothing, before all others.
            if (child > i) children[count++] = {rows[child].first, place};
        }
        const auto used = std::span(children).first(count);
        std::ranges::sort(used, {}, &Child::first);
        rows[i] = {used.front().first, ~0U};
        for (std::uint32_t k = 0; k < count; ++k) {
            const std::uint32_t shift = 4 * k;
            rows[i].order = (rows[i].order & ~(RayBlockRows::no_child << shift)) | used[k].place << shift;
        }
    }
    return rows;
}

} // namespace proxima
