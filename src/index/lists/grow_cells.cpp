#include "index/lists/grow_cells.h"

#include "base/parallel.h"
#include "base/progress.h"
#include "index/lists/cell_cover.h"
#include "index/lists/domination.h"
#include "index/lists/local_region.h"

#include <algorithm>
#include <array>
#include <bit>
#include <memory>
#include <numeric>

namespace proxima {

namespace {

/// Levels that are grown breadth-first.
constexpr int top_depth = 4;

/// In place of the number of a parent's triangles where the cell is not compared with it: more than any cell has.
constexpr std::size_t unknown = std::size_t{1} << 32U;

void append_list(std::span<const std::uint32_t> ranks, std::vector<std::uint8_t>& bytes)
{
    std::uint32_t last = 0;
    for (const std::uint32_t rank : ranks) {
        std::uint32_t difference = rank - last;
        last = rank;
        while (difference >= 0x80) {
            bytes.push_back(static_cast<std::uint8_t>(difference | 0x80U));
            difference >>= 7U;
        }
        bytes.push_back(static_cast<std::uint8_t>(difference));
    }
}

std::array<OpenCell, 8> children_of(const OpenCell& cell, const QueryDensity& density)
{
    std::array<OpenCell, 8> children;
    const std::array<CellDensity, 8> densities = density.split(cell.density, cell.key);
    for (int octant = 0; octant < 8; ++octant) {
        const auto i = static_cast<std::size_t>(octant);
        children[i].cube = child(cell.cube, octant);
        children[i].key = child(cell.key, octant);
        children[i].density = densities[i];
    }
    return children;
}

/// Counts the splits in a row that the children come from and that left nearly all of them with nearly all
/// features. Once, that may be, as round the middle of a ball. Where many triangles are in the same place it goes on
/// for ever: after the second time nothing is split.
void count_idle_splits(const OpenCell& cell, std::size_t features, std::size_t of_children,
                       std::array<OpenCell, 8>& children)
{
    const bool is_idle = of_children >= 6 * features;
    for (OpenCell& child : children)
        child.idle_splits = is_idle ? static_cast<std::uint8_t>(cell.idle_splits + 1) : 0;
}
constexpr int most_idle_splits = 2;

/// Splits cells; one per thread at a time.
class CellGrower {
public:
    CellGrower(const LocalFeatures& features, const QueryDensity& density,
               const GrowOptions& options)
        : features_(features), density_(density), options_(options)
    {}

    using Lists = std::array<std::vector<std::uint32_t>, 8>;

    /// The features whose regions reach a cell's children.
    void find_in_reach(const FrameCell& cube, std::span<const std::uint32_t> list, Lists& lists)
    {
        masks_.resize(list.size());
        find_children_in_reach(features_, list, cube, masks_.data());
        for (auto& one : lists) one.clear();
        for (std::size_t k = 0; k < list.size(); ++k) {
            for (unsigned mask = masks_[k]; mask != 0; mask &= mask - 1)
                lists[static_cast<std::size_t>(std::countr_zero(mask))].push_back(list[k]);
        }
    }

    /// Of a cell's features those that may be closest to a point of it.
    void drop_farther(const FrameCell& cube, std::vector<std::uint32_t>& list)
    {
        list.resize(drop_dominated(features_, list.data(), list.size(), cube, scratch_));
    }

    /// The features of a cell's children.
    void split(const FrameCell& cube, std::span<const std::uint32_t> list, Lists& lists)
    {
        find_in_reach(cube, list, lists);
        for (int octant = 0; octant < 8; ++octant)
            drop_farther(child(cube, octant), lists[static_cast<std::size_t>(octant)]);
    }

    /// Adds the cell's list to the tree and describes it.
    GrownCell describe(const OpenCell& cell, std::span<const std::uint32_t> list, GrownTree& tree)
    {
        cover_features(features_, list, taken_, cover_);
        GrownCell grown;
        grown.probability = static_cast<float>(density_.probability(cell.density, cell.key));
        grown.list = static_cast<std::uint32_t>(tree.lists.size());
        grown.triangles = static_cast<std::uint32_t>(cover_.size()) & 0x3FFFFFFFU;
        append_list(cover_, tree.lists);
        return grown;
    }

    /// A cell with all triangles of its parent is taken to keep a quarter of them below. Where many are in
    /// the same place, no cell has fewer, and all would be split down to the last level for nothing.
    [[nodiscard]] bool may_split(const GrownCell& grown, int depth, std::size_t parents) const
    {
        const std::size_t count = grown.triangles;
        const std::size_t fewest = count >= parents ? count / 4 : 1;
        return depth < options_.max_depth && count > options_.max_triangles &&
               options_.cost.may_split(grown.probability, count, fewest);
    }

    /// The tree of a cell and all that is below it.
    void grow_tree(const OpenCell& root, GrownTree& tree)
    {
        constexpr double least_work = 1 << 18;
        work_ = 0;
        most_work_ =
            std::max(options_.most_work * static_cast<double>(root.features.size()), least_work);
        tree.key = root.key;
        tree.cells.push_back(describe(root, root.features, tree));
        (void)grow(root, root.features, 0, unknown, tree);
        tree.cells.shrink_to_fit();
        tree.lists.shrink_to_fit();
    }

private:
    /// Everything below `cell`, whose description is tree.cells[position] and whose parent lists so many
    /// triangles. Returns the cost of the
    /// cheapest way to end, with what does not pay taken back.
    double grow(const OpenCell& cell, std::span<const std::uint32_t> list, std::size_t position,
                std::size_t parents, GrownTree& tree)
    {
        const GrownCell grown = tree.cells[position];
        const double as_leaf = options_.cost.leaf(grown.probability, grown.triangles);
        const int level = depth(cell.key);
        if (!may_split(grown, level, parents) || cell.idle_splits >= most_idle_splits ||
            work_ > most_work_ || tree.lists.size() > options_.most_list_bytes ||
            is_cancelled(options_.execution.progress))
            return as_leaf;
        work_ += static_cast<double>(list.size());

        auto& scratch = lists_at(level);
        split(cell.cube, list, scratch);
        std::array<OpenCell, 8> children = children_of(cell, density_);
        std::size_t of_children = 0;
        for (const auto& one : scratch) of_children += one.size();
        count_idle_splits(cell, list.size(), of_children, children);
        const std::size_t first = tree.cells.size();
        const std::size_t first_byte = tree.lists.size();
        for (std::size_t i = 0; i < 8; ++i)
            tree.cells.push_back(describe(children[i], scratch[i], tree));
        double as_split = options_.cost.split(grown.probability);
        for (std::size_t i = 0; i < 8; ++i)
            as_split += grow(children[i], scratch[i], first + i, grown.triangles, tree);
        if (as_split >= as_leaf) {
            tree.cells.resize(first);
            tree.lists.resize(first_byte);
            return as_leaf;
        }
        tree.cells[position].children = static_cast<std::uint32_t>(first);
        return as_split;
    }

    Lists& lists_at(int level)
    {
        auto& lists = levels_[static_cast<std::size_t>(level)];
        if (!lists) lists = std::make_unique<Lists>();
        return *lists;
    }

    const LocalFeatures& features_;
    const QueryDensity& density_;
    const GrowOptions& options_;
    std::vector<std::uint8_t> masks_;
    DominationScratch scratch_;
    RankSet taken_;
    std::vector<std::uint32_t> cover_;
    double work_ = 0;      ///< features that were looked at for the tree at hand
    double most_work_ = 0; ///< after which none of its cells is split
    std::array<std::unique_ptr<Lists>, max_list_depth + 1> levels_;
};

} // namespace

void GrownTree::read_list(const GrownCell& cell, std::vector<std::uint32_t>& ranks) const
{
    ranks.resize(cell.triangles);
    const std::uint8_t* byte = lists.data() + cell.list;
    std::uint32_t rank = 0;
    for (std::uint32_t& one : ranks) {
        std::uint32_t difference = 0;
        unsigned shift = 0;
        for (; (*byte & 0x80U) != 0; ++byte, shift += 7)
            difference |= static_cast<std::uint32_t>(*byte & 0x7FU) << shift;
        difference |= static_cast<std::uint32_t>(*byte++) << shift;
        rank += difference;
        one = rank;
    }
}

std::uint64_t GrownTree::bytes() const noexcept
{
    return std::span(cells).size_bytes() + std::span(lists).size_bytes();
}

std::optional<GrownTop> grow_top(const LocalFeatures& features, const QueryDensity& density,
                                 double frame_half, const GrowOptions& options)
{
    GrownTop top;
    std::vector<OpenCell>& level = top.open;
    level.resize(1);
    level[0].cube = {{0, 0, 0}, static_cast<float>(frame_half)};
    level[0].density = density.root();
    level[0].features.resize(features.features.size());
    std::iota(level[0].features.begin(), level[0].features.end(), 0U);
    CellGrower grower(features, density, options);
    top.tree.cells.push_back(grower.describe(level[0], level[0].features, top.tree));
    const auto drop_finished = [&](int depth) {
        std::erase_if(level, [&](const OpenCell& one) {
            return one.idle_splits >= most_idle_splits ||
                   !grower.may_split(top.tree.cells[one.position], depth, unknown);
        });
    };
    for (int depth = 0; depth < top_depth; ++depth) {
        drop_finished(depth);
        begin_stage(options.execution.progress, "topmost cells", 9 * level.size());
        std::vector<std::array<OpenCell, 8>> next(level.size());
        parallel_for(level.size(), options.execution.threads, [&](std::size_t i) {
            if (is_cancelled(options.execution.progress)) return;
            CellGrower own(features, density, options);
            CellGrower::Lists lists;
            own.find_in_reach(level[i].cube, level[i].features, lists);
            next[i] = children_of(level[i], density);
            for (std::size_t k = 0; k < 8; ++k) next[i][k].features = std::move(lists[k]);
            advance_stage(options.execution.progress, 1);
        });
        // Child by child: there is work for several threads from the root on.
        std::vector<GrownTree> described(8 * level.size());
        parallel_for(described.size(), options.execution.threads, [&](std::size_t i) {
            if (is_cancelled(options.execution.progress)) return;
            CellGrower own(features, density, options);
            OpenCell& one = next[i / 8][i % 8];
            own.drop_farther(one.cube, one.features);
            described[i].cells.push_back(own.describe(one, one.features, described[i]));
            advance_stage(options.execution.progress, 1);
        });
        if (is_cancelled(options.execution.progress)) return std::nullopt;
        std::uint64_t list_bytes = top.tree.lists.size();
        for (const GrownTree& one : described) list_bytes += one.lists.size();
        if (list_bytes > options.most_list_bytes) break; // each is split on its own
        for (std::size_t i = 0; i < level.size(); ++i) {
            std::size_t of_children = 0;
            for (const OpenCell& one : next[i]) of_children += one.features.size();
            count_idle_splits(level[i], level[i].features.size(), of_children, next[i]);
        }
        std::vector<OpenCell> cells;
        for (std::size_t i = 0; i < described.size(); ++i) {
            GrownTree& tree = top.tree;
            const auto position = static_cast<std::uint32_t>(tree.cells.size());
            if (i % 8 == 0) tree.cells[level[i / 8].position].children = position;
            OpenCell& one = next[i / 8][i % 8];
            one.position = position;
            GrownCell grown = described[i].cells[0];
            grown.list = static_cast<std::uint32_t>(tree.lists.size());
            tree.cells.push_back(grown);
            tree.lists.insert(tree.lists.end(), described[i].lists.begin(),
                              described[i].lists.end());
            described[i] = {};
            cells.push_back(std::move(one));
        }
        level = std::move(cells);
    }
    drop_finished(top_depth);
    return top;
}

std::optional<std::vector<GrownTree>> grow_below(const LocalFeatures& features,
                                                 const QueryDensity& density,
                                                 std::span<const OpenCell* const> open,
                                                 const GrowOptions& options)
{
    std::vector<GrownTree> trees(open.size());
    begin_stage(options.execution.progress, "cells", open.size());
    parallel_for(open.size(), options.execution.threads, [&](std::size_t i) {
        if (is_cancelled(options.execution.progress)) return;
        CellGrower grower(features, density, options);
        grower.grow_tree(*open[i], trees[i]);
        advance_stage(options.execution.progress, 1);
    });
    if (is_cancelled(options.execution.progress)) return std::nullopt;
    return trees;
}

GrownForest join_forest(GrownTop&& top, std::vector<GrownTree>&& below)
{
    GrownForest forest;
    forest.below_of.assign(top.tree.cells.size(), GrownForest::no_tree);
    for (std::size_t i = 0; i < top.open.size(); ++i)
        forest.below_of[top.open[i].position] = static_cast<std::uint32_t>(i);
    forest.top = std::move(top.tree);
    forest.below = std::move(below);
    return forest;
}

} // namespace proxima
