#include "proxima/proximity/grow_cells.h"

#include "proxima/proximity/cell_cover.h"
#include "proxima/proximity/domination.h"
#include "proxima/proximity/local_region.h"

#include <array>
#include <atomic>
#include <memory>
#include <numeric>

namespace proxima {

namespace {

/// Levels that are grown breadth-first.
constexpr int top_depth = 3;

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

/// A cell being grown.
struct OpenCell {
    FrameCell cube;
    CellKey key;
    CellDensity density;
};

std::array<OpenCell, 8> children_of(const OpenCell& cell, const QueryDensity& density)
{
    std::array<OpenCell, 8> children;
    const std::array<CellDensity, 8> densities = density.split(cell.density, cell.key);
    for (int octant = 0; octant < 8; ++octant) {
        const auto i = static_cast<std::size_t>(octant);
        children[i] = {child(cell.cube, octant), child(cell.key, octant), densities[i]};
    }
    return children;
}

/// Splits cells; one per thread at a time.
class CellGrower {
public:
    CellGrower(const LocalFeatures& features, const QueryDensity& density,
               const GrowOptions& options)
        : features_(features), density_(density), options_(options)
    {}

    using Lists = std::array<std::vector<std::uint32_t>, 8>;

    /// The features of a cell's children.
    void split(const FrameCell& cube, std::span<const std::uint32_t> list, Lists& lists)
    {
        masks_.resize(list.size());
        find_children_in_reach(features_, list, cube, masks_.data());
        for (auto& one : lists) one.clear();
        for (std::size_t k = 0; k < list.size(); ++k)
            for (unsigned mask = masks_[k]; mask != 0; mask &= mask - 1)
                lists[static_cast<std::size_t>(std::countr_zero(mask))].push_back(list[k]);
        for (int octant = 0; octant < 8; ++octant) {
            auto& one = lists[static_cast<std::size_t>(octant)];
            one.resize(
                drop_dominated(features_, one.data(), one.size(), child(cube, octant), scratch_));
        }
    }

    /// Adds the cell's list to the tree and describes it.
    GrownCell describe(const OpenCell& cell, std::span<const std::uint32_t> list, GrownTree& tree)
    {
        cover_features(features_, list, taken_, cover_);
        GrownCell grown;
        grown.probability = static_cast<float>(density_.probability(cell.density, cell.key));
        grown.list = static_cast<std::uint32_t>(tree.lists.size());
        grown.triangles = static_cast<std::uint32_t>(cover_.size());
        append_list(cover_, tree.lists);
        return grown;
    }

    [[nodiscard]] bool may_split(const GrownCell& grown, int depth) const
    {
        return depth < options_.max_depth && grown.triangles > options_.max_triangles &&
               options_.cost.may_split(grown.probability, grown.triangles);
    }

    /// Everything below `cell`, whose description is tree.cells[place]. Returns the cost of the
    /// cheapest way to end, with what does not pay taken back.
    double grow(const OpenCell& cell, std::span<const std::uint32_t> list, std::size_t place,
                GrownTree& tree)
    {
        const GrownCell grown = tree.cells[place];
        const double as_leaf = options_.cost.leaf(grown.probability, grown.triangles);
        const int level = depth(cell.key);
        if (!may_split(grown, level) || is_cancelled(options_.progress)) return as_leaf;

        auto& scratch = lists_at(level);
        split(cell.cube, list, scratch);
        const std::array<OpenCell, 8> children = children_of(cell, density_);
        const std::size_t first = tree.cells.size();
        const std::size_t first_byte = tree.lists.size();
        for (std::size_t i = 0; i < 8; ++i)
            tree.cells.push_back(describe(children[i], scratch[i], tree));
        double as_split = options_.cost.split(grown.probability);
        for (std::size_t i = 0; i < 8; ++i)
            as_split += grow(children[i], scratch[i], first + i, tree);
        if (as_split >= as_leaf) {
            tree.cells.resize(first);
            tree.lists.resize(first_byte);
            return as_leaf;
        }
        tree.cells[place].children = static_cast<std::uint32_t>(first);
        return as_split;
    }

private:
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
    std::array<std::unique_ptr<Lists>, max_proximity_depth + 1> levels_;
};

/// A cell of the top with its features.
struct TopCell {
    OpenCell cell;
    std::vector<std::uint32_t> list;
    std::uint32_t place = 0; ///< in the top tree
};

/// Grows level by level; what is left are the cells that may be split further.
std::optional<std::vector<TopCell>> grow_top(const LocalFeatures& features,
                                             const QueryDensity& density, double frame_half,
                                             const GrowOptions& options, GrownTree& top)
{
    std::vector<TopCell> level(1);
    level[0].cell = {{{0, 0, 0}, static_cast<float>(frame_half)}, CellKey{}, density.root()};
    level[0].list.resize(features.features.size());
    std::iota(level[0].list.begin(), level[0].list.end(), 0U);
    CellGrower grower(features, density, options);
    top.cells.push_back(grower.describe(level[0].cell, level[0].list, top));
    for (int depth = 0; depth < top_depth; ++depth) {
        std::erase_if(level, [&](const TopCell& one) {
            return !grower.may_split(top.cells[one.place], depth);
        });
        if (options.progress != nullptr)
            options.progress->begin_stage("topmost cells", level.size());
        std::vector<std::array<TopCell, 8>> next(level.size());
        parallel_for(level.size(), options.threads, [&](std::size_t i) {
            if (is_cancelled(options.progress)) return;
            CellGrower own(features, density, options);
            CellGrower::Lists lists;
            own.split(level[i].cell.cube, level[i].list, lists);
            const std::array<OpenCell, 8> children = children_of(level[i].cell, density);
            for (std::size_t k = 0; k < 8; ++k) next[i][k] = {children[k], std::move(lists[k]), 0};
            if (options.progress != nullptr) options.progress->advance(1);
        });
        if (is_cancelled(options.progress)) return std::nullopt;
        std::vector<TopCell> cells;
        for (std::size_t i = 0; i < next.size(); ++i) {
            top.cells[level[i].place].children = static_cast<std::uint32_t>(top.cells.size());
            for (TopCell& one : next[i]) {
                one.place = static_cast<std::uint32_t>(top.cells.size());
                top.cells.push_back(grower.describe(one.cell, one.list, top));
                cells.push_back(std::move(one));
            }
        }
        level = std::move(cells);
    }
    return level;
}

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

std::optional<GrownForest> grow_cells(const LocalFeatures& features, const QueryDensity& density,
                                      double frame_half, const GrowOptions& options)
{
    GrownForest forest;
    auto level = grow_top(features, density, frame_half, options, forest.top);
    if (!level) return std::nullopt;
    forest.below_of.assign(forest.top.cells.size(), GrownForest::no_tree);
    std::vector<TopCell> roots;
    for (std::size_t i = 0; i < level->size(); i += options.stride)
        roots.push_back(std::move((*level)[i]));
    level->clear();
    forest.below.resize(roots.size());
    if (options.progress != nullptr) options.progress->begin_stage("cells", roots.size());
    parallel_for(roots.size(), options.threads, [&](std::size_t i) {
        if (is_cancelled(options.progress)) return;
        CellGrower grower(features, density, options);
        GrownTree& tree = forest.below[i];
        tree.key = roots[i].cell.key;
        tree.cells.push_back(grower.describe(roots[i].cell, roots[i].list, tree));
        grower.grow(roots[i].cell, roots[i].list, 0, tree);
        tree.cells.shrink_to_fit();
        tree.lists.shrink_to_fit();
        if (options.progress != nullptr) options.progress->advance(1);
    });
    if (is_cancelled(options.progress)) return std::nullopt;
    for (std::size_t i = 0; i < roots.size(); ++i)
        forest.below_of[roots[i].place] = static_cast<std::uint32_t>(i);
    return forest;
}

} // namespace proxima
