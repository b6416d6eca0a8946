#include "index/lists/emit_tree.h"

#include "geometry/closest_point.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace proxima {

TreeEmitter::TreeEmitter(const BlockSource& source, const RankBlocks& by_rank, double frame_half)
    : source_(source), by_rank_(by_rank), frame_half_(frame_half), sharer_(source)
{}

EmittedTree TreeEmitter::emit(const GrownTree& tree)
{
    begin(tree);
    return take_result(word_of(tree.cells[0], tree.key));
}

EmittedTree TreeEmitter::emit_leaf(const GrownTree& tree, std::size_t cell, CellKey key)
{
    begin(tree);
    return take_result(leaf_word(tree.cells[cell], key));
}

void TreeEmitter::begin(const GrownTree& tree)
{
    tree_ = &tree;
    result_ = {};
    sharer_.begin();
}

EmittedTree TreeEmitter::take_result(std::uint64_t root)
{
    result_.root = root;
    sharer_.end();
    result_.positions = sharer_.positions();
    result_.arena = sharer_.arena();
    result_.statistics.blocks = result_.positions.size();
    return std::move(result_);
}

std::uint64_t TreeEmitter::word_of(const GrownCell& cell, CellKey key)
{
    if (GrownTree::is_leaf(cell)) return leaf_word(cell, key);
    ++result_.statistics.nodes;
    const auto base = static_cast<std::uint32_t>(result_.nodes.size());
    result_.nodes.resize(base + 8);
    for (int octant = 0; octant < 8; ++octant) {
        const auto k = static_cast<std::uint32_t>(octant);
        const std::uint64_t word = word_of(tree_->cells[cell.children + k], child(key, octant));
        result_.nodes[base + k] = word;
    }
    return base;
}

std::uint64_t TreeEmitter::leaf_word(const GrownCell& cell, CellKey key)
{
    count_leaf(cell, key);
    if (cell.searched != 0) return proximity_word::search;
    tree_->read_list(cell, ranks_);
    split_list();
    if (chunks_.size() != 2) return proximity_word::run(add_run(key));
    result_.statistics.worst_case_blocks = std::max(result_.statistics.worst_case_blocks, 1U);
    const BlockSharer::Location location = sharer_.put(ranks_);
    return proximity_word::leaf(location.number, location.mask);
}

void TreeEmitter::count_leaf(const GrownCell& cell, CellKey key)
{
    ProximityStatistics& counts = result_.statistics;
    ++counts.nodes;
    ++counts.leaves;
    counts.max_depth = std::max(counts.max_depth, static_cast<std::uint32_t>(depth(key)));
    if (cell.searched != 0) {
        ++counts.searched_leaves;
        return;
    }
    counts.references += cell.triangles;
    counts.max_list = std::max<std::uint32_t>(counts.max_list, cell.triangles);
    counts.expected_list += static_cast<double>(cell.probability) * cell.triangles;
}

void TreeEmitter::split_list()
{
    chunks_.assign(1, 0);
    std::array<std::uint32_t, block_vertices> vertices{};
    std::size_t count = 0;
    for (std::size_t i = 0; i < ranks_.size(); ++i) {
        for (int again = 0; again < 2; ++again) {
            std::size_t grown = count;
            bool fits = i - chunks_.back() < list_triangles;
            for (const std::uint32_t vertex : source_.triangles[ranks_[i]]) {
                auto* const end = vertices.data() + grown;
                if (!fits || std::find(vertices.data(), end, vertex) != end) continue;
                fits = grown < block_vertices;
                if (fits) vertices[grown++] = vertex;
            }
            if (fits) {
                count = grown;
                break;
            }
            chunks_.push_back(i);
            count = 0;
        }
    }
    chunks_.push_back(ranks_.size());
}

std::uint32_t TreeEmitter::add_run(CellKey key)
{
    const Vec3 exact_center = center_of(key);
    const std::size_t begin = result_.runs.size();
    RunEntry head;
    Vec3 center;
    for (int axis = 0; axis < 3; ++axis) {
        head.direction[axis] = static_cast<float>(exact_center[axis]);
        center[axis] = static_cast<double>(head.direction[axis]);
    }
    result_.runs.push_back(head);
    find_blocks_by_rank();
    // A few more blocks are worth it: they cost no memory, and are met again and again.
    if (parts_.size() <= chunks_.size() + chunks_.size() / 2) {
        for (const RankPart& part : parts_) {
            const auto ranks = std::span(ranks_).subspan(part.begin, part.end - part.begin);
            RunEntry& entry = result_.runs.emplace_back(bound(ranks, center));
            entry.position = part.block | by_rank_bit;
            entry.mask = part.mask;
        }
    } else {
        for (std::size_t i = 0; i + 1 < chunks_.size(); ++i) {
            const auto ranks = std::span(ranks_).subspan(chunks_[i], chunks_[i + 1] - chunks_[i]);
            RunEntry& entry = result_.runs.emplace_back(bound(ranks, center));
            const BlockSharer::Location location = sharer_.put(ranks);
            entry.position = location.number;
            entry.mask = location.mask;
        }
    }
    const auto count = static_cast<std::uint32_t>(result_.runs.size() - begin - 1);
    result_.runs[begin].position = count;
    result_.statistics.worst_case_blocks = std::max(result_.statistics.worst_case_blocks, count);
    std::stable_sort(result_.runs.begin() + static_cast<std::ptrdiff_t>(begin) + 1,
                     result_.runs.end(),
                     [](const RunEntry& a, const RunEntry& b) { return a.least < b.least; });
    return static_cast<std::uint32_t>(begin);
}

void TreeEmitter::find_blocks_by_rank()
{
    parts_.clear();
    for (std::size_t i = 0; i < ranks_.size(); ++i) {
        const RankBlocks::Location location = by_rank_.location(ranks_[i]);
        if (parts_.empty() || parts_.back().block != location.block ||
            i - parts_.back().begin == list_triangles)
            parts_.push_back({location.block, 0, i, i});
        parts_.back().mask |= 1U << (ranks_[i] - location.first);
        parts_.back().end = i + 1;
    }
}

Vec3 TreeEmitter::center_of(CellKey key) const
{
    const auto location = cell_coordinates(key);
    const double edge = 2 * frame_half_ / static_cast<double>(1U << depth(key));
    Vec3 center;
    for (int axis = 0; axis < 3; ++axis)
        center[axis] = -frame_half_ + edge * (location[static_cast<std::size_t>(axis)] + 0.5);
    return center;
}

RunEntry TreeEmitter::bound(std::span<const std::uint32_t> chunk, const Vec3& center) const
{
    double squared = std::numeric_limits<double>::infinity();
    Vec3 towards = Vec3::Zero();
    for (const std::uint32_t rank : chunk) {
        const auto& v = source_.triangles[rank];
        const Vec3 point = closest_point(Triangle{{source_.positions[v[0]], source_.positions[v[1]],
                                                   source_.positions[v[2]]}},
                                         center)
                               .point;
        if ((point - center).squaredNorm() < squared) {
            towards = point - center;
            squared = towards.squaredNorm();
        }
    }
    RunEntry entry;
    if (!(squared > 0)) return entry; // direction 0: the bound is 0
    const Vec3 unit = towards / std::sqrt(squared) * (1 - 0x1p-20);
    Vec3 used;
    for (int axis = 0; axis < 3; ++axis) {
        entry.direction[axis] = static_cast<float>(unit[axis]);
        used[axis] = static_cast<double>(entry.direction[axis]);
    }
    double least = std::numeric_limits<double>::infinity();
    for (const std::uint32_t rank : chunk) {
        for (const std::uint32_t vertex : source_.triangles[rank])
            least = std::min(least, used.dot(source_.positions[vertex] - center));
    }
    entry.least = static_cast<float>(least) - 0x1p-20F;
    return entry;
}

} // namespace proxima
