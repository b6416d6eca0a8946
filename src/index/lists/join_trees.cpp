#include "index/lists/join_trees.h"

#include <algorithm>
#include <cstring>

namespace proxima {

namespace {

/// A position as words have it; another one where there are too many (EmittedLists::part_of).
std::uint32_t name(std::size_t position) noexcept
{
    return static_cast<std::uint32_t>(position) & proximity_word::max_position;
}

std::uint32_t position_of(std::size_t byte) noexcept
{
    return name(byte / block_alignment);
}

std::uint32_t block_at(const EmittedTree& tree, std::size_t first_byte,
                       std::uint32_t number) noexcept
{
    return position_of(first_byte + tree.positions[number]);
}

} // namespace

std::uint64_t moved_word(std::uint64_t word, const EmittedTree& tree,
                         const TreePlace& place) noexcept
{
    if (word == proximity_word::search) return word;
    if (!proximity_word::is_leaf(word)) return word + place.first_node;
    const std::uint32_t position = proximity_word::position(word);
    if (proximity_word::is_run(word)) return proximity_word::run(name(position + place.first_run));
    return proximity_word::leaf(block_at(tree, place.first_byte, position),
                                proximity_word::mask(word));
}

OctreeJoiner::OctreeJoiner(EmittedLists& octree, std::span<const EmittedTree> trees,
                           const RankBlocks& by_rank)
    : octree_(octree), by_rank_(by_rank), positions_by_rank_(by_rank.size(), no_position)
{
    std::size_t nodes = 0;
    std::size_t runs = 0;
    std::size_t bytes = block_padding + by_rank.size() * usual_block_bytes;
    for (const EmittedTree& tree : trees) {
        nodes += tree.nodes.size();
        runs += tree.runs.size();
        bytes += tree.arena.size() + block_alignment;
    }
    octree.nodes.reserve(nodes + nodes / 16);
    octree.runs.reserve(runs + runs / 16);
    octree.arena.reserve(bytes + bytes / 16);
}

std::uint64_t OctreeJoiner::join(const EmittedTree& tree)
{
    const std::size_t first_node = octree_.nodes.size();
    const std::size_t first_run = octree_.runs.size();
    const std::size_t first_byte = aligned_end();
    const auto moved = [&](std::uint64_t word) {
        return moved_word(word, tree, {first_node, first_run, first_byte});
    };
    octree_.nodes.resize(first_node + tree.nodes.size());
    for (std::size_t i = 0; i < tree.nodes.size(); ++i)
        octree_.nodes[first_node + i] = moved(tree.nodes[i]);
    append_bytes(first_byte, tree.arena);
    octree_.runs.resize(first_run + tree.runs.size());
    for (std::size_t at = 0; at < tree.runs.size();) {
        const std::uint32_t count = tree.runs[at].position;
        octree_.runs[first_run + at] = tree.runs[at];
        for (const std::size_t last = at++ + count; at <= last; ++at) {
            RunEntry entry = tree.runs[at];
            entry.position = (entry.position & by_rank_bit) != 0
                                 ? block_by_rank(entry.position & ~by_rank_bit)
                                 : block_at(tree, first_byte, entry.position);
            octree_.runs[first_run + at] = entry;
        }
    }
    count(tree.statistics);
    return moved(tree.root);
}

std::uint32_t OctreeJoiner::block_by_rank(std::uint32_t block)
{
    std::uint32_t& position = positions_by_rank_[block];
    if (position != no_position) return position;
    bytes_.clear();
    (void)by_rank_.append(block, bytes_);
    const std::size_t first_byte = aligned_end();
    append_bytes(first_byte, bytes_);
    ++octree_.statistics.blocks;
    return position = position_of(first_byte);
}

std::size_t OctreeJoiner::aligned_end() const
{
    return (octree_.arena.size() + block_alignment - 1) / block_alignment * block_alignment;
}

void OctreeJoiner::append_bytes(std::size_t first_byte, std::span<const std::byte> bytes)
{
    if (bytes.empty()) return;
    const std::size_t end = octree_.arena.size();
    octree_.arena.resize(first_byte + bytes.size());
    if (first_byte > end) std::memset(octree_.arena.data() + end, 0, first_byte - end);
    std::memcpy(octree_.arena.data() + first_byte, bytes.data(), bytes.size());
}

void OctreeJoiner::count(const ProximityStatistics& more)
{
    ProximityStatistics& all = octree_.statistics;
    all.nodes += more.nodes;
    all.leaves += more.leaves;
    all.searched_leaves += more.searched_leaves;
    all.references += more.references;
    all.blocks += more.blocks;
    all.max_depth = std::max(all.max_depth, more.max_depth);
    all.max_list = std::max(all.max_list, more.max_list);
    all.worst_case_blocks = std::max(all.worst_case_blocks, more.worst_case_blocks);
    all.expected_list += more.expected_list;
}

} // namespace proxima
