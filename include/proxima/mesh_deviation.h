// How far one surface is from another at most and on average: to judge a simplified, repaired or
// scanned mesh.
//
//     auto there = greatest_deviation(a, b);              // from each point of A to the closest of B
//     auto back = greatest_deviation(b, a);
//     DistanceBounds hausdorff = both_ways(there->distance, back->distance);
//     mark(there->point_a, there->point_b);               // where A is that far from B
//     auto mean = mean_deviation(a, b, {.histogram_bins = 20, .histogram_end = hausdorff.upper});
//
// All points of A count, not samples: its triangles are cut until bounds of the distance on each part
// are as near to each other as was asked for. Answers are intervals that hold the true number, the
// rounding of doubles included.
//
// How: the distance from one triangle of B is a convex function. So on a part of a triangle of A it is
// largest at a corner, which bounds the greatest distance from above, and it is nowhere below its
// tangents, which bounds the mean from below. Parts are cut where the closest triangle of B changes
// [guthe-2005], so that few are needed. For the greatest distance, a triangle of A is first covered
// with neighbouring triangles of B: where B lies along A, that bound is about the true one.
//
// Distances are those of surfaces, without sign; signed_distance.h tells inside from outside. Each
// function looks from A to B alone: B may have parts that no point of A is close to.
#pragma once

#include "proxima/execution.h"
#include "proxima/export.h"
#include "proxima/geometry.h"
#include "proxima/mesh_index.h"
#include "proxima/result.h"
#include "proxima/triangle_mesh.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

namespace PROXIMA_EXPORT proxima {

/// An interval that holds a distance, in the meshes' unit.
struct DistanceBounds {
    double lower = 0;
    double upper = 0;
};

/// A point of A, the point of B closest to it, and their distance up to rounding.
struct FarPlace {
    double distance = 0;
    Vec3 point_a = Vec3::Zero();
    Vec3 point_b = Vec3::Zero();
    TriangleId triangle_a = {};
    TriangleId triangle_b = {};
};

struct GreatestDeviation {
    /// Bounds of the one-sided Hausdorff distance: the largest distance that a point of A has from B.
    /// Both are 0 where every triangle of A is also a triangle of B. Where others of B pass through these,
    /// or coordinates leave no room for rounding, the upper one may be above 0 by roundings.
    DistanceBounds distance;
    /// A point of A whose distance from B is at least distance.lower, up to the rounding of its
    /// coordinates, and the point of B closest to it.
    Vec3 point_a = Vec3::Zero();
    Vec3 point_b = Vec3::Zero();
    TriangleId triangle_a = {};
    TriangleId triangle_b = {};
    /// Where options.max_places is not 0: points of A whose distance is within the tolerance of the
    /// greatest one, the farthest first, no two nearer to each other than the spacing. Empty where the
    /// distance is 0.
    std::vector<FarPlace> places;
    /// Whether every point of A whose distance is at least distance.lower is within three times the
    /// spacing of one of the places. False where there are more places than max_places, or where
    /// max_splits ended the search for them. Where the distance is 0, it is true: no place is missing.
    bool has_all_places = false;
    /// How many cuts were made of A's triangles and their parts, but for those that cover them with
    /// triangles of B: about none where B lies along A.
    std::uint64_t splits = 0;
    bool is_complete = false; ///< whether distance.upper - distance.lower is within the tolerance
};

/// How many cuts a search makes at most where the caller does not say.
inline constexpr std::uint64_t default_deviation_splits = std::uint64_t{1} << 26U;

struct GreatestDeviationOptions {
    /// How far the bounds may be apart, in the meshes' unit. 0 = default_tolerance times the diagonal
    /// of the box about both meshes.
    double tolerance = 0;
    static constexpr double default_tolerance = 1e-6;
    /// How many places are named at most, up to max_deviation_places; 0 = they are not searched for.
    std::uint32_t max_places = 0;
    /// How far places are from each other at least, in the meshes' unit. 0 = default_spacing times the
    /// diagonal of the box about both meshes.
    double place_spacing = 0;
    static constexpr double default_spacing = 0.01;
    /// After so many cuts of A's triangles and their parts the search ends, with the bounds that it has
    /// by then. The search for places may cut as often again: each triangle of A that may be as far
    /// gets an equal share of these cuts, or 64 if that is more.
    std::uint64_t max_splits = default_deviation_splits;
    Execution execution = {};
};

/// The largest max_places.
inline constexpr std::uint32_t max_deviation_places = 256;

/// The one-sided Hausdorff distance from A to B. The bounds are at most options.tolerance apart, or
/// 2^-38 times the largest coordinate if that is more. They may be farther apart where max_splits or the
/// budget ended the search: is_complete tells. Where several points of A are equally far, point_a is
/// one of them; options.max_places asks for all. The same bits for any number of threads. Cost: one
/// closest feature per vertex of A, about two microseconds per triangle of A that B lies along, more
/// where its triangles are smaller, and some tens of microseconds per triangle that B does not lie along
/// and whose distance is about the largest. Thread safe. Errors: invalid_mesh (a mesh is empty),
/// invalid_argument (a tolerance or spacing below 0 or NaN, too many places), budget_exceeded,
/// cancelled.
[[nodiscard]] Result<GreatestDeviation>
greatest_deviation(const MeshIndex& a, const MeshIndex& b,
                   const GreatestDeviationOptions& options = {});

struct MeanDeviation {
    DistanceBounds mean;             ///< of the distances of A's points from B, weighted by area
    DistanceBounds root_mean_square; ///< the root of the mean of their squares
    /// A's area, in the square of the meshes' unit; infinite or 0 where doubles cannot hold it.
    double area = 0;
    double area_error = 0; ///< how far from the true one at most; infinite where the area is
    /// By bin: which share of A's area is at distances in it. An estimate without bounds, which is the
    /// better the smaller the tolerance is. Distances beyond histogram_end count in the last bin.
    std::vector<double> histogram;
    std::uint64_t splits = 0; ///< how many cuts were made of A's triangles and their parts
    /// Whether the bounds of the mean and those of the root mean square are within the tolerance.
    bool is_complete = false;
};

struct MeanDeviationOptions {
    /// How far the bounds of the mean may be apart, and those of the root mean square, in the meshes'
    /// unit. 0 = default_tolerance times the diagonal of the box about both meshes.
    double tolerance = 0;
    static constexpr double default_tolerance = 1e-5;
    /// How many bins of equal width the histogram has, up to max_histogram_bins; 0 = no histogram.
    std::uint32_t histogram_bins = 0;
    /// Where the last bin ends, in the meshes' unit; the first begins at 0.
    double histogram_end = 0;
    /// How many cuts of A's triangles and their parts are made at most, but for this: a share of 64 is
    /// granted to each triangle, however small the limit is. Each group of neighbouring triangles may
    /// use its equal share; cuts that are not used go to the parts of large triangles that need more.
    /// Where the cuts do not suffice, the bounds are farther apart than the tolerance.
    std::uint64_t max_splits = default_deviation_splits;
    Execution execution = {};
};

/// The largest histogram_bins.
inline constexpr std::uint32_t max_histogram_bins = 4096;

/// The mean distance of A's points from B, weighted by area, and the root of their mean square. The
/// same bits for any number of threads. Cost, where triangles of A are no larger than those of B: about
/// ten microseconds per triangle of A, and two for each triangle of B that it is close to. Where a
/// triangle of A is close to thousands of B, it is 90 for each of these; threads share such triangles.
/// The tolerance of the root mean square rests on a guess by samples: where that was too large, the
/// search is done again. Thread safe. Errors: invalid_mesh (a mesh is empty, or A has no area, or none in doubles
/// beside the largest coordinate of both), invalid_argument (a tolerance below 0 or NaN,
/// bins without an end or too many), budget_exceeded, cancelled.
[[nodiscard]] Result<MeanDeviation> mean_deviation(const MeshIndex& a, const MeshIndex& b,
                                                   const MeanDeviationOptions& options = {});

/// The Hausdorff distance of two surfaces from both one-sided ones.
[[nodiscard]] inline DistanceBounds both_ways(const DistanceBounds& there,
                                              const DistanceBounds& back) noexcept
{
    return {std::max(there.lower, back.lower), std::max(there.upper, back.upper)};
}

/// Means over both surfaces together.
struct TwoSidedMean {
    /// Every point of A and of B counts, by area: the larger surface counts more.
    DistanceBounds mean;
    DistanceBounds root_mean_square;
    /// The larger of both directions, as Metro [cignoni-1998] has it of the maximum: each surface
    /// counts as much as the other.
    DistanceBounds larger_mean;
    DistanceBounds larger_root_mean_square;
};

/// The means over two surfaces from those of both directions. Where doubles cannot hold an area, `mean`
/// and `root_mean_square` are intervals about those of both directions. Thread safe.
[[nodiscard]] TwoSidedMean both_ways(const MeanDeviation& there,
                                     const MeanDeviation& back) noexcept;

} // namespace proxima
