#include "index/lists/check_cells.h"

#include "base/fixed_stack.h"
#include "base/progress.h"
#include "base/text.h"
#include "index/lists/grow_cells.h"
#include "proxima/mesh_index.h"

#include <algorithm>
#include <cmath>

namespace proxima {

namespace {

/// Cells that are split there are tasks: up to 4096.
constexpr int task_depth = 4;

tl::unexpected<Error> bad_cells(std::string message, std::string where)
{
    return fail(ErrorCode::broken_invariant, std::move(message), std::move(where));
}

tl::unexpected<Error> bad_cell(const char* fault, const ProximityCell& cell)
{
    return bad_cells(fault, concat("cell at ", cell.at[0], " ", cell.at[1], " ", cell.at[2],
                                   " of depth ", cell.depth));
}

/// What checks of a cell return where they find no fault.
constexpr const char* sound = nullptr;

} // namespace

void CellChecker::Part::add(const Part& other)
{
    counts.nodes += other.counts.nodes;
    counts.leaves += other.counts.leaves;
    counts.searched_leaves += other.counts.searched_leaves;
    counts.references += other.counts.references;
    counts.max_list = std::max(counts.max_list, other.counts.max_list);
    counts.max_depth = std::max(counts.max_depth, other.counts.max_depth);
    counts.worst_case_blocks = std::max(counts.worst_case_blocks, other.counts.worst_case_blocks);
    run_entries += other.run_entries;
}

CellChecker::CellChecker(const ProximityLists& lists, ArenaChecker& arena)
    : arrays_(lists.arrays()), table_depth_(lists.table_depth()),
      frame_half_(lists.frame().frame_half()), arena_(arena)
{}

Status CellChecker::run(const CheckWork& work)
{
    const auto root = root_word(arrays_);
    if (!root) return tl::unexpected(root.error());
    std::vector<ProximityCell> tops;
    StageSteps steps = work.steps();
    if (Status status = walk({*root, 0, {}}, task_depth, tops, part_, steps); !status)
        return status;
    std::vector<Part> parts(tops.size());
    Status status = work.run(tops.size(), [&](std::size_t task) {
        std::vector<ProximityCell> none;
        StageSteps task_steps = work.steps();
        return walk(tops[task], max_list_depth + 1, none, parts[task], task_steps);
    });
    if (!status) return status;
    for (const Part& part : parts) part_.add(part);
    // Each group has one parent at most, so what was not met goes round in circles.
    if (part_.counts.nodes != arrays_.nodes.size() + 1)
        return bad_cells("cells out of reach", "nodes");
    if (part_.run_entries != arrays_.runs.size()) return bad_cells("runs of no leaf", "runs");
    if (!arena_.all_used()) return bad_cells("blocks of no leaf", "blocks");
    return {};
}

Status CellChecker::walk(const ProximityCell& top, int end_depth, std::vector<ProximityCell>& below,
                         Part& part, StageSteps& steps)
{
    // Split cells wait, leaves are looked at on the spot: most nodes are leaves.
    FixedStack<ProximityCell, 7 * max_list_depth + 1> pending;
    const auto meet = [&](const ProximityCell& cell) -> const char* {
        const bool is_leaf = proximity_word::is_leaf(cell.word);
        if (!is_leaf && cell.depth == end_depth) {
            below.push_back(cell);
            return sound;
        }
        ++part.counts.nodes;
        if (cell.depth <= table_depth_ && !check_table(cell))
            return "the table contradicts the nodes";
        if (is_leaf) return check_leaf(cell, part);
        if (cell.depth == max_list_depth) return "split at the deepest level";
        __builtin_prefetch(&arrays_.nodes[cell.word]);
        pending.push(cell);
        return sound;
    };
    if (const char* const fault = meet(top); fault != sound) return bad_cell(fault, top);
    while (!pending.empty()) {
        const ProximityCell cell = pending.pop();
        if (!steps.done(8 * sizeof cell.word)) return cancelled("checking the index");
        for (std::uint32_t octant = 0; octant < 8; ++octant) {
            const ProximityCell one = child(arrays_, cell, octant);
            if (const char* const fault = meet(one); fault != sound) return bad_cell(fault, one);
        }
    }
    return {};
}

/// The table holds cells of its own level and leaves above.
bool CellChecker::check_table(const ProximityCell& cell) const
{
    if (cell.depth < table_depth_ && !proximity_word::is_leaf(cell.word)) return true;
    const int up = table_depth_ - cell.depth;
    const std::size_t edge = std::size_t{1} << up;
    for (std::size_t z = 0; z < edge; ++z) {
        for (std::size_t y = 0; y < edge; ++y) {
            const std::size_t line = ((std::size_t{cell.at[2]} << up) + z) << 2 * table_depth_ |
                                     ((std::size_t{cell.at[1]} << up) + y) << table_depth_ |
                                     std::size_t{cell.at[0]} << up;
            for (const std::uint64_t word : arrays_.table.subspan(line, edge))
                if (word != cell.word) return false;
        }
    }
    return true;
}

const char* CellChecker::check_leaf(const ProximityCell& cell, Part& part)
{
    const std::uint32_t position = proximity_word::position(cell.word);
    std::uint32_t list = 0;
    std::uint32_t blocks = 1;
    if (proximity_word::is_block(cell.word)) {
        list = arena_.use(position, proximity_word::mask(cell.word));
        if (list == 0) return "no such triangles";
    } else if (cell.word == proximity_word::search) {
        ++part.counts.searched_leaves;
        blocks = 0;
    } else {
        if (proximity_word::mask(cell.word) != 0 || position >= arrays_.runs.size())
            return "no such run";
        blocks = arrays_.runs[position].position;
        list = check_run(cell, position, part);
        if (list == 0) return "its run is damaged";
    }
    ProximityStatistics& counts = part.counts;
    ++counts.leaves;
    counts.references += list;
    counts.max_list = std::max(counts.max_list, list);
    counts.max_depth = std::max(counts.max_depth, static_cast<std::uint32_t>(cell.depth));
    counts.worst_case_blocks = std::max(counts.worst_case_blocks, blocks);
    return sound;
}

/// Its triangles, 0 where it is damaged. Sound runs do not overlap: a head holds its own leaf's centre
/// and no triangles, and every entry after a head holds triangles.
std::uint32_t CellChecker::check_run(const ProximityCell& cell, std::size_t begin, Part& part)
{
    const RunEntry& head = arrays_.runs[begin];
    const std::size_t count = head.position;
    if (count < 2 || count >= arrays_.runs.size() - begin) return 0;
    if (head.mask != 0 || head.least != 0) return 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const double edge = 2 * frame_half_ / static_cast<double>(1U << cell.depth);
        const double center = -frame_half_ + edge * (cell.at[axis] + 0.5);
        if (head.direction[axis] != static_cast<float>(center)) return 0;
    }
    std::uint32_t list = 0;
    for (std::size_t i = begin + 1; i <= begin + count; ++i) {
        const RunEntry& entry = arrays_.runs[i];
        double squared = 0;
        for (const float part_of : entry.direction)
            squared += static_cast<double>(part_of) * static_cast<double>(part_of);
        if (!(squared <= 1) || !std::isfinite(entry.least)) return 0;
        if (i > begin + 1 && entry.least < arrays_.runs[i - 1].least) return 0;
        const std::uint32_t triangles = arena_.use(entry.position, entry.mask);
        if (triangles == 0) return 0;
        list += triangles;
    }
    part.run_entries += count + 1;
    return list;
}

} // namespace proxima
