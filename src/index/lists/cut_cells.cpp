#include "index/lists/cut_cells.h"

#include "base/parallel.h"

#include <vector>

namespace proxima {

namespace {

/// What a cell and all below it cost, and the bytes in that.
struct CutCost {
    double cost = 0;
    double bytes = 0;

    CutCost& operator+=(const CutCost& other) noexcept
    {
        cost += other.cost;
        bytes += other.bytes;
        return *this;
    }
};

/// Chooses for each cell the cheaper of ending and of going on, from the last cell to the first,
/// and returns what the whole tree costs. `costs` is scratch, one per cell; below(i, split) adds
/// what hangs below a cell without children and says whether something does.
template <class Below>
CutCost cut(GrownTree& tree, const CostModel& model, std::vector<CutCost>& costs,
            const Below& below)
{
    costs.resize(tree.cells.size());
    for (std::size_t i = tree.cells.size(); i-- > 0;) {
        GrownCell& cell = tree.cells[i];
        cell.searched = CostModel::searched(cell.probability, cell.triangles) <
                        model.listed(cell.probability, cell.triangles);
        costs[i] = {model.leaf(cell.probability, cell.triangles),
                    cell.searched != 0 ? 0 : CostModel::leaf_bytes(cell.triangles)};
        cell.ended = 1;
        CutCost split{model.split(cell.probability), CostModel::split_bytes};
        if (cell.children != 0) {
            for (std::uint32_t k = 0; k < 8; ++k) split += costs[cell.children + k];
        } else if (!below(i, split))
            continue;
        if (split.cost >= costs[i].cost) continue;
        costs[i] = split;
        cell.ended = 0;
    }
    return costs[0];
}

/// Of trees that end where their cells do, each on its own.
std::vector<CutCost> cut_each(std::span<GrownTree> trees, const CostModel& model, Threads threads)
{
    constexpr std::size_t trees_per_task = 16;
    std::vector<CutCost> costs(trees.size());
    parallel_chunks(trees.size(), trees_per_task, threads, [&](std::size_t first, std::size_t end) {
        std::vector<CutCost> scratch;
        for (std::size_t i = first; i < end; ++i) {
            costs[i] = cut(trees[i], model, scratch,
                           [](std::size_t /*cell*/, CutCost& /*split*/) { return false; });
        }
    });
    return costs;
}

} // namespace

double cut_trees(std::span<GrownTree> trees, double price, Threads threads)
{
    double bytes = 0;
    for (const CutCost& tree : cut_each(trees, {price}, threads)) bytes += tree.bytes;
    return bytes;
}

double cut_cells(GrownForest& forest, double price, Threads threads)
{
    const CostModel model{price};
    const std::vector<CutCost> roots = cut_each(forest.below, model, threads);
    std::vector<CutCost> costs;
    const CutCost all = cut(forest.top, model, costs, [&](std::size_t cell, CutCost& split) {
        const std::uint32_t tree = forest.below_of[cell];
        if (tree == GrownForest::no_tree) return false;
        split = roots[tree];
        return true;
    });
    return all.bytes;
}

} // namespace proxima
