#include "index/lists/cut_cells.h"

#include <vector>

namespace proxima {

namespace {

/// Chooses for each cell the cheaper of ending and of going on, from the last cell to the first,
/// and returns what the whole tree costs. `costs` is scratch, one per cell; below(i, split) adds
/// what hangs below a cell without children and says whether something does.
template <class Below>
double cut(GrownTree& tree, const CostModel& model, std::vector<double>& costs, const Below& below)
{
    costs.resize(tree.cells.size());
    for (std::size_t i = tree.cells.size(); i-- > 0;) {
        GrownCell& cell = tree.cells[i];
        costs[i] = model.leaf(cell.probability, cell.triangles);
        cell.searched = CostModel::searched(cell.probability, cell.triangles) <
                        model.listed(cell.probability, cell.triangles);
        cell.ended = 1;
        double split = model.split(cell.probability);
        if (cell.children != 0) {
            for (std::uint32_t k = 0; k < 8; ++k) split += costs[cell.children + k];
        } else if (!below(i, split))
            continue;
        if (split >= costs[i]) continue;
        costs[i] = split;
        cell.ended = 0;
    }
    return costs[0];
}

/// For trees that end where their cells do.
bool no_tree_below(std::size_t /*cell*/, double& /*split*/)
{
    return false;
}

} // namespace

void cut_trees(std::span<GrownTree> trees, double price)
{
    std::vector<double> costs;
    for (GrownTree& tree : trees) (void)cut(tree, {price}, costs, no_tree_below);
}

void cut_cells(GrownForest& forest, double price)
{
    const CostModel model{price};
    std::vector<double> costs;
    std::vector<double> roots;
    roots.reserve(forest.below.size());
    for (GrownTree& tree : forest.below) roots.push_back(cut(tree, model, costs, no_tree_below));
    (void)cut(forest.top, model, costs, [&](std::size_t cell, double& split) {
        const std::uint32_t tree = forest.below_of[cell];
        if (tree == GrownForest::no_tree) return false;
        split = roots[tree];
        return true;
    });
}

} // namespace proxima
