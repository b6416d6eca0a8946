#include "index/lists/check_lists.h"

#include "base/text.h"
#include "index/index_parts.h"
#include "index/lists/check_arena.h"
#include "index/lists/check_cells.h"
#include "proxima/mesh_index.h"

#include <algorithm>
#include <cmath>

namespace proxima {

namespace {

/// Squared distances within it are numbers.
constexpr double max_half = 1e153;

tl::unexpected<Error> bad_lists(std::string message, std::string where)
{
    return fail(ErrorCode::broken_invariant, std::move(message), std::move(where));
}

Status check_header(const ProximityLists& lists, std::uint32_t triangles)
{
    const RootFrame& frame = lists.frame();
    const bool is_cube = frame.center.allFinite() && frame.half > 0 && frame.half <= max_half;
    if (!is_cube || !is_power_of_two(frame.scale) ||
        !(frame.frame_half() >= 0.5 && frame.frame_half() <= 1)) {
        return bad_lists("the root is not a finite cube", "frame");
    }
    if (lists.table_depth() < 0 || lists.table_depth() > max_table_depth ||
        lists.arrays().table.size() != std::size_t{1} << 3 * lists.table_depth()) {
        return bad_lists("the table is not a level of cells", "table");
    }
    if (triangles > max_listed_triangles)
        return bad_lists(concat("impossible number of triangles ", triangles), "rows");
    return {};
}

Status check_root(const IndexParts& index, const RootFrame& frame)
{
    for (std::uint32_t row = 0; row < index.triangle_count(); ++row) {
        for (const Vec3& corner : index.triangle(row).vertices) {
            if (!frame.contains(corner))
                return bad_lists("a corner outside of the root", concat("row ", row));
        }
    }
    return {};
}

Status check_statistics(const ProximityLists& lists, ProximityStatistics counts)
{
    const auto table_depth = static_cast<std::uint32_t>(lists.table_depth());
    counts.worst_case_steps = 1 + counts.max_depth - std::min(counts.max_depth, table_depth);
    counts.mean_list = mean_list(counts);
    counts.expected_list = lists.statistics().expected_list;
    if (!(counts.expected_list >= 0 && std::isfinite(counts.expected_list)) ||
        counts != lists.statistics()) {
        return bad_lists("they are not those of the lists", "statistics");
    }
    return {};
}

} // namespace

bool is_power_of_two(double value) noexcept
{
    int exponent = 0;
    return std::isfinite(value) && std::frexp(value, &exponent) == 0.5;
}

Status check_lists(const IndexParts& index, const CheckWork& work)
{
    const ProximityLists& lists = *index.lists();
    if (Status status = check_header(lists, index.triangle_count()); !status) return status;
    if (Status status = check_root(index, lists.frame()); !status) return status;
    ArenaChecker arena(lists.arrays().arena, index.triangle_count());
    if (Status status = arena.check_blocks(work); !status) return status;
    CellChecker cells(lists, arena);
    if (Status status = cells.run(work); !status) return status;
    ProximityStatistics counts = cells.counts();
    counts.blocks = arena.blocks();
    return check_statistics(lists, counts);
}

} // namespace proxima
