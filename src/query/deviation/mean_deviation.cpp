#include "base/text.h"
#include "proxima/mesh_deviation.h"
#include "query/deviation/mean_rounds.h"
#include "query/deviation/surface_pair.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace proxima {

namespace {

/// About the root of the mean squared distance, from those of vertices and of some centroids.
double guessed_root(const SurfacePair& pair, const MeasuredVertices& vertices)
{
    constexpr std::uint32_t most_samples = 2048;
    const std::uint32_t count = pair.a().triangle_count();
    const std::uint32_t step = count / most_samples + 1;
    double areas = 0;
    double squares = 0;
    for (std::uint32_t row = 0; row < count; row += step) {
        const Triangle triangle = pair.a().triangle(row);
        const double area = scaled_normal(triangle).norm();
        const Vec3 center = (triangle[0] + triangle[1] + triangle[2]) / 3;
        double sum = 0;
        double known = HUGE_VAL;
        const auto nearest = vertices.of_row(pair.a(), row);
        for (std::size_t k = 0; k < 3; ++k) {
            sum += nearest[k].distance * nearest[k].distance;
            known = std::min(known, nearest[k].distance + (triangle.vertices[k] - center).norm());
        }
        const double at_center = pair.nearest(center, known).distance;
        areas += area;
        squares += area * (0.75 * at_center * at_center + sum / 12);
    }
    return areas > 0 ? std::sqrt(squares / areas) : 0;
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

/// Whether some triangle has an area, however small.
bool has_area(const MeshIndex& mesh)
{
    const IndexParts& parts = mesh.parts();
    for (std::uint32_t row = 0; row < parts.triangle_count(); ++row) {
        const Triangle triangle = parts.triangle(row);
        const Vec3 u = triangle[1] - triangle[0];
        const Vec3 v = triangle[2] - triangle[0];
        const double u_size = u.cwiseAbs().maxCoeff();
        const double v_size = v.cwiseAbs().maxCoeff();
        if (u_size > 0 && v_size > 0 && (u / u_size).cross(v / v_size) != Vec3::Zero()) return true;
    }
    return false;
}

/// The interval about both bounds that rounding may have moved them out of, no part of it below 0.
DistanceBounds widened(double lower, double upper, double rounding)
{
    constexpr double of_sums = 0x1p-44;
    return {std::max(lower * (1 - of_sums) - rounding, 0.0), upper * (1 + of_sums) + rounding};
}

/// Both bounds, moved outward by more than a few roundings.
DistanceBounds widened(const DistanceBounds& bounds)
{
    constexpr double rounding = 0x1p-48;
    constexpr double least = std::numeric_limits<double>::denorm_min();
    return {std::max(bounds.lower * (1 - rounding) - least, 0.0),
            bounds.upper * (1 + rounding) + least};
}

double width(const DistanceBounds& bounds)
{
    return bounds.upper - bounds.lower;
}

/// What both hold.
DistanceBounds common(const DistanceBounds& one, const DistanceBounds& other)
{
    return {std::max(one.lower, other.lower), std::min(one.upper, other.upper)};
}

/// In the pair's units.
struct MeanIntervals {
    DistanceBounds mean;
    DistanceBounds root;
};

/// \pre the sums' area is not 0
MeanIntervals intervals_of(const SurfacePair& pair, const MeanSums& sums)
{
    const double area = sums.area.value();
    // Areas that are off shift the mean towards some distances, which are all below the farthest.
    const double shift = std::min(2 * sums.area_error.value() / area, 1.0) * sums.farthest;
    const double rounding = 2 * pair.rounding(sums.cuts);
    const double lower_root = std::sqrt(sums.squares_lower.value() / area);
    const double upper_root = std::sqrt(sums.squares_upper.value() / area);
    // The mean of squares shifts by as much times the farthest distance, and so its root by no more than this.
    const double root_shift =
        shift > 0 ? std::min(std::sqrt(shift * sums.farthest), shift * sums.farthest / upper_root)
                  : 0;
    return {widened(sums.lower.value() / area, sums.upper.value() / area, rounding + shift),
            widened(lower_root, upper_root, rounding + root_shift)};
}

/// Which part of two surfaces the first is.
struct SurfaceShare {
    double least = 0;
    double most = 1;
};

SurfaceShare share_of(const MeanDeviation& there, const MeanDeviation& back)
{
    const double largest = std::max({there.area, there.area_error, back.area, back.area_error});
    if (!std::isfinite(largest)) return {};
    // The sum of all four stays within the doubles. Small ones keep their last bits.
    const double scale = largest > 1 ? 0.25 : 1;
    const auto bounds = [scale](const MeanDeviation& of) {
        const double area = scale * of.area;
        const double error = scale * of.area_error;
        return DistanceBounds{std::max(area - error, 0.0), area + error};
    };
    const auto share = [](double one, double other) { return one / (one + other); };
    const DistanceBounds one = bounds(there);
    const DistanceBounds other = bounds(back);
    const double least = share(one.lower, other.upper);
    const double most = share(one.upper, other.lower);
    if (!(least >= 0 && most <= 1)) return {}; // neither is known to have an area
    return {least, most};
}

/// Whatever the share is of the first, so of the rest the second.
DistanceBounds mixed(const DistanceBounds& one, const DistanceBounds& other,
                     const SurfaceShare& share)
{
    const auto mix = [](double a, double b, double part) { return part * a + (1 - part) * b; };
    return {
        std::min(mix(one.lower, other.lower, share.least), mix(one.lower, other.lower, share.most)),
        std::max(mix(one.upper, other.upper, share.least),
                 mix(one.upper, other.upper, share.most))};
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

    auto sums = sum_means(*pair, *vertices, options, tolerance, guessed_root(*pair, *vertices),
                          options.max_splits);
    if (!sums) return tl::unexpected(sums.error());
    const double area = sums->area.value();
    if (!(area > 0)) {
        return fail(
            ErrorCode::invalid_mesh,
            has_area(a)
                ? "the mesh's area is too small for doubles beside the largest "
                  "coordinate of both meshes: bring them nearer to each other's size and place"
                : "the mesh has no area: there is no mean of distances from it",
            "a");
    }
    MeanIntervals found = intervals_of(*pair, *sums);
    std::uint64_t splits = sums->splits;
    if (width(found.mean) <= tolerance && width(found.root) > tolerance &&
        splits < options.max_splits) {
        // The guess was too large. With what is proven of the root, its bounds reach the tolerance, too.
        sums = sum_means(*pair, *vertices, options, tolerance, found.root.lower,
                         options.max_splits - splits);
        if (!sums) return tl::unexpected(sums.error());
        splits += sums->splits;
        const MeanIntervals again = intervals_of(*pair, *sums);
        found = {common(found.mean, again.mean), common(found.root, again.root)};
    }
    MeanDeviation result;
    result.mean = pair->from_units(found.mean);
    result.root_mean_square = pair->from_units(found.root);
    result.area = pair->area_from_units(area);
    result.area_error =
        pair->area_error_from_units(area, sums->area_error.value() + 0x1p-44 * area);
    if (options.histogram_bins != 0) result.histogram = sums->histogram.shares(area);
    result.splits = splits;
    result.is_complete = width(found.mean) <= tolerance && width(found.root) <= tolerance;
    return result;
}

TwoSidedMean both_ways(const MeanDeviation& there, const MeanDeviation& back) noexcept
{
    const SurfaceShare share = share_of(there, back);
    const auto root_of = [](const DistanceBounds& squares) {
        return DistanceBounds{std::sqrt(squares.lower), std::sqrt(squares.upper)};
    };
    const auto square = [](const DistanceBounds& root, double scale) {
        const double lower = root.lower / scale;
        const double upper = root.upper / scale;
        return DistanceBounds{lower * lower, upper * upper};
    };
    TwoSidedMean result;
    result.larger_mean = both_ways(there.mean, back.mean);
    result.larger_root_mean_square = both_ways(there.root_mean_square, back.root_mean_square);
    result.mean = widened(mixed(there.mean, back.mean, share));
    const double most = result.larger_root_mean_square.upper;
    if (!(most > 0)) return result;
    // Scaled, so that squares stay within the doubles.
    const DistanceBounds root = root_of(
        mixed(square(there.root_mean_square, most), square(back.root_mean_square, most), share));
    result.root_mean_square = widened({most * root.lower, most * root.upper});
    return result;
}

} // namespace proxima
