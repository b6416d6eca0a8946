#include "proxima/proximity/cut_cells.h"

#include <cmath>
#include <vector>

namespace proxima {

namespace {

/// What a cell and all below it cost at the price, and take.
struct CellCost {
    double cost = 0; ///< price * bytes included
    double bytes = 0;
};

CellCost leaf_of(const CostModel& model, const GrownCell& cell)
{
    const double listed = model.listed(cell.probability, cell.triangles);
    const double searched = CostModel::searched(cell.probability, cell.triangles);
    if (searched < listed) return {searched, 0};
    return {listed, CostModel::leaf_bytes(cell.triangles)};
}

/// The cheaper of ending at each cell and of going on, from the last cell to the first. `costs` is
/// room for one per cell; below(i, split) adds what hangs below a cell without children and says
/// whether something does; chosen(i) is told the split cells that had better end.
template <class Below, class Chosen>
CellCost cheapest(const GrownTree& tree, const CostModel& model, std::vector<CellCost>& costs,
                  const Below& below, const Chosen& chosen)
{
    costs.resize(tree.cells.size());
    for (std::size_t i = tree.cells.size(); i-- > 0;) {
        const GrownCell& cell = tree.cells[i];
        costs[i] = leaf_of(model, cell);
        CellCost split{model.split(cell.probability), CostModel::split_bytes};
        if (cell.children != 0) {
            for (std::uint32_t k = 0; k < 8; ++k) {
                const CellCost& one = costs[cell.children + k];
                split.cost += one.cost;
                split.bytes += one.bytes;
            }
        } else if (!below(i, split))
            continue;
        if (split.cost < costs[i].cost)
            costs[i] = split;
        else
            chosen(i);
    }
    return costs[0];
}

/// For trees that end where their cells do.
bool no_tree_below(std::size_t /*cell*/, CellCost& /*split*/)
{
    return false;
}

/// By bisection of the logarithm.
template <class BytesAt>
double least_price(const BytesAt& bytes_at_price, double bytes, double low, double high)
{
    while (high > 1.02 * low) {
        const double middle = std::sqrt(low * high);
        (bytes_at_price(middle) > bytes ? low : high) = middle;
    }
    return high;
}

/// The cheapest tree of the whole forest. `chosen(tree, cell)` is told the split cells that end.
template <class Chosen>
CellCost cheapest(const GrownForest& forest, const CostModel& model, const Chosen& chosen)
{
    std::vector<CellCost> costs;
    std::vector<CellCost> roots(forest.below.size());
    for (std::size_t i = 0; i < roots.size(); ++i) {
        roots[i] = cheapest(forest.below[i], model, costs, no_tree_below,
                            [&](std::size_t cell) { chosen(i, cell); });
    }
    std::vector<CellCost> top;
    return cheapest(
        forest.top, model, top,
        [&](std::size_t cell, CellCost& split) {
            const std::uint32_t tree = forest.below_of[cell];
            if (tree == GrownForest::no_tree) return false;
            split = roots[tree];
            return true;
        },
        [&](std::size_t cell) { chosen(forest.below.size(), cell); });
}

/// Tells leaves with and without a list apart.
void choose_lists(GrownTree& tree, const CostModel& model)
{
    for (GrownCell& cell : tree.cells) {
        cell.searched = CostModel::searched(cell.probability, cell.triangles) <
                        model.listed(cell.probability, cell.triangles);
    }
}

} // namespace

double bytes_at(std::span<const GrownTree> trees, double price)
{
    std::vector<CellCost> costs;
    double bytes = 0;
    for (const GrownTree& tree : trees)
        bytes += cheapest(tree, {price}, costs, no_tree_below, [](std::size_t) {}).bytes;
    return bytes;
}

double price_for(std::span<const GrownTree> trees, double bytes, double low, double high)
{
    return least_price([&](double price) { return bytes_at(trees, price); }, bytes, low, high);
}

double price_for(const GrownForest& forest, double bytes, double low, double high)
{
    const auto taken = [&](double price) {
        return cheapest(forest, {price}, [](std::size_t, std::size_t) {}).bytes;
    };
    return least_price(taken, bytes, low, high);
}

void cut_trees(std::span<GrownTree> trees, double price)
{
    std::vector<CellCost> costs;
    for (GrownTree& tree : trees) {
        cheapest(tree, {price}, costs, no_tree_below,
                 [&](std::size_t cell) { tree.cells[cell].children = 0; });
        choose_lists(tree, {price});
    }
}

void cut_cells(GrownForest& forest, double price)
{
    cheapest(forest, {price}, [&](std::size_t tree, std::size_t cell) {
        if (tree < forest.below.size())
            forest.below[tree].cells[cell].children = 0;
        else
            forest.top.cells[cell].children = 0, forest.below_of[cell] = GrownForest::no_tree;
    });
    choose_lists(forest.top, {price});
    for (GrownTree& tree : forest.below) choose_lists(tree, {price});
}

} // namespace proxima
