// Several points in the lists of a mesh index at once. Included once per target.
#if defined(PROXIMA_QUERY_CLOSEST_BATCH_LISTS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef PROXIMA_QUERY_CLOSEST_BATCH_LISTS_INL_H
#undef PROXIMA_QUERY_CLOSEST_BATCH_LISTS_INL_H
#else
#define PROXIMA_QUERY_CLOSEST_BATCH_LISTS_INL_H
#endif

#include "index/index_parts.h"
#include "query/closest/find_closest.h"
#include "query/closest/search_lists-inl.h"

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <hwy/cache_control.h>
#include <hwy/highway.h>
#include <limits>

HWY_BEFORE_NAMESPACE();
namespace proxima::HWY_NAMESPACE {

/// Queries under way at once.
inline constexpr std::size_t queries_together = 16;

/// A query on its way, when several are under way at once.
struct ListQuery {
    Vec3 frame_p;
    std::array<std::uint32_t, 3> at{};
    std::uint64_t word = 0;
    int shift = 0;
    bool inside = false;
    BlockCandidates candidates;
};

/// Where a query's next word is.
HWY_INLINE std::uint64_t next_node(const ListQuery& query, int shift)
{
    return query.word + ((query.at[0] >> shift & 1U) | (query.at[1] >> shift & 1U) << 1U |
                         (query.at[2] >> shift & 1U) << 2U);
}

/// Every stage for all queries before the next one, so that they wait for memory together.
template <class Scalar>
void search_lists_together(const IndexParts& index, const ProximityLists& lists,
                           std::span<const TriangleRow<Scalar>> rows, std::span<const Vec3> points,
                           RowDistance* found)
{
    std::array<ListQuery, queries_together> queries;
    const ProximityArrays& arrays = lists.arrays();
    const int depth = lists.table_depth();
    const int table_shift = static_cast<int>(ProximityLists::location_bits) - depth;
    const auto table_position = [&](const std::array<std::uint32_t, 3>& at) {
        return (std::size_t{at[2] >> table_shift} << depth | at[1] >> table_shift) << depth |
               at[0] >> table_shift;
    };
    for (std::size_t i = 0; i < points.size(); ++i) {
        ListQuery& query = queries[i];
        query.frame_p = lists.frame().to_frame(points[i]);
        query.inside = lists.locate(query.frame_p, query.at);
        query.shift = table_shift;
        if (query.inside) hwy::Prefetch(&arrays.table[table_position(query.at)]);
    }
    for (std::size_t i = 0; i < points.size(); ++i) {
        ListQuery& query = queries[i];
        query.word =
            query.inside ? arrays.table[table_position(query.at)] : proximity_word::leaf_bit;
        if (!proximity_word::is_leaf(query.word))
            hwy::Prefetch(&arrays.nodes[next_node(query, query.shift - 1)]);
    }
    for (bool more = true; more;) {
        more = false;
        for (std::size_t i = 0; i < points.size(); ++i) {
            ListQuery& query = queries[i];
            if (proximity_word::is_leaf(query.word)) continue;
            --query.shift;
            query.word = arrays.nodes[next_node(query, query.shift)];
            if (proximity_word::is_leaf(query.word)) continue;
            hwy::Prefetch(&arrays.nodes[next_node(query, query.shift - 1)]);
            more = true;
        }
    }
    const auto block_of = [&](const ListQuery& query) {
        return arrays.arena.data() +
               std::size_t{proximity_word::position(query.word)} * block_alignment;
    };
    const auto has_block = [](const ListQuery& query) {
        return query.inside && proximity_word::is_block(query.word);
    };
    for (std::size_t i = 0; i < points.size(); ++i)
        if (has_block(queries[i])) prefetch_block(block_of(queries[i]));
    for (std::size_t i = 0; i < points.size(); ++i) {
        ListQuery& query = queries[i];
        if (!has_block(query)) continue;
        scan_block<false>(block_of(query), proximity_word::mask(query.word), query.frame_p, 0,
                          query.candidates);
    }
    // Apart from the scans: whether a loop goes on is known at once here, there only at their end.
    for (std::size_t i = 0; i < points.size(); ++i) {
        const ListQuery& query = queries[i];
        if (!has_block(query)) continue;
        for (std::uint32_t left = query.candidates.lanes; left != 0; left &= left - 1)
            prefetch_row_of(rows[query.candidates.rank(std::countr_zero(left))]);
    }
    QuerySteps steps;
    for (std::size_t i = 0; i < points.size(); ++i) {
        ListQuery& query = queries[i];
        if (!has_block(query)) {
            constexpr double unknown = std::numeric_limits<double>::infinity();
            found[i] = find_closest(index, points[i], unknown);
            continue;
        }
        found[i] = {};
        recheck(query.candidates, rows, points[i], row_scale_of(index), found[i], steps);
    }
}

} // namespace proxima::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
