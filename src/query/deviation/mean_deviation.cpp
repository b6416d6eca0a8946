#include "base/parallel.h"
#include "base/progress.h"
#include "base/text.h"
#include "proxima/mesh_deviation.h"
#include "query/deviation/mean_piece.h"
#include "query/deviation/surface_pair.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace proxima {

namespace {

/// A sum of many numbers that is off by two roundings of itself [neumaier-1974].
class LongSum {
public:
    void add(double value) noexcept
    {
        const double sum = sum_ + value;
        rest_ += std::abs(sum_) >= std::abs(value) ? (sum_ - sum) + value : (value - sum) + sum_;
        sum_ = sum;
    }
    [[nodiscard]] double value() const noexcept { return sum_ + rest_; }

private:
    double sum_ = 0;
    double rest_ = 0;
};

/// Bins of equal widths; what is beyond counts in the last one.
class AreaHistogram {
public:
    AreaHistogram(std::uint32_t bins, double end) : width_(end / bins), areas_(bins) {}

    /// A triangle whose points' values are linear, with these at its corners.
    void add(double area, std::array<double, 3> values)
    {
        if (areas_.empty()) return;
        std::ranges::sort(values);
        const std::size_t last = bin_of(values[2]);
        double before = 0;
        for (std::size_t bin = bin_of(values[0]); bin <= last; ++bin) {
            const double below =
                bin == last ? 1 : part_below(values, width_ * static_cast<double>(bin + 1));
            areas_[bin] += area * (below - before);
            before = below;
        }
    }
    void add(const AreaHistogram& other)
    {
        for (std::size_t i = 0; i < areas_.size(); ++i) areas_[i] += other.areas_[i];
    }
    [[nodiscard]] std::vector<double> shares(double area) const
    {
        std::vector<double> result = areas_;
        for (double& share : result) share /= area;
        return result;
    }

private:
    [[nodiscard]] std::size_t bin_of(double value) const
    {
        const double bin = value / width_;
        const std::size_t last = areas_.size() - 1;
        return bin < static_cast<double>(last) ? static_cast<std::size_t>(bin) : last;
    }
    /// The part of the triangle where the value is below a limit.
    static double part_below(const std::array<double, 3>& values, double limit)
    {
        const auto [a, b, c] = values;
        if (limit <= a) return 0;
        if (limit >= c) return 1;
        if (limit < b) return (limit - a) / (b - a) * ((limit - a) / (c - a));
        return 1 - (c - limit) / (c - b) * ((c - limit) / (c - a));
    }

    double width_;
    std::vector<double> areas_;
};

/// What some triangles of A add up to.
struct MeanSums {
    explicit MeanSums(const AreaHistogram& empty) : histogram(empty) {}

    LongSum area;
    LongSum area_error; ///< by which areas may be off
    LongSum lower;
    LongSum upper;
    LongSum squares_lower;
    LongSum squares_upper;
    double farthest = 0;
    std::uint64_t splits = 0;
    std::uint32_t cuts = 0;
    AreaHistogram histogram;
};

class MeanSearch {
public:
    MeanSearch(const SurfacePair& pair, const MeasuredVertices& vertices, double tolerance,
               std::uint64_t splits_each, const Progress* progress)
        : pair_(pair), progress_(progress), vertices_(vertices),
          tolerance_(std::max(tolerance - 4 * pair.rounding(64), 4 * pair.rounding(64))),
          splits_each_(splits_each), pieces_(pair, 0.25 * tolerance_)
    {}

    void add_triangle(std::uint32_t row, MeanSums& sums)
    {
        const Triangle triangle = pair_.a().triangle(row);
        area_ = 0.5 * scaled_normal(triangle).norm();
        double side = 0;
        for (int i = 0; i < 3; ++i)
            side = std::max(side, (triangle[(i + 1) % 3] - triangle[i]).squaredNorm());
        sums.area.add(area_);
        sums.area_error.add(0x1p-48 * side);
        heap_.clear();
        double doubt = 0;
        const auto take = [&](const MeanPiece& piece) {
            if (piece.mean_upper - piece.mean_lower <= 0.25 * tolerance_) {
                settle(piece, sums);
                return;
            }
            doubt += piece.doubt();
            heap_.push_back(piece);
            std::ranges::push_heap(heap_, has_less_doubt);
        };
        take(pieces_.whole(row, vertices_.of_row(pair_.a(), row)));
        // What was settled is in doubt by a quarter of the tolerance.
        for (std::uint64_t splits = 0; !heap_.empty() && doubt > 0.75 * tolerance_; ++splits) {
            if (splits % 64 == 63 && is_cancelled(progress_)) return;
            if (splits == splits_each_ || heap_.size() >= most_pieces || pieces_.is_full()) break;
            std::ranges::pop_heap(heap_, has_less_doubt);
            const MeanPiece piece = heap_.back();
            heap_.pop_back();
            doubt -= piece.doubt();
            for (const MeanPiece& part : pieces_.split(piece)) take(part);
            ++sums.splits;
        }
        for (const MeanPiece& piece : heap_) settle(piece, sums);
    }

private:
    static constexpr std::size_t most_pieces = std::size_t{1} << 19U;

    static bool has_less_doubt(const MeanPiece& one, const MeanPiece& other) noexcept
    {
        return one.doubt() < other.doubt();
    }

    void settle(const MeanPiece& piece, MeanSums& sums) const
    {
        const double area = area_ * piece.weight;
        sums.lower.add(area * piece.mean_lower);
        sums.upper.add(area * piece.mean_upper);
        sums.squares_lower.add(area * piece.squares_lower);
        sums.squares_upper.add(area * piece.squares_upper);
        sums.farthest = std::max(sums.farthest, *std::ranges::max_element(piece.above));
        sums.cuts = std::max(sums.cuts, piece.cuts);
        sums.histogram.add(area, piece.above);
    }

    const SurfacePair& pair_;
    const Progress* progress_;
    const MeasuredVertices& vertices_;
    double tolerance_;
    std::uint64_t splits_each_;
    MeanPieces pieces_;
    std::vector<MeanPiece> heap_;
    double area_ = 0;
};

void add_to(MeanSums& all, const MeanSums& some)
{
    all.area.add(some.area.value());
    all.area_error.add(some.area_error.value());
    all.lower.add(some.lower.value());
    all.upper.add(some.upper.value());
    all.squares_lower.add(some.squares_lower.value());
    all.squares_upper.add(some.squares_upper.value());
    all.farthest = std::max(all.farthest, some.farthest);
    all.splits += some.splits;
    all.cuts = std::max(all.cuts, some.cuts);
    all.histogram.add(some.histogram);
}

Status check_options(const MeanDeviationOptions& options)
{
    const auto bad = [](std::string what, const char* where) {
        return fail(ErrorCode::invalid_argument, std::move(what), where);
    };
    if (!(options.tolerance >= 0)) return bad("the tolerance is no number from 0 up", "tolerance");
    if (options.histogram_bins > max_histogram_bins)
        return bad(concat("more than ", max_histogram_bins, " bins"), "histogram_bins");
    const double end = options.histogram_end;
    if (options.histogram_bins != 0 && !(end > 0 && std::isfinite(end)))
        return bad("the histogram's end is no positive number", "histogram_end");
    return {};
}

/// The interval about both bounds that rounding may have moved them out of, no part of it below 0.
DistanceBounds widened(double lower, double upper, double rounding)
{
    constexpr double of_sums = 0x1p-44;
    return {std::max(lower * (1 - of_sums) - rounding, 0.0), upper * (1 + of_sums) + rounding};
}

} // namespace

Result<MeanDeviation> mean_deviation(const MeshIndex& a, const MeshIndex& b,
                                     const MeanDeviationOptions& options)
{
    if (Status status = check_options(options); !status) return tl::unexpected(status.error());
    const auto pair = SurfacePair::make(a, b, options.execution);
    if (!pair) return tl::unexpected(pair.error());
    const double tolerance = options.tolerance > 0
                                 ? pair->to_units(options.tolerance)
                                 : MeanDeviationOptions::default_tolerance * pair->diagonal();
    const auto vertices = measure_vertices(*pair, options.execution);
    if (!vertices) return tl::unexpected(vertices.error());

    const std::uint32_t count = pair->a().triangle_count();
    Progress* const progress = options.execution.progress;
    const AreaHistogram empty(options.histogram_bins, pair->to_units(options.histogram_end));
    const std::uint64_t splits_each = std::max<std::uint64_t>(options.max_splits / count, 64);
    // As many chunks as tell how to share the work, and no more: each has a histogram.
    const std::size_t chunk = std::max<std::size_t>(16, chunk_count(count, 1024));
    std::vector<MeanSums> parts(chunk_count(count, chunk), MeanSums(empty));
    begin_stage(progress, "mean deviation", count);
    parallel_chunks(
        count, chunk, options.execution.threads, [&](std::size_t first, std::size_t end) {
            MeanSearch search(*pair, *vertices, tolerance, splits_each, progress);
            for (std::size_t row = first; row < end; ++row) {
                if (is_cancelled(progress)) return;
                search.add_triangle(static_cast<std::uint32_t>(row), parts[first / chunk]);
            }
            advance_stage(progress, end - first);
        });
    if (is_cancelled(progress)) return cancelled("measuring the mean deviation");
    MeanSums sums(empty);
    for (const MeanSums& some : parts) add_to(sums, some);

    const double area = sums.area.value();
    if (!(area > 0)) {
        return fail(ErrorCode::invalid_mesh,
                    "the mesh has no area: there is no mean of distances from it", "a");
    }
    // Areas that are off shift the mean towards some distances, which are all below the farthest.
    const double shift = std::min(2 * sums.area_error.value() / area, 1.0) * sums.farthest;
    const double rounding = 2 * pair->rounding(sums.cuts);
    const DistanceBounds mean =
        widened(sums.lower.value() / area, sums.upper.value() / area, rounding + shift);
    const double lower_root = std::sqrt(sums.squares_lower.value() / area);
    const double upper_root = std::sqrt(sums.squares_upper.value() / area);
    // The same of squares, whose root it is that is wanted.
    const double root_shift =
        shift > 0 ? std::min(std::sqrt(shift * sums.farthest), shift * sums.farthest / upper_root)
                  : 0;
    const DistanceBounds root = widened(lower_root, upper_root, rounding + root_shift);
    MeanDeviation result;
    result.mean = pair->from_units(mean);
    result.root_mean_square = pair->from_units(root);
    result.area = pair->area_from_units(area);
    if (options.histogram_bins != 0) result.histogram = sums.histogram.shares(area);
    result.splits = sums.splits;
    result.is_complete = mean.upper - mean.lower <= tolerance;
    return result;
}

} // namespace proxima
