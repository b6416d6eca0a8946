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
// How: the distance from one triangle of B is a convex function, so on a part of a triangle of A it
// is largest at a corner and above its tangents. The first bounds what is largest, the second the
// mean. Parts are cut where the closest triangle of B changes [guthe-2005], so that few are needed.
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
    /// Bounds of the one-sided Hausdorff distance, the largest distance of a point of A from B. Both
    /// are 0 where all triangles of A are triangles of B.
    DistanceBounds distance;
    /// A point of A whose distance from B is at least distance.lower, up to the rounding of its
    /// coordinates, and the point of B closest to it.
    Vec3 point_a = Vec3::Zero();
    Vec3 point_b = Vec3::Zero();
    TriangleId triangle_a = {};
    TriangleId triangle_b = {};
    /// With max_places: points of A whose distance is within the tolerance of the greatest, the
    /// farthest first, no two within the spacing of each other. None where the distance is 0.
    std::vector<FarPlace> places;
    /// Whether every point of A whose distance is distance.lower or more is within three times the
    /// spacing of one of the places. False where there are more places than max_places, or where the
    /// splits ended. True without places where the distance is 0: none is missing.
    bool has_all_places = false;
    std::uint64_t splits = 0; ///< how often a triangle of A or a part of one was cut
    bool is_complete = false; ///< whether upper - lower is within the tolerance
};

/// What a search of the greatest deviation cuts at most.
inline constexpr std::uint64_t default_deviation_splits = std::uint64_t{1} << 26U;

struct GreatestDeviationOptions {
    /// How far the bounds may be apart, in the meshes' unit. 0 = default_tolerance times the diagonal
    /// of the box about both meshes.
    double tolerance = 0;
    static constexpr double default_tolerance = 1e-6;
    std::uint32_t max_places = 0; ///< max_deviation_places at most
    /// In the meshes' unit. 0 = default_spacing times the diagonal of the box about both meshes.
    double place_spacing = 0;
    static constexpr double default_spacing = 0.01;
    /// Then it ends with the bounds so far. The search for places has as many again, in equal shares to
    /// the triangles of A that may be as far: but 64 or more for each.
    std::uint64_t max_splits = default_deviation_splits;
    Execution execution = {};
};

inline constexpr std::uint32_t max_deviation_places = 256;

/// The one-sided Hausdorff distance from A to B. The bounds are as near to each other as
/// options.tolerance says, but not nearer than 2^-38 times the largest coordinate, and not where
/// max_splits or the budget end the search: is_complete tells. Where several points are as far, one
/// of them is named, and all with max_places. The same bits for any number of threads. One closest
/// feature per vertex of A, and some ten microseconds per triangle whose distance is about the
/// largest. Thread safe. Errors: invalid_mesh (a mesh is empty), invalid_argument (a tolerance or
/// spacing below 0 or NaN, too many places), budget_exceeded, cancelled.
[[nodiscard]] Result<GreatestDeviation>
greatest_deviation(const MeshIndex& a, const MeshIndex& b,
                   const GreatestDeviationOptions& options = {});

struct MeanDeviation {
    DistanceBounds mean;             ///< of the distance of A's points from B, by area
    DistanceBounds root_mean_square; ///< the root of the mean of squared distances
    /// Of A, in the square of the meshes' unit; infinite or 0 where that is beyond the doubles.
    double area = 0;
    double area_error = 0; ///< by which the area may be off
    /// By bin, the share of A's area at distances in it: an estimate without bounds, the better the
    /// smaller the tolerance. What is beyond the end counts in the last bin.
    std::vector<double> histogram;
    std::uint64_t splits = 0;
    /// Whether the bounds of the mean and those of the root mean square are within the tolerance.
    bool is_complete = false;
};

struct MeanDeviationOptions {
    /// How far the bounds of the mean may be apart, and those of the root mean square, in the meshes'
    /// unit. 0 = default_tolerance times the diagonal of the box about both.
    double tolerance = 0;
    static constexpr double default_tolerance = 1e-5;
    /// Bins of equal widths from 0 to histogram_end; 0 = no histogram, max_histogram_bins at most.
    std::uint32_t histogram_bins = 0;
    double histogram_end = 0;
    /// In equal shares to groups of A's triangles, 64 or more for each triangle, and what these leave to
    /// parts of large ones.
    std::uint64_t max_splits = default_deviation_splits;
    Execution execution = {};
};

inline constexpr std::uint32_t max_histogram_bins = 4096;

/// The mean distance of A's points from B, by area. The same bits for any number of threads. About
/// ten microseconds for each triangle of A and two for each of B that it is close to, where triangles
/// of A are no larger than those of B; where one of A is close to thousands of B, 90 for each of
/// these. Threads share large triangles. Where samples of distances mislead, the root mean square takes as
/// long again. Thread safe. Errors: invalid_mesh (a mesh is empty, or A has no area, or none in doubles
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

/// The means over two surfaces from those of both directions. Where an area is beyond the doubles,
/// the means by area are as wide as both directions. Thread safe.
[[nodiscard]] TwoSidedMean both_ways(const MeanDeviation& there,
                                     const MeanDeviation& back) noexcept;

} // namespace proxima
