// The cells of closest-feature lists before they are cut to the budget: every cell with its list.
//
//     nodes    { probability | first of 8 children or 0 | list: where, how many }
//     lists    ranks of triangles, ascending: differences as bytes of 7 bits
//
// From the root down, a cell's features are its parent's that reach into it (local_region.h) and
// are not dominated there (domination.h); its list is their cover. The topmost levels are grown
// breadth-first, the cells below them in parallel, each on its own; what comes out does not depend
// on threads.
#pragma once

#include "index/lists/cost_model.h"
#include "index/lists/local_features.h"
#include "index/lists/local_region.h"
#include "index/lists/query_density.h"
#include "proxima/execution.h"
#include "proxima/mesh_index.h"
#include "proxima/octree.h"

#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

namespace proxima {

/// A cell that was grown.
struct GrownCell {
    float probability = 0;           ///< of a query to fall into it
    std::uint32_t children = 0;      ///< first of eight, 0 for none
    std::uint32_t list = 0;          ///< where its list's bytes begin
    std::uint32_t triangles : 30 {}; ///< length of its list
    std::uint32_t ended : 1 {};      ///< a leaf whatever is below it: cut_cells.h
    std::uint32_t searched : 1 {};   ///< a leaf that is better off without its list
};

/// A cell and all below it. Cell 0 is the topmost; children come after their parents.
struct GrownTree {
    CellKey key;
    std::vector<GrownCell> cells;
    std::vector<std::uint8_t> lists;

    [[nodiscard]] static bool is_leaf(const GrownCell& cell) noexcept
    {
        return cell.children == 0 || cell.ended != 0;
    }
    /// The list of a cell into `ranks`.
    void read_list(const GrownCell& cell, std::vector<std::uint32_t>& ranks) const;
    [[nodiscard]] std::uint64_t bytes() const noexcept;
};

/// A cell that is about to be split, with its features.
struct OpenCell {
    FrameCell cube;
    CellKey key;
    CellDensity density;
    std::vector<std::uint32_t> features;
    std::uint32_t position = 0;   ///< in the tree that it belongs to
    std::uint8_t idle_splits = 0; ///< that it comes from, in a row: count_idle_splits
};

/// All cells: `top` down to a few levels; leaves of it may be the roots of trees of `below`.
struct GrownForest {
    GrownTree top;
    std::vector<GrownTree> below;
    std::vector<std::uint32_t> below_of; ///< per cell of top: its tree of `below`, or no_tree

    static constexpr std::uint32_t no_tree = 0xFFFFFFFF;
};

/// The topmost cells, and those of them that may be split further.
struct GrownTop {
    GrownTree tree;
    std::vector<OpenCell> open;
};

/// What growing goes by.
struct GrowOptions {
    CostModel cost = {};            ///< cells that cannot pay at this price are not split
    int max_depth = max_list_depth; ///< of any cell
    std::size_t max_triangles = list_triangles; ///< lists this short are not split
    /// Features that are looked at below a cell, per feature of its own; at least 2^18 of them.
    double most_work = std::numeric_limits<double>::infinity();
    /// A tree with more bytes of lists is not split further: places in it are 32 bits.
    std::uint64_t most_list_bytes = std::uint64_t{1} << 31U;
    Execution execution = {};
};

/// The topmost levels: breadth-first. Null where cancelled.
[[nodiscard]] std::optional<GrownTop> grow_top(const LocalFeatures& features,
                                               const QueryDensity& density, double frame_half,
                                               const GrowOptions& options);

/// Everything below the given open cells, a tree each. Null where cancelled. Time: about 1 us per
/// cell and 60 ns per feature of its parent.
[[nodiscard]] std::optional<std::vector<GrownTree>>
grow_below(const LocalFeatures& features, const QueryDensity& density,
           std::span<const OpenCell* const> open, const GrowOptions& options);

/// The forest of the top and the trees below all its open cells.
[[nodiscard]] GrownForest join_forest(GrownTop&& top, std::vector<GrownTree>&& below);

} // namespace proxima
