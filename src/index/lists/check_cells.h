// Whether the cells of closest-feature lists are one tree whose leaves name what there is.
#pragma once

#include "base/progress.h"
#include "index/check_work.h"
#include "index/lists/check_arena.h"
#include "index/lists/proximity_cells.h"
#include "index/lists/proximity_lists.h"
#include "proxima/result.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace proxima {

/// Walks from the root to the leaves and counts what the statistics count. Refers to the lists.
class CellChecker {
public:
    CellChecker(const ProximityLists& lists, ArenaChecker& arena);

    /// Error broken_invariant, naming the cell; cancelled. \pre the table is a level of cells, the
    /// blocks are sound
    [[nodiscard]] Status run(const CheckWork& work);

    /// All but worst_case_steps, blocks and the means.
    [[nodiscard]] const ProximityStatistics& counts() const noexcept { return part_.counts; }

private:
    /// What was found in some of the cells.
    struct Part {
        ProximityStatistics counts;
        std::size_t run_entries = 0;
        void add(const Part& other);
    };

    /// The cells below one, itself included, but for those that are split at `end_depth`: they go
    /// to `below`.
    Status walk(const ProximityCell& top, int end_depth, std::vector<ProximityCell>& below,
                Part& part, StageSteps& steps);
    /// \pre the cell is of the table's depth or above
    [[nodiscard]] bool check_table(const ProximityCell& cell) const;
    /// The fault, null where there is none.
    const char* check_leaf(const ProximityCell& cell, Part& part);
    std::uint32_t check_run(const ProximityCell& cell, std::size_t begin, Part& part);

    const ProximityArrays& arrays_;
    int table_depth_;
    double frame_half_;
    ArenaChecker& arena_;
    Part part_;
};

} // namespace proxima
