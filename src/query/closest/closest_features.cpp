#include "base/morton_code.h"
#include "base/parallel.h"
#include "base/progress.h"
#include "base/radix_sort.h"
#include "base/text.h"
#include "query/closest/closest_feature.h"
#include "query/closest/describe_closest.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <limits>
#include <vector>

#ifndef PROXIMA_PROXIMITY_CLOSEST_FEATURES_ONCE
#define PROXIMA_PROXIMITY_CLOSEST_FEATURES_ONCE

namespace proxima {

/// Queries under way at once.
inline constexpr std::size_t queries_together = 16;

} // namespace proxima

#endif

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "query/closest/closest_features.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
// After them: it is read once for every instruction set.
#include "query/closest/search_octree-inl.h"

HWY_BEFORE_NAMESPACE();
namespace proxima::HWY_NAMESPACE {

/// A query on its way, when several are under way at once.
struct OpenQuery {
    Vec3 frame_p;
    std::array<std::uint32_t, 3> at{};
    std::uint64_t word = 0;
    int shift = 0;
    bool inside = false;
    BlockCandidates candidates;
};

/// Where a query's next word is.
HWY_INLINE std::uint64_t next_node(const OpenQuery& query, int shift)
{
    return query.word + ((query.at[0] >> shift & 1U) | (query.at[1] >> shift & 1U) << 1U |
                         (query.at[2] >> shift & 1U) << 2U);
}

/// Every stage for all queries before the next one, so that they wait for memory together.
template <class Scalar>
void search_together(const ProximityOctree& octree, std::span<const TriangleRow<Scalar>> rows,
                     std::span<const Vec3> points, RowDistance* found)
{
    std::array<OpenQuery, queries_together> queries;
    const ProximityArrays& arrays = octree.arrays();
    const int depth = octree.table_depth();
    const int table_shift = static_cast<int>(ProximityOctree::location_bits) - depth;
    const auto table_place = [&](const std::array<std::uint32_t, 3>& at) {
        return (std::size_t{at[2] >> table_shift} << depth | at[1] >> table_shift) << depth |
               at[0] >> table_shift;
    };
    for (std::size_t i = 0; i < points.size(); ++i) {
        OpenQuery& query = queries[i];
        query.frame_p = octree.frame().to_frame(points[i]);
        query.inside = octree.locate(query.frame_p, query.at);
        query.shift = table_shift;
        if (query.inside) hwy::Prefetch(&arrays.table[table_place(query.at)]);
    }
    for (std::size_t i = 0; i < points.size(); ++i) {
        OpenQuery& query = queries[i];
        query.word = query.inside ? arrays.table[table_place(query.at)] : proximity_word::leaf_bit;
        if (!proximity_word::is_leaf(query.word))
            hwy::Prefetch(&arrays.nodes[next_node(query, query.shift - 1)]);
    }
    for (bool more = true; more;) {
        more = false;
        for (std::size_t i = 0; i < points.size(); ++i) {
            OpenQuery& query = queries[i];
            if (proximity_word::is_leaf(query.word)) continue;
            --query.shift;
            query.word = arrays.nodes[next_node(query, query.shift)];
            if (proximity_word::is_leaf(query.word)) continue;
            hwy::Prefetch(&arrays.nodes[next_node(query, query.shift - 1)]);
            more = true;
        }
    }
    const auto block_of = [&](const OpenQuery& query) {
        return arrays.arena.data() +
               std::size_t{proximity_word::place(query.word)} * block_alignment;
    };
    const auto has_block = [](const OpenQuery& query) {
        return query.inside && proximity_word::is_block(query.word);
    };
    for (std::size_t i = 0; i < points.size(); ++i)
        if (has_block(queries[i])) prefetch_block(block_of(queries[i]));
    for (std::size_t i = 0; i < points.size(); ++i) {
        OpenQuery& query = queries[i];
        if (!has_block(query)) continue;
        scan_block<false>(block_of(query), proximity_word::mask(query.word), query.frame_p, 0,
                          query.candidates);
    }
    // Apart from the scans: whether a loop goes on is known at once here, there only at their end.
    for (std::size_t i = 0; i < points.size(); ++i) {
        const OpenQuery& query = queries[i];
        if (!has_block(query)) continue;
        for (std::uint32_t left = query.candidates.lanes; left != 0; left &= left - 1)
            prefetch_row(rows[query.candidates.rank(std::countr_zero(left))]);
    }
    QuerySteps steps;
    for (std::size_t i = 0; i < points.size(); ++i) {
        OpenQuery& query = queries[i];
        if (!has_block(query)) {
            constexpr double unknown = std::numeric_limits<double>::infinity();
            found[i] = search(octree, rows, points[i], unknown, steps);
            continue;
        }
        found[i] = {};
        recheck(query.candidates, rows, points[i], scale_of(octree), found[i], steps);
    }
}

void search_octree_together(const ProximityOctree& octree, std::span<const Vec3> points,
                            RowDistance* found)
{
    const ProximityArrays& arrays = octree.arrays();
    if (arrays.double_rows.empty()) {
        search_together(octree, arrays.float_rows, points, found);
    } else {
        search_together(octree, arrays.double_rows, points, found);
    }
}

} // namespace proxima::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace proxima {

HWY_EXPORT(search_octree_together);

namespace {

/// Points that are searched for one after the other, at most: what they meet is to stay in the
/// caches, and so are the answers.
constexpr std::size_t chunk_points = 4096;
constexpr std::size_t sorted_chunk_points = std::size_t{1} << 18U;

/// Where a point is along the curve, and which it is.
struct SortedPoint {
    std::uint32_t key = 0;
    std::uint32_t index = 0;
};

/// Bits of each coordinate that points are sorted by.
constexpr unsigned sorted_bits = 7;

std::array<std::uint32_t, 3> sorting_cell(const ProximityOctree& octree, const Vec3& p)
{
    std::array<std::uint32_t, 3> at{};
    if (!octree.locate(octree.frame().to_frame(p), at)) return {};
    for (std::uint32_t& coordinate : at)
        coordinate >>= ProximityOctree::location_bits - sorted_bits;
    return at;
}

/// Whether it pays to sort: where the octree is beyond all caches, and many points are there whose
/// neighbours in the span are none in space.
bool pays_to_sort(const ProximityOctree& octree, std::span<const Vec3> points)
{
    constexpr std::size_t samples = 256;
    constexpr std::uint64_t beyond_caches = std::uint64_t{1} << 26U;
    if (points.size() < 8 * chunk_points || octree.bytes() < beyond_caches) return false;
    std::size_t apart = 0;
    for (std::size_t i = 0; i < samples; ++i) {
        const std::size_t at = points.size() / samples * i;
        apart += sorting_cell(octree, points[at]) != sorting_cell(octree, points[at + 1]) ? 1 : 0;
    }
    return 2 * apart > samples;
}

/// The order of the points along the Morton curve.
std::vector<SortedPoint> sorted_points(const ProximityOctree& octree, std::span<const Vec3> points)
{
    std::vector<SortedPoint> order(points.size());
    for (std::uint32_t i = 0; i < points.size(); ++i)
        order[i] = {static_cast<std::uint32_t>(morton_code(sorting_cell(octree, points[i]))), i};
    StageSteps unwatched(nullptr, "", 0);
    (void)radix_sort(
        order, 3 * sorted_bits, [](const SortedPoint& point) { return point.key; }, unwatched);
    return order;
}

/// Answers a few points; `place(k)` is where the k-th one's answer goes.
template <class Place>
void answer_together(const ProximityOctree& octree, std::span<const Vec3> points,
                     std::span<ClosestFeature> answers, const Place& place)
{
    std::array<RowDistance, queries_together> found;
    HWY_DYNAMIC_DISPATCH(search_octree_together)(octree, points, found.data());
    const ProximityArrays& arrays = octree.arrays();
    for (std::size_t k = 0; k < points.size(); ++k) {
        const FeatureKind kind = found[k].kind();
        if (kind == FeatureKind::vertex) hwy::Prefetch(&arrays.vertex_places[found[k].id()]);
        if (kind == FeatureKind::edge) hwy::Prefetch(&arrays.edge_places[found[k].id()]);
    }
    for (std::size_t k = 0; k < points.size(); ++k)
        answers[place(k)] = describe_closest(octree, found[k]);
}

/// Answers up to the first point that is not finite; returns where that is.
/// \pre the order is not automatic
std::size_t answer_chunk(const ProximityOctree& octree, std::span<const Vec3> points,
                         std::span<ClosestFeature> answers, BatchOrder batch_order)
{
    const auto bad = std::ranges::find_if(points, [](const Vec3& p) { return !p.allFinite(); });
    const auto finite = static_cast<std::size_t>(bad - points.begin());
    const bool sorted = batch_order == BatchOrder::sorted;
    const std::vector<SortedPoint> order =
        sorted ? sorted_points(octree, points.first(finite)) : std::vector<SortedPoint>{};
    std::array<Vec3, queries_together> some;
    for (std::size_t i = 0; i < finite; i += queries_together) {
        const std::size_t count = std::min(queries_together, finite - i);
        if (!sorted) {
            answer_together(octree, points.subspan(i, count), answers,
                            [&](std::size_t k) { return i + k; });
            continue;
        }
        for (std::size_t k = 0; k < count; ++k) some[k] = points[order[i + k].index];
        answer_together(octree, std::span(some).first(count), answers,
                        [&](std::size_t k) { return order[i + k].index; });
    }
    return finite;
}

void keep_least(std::atomic<std::size_t>& least, std::size_t value)
{
    std::size_t seen = least.load();
    while (value < seen && !least.compare_exchange_weak(seen, value)) {
    }
}

} // namespace

Status closest_features(const ProximityOctree& octree, std::span<const Vec3> points,
                        std::span<ClosestFeature> answers, const BatchOptions& options)
{
    if (points.size() != answers.size()) {
        return fail(
            ErrorCode::invalid_argument,
            concat("room for ", answers.size(), " answers, but ", points.size(), " points"));
    }
    BatchOrder order = options.order;
    if (order == BatchOrder::automatic)
        order = pays_to_sort(octree, points) ? BatchOrder::sorted : BatchOrder::as_given;
    // Sorted ones in chunks as large as the threads leave them.
    const std::size_t share =
        points.size() / static_cast<std::size_t>(thread_count(options.execution.threads)) + 1;
    const std::size_t chunk = order == BatchOrder::sorted
                                  ? std::clamp(share, chunk_points, sorted_chunk_points)
                                  : chunk_points;
    const std::size_t chunks = (points.size() + chunk - 1) / chunk;
    std::atomic<std::size_t> bad{points.size()};
    begin_stage(options.execution.progress, "closest features", points.size());
    parallel_for(chunks, options.execution.threads, [&](std::size_t i) {
        if (is_cancelled(options.execution.progress)) return;
        const std::size_t first = i * chunk;
        const std::size_t count = std::min(chunk, points.size() - first);
        const std::size_t finite = answer_chunk(octree, points.subspan(first, count),
                                                answers.subspan(first, count), order);
        if (finite < count) keep_least(bad, first + finite);
        advance_stage(options.execution.progress, count);
    });
    if (is_cancelled(options.execution.progress)) {
        return fail(ErrorCode::cancelled, "searching closest features was cancelled");
    }
    if (bad < points.size()) {
        return fail(ErrorCode::invalid_argument,
                    concat("point ", bad.load(), " is not finite: leave it out"), "points");
    }
    return {};
}

} // namespace proxima

#endif
