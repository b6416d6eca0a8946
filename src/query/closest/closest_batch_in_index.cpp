#include "base/hilbert_code.h"
#include "base/parallel.h"
#include "base/progress.h"
#include "base/radix_sort.h"
#include "base/text.h"
#include "index/index_parts.h"
#include "proxima/closest_feature.h"
#include "query/batch_size.h"
#include "query/closest/describe_closest.h"
#include "query/closest/find_closest.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <vector>

#ifndef PROXIMA_QUERY_CLOSEST_BATCH_IN_INDEX_ONCE
#define PROXIMA_QUERY_CLOSEST_BATCH_IN_INDEX_ONCE

namespace proxima {

/// Where a point is along the curve, and which it is.
struct CurvePoint {
    std::uint32_t key = 0;
    std::uint32_t position = 0;
};

/// Points that are searched for one after the other, all finite, and where their answers go.
struct ClosestChunk {
    const IndexParts& index;
    std::span<const Vec3> points;
    std::span<const CurvePoint> order; ///< empty: as they are
    ClosestOutputs outputs;            ///< of these points
    Progress* progress;                ///< of a stage that somebody has entered: a step for each

    [[nodiscard]] std::size_t position(std::size_t i) const noexcept
    {
        return order.empty() ? i : order[i].position;
    }

    /// Whether outputs want more than distances and triangles.
    [[nodiscard]] bool describes() const noexcept
    {
        return !outputs.answers.empty() || !outputs.points.empty() || !outputs.barycentrics.empty();
    }
};

/// Points that are searched for between two looks at whether to go on. A point from which all of a
/// round mesh is as far takes milliseconds.
constexpr std::size_t points_per_report = 64;

inline void write_description(const ClosestOutputs& to, std::size_t position,
                              const ClosestFeature& answer)
{
    if (!to.answers.empty()) to.answers[position] = answer;
    if (!to.points.empty()) to.points[position] = answer.point;
    if (!to.barycentrics.empty()) to.barycentrics[position] = answer.barycentric;
    if (!to.triangles.empty()) to.triangles[position] = answer.triangle;
}

} // namespace proxima

#endif

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "query/closest/closest_batch_in_index.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
// After them: it is read once for every instruction set.
#include "query/closest/batch_lists-inl.h"

HWY_BEFORE_NAMESPACE();
namespace proxima::HWY_NAMESPACE {

HWY_INLINE void prefetch_feature(const IndexParts& index, const RowDistance& found)
{
    if (found.kind() == FeatureKind::vertex) hwy::Prefetch(&index.vertex_incidences()[found.id()]);
    if (found.kind() == FeatureKind::edge) hwy::Prefetch(&index.edge_incidences()[found.id()]);
}

HWY_INLINE void write_answer(const ClosestChunk& chunk, std::size_t position,
                             const RowDistance& found)
{
    const ClosestOutputs& to = chunk.outputs;
    if (chunk.describes()) {
        write_description(to, position, describe_closest(chunk.index, found));
    } else if (!to.triangles.empty()) {
        to.triangles[position] = triangle_of(chunk.index, found);
    }
    const double squared = row_scale_of(chunk.index).unscale_squared(found.squared);
    if (!to.squared_distances.empty()) to.squared_distances[position] = squared;
    if (!to.distances.empty()) to.distances[position] = std::sqrt(squared);
    if (!to.feature_kinds.empty())
        to.feature_kinds[position] = found.found() ? found.kind() : FeatureKind::vertex;
    if (!to.feature_ids.empty()) to.feature_ids[position] = found.id();
}

/// The points of a chunk, several of them on their way at once, so that they wait for memory
/// together. Each starts from the answer found last, which is near where points are in order.
template <class Scalar>
class ChunkSearch {
public:
    ChunkSearch(const ClosestChunk& chunk, std::span<const TriangleRow<Scalar>> rows)
        : chunk_(chunk), rows_(rows), blocks_(chunk.index.blocks().data()),
          steps_(chunk.progress, points_per_report)
    {}

    void run()
    {
        std::size_t busy = 0;
        while (busy < flights_.size() && begin_next(flights_[busy])) ++busy;
        while (busy > 0) {
            for (std::size_t i = 0; i < busy;) {
                Flight& flight = flights_[i];
                const Eight3 lanes = lanes_of(flight.query);
                if (search_step(chunk_.index, rows_, blocks_, lanes, flight.p, flight.query)) {
                    prefetch_block_of(blocks_, flight.query.next);
                    ++i;
                    continue;
                }
                settle(chunk_.index, rows_, flight.p, flight.query);
                take(flight.position, flight.p, flight.query.best);
                if (begin_next(flight)) {
                    ++i;
                } else {
                    std::swap(flights_[i], flights_[--busy]);
                }
            }
        }
        write_last();
        steps_.finish();
    }

private:
    /// How many are on their way at once.
    static constexpr std::size_t together = 2;

    struct Flight {
        Vec3 p;
        std::size_t position;
        IndexQuery query;

        Flight() noexcept {} // NOLINT(modernize-use-equals-default): clears nothing
    };

    /// The next point that needs a walk; false where there is none, or the search shall stop.
    bool begin_next(Flight& flight)
    {
        while (next_ < chunk_.points.size()) {
            if (!steps_.done(1)) {
                next_ = chunk_.points.size();
                break;
            }
            flight.position = chunk_.position(next_++);
            if (next_ + ahead < chunk_.points.size())
                hwy::Prefetch(&chunk_.points[chunk_.position(next_ + ahead)]);
            flight.p = chunk_.points[flight.position];
            // In the index's units: squares of very small numbers are zero.
            const double step = (chunk_.index.scale() * (flight.p - last_point_)).norm();
            const double known = last_distance_ + chunk_.index.unscale() * step;
            const double bound = known >= 0 ? known : std::numeric_limits<double>::infinity();
            if (flight.query.begin(chunk_.index, flight.p, bound) == QueryStart::near) return true;
            take(flight.position, flight.p, find_closest(chunk_.index, flight.p, bound));
        }
        return false;
    }

    /// Keeps an answer to write it when what it names has arrived from memory.
    void take(std::size_t position, const Vec3& p, const RowDistance& found)
    {
        last_point_ = p;
        last_distance_ = std::sqrt(found.squared) * chunk_.index.unscale();
        write_last();
        prefetch_feature(chunk_.index, found);
        unwritten_ = found_or_any(found, rows_, std::numeric_limits<double>::infinity());
        unwritten_position_ = position;
        has_unwritten_ = true;
    }

    void write_last()
    {
        if (has_unwritten_) write_answer(chunk_, unwritten_position_, unwritten_);
        has_unwritten_ = false;
    }

    static constexpr std::size_t ahead = 8; ///< points that are fetched before they begin

    const ClosestChunk& chunk_;
    std::span<const TriangleRow<Scalar>> rows_;
    const IndexBlock* blocks_;
    StageSteps steps_;
    std::size_t next_ = 0;
    Vec3 last_point_ = Vec3::Zero();
    double last_distance_ = std::numeric_limits<double>::infinity();
    RowDistance unwritten_;
    std::size_t unwritten_position_ = 0;
    bool has_unwritten_ = false;
    std::array<Flight, together> flights_;
};

/// The points of a chunk by the index's lists.
template <class Scalar>
void search_chunk_in_lists(const ClosestChunk& chunk, std::span<const TriangleRow<Scalar>> rows)
{
    std::array<Vec3, queries_together> points;
    std::array<RowDistance, queries_together> found;
    StageSteps steps(chunk.progress, points_per_report);
    for (std::size_t first = 0; first < chunk.points.size(); first += queries_together) {
        const std::size_t count = HWY_MIN(queries_together, chunk.points.size() - first);
        if (!steps.done(count)) return;
        for (std::size_t i = 0; i < count; ++i) points[i] = chunk.points[chunk.position(first + i)];
        search_lists_together(chunk.index, *chunk.index.lists(), rows,
                              std::span(points).first(count), found.data());
        for (std::size_t i = 0; i < count; ++i) prefetch_feature(chunk.index, found[i]);
        for (std::size_t i = 0; i < count; ++i)
            write_answer(chunk, chunk.position(first + i), found[i]);
    }
    steps.finish();
}

template <class Scalar>
void search_chunk_of(const ClosestChunk& chunk, std::span<const TriangleRow<Scalar>> rows)
{
    if (chunk.index.lists() != nullptr) {
        search_chunk_in_lists(chunk, rows);
    } else {
        ChunkSearch<Scalar>(chunk, rows).run();
    }
}

void search_chunk(const ClosestChunk& chunk)
{
    const IndexParts& index = chunk.index;
    if (index.double_rows().empty()) {
        search_chunk_of(chunk, index.float_rows());
    } else {
        search_chunk_of(chunk, index.double_rows());
    }
}

} // namespace proxima::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace proxima {

HWY_EXPORT(search_chunk);

namespace {

/// Points that a thread searches for before it takes more, and those of them that are sorted.
constexpr std::size_t chunk_points = 4096;
constexpr std::size_t sorted_chunk_points = std::size_t{1} << 18U;

/// Bits of each coordinate that points are sorted by: two passes.
constexpr int curve_bits = 7;

/// Where a point is in a grid of 2^curve_bits cells along the index's box and a little around it.
std::array<std::uint32_t, 3> curve_cell(const IndexParts& index, const Vec3& p) noexcept
{
    constexpr double cells = 1U << static_cast<unsigned>(curve_bits);
    constexpr double reach = 1.25; // of the mesh's own [-1, 1]
    std::array<std::uint32_t, 3> cell{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto k = static_cast<Eigen::Index>(axis);
        const double at = (p[k] - index.center()[k]) * index.scale();
        const double position = (at + reach) * (cells / (2 * reach));
        // Samples are taken before all points are known to be finite: NaN is in the first cell.
        cell[axis] = position > 0 ? static_cast<std::uint32_t>(std::min(position, cells - 1)) : 0;
    }
    return cell;
}

/// Whether points that follow each other are mostly apart: then it pays to sort them, in lists
/// where these are beyond all caches.
bool pays_to_sort(const MeshIndex& index, std::span<const Vec3> points) noexcept
{
    constexpr std::size_t samples = 64;
    constexpr std::uint64_t beyond_caches = std::uint64_t{1} << 26U;
    if (points.size() < 4 * samples) return false;
    if (index.has_lists() && (points.size() < 8 * chunk_points || index.bytes() < beyond_caches))
        return false;
    const IndexParts& parts = index.parts();
    std::size_t apart = 0;
    for (std::size_t i = 0; i < samples; ++i) {
        const std::size_t at = points.size() / samples * i;
        apart += curve_cell(parts, points[at]) != curve_cell(parts, points[at + 1]) ? 1 : 0;
    }
    return 2 * apart > samples;
}

std::vector<CurvePoint> points_along_curve(const IndexParts& index, std::span<const Vec3> points)
{
    std::vector<CurvePoint> order(points.size());
    for (std::uint32_t i = 0; i < points.size(); ++i) {
        order[i] = {
            static_cast<std::uint32_t>(hilbert_code(curve_cell(index, points[i]), curve_bits)), i};
    }
    StageSteps unwatched(nullptr, "", 0);
    (void)radix_sort(
        order, 3 * curve_bits, [](const CurvePoint& point) { return point.key; }, unwatched);
    return order;
}

template <class T>
std::span<T> part_of(std::span<T> all, std::size_t first, std::size_t count)
{
    return all.empty() ? all : all.subspan(first, count);
}

ClosestOutputs part_of(const ClosestOutputs& all, std::size_t first, std::size_t count)
{
    return {.answers = part_of(all.answers, first, count),
            .squared_distances = part_of(all.squared_distances, first, count),
            .triangles = part_of(all.triangles, first, count),
            .distances = part_of(all.distances, first, count),
            .points = part_of(all.points, first, count),
            .feature_kinds = part_of(all.feature_kinds, first, count),
            .feature_ids = part_of(all.feature_ids, first, count),
            .barycentrics = part_of(all.barycentrics, first, count)};
}

bool is_sorted(const MeshIndex& index, std::span<const Vec3> points, BatchOrder order) noexcept
{
    return order == BatchOrder::sorted ||
           (order == BatchOrder::automatic && pays_to_sort(index, points));
}

/// \pre points are finite
void answer_chunk(const IndexParts& index, std::span<const Vec3> points,
                  const ClosestOutputs& outputs, bool sorted, Progress* progress)
{
    const auto order = sorted ? points_along_curve(index, points) : std::vector<CurvePoint>{};
    HWY_DYNAMIC_DISPATCH(search_chunk)({index, points, order, outputs, progress});
}

std::span<const Vec3> until_not_finite(std::span<const Vec3> points) noexcept
{
    const auto bad = std::ranges::find_if(points, [](const Vec3& p) { return !p.allFinite(); });
    return points.first(static_cast<std::size_t>(bad - points.begin()));
}

void keep_least(std::atomic<std::size_t>& least, std::size_t value)
{
    std::size_t seen = least.load();
    while (value < seen && !least.compare_exchange_weak(seen, value)) {
    }
}

Status check_sizes(std::size_t points, const ClosestOutputs& outputs)
{
    for (const std::size_t size :
         {outputs.answers.size(), outputs.squared_distances.size(), outputs.triangles.size(),
          outputs.distances.size(), outputs.points.size(), outputs.feature_kinds.size(),
          outputs.feature_ids.size(), outputs.barycentrics.size()}) {
        if (size == 0) continue;
        if (Status status = check_batch_size(size, points, "points"); !status) return status;
    }
    return {};
}

} // namespace

void find_closest_features(const MeshIndex& index, std::span<const Vec3> points,
                           std::span<ClosestFeature> answers, BatchOrder order, Progress* progress)
{
    answer_chunk(index.parts(), points, {.answers = answers}, is_sorted(index, points, order),
                 progress);
}

Status closest_features(const MeshIndex& index, std::span<const Vec3> points,
                        const ClosestOutputs& outputs, const BatchOptions& options)
{
    if (auto status = check_sizes(points.size(), outputs); !status) return status;
    const bool sorted = is_sorted(index, points, options.order);
    // Sorted ones in chunks as large as the threads leave them.
    const std::size_t share =
        points.size() / static_cast<std::size_t>(thread_count(options.execution.threads)) + 1;
    const std::size_t chunk =
        sorted ? std::clamp(share, chunk_points, sorted_chunk_points) : chunk_points;
    std::atomic<std::size_t> bad{points.size()};
    begin_stage(options.execution.progress, "closest features", points.size());
    parallel_chunks(points.size(), chunk, options.execution.threads,
                    [&](std::size_t first, std::size_t end) {
                        if (is_cancelled(options.execution.progress)) return;
                        const std::size_t count = end - first;
                        const auto finite = until_not_finite(points.subspan(first, count));
                        if (finite.size() < count) keep_least(bad, first + finite.size());
                        answer_chunk(index.parts(), finite, part_of(outputs, first, count), sorted,
                                     options.execution.progress);
                    });
    if (is_cancelled(options.execution.progress))
        return cancelled("the search for closest features");
    if (bad < points.size()) {
        return fail(ErrorCode::invalid_argument,
                    concat("point ", bad.load(), " is not finite: leave it out"), "points");
    }
    return {};
}

} // namespace proxima

#endif
