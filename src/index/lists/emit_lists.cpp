#include "index/lists/emit_lists.h"

#include "base/parallel.h"
#include "base/progress.h"
#include "index/lists/emit_tree.h"
#include "index/lists/join_trees.h"
#include "index/lists/proximity_cells.h"
#include "index/lists/rank_blocks.h"

#include <algorithm>
#include <cstring>
#include <memory>
#include <mutex>

namespace proxima {

namespace {

/// Emitters that threads take and give back: each has a word per triangle.
class EmitterPool {
public:
    EmitterPool(const BlockSource& source, const RankBlocks& by_rank, double frame_half)
        : source_(source), by_rank_(by_rank), frame_half_(frame_half)
    {}

    std::unique_ptr<TreeEmitter> take()
    {
        const std::lock_guard lock(mutex_);
        if (free_.empty()) return std::make_unique<TreeEmitter>(source_, by_rank_, frame_half_);
        auto emitter = std::move(free_.back());
        free_.pop_back();
        return emitter;
    }

    void give_back(std::unique_ptr<TreeEmitter> emitter)
    {
        const std::lock_guard lock(mutex_);
        free_.push_back(std::move(emitter));
    }

private:
    BlockSource source_;
    const RankBlocks& by_rank_;
    double frame_half_;
    std::mutex mutex_;
    std::vector<std::unique_ptr<TreeEmitter>> free_;
};

/// Those that the top still leads to.
void find_trees_in_use(const GrownForest& forest, std::size_t cell, std::vector<bool>& used)
{
    const GrownCell& grown = forest.top.cells[cell];
    if (grown.ended != 0) return;
    if (forest.below_of[cell] != GrownForest::no_tree) {
        used[forest.below_of[cell]] = true;
        return;
    }
    for (std::size_t i = 0; i < 8; ++i) find_trees_in_use(forest, grown.children + i, used);
}

/// The trees in use, each on its own. Null where cancelled.
std::optional<std::vector<EmittedTree>> emit_trees(std::span<const GrownTree> trees,
                                                   const std::vector<bool>& used, EmitterPool& pool,
                                                   const EmitOptions& options)
{
    std::vector<EmittedTree> emitted(trees.size());
    begin_stage(options.execution.progress, "blocks", trees.size());
    parallel_for(trees.size(), options.execution.threads, [&](std::size_t i) {
        if (is_cancelled(options.execution.progress)) return;
        if (used[i]) {
            auto emitter = pool.take();
            emitted[i] = emitter->emit(trees[i]);
            pool.give_back(std::move(emitter));
        }
        advance_stage(options.execution.progress, 1);
    });
    if (is_cancelled(options.execution.progress)) return std::nullopt;
    return emitted;
}

/// Emits the top's own leaves and links the trees below it.
std::uint64_t join_top(const GrownForest& forest, const std::vector<std::uint64_t>& roots,
                       std::size_t cell, CellKey key, TreeEmitter& emitter, OctreeJoiner& joiner,
                       EmittedLists& octree)
{
    const GrownCell& grown = forest.top.cells[cell];
    if (grown.ended != 0) return joiner.join(emitter.emit_leaf(forest.top, cell, key));
    if (forest.below_of[cell] != GrownForest::no_tree) return roots[forest.below_of[cell]];
    ++octree.statistics.nodes;
    std::array<std::uint64_t, 8> words{};
    for (int octant = 0; octant < 8; ++octant) {
        const auto k = static_cast<std::size_t>(octant);
        words[k] = join_top(forest, roots, grown.children + k, child(key, octant), emitter, joiner,
                            octree);
    }
    const std::size_t base = octree.nodes.size();
    octree.nodes.resize(base + 8);
    std::ranges::copy(words, octree.nodes.begin() + base);
    return base;
}

/// Half as many words as the nodes at most.
void make_table(EmittedLists& octree, std::uint64_t root)
{
    while (octree.table_depth < max_table_depth &&
           std::size_t{1} << 3 * (octree.table_depth + 1) <= octree.nodes.size() / 2)
        ++octree.table_depth;
    octree.table.resize(std::size_t{1} << 3 * octree.table_depth);
    fill_table(root, octree.nodes.span(), octree.table_depth,
               {octree.table.data(), octree.table.size()});
}

} // namespace

std::uint64_t EmittedLists::bytes() const noexcept
{
    return table.span().size_bytes() + nodes.span().size_bytes() + runs.span().size_bytes() +
           arena.span().size_bytes();
}

double part_of_words(std::size_t arena_bytes, std::size_t runs) noexcept
{
    constexpr double positions = 1.0 + proximity_word::max_position;
    return std::max(static_cast<double>(arena_bytes) / (positions * block_alignment),
                    static_cast<double>(runs) / positions);
}

double EmittedLists::part_of(double most_bytes) const noexcept
{
    return std::max(static_cast<double>(bytes()) / most_bytes,
                    part_of_words(arena.size(), runs.size()));
}

std::optional<double> emitted_bytes(std::span<const GrownTree> trees, const BlockSource& source,
                                    const EmitOptions& options)
{
    const std::vector<bool> used(trees.size(), true);
    const RankBlocks by_rank(source);
    EmitterPool pool(source, by_rank, options.frame_half);
    const auto emitted = emit_trees(trees, used, pool, options);
    if (!emitted) return std::nullopt;
    std::size_t bytes = 0;
    for (const EmittedTree& tree : *emitted) {
        bytes += std::span(tree.nodes).size_bytes() + std::span(tree.runs).size_bytes() +
                 tree.arena.size();
    }
    return static_cast<double>(bytes);
}

std::optional<EmittedLists> emit_lists(const GrownForest& forest, const BlockSource& source,
                                       const EmitOptions& options)
{
    std::vector<bool> used(forest.below.size());
    find_trees_in_use(forest, 0, used);
    const RankBlocks by_rank(source);
    EmitterPool pool(source, by_rank, options.frame_half);
    auto emitted = emit_trees(forest.below, used, pool, options);
    if (!emitted) return std::nullopt;
    std::vector<EmittedTree>& trees = *emitted;

    EmittedLists octree;
    OctreeJoiner joiner(octree, trees, by_rank);
    std::vector<std::uint64_t> roots;
    for (EmittedTree& tree : trees) {
        roots.push_back(tree.statistics.nodes == 0 ? 0 : joiner.join(tree));
        tree = {};
    }
    const auto emitter = pool.take();
    const std::uint64_t root = join_top(forest, roots, 0, CellKey{}, *emitter, joiner, octree);
    make_table(octree, root);
    octree.arena.resize(octree.arena.size() + block_padding);
    std::memset(octree.arena.data() + (octree.arena.size() - block_padding), 0, block_padding);
    ProximityStatistics& counts = octree.statistics;
    counts.mean_list = mean_list(counts);
    counts.worst_case_steps =
        1 + (counts.max_depth > static_cast<std::uint32_t>(octree.table_depth)
                 ? counts.max_depth - static_cast<std::uint32_t>(octree.table_depth)
                 : 0);
    return octree;
}

} // namespace proxima
