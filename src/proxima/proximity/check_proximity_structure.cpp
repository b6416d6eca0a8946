#include "proxima/proximity/check_proximity_structure.h"

#include "proxima/base/fixed_stack.h"
#include "proxima/base/text.h"
#include "proxima/mesh/topology.h"
#include "proxima/proximity/block.h"
#include "proxima/proximity/build_proximity_octree.h"
#include "proxima/proximity/proximity_cells.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <vector>

namespace proxima {

namespace {

/// Squared distances within it are numbers.
constexpr double max_half = 1e153;

tl::unexpected<Error> bad(std::string message, std::string where)
{
    return fail(ErrorCode::broken_invariant, std::move(message), std::move(where));
}

tl::unexpected<Error> checking_stopped()
{
    return fail(ErrorCode::cancelled, "checking was stopped on request");
}

bool is_power_of_two(double value)
{
    int exponent = 0;
    return std::isfinite(value) && std::frexp(value, &exponent) == 0.5;
}

bool all_zero(std::span<const std::byte> bytes)
{
    return std::ranges::all_of(bytes, [](std::byte byte) { return byte == std::byte{0}; });
}

/// Blocks and what leaves say of them. Places are in units of block_alignment.
class ArenaChecker {
public:
    ArenaChecker(std::span<const std::byte> arena, std::uint64_t rows)
        : arena_(arena), rows_(rows), begins_(arena.size() / block_alignment), used_(begins_.size())
    {}

    [[nodiscard]] std::uint64_t blocks() const noexcept { return blocks_; }
    [[nodiscard]] std::uint64_t used_blocks() const noexcept { return used_blocks_; }

    Status check_blocks(StageSteps& steps)
    {
        if (arena_.size() < block_padding) return bad("the arena has no padding", "blocks");
        const std::size_t limit = arena_.size() - block_padding;
        std::size_t at = 0;
        while (true) {
            const std::size_t bytes = check_block(at, limit);
            if (bytes == 0) return bad("a block is damaged", concat("arena byte ", at));
            begins_[at / block_alignment] = true;
            ++blocks_;
            if (!steps.done(bytes)) return checking_stopped();
            const std::size_t end = at + bytes;
            if (end == limit) break;
            at = (end + block_alignment - 1) / block_alignment * block_alignment;
            if (at >= limit) return bad("the last block is damaged", concat("arena byte ", end));
            if (!all_zero(arena_.subspan(end, at - end)))
                return bad("bytes between blocks", concat("arena byte ", end));
        }
        if (!all_zero(arena_.subspan(limit))) return bad("the padding is damaged", "blocks");
        return {};
    }

    /// Whether a leaf may have these triangles of a block there.
    bool use(std::uint32_t place, std::uint32_t mask)
    {
        if (place >= begins_.size() || !begins_[place]) return false;
        const std::uint32_t triangles = header_at(place * block_alignment).triangles;
        if (mask == 0 || std::popcount(mask) > static_cast<int>(list_triangles)) return false;
        if (static_cast<std::uint64_t>(mask) >> triangles != 0) return false;
        if (!used_[place]) ++used_blocks_;
        used_[place] = true;
        return true;
    }

private:
    [[nodiscard]] BlockHeader header_at(std::size_t at) const
    {
        BlockHeader header;
        std::memcpy(&header, arena_.data() + at, sizeof header);
        return header;
    }

    template <class T>
    [[nodiscard]] T number_at(std::size_t at) const
    {
        T value = 0;
        std::memcpy(&value, arena_.data() + at, sizeof value);
        return value;
    }

    static bool is_representable(const BlockHeader& header)
    {
        constexpr std::uint16_t infinite = 0x7F80; // upper half of a float
        const bool finite = std::isfinite(header.origin[0]) && std::isfinite(header.origin[1]) &&
                            std::isfinite(header.origin[2]) && std::isfinite(header.inverse_unit) &&
                            header.inverse_unit > 0;
        return finite && header.slack_size < infinite && header.slack_reach < infinite &&
               header.vertices >= 1 && header.vertices <= block_vertices && header.triangles >= 1 &&
               header.triangles <= block_triangles && header.wide <= 1 && header.unused == 0;
    }

    /// Its bytes, 0 where it is damaged.
    [[nodiscard]] std::size_t check_block(std::size_t at, std::size_t limit) const
    {
        if (limit - at < sizeof(BlockHeader)) return 0;
        const BlockHeader header = header_at(at);
        if (!is_representable(header)) return 0;
        const BlockLayout layout =
            block_layout(header.vertices, header.triangles, header.wide != 0);
        if (layout.end > limit - at) return 0;
        for (std::size_t i = 0; i < header.triangles; ++i) {
            const unsigned corners = number_at<std::uint16_t>(at + layout.corners + 2 * i);
            const unsigned highest = std::max({corners & 31U, corners >> 5U & 31U, corners >> 10U});
            if (highest >= header.vertices) return 0;
            const std::uint64_t rank =
                std::uint64_t{header.base} +
                (header.wide != 0 ? number_at<std::uint32_t>(at + layout.ranks + 4 * i)
                                  : number_at<std::uint16_t>(at + layout.ranks + 2 * i));
            if (rank >= rows_) return 0;
        }
        return layout.end;
    }

    std::span<const std::byte> arena_;
    std::uint64_t rows_;
    std::vector<bool> begins_; ///< where blocks begin
    std::vector<bool> used_;   ///< those that some leaf names
    std::uint64_t blocks_ = 0;
    std::uint64_t used_blocks_ = 0;
};

/// Walks from the root to the leaves and counts what the statistics count.
class CellChecker {
public:
    CellChecker(const ProximityOctree& octree, ArenaChecker& arena)
        : arrays_(octree.arrays()), table_depth_(octree.table_depth()),
          frame_half_(octree.frame().frame_half()), arena_(arena), run_taken_(arrays_.runs.size())
    {}

    [[nodiscard]] const ProximityStatistics& counts() const noexcept { return counts_; }

    Status run(StageSteps& steps)
    {
        const auto root = root_word(arrays_);
        if (!root) return tl::unexpected(root.error());
        FixedStack<ProximityCell, 7 * max_proximity_depth + 1> pending;
        pending.push({*root, 0, {}});
        while (!pending.empty()) {
            const ProximityCell cell = pending.pop();
            ++counts_.nodes;
            if (!steps.done(sizeof cell.word)) return checking_stopped();
            if (!check_table(cell)) {
                return bad("the table contradicts the nodes", concat("cell at ", name(cell)));
            }
            if (proximity_word::is_leaf(cell.word)) {
                if (const Status status = check_leaf(cell, steps); !status) return status;
                continue;
            }
            if (cell.depth == max_proximity_depth) {
                return bad(concat("split at depth ", cell.depth), concat("cell at ", name(cell)));
            }
            for (std::uint32_t octant = 0; octant < 8; ++octant)
                pending.push(child(arrays_, cell, octant));
        }
        // Each group has one parent at most, so what was not met goes round in circles.
        if (counts_.nodes != arrays_.nodes.size() + 1) return bad("cells out of reach", "nodes");
        if (taken_ != arrays_.runs.size()) return bad("runs of no leaf", "runs");
        if (arena_.used_blocks() != arena_.blocks()) return bad("blocks of no leaf", "blocks");
        return {};
    }

private:
    static std::string name(const ProximityCell& cell)
    {
        return concat(cell.at[0], " ", cell.at[1], " ", cell.at[2], " of depth ", cell.depth);
    }

    /// The table holds cells of its own level and leaves above.
    [[nodiscard]] bool check_table(const ProximityCell& cell) const
    {
        if (cell.depth > table_depth_) return true;
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

    Status check_leaf(const ProximityCell& cell, StageSteps& steps)
    {
        const std::uint32_t place = proximity_word::place(cell.word);
        std::uint32_t list = 0;
        std::uint32_t blocks = 1;
        if (proximity_word::is_block(cell.word)) {
            const std::uint32_t mask = proximity_word::mask(cell.word);
            if (!arena_.use(place, mask)) return bad("no such triangles", "leaf at " + name(cell));
            list = static_cast<std::uint32_t>(std::popcount(mask));
        } else if (cell.word == proximity_word::search) {
            ++counts_.searched_leaves;
            blocks = 0;
        } else {
            if (proximity_word::mask(cell.word) != 0 || place >= arrays_.runs.size())
                return bad("no such run", "leaf at " + name(cell));
            blocks = arrays_.runs[place].place;
            if (!steps.done(sizeof(RunEntry) * std::uint64_t{blocks})) return checking_stopped();
            list = check_run(cell, place);
            if (list == 0) return bad("its run is damaged", "leaf at " + name(cell));
        }
        ++counts_.leaves;
        counts_.references += list;
        counts_.max_list = std::max(counts_.max_list, list);
        counts_.max_depth = std::max(counts_.max_depth, static_cast<std::uint32_t>(cell.depth));
        counts_.worst_case_blocks = std::max(counts_.worst_case_blocks, blocks);
        return {};
    }

    /// Its triangles, 0 where it is damaged.
    std::uint32_t check_run(const ProximityCell& cell, std::size_t begin)
    {
        const RunEntry& head = arrays_.runs[begin];
        const std::size_t count = head.place;
        if (count < 2 || count >= arrays_.runs.size() - begin) return 0;
        if (head.mask != 0 || head.least != 0) return 0;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const double edge = 2 * frame_half_ / static_cast<double>(1U << cell.depth);
            const double center = -frame_half_ + edge * (cell.at[axis] + 0.5);
            if (head.direction[axis] != static_cast<float>(center)) return 0;
        }
        std::uint32_t list = 0;
        for (std::size_t i = begin; i <= begin + count; ++i) {
            if (run_taken_[i]) return 0;
            run_taken_[i] = true;
            if (i == begin) continue;
            const RunEntry& entry = arrays_.runs[i];
            double squared = 0;
            for (const float part : entry.direction) {
                squared += static_cast<double>(part) * static_cast<double>(part);
            }
            if (!(squared <= 1) || !std::isfinite(entry.least)) return 0;
            if (i > begin + 1 && entry.least < arrays_.runs[i - 1].least) return 0;
            if (!arena_.use(entry.place, entry.mask)) return 0;
            list += static_cast<std::uint32_t>(std::popcount(entry.mask));
        }
        taken_ += count + 1;
        return list;
    }

    const ProximityArrays& arrays_;
    int table_depth_;
    double frame_half_;
    ArenaChecker& arena_;
    std::vector<bool> run_taken_; ///< entries that some leaf has
    std::size_t taken_ = 0;
    ProximityStatistics counts_;
};

/// What a row says of its triangle; an empty text where it can be.
template <class Scalar>
const char* fault_of(const TriangleRow<Scalar>& row, const ProximityOctree& octree)
{
    const ProximityArrays& arrays = octree.arrays();
    for (int i = 0; i < 3; ++i) {
        if (!octree.frame().contains(row.corner(i))) return "a corner outside of the root";
    }
    for (std::size_t k = 0; k < 3; ++k) {
        const std::size_t next = (k + 1) % 3;
        const std::uint32_t from = row.vertices[k];
        const std::uint32_t to = row.vertices[next];
        if (from >= arrays.vertex_places.size()) return "no such vertex";
        if (row.backward(k) != (from > to)) return "a side's direction is wrong";
        if ((row.edges[k] == index(no_edge)) != (from == to)) return "an edge of one vertex";
        if (from != to && row.edges[k] >= arrays.edge_places.size()) return "no such edge";
        for (const auto& line : row.coordinates) {
            if (from == to && line[k] != line[next]) return "a vertex at two places";
        }
    }
    if (row.triangle_id() >= octree.triangle_count()) return "no such triangle";
    return "";
}

/// Rows against the places of vertices and edges: each names the lowest triangle that has it.
class PlaceChecker {
public:
    explicit PlaceChecker(const ProximityArrays& arrays) : arrays_(arrays) {}

    /// An empty text where the row agrees. \pre its vertices and edges exist
    template <class Scalar>
    const char* fault_of(const TriangleRow<Scalar>& row)
    {
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t vertex = row.vertices[k];
            const std::uint32_t corner = arrays_.vertex_places[vertex];
            if (place_word::triangle(corner) > row.triangle_id())
                return "a vertex's place is wrong";
            if (corner_of(row, vertex) == k && corner == word(row, k, false)) ++vertices_;
            const std::uint32_t edge = row.edges[k];
            if (edge == index(no_edge)) continue;
            const std::uint32_t side = arrays_.edge_places[edge];
            if (place_word::triangle(side) > row.triangle_id()) return "an edge's place is wrong";
            if (side_of(row, edge) == k && side == word(row, k, row.backward(k))) ++edges_;
        }
        return "";
    }

    /// Whether every place was met.
    [[nodiscard]] bool all_met() const
    {
        const auto unused = std::ranges::count(arrays_.vertex_places, place_word::none);
        return vertices_ + static_cast<std::size_t>(unused) == arrays_.vertex_places.size() &&
               edges_ == arrays_.edge_places.size();
    }

private:
    template <class Scalar>
    static std::uint32_t word(const TriangleRow<Scalar>& row, std::size_t corner, bool backward)
    {
        return place_word::make(row.triangle_id(), static_cast<std::uint32_t>(corner), backward);
    }

    const ProximityArrays& arrays_;
    std::size_t vertices_ = 0;
    std::size_t edges_ = 0;
};

template <class Scalar>
Status check_rows(std::span<const TriangleRow<Scalar>> rows, const ProximityOctree& octree,
                  StageSteps& steps)
{
    std::vector<bool> seen(rows.size());
    PlaceChecker places(octree.arrays());
    for (std::size_t rank = 0; rank < rows.size(); ++rank) {
        const TriangleRow<Scalar>& row = rows[rank];
        if (!steps.done(sizeof row)) return checking_stopped();
        if (const char* const fault = fault_of(row, octree); *fault != '\0')
            return bad(fault, concat("row ", rank));
        if (seen[row.triangle_id()]) return bad("a triangle twice", concat("row ", rank));
        seen[row.triangle_id()] = true;
        if (const char* const fault = places.fault_of(row); *fault != '\0')
            return bad(fault, concat("row ", rank));
    }
    if (!rows.empty() && !places.all_met()) return bad("places of no row", "vertices and edges");
    return {};
}

Status check_header(const ProximityOctree& octree)
{
    const RootFrame& frame = octree.frame();
    const ProximityArrays& arrays = octree.arrays();
    const bool is_cube = frame.center.allFinite() && frame.half > 0 && frame.half <= max_half;
    if (!is_cube || !is_power_of_two(frame.scale) ||
        !(frame.frame_half() >= 0.5 && frame.frame_half() <= 1)) {
        return bad("the root is not a finite cube", "frame");
    }
    if (octree.table_depth() < 0 || octree.table_depth() > max_table_depth ||
        arrays.table.size() != std::size_t{1} << 3 * octree.table_depth()) {
        return bad("the table is not a level of cells", "table");
    }
    if (arrays.float_rows.empty() == arrays.double_rows.empty() ||
        octree.triangle_count() > max_proximity_triangles) {
        return bad(concat("impossible number of triangles ", octree.triangle_count()), "rows");
    }
    const TriangleTree& tree = octree.tree();
    if (tree.triangle_count() != octree.triangle_count() || !tree.origin().allFinite() ||
        !is_power_of_two(tree.scale()) || !(tree.reach() >= 0 && std::isfinite(tree.reach()))) {
        return bad("boxes of other triangles", "triangle tree");
    }
    return {};
}

Status check_statistics(const ProximityOctree& octree, ProximityStatistics counts)
{
    const auto table_depth = static_cast<std::uint32_t>(octree.table_depth());
    counts.worst_case_steps = 1 + counts.max_depth - std::min(counts.max_depth, table_depth);
    counts.mean_list = mean_list(counts);
    counts.expected_list = octree.statistics().expected_list;
    if (!(counts.expected_list >= 0 && std::isfinite(counts.expected_list)) ||
        counts != octree.statistics()) {
        return bad("they are not those of the octree", "statistics");
    }
    return {};
}

} // namespace

Status check_structure(const ProximityOctree& octree, Progress* progress)
{
    const ProximityArrays& arrays = octree.arrays();
    StageSteps steps(progress, "checking the octree", octree.bytes(), std::uint64_t{1} << 18U);
    if (const Status status = check_header(octree); !status) return status;
    if (const Status status = check_rows(arrays.float_rows, octree, steps); !status) return status;
    if (const Status status = check_rows(arrays.double_rows, octree, steps); !status) return status;
    ArenaChecker arena(arrays.arena, octree.triangle_count());
    if (const Status status = arena.check_blocks(steps); !status) return status;
    CellChecker cells(octree, arena);
    if (const Status status = cells.run(steps); !status) return status;
    ProximityStatistics counts = cells.counts();
    counts.blocks = arena.blocks();
    return check_statistics(octree, counts);
}

} // namespace proxima
