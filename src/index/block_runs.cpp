#include "index/block_runs.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

namespace proxima {

namespace {

constexpr std::uint32_t place_of(std::uint32_t reference) noexcept
{
    return reference & ~index_leaf_bit;
}

constexpr bool is_leaf(std::uint32_t reference) noexcept
{
    return (reference & index_leaf_bit) != 0;
}

} // namespace

void write_run(std::span<const IndexBlock> blocks, IndexNode& node)
{
    struct Child {
        std::uint32_t first;
        std::uint32_t place;
    };
    std::array<Child, 8> children{};
    std::uint32_t count = 0;
    for (std::uint32_t place = 0; place < 8; ++place) {
        const std::uint32_t reference = node.children[place];
        const IndexBlock& child = blocks[place_of(reference)];
        if (place_of(reference) == 0) continue; // nothing there
        const std::uint32_t first =
            is_leaf(reference) ? child.leaf.first_row : child.node.first_row;
        std::uint32_t k = count++;
        for (; k > 0 && children[k - 1].first > first; --k) children[k] = children[k - 1];
        children[k] = {first, place};
    }
    node.first_row = children[0].first;
    node.order = ~0U;
    node.starts.fill(0);
    for (std::uint32_t k = 0; k < count; ++k) {
        const auto [first, place] = children[k];
        node.order ^= (IndexNode::no_child ^ place) << 4 * k;
        node.starts[place] = static_cast<std::uint16_t>(
            std::min(first - node.first_row, std::uint32_t{IndexNode::far_start}));
    }
}

void write_runs(std::span<IndexBlock> blocks, std::uint32_t root)
{
    std::vector<std::uint32_t> nodes;
    if (!is_leaf(root)) nodes.push_back(root);
    for (std::size_t i = 0; i < nodes.size(); ++i) {
        for (const std::uint32_t child : blocks[nodes[i]].node.children)
            if (!is_leaf(child)) nodes.push_back(child);
    }
    // Children before their parents.
    for (std::size_t i = nodes.size(); i-- > 0;) write_run(blocks, blocks[nodes[i]].node);
}

} // namespace proxima
