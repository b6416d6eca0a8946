#include "proxima/proximity/emit_octree.h"

#include "proxima/base/check.h"
#include "proxima/geometry/closest_point.h"
#include "proxima/proximity/proximity_cells.h"
#include "proxima/proximity/rank_blocks.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <limits>
#include <memory>
#include <mutex>

namespace proxima {

namespace {

/// In a tree on its own: a run's block is one of the blocks by rank, which all trees share.
constexpr std::uint32_t by_rank_bit = 1U << 31U;

/// A tree with places of its own: nodes and runs count from its own beginning, blocks by number.
struct EmittedTree {
    std::uint64_t root = 0;
    std::vector<std::uint64_t> nodes;
    std::vector<RunEntry> runs;
    std::vector<std::size_t> places; ///< of blocks in the arena
    std::vector<std::byte> arena;
    ProximityStatistics statistics;
};

/// Emits one tree after the other.
class TreeEmitter {
public:
    TreeEmitter(const BlockSource& source, const RankBlocks& by_rank, double frame_half)
        : source_(source), by_rank_(by_rank), frame_half_(frame_half), sharer_(source)
    {}

    /// `root` is the cell to begin with.
    EmittedTree emit(const GrownTree& tree)
    {
        tree_ = &tree;
        result_ = {};
        sharer_.begin();
        const std::uint64_t root = word_of(tree.cells[0], tree.key);
        result_.root = root;
        sharer_.end();
        result_.places = sharer_.places();
        result_.arena = sharer_.arena();
        result_.statistics.blocks = result_.places.size();
        return std::move(result_);
    }

    /// The word of a leaf of the top, into a tree of its own.
    EmittedTree emit_leaf(const GrownTree& tree, std::size_t cell, CellKey key)
    {
        tree_ = &tree;
        result_ = {};
        sharer_.begin();
        result_.root = leaf_word(tree.cells[cell], key);
        sharer_.end();
        result_.places = sharer_.places();
        result_.arena = sharer_.arena();
        result_.statistics.blocks = result_.places.size();
        return std::move(result_);
    }

private:
    std::uint64_t word_of(const GrownCell& cell, CellKey key)
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

    std::uint64_t leaf_word(const GrownCell& cell, CellKey key)
    {
        count_leaf(cell, key);
        if (cell.searched != 0) return proximity_word::search;
        tree_->read_list(cell, ranks_);
        split_list();
        if (chunks_.size() != 2) return proximity_word::run(add_run(key));
        result_.statistics.worst_case_blocks = std::max(result_.statistics.worst_case_blocks, 1U);
        const BlockSharer::Place place = sharer_.place(ranks_);
        return proximity_word::leaf(place.number, place.mask);
    }

    void count_leaf(const GrownCell& cell, CellKey key)
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

    /// Where the list's chunks begin, each small enough for a block, and where the last one ends.
    void split_list()
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

    std::uint32_t add_run(CellKey key)
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
                entry.place = part.block | by_rank_bit;
                entry.mask = part.mask;
            }
        } else {
            for (std::size_t i = 0; i + 1 < chunks_.size(); ++i) {
                const auto ranks =
                    std::span(ranks_).subspan(chunks_[i], chunks_[i + 1] - chunks_[i]);
                RunEntry& entry = result_.runs.emplace_back(bound(ranks, center));
                const BlockSharer::Place place = sharer_.place(ranks);
                entry.place = place.number;
                entry.mask = place.mask;
            }
        }
        const auto count = static_cast<std::uint32_t>(result_.runs.size() - begin - 1);
        result_.runs[begin].place = count;
        result_.statistics.worst_case_blocks =
            std::max(result_.statistics.worst_case_blocks, count);
        std::stable_sort(result_.runs.begin() + static_cast<std::ptrdiff_t>(begin) + 1,
                         result_.runs.end(),
                         [](const RunEntry& a, const RunEntry& b) { return a.least < b.least; });
        return static_cast<std::uint32_t>(begin);
    }

    /// The list's parts by the blocks of their ranks.
    void find_blocks_by_rank()
    {
        parts_.clear();
        for (std::size_t i = 0; i < ranks_.size(); ++i) {
            const RankBlocks::Place place = by_rank_.place(ranks_[i]);
            if (parts_.empty() || parts_.back().block != place.block ||
                i - parts_.back().begin == list_triangles)
                parts_.push_back({place.block, 0, i, i});
            parts_.back().mask |= 1U << (ranks_[i] - place.first);
            parts_.back().end = i + 1;
        }
    }

    [[nodiscard]] Vec3 center_of(CellKey key) const
    {
        const auto place = cell_coordinates(key);
        const double edge = 2 * frame_half_ / static_cast<double>(1U << depth(key));
        Vec3 center;
        for (int axis = 0; axis < 3; ++axis)
            center[axis] = -frame_half_ + edge * (place[static_cast<std::size_t>(axis)] + 0.5);
        return center;
    }

    /// A lower bound on distances from about the cell's centre.
    [[nodiscard]] RunEntry bound(std::span<const std::uint32_t> chunk, const Vec3& center) const
    {
        double squared = std::numeric_limits<double>::infinity();
        Vec3 towards = Vec3::Zero();
        for (const std::uint32_t rank : chunk) {
            const auto& v = source_.triangles[rank];
            const Vec3 point =
                closest_point(Triangle{{source_.positions[v[0]], source_.positions[v[1]],
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
        for (const std::uint32_t rank : chunk)
            for (const std::uint32_t vertex : source_.triangles[rank])
                least = std::min(least, used.dot(source_.positions[vertex] - center));
        entry.least = static_cast<float>(least) - 0x1p-20F;
        return entry;
    }

    /// Of a list: a block by rank and what it has of it, entries begin to end.
    struct RankPart {
        std::uint32_t block = 0;
        std::uint32_t mask = 0;
        std::size_t begin = 0;
        std::size_t end = 0;
    };

    BlockSource source_;
    const RankBlocks& by_rank_;
    double frame_half_;
    BlockSharer sharer_;
    const GrownTree* tree_ = nullptr;
    EmittedTree result_;
    std::vector<std::uint32_t> ranks_;
    std::vector<std::size_t> chunks_;
    std::vector<RankPart> parts_;
};

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
    if (options.progress != nullptr) options.progress->begin_stage("blocks", trees.size());
    parallel_for(trees.size(), options.threads, [&](std::size_t i) {
        if (is_cancelled(options.progress)) return;
        if (used[i]) {
            auto emitter = pool.take();
            emitted[i] = emitter->emit(trees[i]);
            pool.give_back(std::move(emitter));
        }
        if (options.progress != nullptr) options.progress->advance(1);
    });
    if (is_cancelled(options.progress)) return std::nullopt;
    return emitted;
}

/// Joins trees into one.
class OctreeJoiner {
public:
    /// Room for all at once: what moves while it grows loses its huge pages.
    OctreeJoiner(EmittedOctree& octree, std::span<const EmittedTree> trees,
                 const RankBlocks& by_rank)
        : octree_(octree), by_rank_(by_rank), places_by_rank_(by_rank.size(), no_place)
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

    /// Copies the tree's arrays to the end. Returns the word of its root.
    std::uint64_t join(const EmittedTree& tree)
    {
        const std::size_t first_node = octree_.nodes.size();
        const std::size_t first_run = octree_.runs.size();
        const std::size_t first_byte = aligned_end();
        const auto moved = [&](std::uint64_t word) {
            if (word == proximity_word::search) return word;
            if (!proximity_word::is_leaf(word)) return word + first_node;
            const std::uint32_t place = proximity_word::place(word);
            if (proximity_word::is_run(word))
                return proximity_word::run(place + static_cast<std::uint32_t>(first_run));
            return proximity_word::leaf(block_at(tree, first_byte, place),
                                        proximity_word::mask(word));
        };
        octree_.nodes.resize(first_node + tree.nodes.size());
        for (std::size_t i = 0; i < tree.nodes.size(); ++i)
            octree_.nodes[first_node + i] = moved(tree.nodes[i]);
        append_bytes(first_byte, tree.arena);
        octree_.runs.resize(first_run + tree.runs.size());
        for (std::size_t at = 0; at < tree.runs.size();) {
            const std::uint32_t count = tree.runs[at].place;
            octree_.runs[first_run + at] = tree.runs[at];
            for (const std::size_t last = at++ + count; at <= last; ++at) {
                RunEntry entry = tree.runs[at];
                entry.place = (entry.place & by_rank_bit) != 0
                                  ? block_by_rank(entry.place & ~by_rank_bit)
                                  : block_at(tree, first_byte, entry.place);
                octree_.runs[first_run + at] = entry;
            }
        }
        count(tree.statistics);
        return moved(tree.root);
    }

private:
    static constexpr std::size_t usual_block_bytes = 384;

    static std::uint32_t block_at(const EmittedTree& tree, std::size_t first_byte,
                                  std::uint32_t number)
    {
        return place_of(first_byte + tree.places[number]);
    }

    static std::uint32_t place_of(std::size_t byte)
    {
        PROXIMA_CHECK_LE(byte / block_alignment, proximity_word::max_place);
        return static_cast<std::uint32_t>(byte / block_alignment);
    }

    /// Written when it is first met.
    std::uint32_t block_by_rank(std::uint32_t block)
    {
        std::uint32_t& place = places_by_rank_[block];
        if (place != no_place) return place;
        bytes_.clear();
        (void)by_rank_.append(block, bytes_);
        const std::size_t first_byte = aligned_end();
        append_bytes(first_byte, bytes_);
        ++octree_.statistics.blocks;
        return place = place_of(first_byte);
    }

    [[nodiscard]] std::size_t aligned_end() const
    {
        return (octree_.arena.size() + block_alignment - 1) / block_alignment * block_alignment;
    }

    void append_bytes(std::size_t first_byte, std::span<const std::byte> bytes)
    {
        if (bytes.empty()) return;
        const std::size_t end = octree_.arena.size();
        octree_.arena.resize(first_byte + bytes.size());
        if (first_byte > end) std::memset(octree_.arena.data() + end, 0, first_byte - end);
        std::memcpy(octree_.arena.data() + first_byte, bytes.data(), bytes.size());
    }

    void count(const ProximityStatistics& more)
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

    static constexpr std::uint32_t no_place = 0xFFFFFFFF;

    EmittedOctree& octree_;
    const RankBlocks& by_rank_;
    std::vector<std::uint32_t> places_by_rank_; ///< in the arena
    std::vector<std::byte> bytes_;
};

/// Emits the top's own leaves and links the trees below it.
std::uint64_t join_top(const GrownForest& forest, const std::vector<std::uint64_t>& roots,
                       std::size_t cell, CellKey key, TreeEmitter& emitter, OctreeJoiner& joiner,
                       EmittedOctree& octree)
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
void make_table(EmittedOctree& octree, std::uint64_t root)
{
    while (octree.table_depth < max_table_depth &&
           std::size_t{1} << 3 * (octree.table_depth + 1) <= octree.nodes.size() / 2)
        ++octree.table_depth;
    octree.table.resize(std::size_t{1} << 3 * octree.table_depth);
    fill_table(root, octree.nodes.span(), octree.table_depth,
               {octree.table.data(), octree.table.size()});
}

} // namespace

std::uint64_t EmittedOctree::bytes() const noexcept
{
    return table.span().size_bytes() + nodes.span().size_bytes() + runs.span().size_bytes() +
           arena.span().size_bytes();
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

std::optional<EmittedOctree> emit_octree(const GrownForest& forest, const BlockSource& source,
                                         const EmitOptions& options)
{
    std::vector<bool> used(forest.below.size());
    find_trees_in_use(forest, 0, used);
    const RankBlocks by_rank(source);
    EmitterPool pool(source, by_rank, options.frame_half);
    auto emitted = emit_trees(forest.below, used, pool, options);
    if (!emitted) return std::nullopt;
    std::vector<EmittedTree>& trees = *emitted;

    EmittedOctree octree;
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
