#include "index/lists/check_proximity_structure.h"

#include "base/atomic_bits.h"
#include "base/progress.h"
#include "base/text.h"
#include "index/lists/build_proximity_octree.h"
#include "index/lists/check_arena.h"
#include "index/lists/check_cells.h"
#include "index/lists/check_work.h"
#include "proxima/topology.h"

#include <algorithm>
#include <atomic>
#include <cmath>

namespace proxima {

namespace {

/// Squared distances within it are numbers.
constexpr double max_half = 1e153;

tl::unexpected<Error> bad_structure(std::string message, std::string where)
{
    return fail(ErrorCode::broken_invariant, std::move(message), std::move(where));
}

bool is_power_of_two(double value)
{
    int exponent = 0;
    return std::isfinite(value) && std::frexp(value, &exponent) == 0.5;
}

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

    /// Places that rows met.
    struct Met {
        std::size_t vertices = 0;
        std::size_t edges = 0;
    };

    /// An empty text where the row agrees. \pre its vertices and edges exist
    template <class Scalar>
    const char* fault_of(const TriangleRow<Scalar>& row, Met& met) const
    {
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t vertex = row.vertices[k];
            const std::uint32_t corner = arrays_.vertex_places[vertex];
            if (place_word::triangle(corner) > row.triangle_id())
                return "a vertex's place is wrong";
            if (corner_of(row, vertex) == k && corner == word(row, k, false)) ++met.vertices;
            const std::uint32_t edge = row.edges[k];
            if (edge == index(no_edge)) continue;
            const std::uint32_t side = arrays_.edge_places[edge];
            if (place_word::triangle(side) > row.triangle_id()) return "an edge's place is wrong";
            if (side_of(row, edge) == k && side == word(row, k, row.backward(k))) ++met.edges;
        }
        return "";
    }

    /// Thread safe.
    void add(const Met& met) noexcept
    {
        vertices_.fetch_add(met.vertices, std::memory_order_relaxed);
        edges_.fetch_add(met.edges, std::memory_order_relaxed);
    }

    /// Whether every place was met, once all was added.
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
    std::atomic<std::size_t> vertices_ = 0;
    std::atomic<std::size_t> edges_ = 0;
};

template <class Scalar>
Status check_rows(std::span<const TriangleRow<Scalar>> rows, const ProximityOctree& octree,
                  const CheckWork& work)
{
    constexpr std::size_t task_rows = CheckWork::task_bytes / sizeof(TriangleRow<Scalar>);
    AtomicBits seen(rows.size());
    PlaceChecker places(octree.arrays());
    const auto check_task = [&](std::size_t task) -> Status {
        const std::size_t begin = task * task_rows;
        const std::size_t end = std::min(begin + task_rows, rows.size());
        PlaceChecker::Met met;
        for (std::size_t rank = begin; rank < end; ++rank) {
            const TriangleRow<Scalar>& row = rows[rank];
            if (const char* const fault = fault_of(row, octree); *fault != '\0')
                return bad_structure(fault, concat("row ", rank));
            if (seen.set(row.triangle_id()))
                return bad_structure("a triangle twice", concat("row ", rank));
            if (const char* const fault = places.fault_of(row, met); *fault != '\0')
                return bad_structure(fault, concat("row ", rank));
        }
        places.add(met);
        StageSteps steps = work.steps();
        if (!steps.done((end - begin) * sizeof(TriangleRow<Scalar>))) return CheckWork::stopped();
        return {};
    };
    if (Status status = work.run((rows.size() + task_rows - 1) / task_rows, check_task); !status)
        return status;
    if (!rows.empty() && !places.all_met())
        return bad_structure("places of no row", "vertices and edges");
    return {};
}

Status check_header(const ProximityOctree& octree)
{
    const RootFrame& frame = octree.frame();
    const ProximityArrays& arrays = octree.arrays();
    const bool is_cube = frame.center.allFinite() && frame.half > 0 && frame.half <= max_half;
    if (!is_cube || !is_power_of_two(frame.scale) ||
        !(frame.frame_half() >= 0.5 && frame.frame_half() <= 1)) {
        return bad_structure("the root is not a finite cube", "frame");
    }
    if (octree.table_depth() < 0 || octree.table_depth() > max_table_depth ||
        arrays.table.size() != std::size_t{1} << 3 * octree.table_depth()) {
        return bad_structure("the table is not a level of cells", "table");
    }
    if (arrays.float_rows.empty() == arrays.double_rows.empty() ||
        octree.triangle_count() > max_proximity_triangles) {
        return bad_structure(concat("impossible number of triangles ", octree.triangle_count()),
                             "rows");
    }
    const TriangleTree& tree = octree.tree();
    if (tree.triangle_count() != octree.triangle_count() || !tree.origin().allFinite() ||
        !is_power_of_two(tree.scale()) || !(tree.reach() >= 0 && std::isfinite(tree.reach()))) {
        return bad_structure("boxes of other triangles", "triangle tree");
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
        return bad_structure("they are not those of the octree", "statistics");
    }
    return {};
}

Status check_all(const ProximityOctree& octree, const CheckWork& work)
{
    const ProximityArrays& arrays = octree.arrays();
    if (Status status = check_header(octree); !status) return status;
    if (Status status = check_rows(arrays.float_rows, octree, work); !status) return status;
    if (Status status = check_rows(arrays.double_rows, octree, work); !status) return status;
    ArenaChecker arena(arrays.arena, octree.triangle_count());
    if (Status status = arena.check_blocks(work); !status) return status;
    CellChecker cells(octree, arena);
    if (Status status = cells.run(work); !status) return status;
    ProximityStatistics counts = cells.counts();
    counts.blocks = arena.blocks();
    return check_statistics(octree, counts);
}

} // namespace

Status check_structure(const ProximityOctree& octree, const CheckStructureOptions& options)
{
    begin_stage(options.execution.progress, "checking the octree", octree.bytes());
    Status status = check_all(octree, CheckWork(options.execution));
    if (status || status.error().code == ErrorCode::cancelled) return status;
    // Which of two claims to one thing comes second depends on threads; the message shall not.
    return check_all(octree, CheckWork({.threads = {1}, .progress = options.execution.progress}));
}

} // namespace proxima
