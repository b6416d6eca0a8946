#include "proxima/proximity/closest_feature.h"

#include "proxima/base/morton_code.h"
#include "proxima/base/radix_sort.h"
#include "proxima/base/text.h"
#include "proxima/proximity/proximity_octree.h"
#include "proxima/proximity/triangle_lanes.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cstring>
#include <hwy/cache_control.h>
#include <limits>
#include <vector>

#ifndef PROXIMA_PROXIMITY_CLOSEST_FEATURE_ONCE
#define PROXIMA_PROXIMITY_CLOSEST_FEATURE_ONCE

namespace proxima {

/// Queries under way at once.
inline constexpr std::size_t queries_together = 16;

/// Of the distance of a search that starts from scratch.
inline constexpr double nothing_known = std::numeric_limits<double>::infinity();

} // namespace proxima

#endif

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "proxima/proximity/closest_feature.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
// After them: it is read once for every instruction set.
#include "proxima/proximity/block_scan-inl.h"
#include "proxima/proximity/row_distance-inl.h"

HWY_BEFORE_NAMESPACE();
namespace proxima::HWY_NAMESPACE {

/// Where a query ends.
struct FoundLeaf {
    std::uint64_t word = 0;
    int depth = 0;
};

HWY_INLINE FoundLeaf find_leaf(const ProximityOctree& octree,
                               const std::array<std::uint32_t, 3>& at)
{
    const int depth = octree.table_depth();
    int shift = static_cast<int>(ProximityOctree::location_bits) - depth;
    const std::uint64_t* const nodes = octree.arrays().nodes.data();
    std::uint64_t word =
        octree.arrays().table[(std::size_t{at[2] >> shift} << depth | at[1] >> shift) << depth |
                              at[0] >> shift];
    while (!proximity_word::is_leaf(word)) {
        --shift;
        word = nodes[word + ((at[0] >> shift & 1U) | (at[1] >> shift & 1U) << 1U |
                             (at[2] >> shift & 1U) << 2U)];
    }
    return {word, static_cast<int>(ProximityOctree::location_bits) - shift};
}

/// All of a usual one.
HWY_INLINE void prefetch_block(const std::byte* block)
{
    for (int line = 0; line < 6; ++line) hwy::Prefetch(block + 64 * line);
}

template <class Scalar>
HWY_INLINE void prefetch_row(const TriangleRow<Scalar>& row)
{
    hwy::Prefetch(&row);
    if (sizeof(row) > 64) hwy::Prefetch(&row.edges[2]);
}

HWY_INLINE RowScale scale_of(const ProximityOctree& octree)
{
    return {octree.frame().scale, 1 / octree.frame().scale};
}

/// Looks at the candidates in doubles.
template <class Scalar>
HWY_INLINE void recheck(const BlockCandidates& candidates,
                        std::span<const TriangleRow<Scalar>> rows, const Vec3& p,
                        const RowScale& scale, RowDistance& best, QuerySteps& steps)
{
    for (std::uint32_t left = candidates.lanes; left != 0; left &= left - 1)
        prefetch_row(rows[candidates.rank(std::countr_zero(left))]);
    for (std::uint32_t left = candidates.lanes; left != 0; left &= left - 1) {
        const std::uint32_t rank = candidates.rank(std::countr_zero(left));
        const RowDistance found = closest_of_row(rows[rank], rank, p, scale);
        if (found.before(best)) best = found;
        ++steps.rechecks;
    }
}

/// By the tree over all triangles: for points outside of the root and leaves without a list.
/// `known`: some point of the mesh is no farther, up to rounding; infinite where that is not known.
template <class Scalar>
RowDistance search_tree(const ProximityOctree& octree, std::span<const TriangleRow<Scalar>> rows,
                        const Vec3& p, double known, QuerySteps& steps)
{
    const RowScale scale = scale_of(octree);
    const double tree_scale = octree.tree().scale();
    const double reach = octree.tree().reach();
    RowDistance best;
    const double bound = known * known * (1 + 0x1p-40) + std::numeric_limits<double>::min();
    visit_nearest(octree.tree(), p, bound, [&](RankRange ranks) noexcept {
        const auto group = rows.subspan(ranks.first, ranks.count);
        std::array<double, TriangleTree::width> squared;
        triangle_distances(group, p, tree_scale, squared);
        ++steps.groups;
        offer_nearest(
            squared, group.size(),
            [&] {
                const double least = std::min(bound, best.squared);
                return triangle_distance_limit(least * tree_scale * tree_scale, reach);
            },
            [&](std::size_t i) {
                const auto rank = static_cast<std::uint32_t>(ranks.first + i);
                const RowDistance found = closest_of_row(rows[rank], rank, p, scale);
                if (found.before(best)) best = found;
                ++steps.rechecks;
            });
        return std::min(bound, best.squared);
    });
    return best;
}

/// A leaf of several blocks: those whose lower bound is beyond what was found are passed over.
template <class Scalar>
void search_run(const ProximityOctree& octree, std::span<const TriangleRow<Scalar>> rows,
                std::uint64_t word, const Vec3& frame_p, const Vec3& p, double known,
                RowDistance& best, QuerySteps& steps)
{
    const RunEntry* const run = octree.arrays().runs.data() + proximity_word::place(word);
    const Vec3 from_center = frame_p - Eigen::Vector3f(run->direction).cast<double>();
    const double radius = from_center.norm();
    const std::byte* const arena = octree.arrays().arena.data();
    // In the frame, rounded up.
    double nearest = known * octree.frame().scale * (1 + 0x1p-40) + 0x1p-44;
    for (std::uint32_t i = 1; i <= run->place; ++i) {
        const RunEntry& entry = run[i];
        if (static_cast<double>(entry.least) - radius > nearest) break;
        const double bound = static_cast<double>(entry.least) -
                             static_cast<double>(entry.direction[0]) * from_center[0] -
                             static_cast<double>(entry.direction[1]) * from_center[1] -
                             static_cast<double>(entry.direction[2]) * from_center[2];
        if (bound > nearest) continue;
        const std::byte* const block = arena + std::size_t{entry.place} * block_alignment;
        BlockHeader header;
        std::memcpy(&header, block, sizeof(header));
        ++steps.blocks;
        const double in_units = nearest * static_cast<double>(header.inverse_unit);
        BlockCandidates candidates;
        scan_block<true>(block, entry.mask, frame_p, in_units, candidates);
        if (candidates.lanes == 0) continue;
        recheck(candidates, rows, p, scale_of(octree), best, steps);
        nearest = std::min(nearest, std::sqrt(best.squared) * octree.frame().scale * (1 + 0x1p-40) +
                                        0x1p-44);
    }
}

template <class Scalar>
HWY_INLINE RowDistance search(const ProximityOctree& octree,
                              std::span<const TriangleRow<Scalar>> rows, const Vec3& p,
                              double known, QuerySteps& steps)
{
    RowDistance best;
    const Vec3 frame_p = octree.frame().to_frame(p);
    std::array<std::uint32_t, 3> at{};
    if (!octree.locate(frame_p, at)) return search_tree(octree, rows, p, known, steps);
    const FoundLeaf leaf = find_leaf(octree, at);
    steps.steps += 1 + static_cast<std::uint32_t>(HWY_MAX(leaf.depth - octree.table_depth(), 0));
    if (!proximity_word::is_block(leaf.word)) [[unlikely]] {
        if (leaf.word == proximity_word::search) return search_tree(octree, rows, p, known, steps);
        search_run(octree, rows, leaf.word, frame_p, p, known, best, steps);
        return best;
    }
    const std::byte* const block = octree.arrays().arena.data() +
                                   std::size_t{proximity_word::place(leaf.word)} * block_alignment;
    prefetch_block(block);
    ++steps.blocks;
    BlockCandidates candidates;
    scan_block<false>(block, proximity_word::mask(leaf.word), frame_p, 0, candidates);
    recheck(candidates, rows, p, scale_of(octree), best, steps);
    return best;
}

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
        for (std::uint32_t left = query.candidates.lanes; left != 0; left &= left - 1)
            prefetch_row(rows[query.candidates.rank(std::countr_zero(left))]);
    }
    QuerySteps steps;
    for (std::size_t i = 0; i < points.size(); ++i) {
        OpenQuery& query = queries[i];
        if (!has_block(query)) {
            found[i] = search(octree, rows, points[i], nothing_known, steps);
            continue;
        }
        found[i] = {};
        recheck(query.candidates, rows, points[i], scale_of(octree), found[i], steps);
    }
}

RowDistance search_octree(const ProximityOctree& octree, const Vec3& p, double known,
                          QuerySteps& steps)
{
    const ProximityArrays& arrays = octree.arrays();
    return arrays.double_rows.empty() ? search(octree, arrays.float_rows, p, known, steps)
                                      : search(octree, arrays.double_rows, p, known, steps);
}

void search_octree_together(const ProximityOctree& octree, std::span<const Vec3> points,
                            RowDistance* found)
{
    const ProximityArrays& arrays = octree.arrays();
    if (arrays.double_rows.empty())
        search_together(octree, arrays.float_rows, points, found);
    else
        search_together(octree, arrays.double_rows, points, found);
}

} // namespace proxima::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace proxima {

HWY_EXPORT(search_octree);
HWY_EXPORT(search_octree_together);

namespace {

/// The answer in full: named by the lowest triangle that has the feature.
template <class Scalar>
ClosestFeature describe(const ProximityArrays& arrays, std::span<const TriangleRow<Scalar>> rows,
                        const RowDistance& found)
{
    const TriangleRow<Scalar>& row = rows[found.rank];
    ClosestFeature answer;
    answer.feature = {found.kind(), found.id()};
    answer.squared_distance = found.squared;
    switch (found.kind()) {
    case FeatureKind::vertex: {
        const std::uint32_t place = arrays.vertex_places[found.id()];
        answer.triangle = TriangleId{place_word::triangle(place)};
        answer.barycentric[place_word::corner(place)] = 1;
        answer.point = row.corner(static_cast<int>(corner_of(row, found.id())));
        break;
    }
    case FeatureKind::edge: {
        const std::uint32_t place = arrays.edge_places[found.id()];
        answer.triangle = TriangleId{place_word::triangle(place)};
        const std::size_t side = side_of(row, found.id());
        const double along = found.along[side];
        const auto next_to = [](std::size_t corner) { return corner == 2 ? 0 : corner + 1; };
        const auto lower_first = [&](bool backward, std::size_t from) {
            const std::size_t to = next_to(from);
            return backward ? std::array{to, from} : std::array{from, to};
        };
        const auto [lower, upper] = lower_first(row.backward(side), side);
        answer.point = (1 - along) * row.corner(static_cast<int>(lower)) +
                       along * row.corner(static_cast<int>(upper));
        const auto [first, second] =
            lower_first(place_word::backward(place), place_word::corner(place));
        answer.barycentric[first] = 1 - along;
        answer.barycentric[second] = along;
        break;
    }
    case FeatureKind::face: {
        answer.triangle = TriangleId{found.id()};
        const double all = found.parts[0] + found.parts[1] + found.parts[2];
        const double v = found.parts[2] / all;
        const double w = found.parts[0] / all;
        answer.barycentric = {std::max(0.0, 1 - v - w), v, w};
        answer.point =
            answer.barycentric[0] * row.corner(0) + v * row.corner(1) + w * row.corner(2);
        break;
    }
    }
    return answer;
}

ClosestFeature describe(const ProximityOctree& octree, const RowDistance& found)
{
    const ProximityArrays& arrays = octree.arrays();
    return arrays.double_rows.empty() ? describe(arrays, arrays.float_rows, found)
                                      : describe(arrays, arrays.double_rows, found);
}

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
    for (std::size_t k = 0; k < points.size(); ++k) answers[place(k)] = describe(octree, found[k]);
}

/// Answers up to the first point that is not finite; returns where that is.
std::size_t answer_chunk(const ProximityOctree& octree, std::span<const Vec3> points,
                         std::span<ClosestFeature> answers, bool sorted)
{
    const auto bad = std::ranges::find_if(points, [](const Vec3& p) { return !p.allFinite(); });
    const auto finite = static_cast<std::size_t>(bad - points.begin());
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

ClosestFeature closest_feature(const ProximityOctree& octree, const Vec3& p,
                               QuerySteps& steps) noexcept
{
    return describe(octree, HWY_DYNAMIC_DISPATCH(search_octree)(octree, p, nothing_known, steps));
}

ClosestFeature closest_feature(const ProximityOctree& octree, const Vec3& p) noexcept
{
    QuerySteps steps;
    return closest_feature(octree, p, steps);
}

ClosestFeature closest_feature(const ProximityOctree& octree, const Vec3& p,
                               const ClosestFeature& earlier, QuerySteps& steps) noexcept
{
    // The earlier point is of the mesh up to the rounding of its coordinates.
    const RootFrame& frame = octree.frame();
    const double rounding = 0x1p-46 * (frame.center.cwiseAbs().maxCoeff() + frame.half);
    const double known = (p - earlier.point).norm() + rounding;
    const RowDistance found = HWY_DYNAMIC_DISPATCH(search_octree)(octree, p, known, steps);
    // Nothing that near: it was no point of this mesh, and what was passed over may be nearer.
    if (!(found.squared <= known * known)) return closest_feature(octree, p, steps);
    return describe(octree, found);
}

ClosestFeature closest_feature(const ProximityOctree& octree, const Vec3& p,
                               const ClosestFeature& earlier) noexcept
{
    QuerySteps steps;
    return closest_feature(octree, p, earlier, steps);
}

std::optional<ClosestFeature> closest_feature(const ProximityOctree& octree, const Vec3& p,
                                              double radius) noexcept
{
    const ClosestFeature closest = closest_feature(octree, p);
    if (closest.squared_distance > radius * radius) return std::nullopt;
    return closest;
}

Status closest_features(const ProximityOctree& octree, std::span<const Vec3> points,
                        std::span<ClosestFeature> answers, const BatchOptions& options)
{
    if (points.size() != answers.size()) {
        return fail(
            ErrorCode::invalid_argument,
            concat("room for ", answers.size(), " answers, but ", points.size(), " points"));
    }
    const bool sorted = options.order == BatchOrder::automatic
                            ? pays_to_sort(octree, points)
                            : options.order == BatchOrder::sorted;
    // Sorted ones in chunks as large as the threads leave them.
    const std::size_t share =
        points.size() / static_cast<std::size_t>(thread_count(options.threads)) + 1;
    const std::size_t chunk =
        sorted ? std::clamp(share, chunk_points, sorted_chunk_points) : chunk_points;
    const std::size_t chunks = (points.size() + chunk - 1) / chunk;
    std::atomic<std::size_t> bad{points.size()};
    if (options.progress != nullptr)
        options.progress->begin_stage("closest features", points.size());
    parallel_for(chunks, options.threads, [&](std::size_t i) {
        if (is_cancelled(options.progress)) return;
        const std::size_t first = i * chunk;
        const std::size_t count = std::min(chunk, points.size() - first);
        const std::size_t finite = answer_chunk(octree, points.subspan(first, count),
                                                answers.subspan(first, count), sorted);
        if (finite < count) keep_least(bad, first + finite);
        if (options.progress != nullptr) options.progress->advance(count);
    });
    if (is_cancelled(options.progress)) {
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
