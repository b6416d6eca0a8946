// The feature of a mesh closest to a point: a vertex, an edge or a face (thesis chapter 4).
//
//     auto index = build_mesh_index(mesh);
//     if (auto closest = closest_feature(*index, point)) use(closest->point, closest->triangle);
//
//     std::vector<double> squared(points.size());                  // many points, on all cores
//     Status done = closest_features(*index, points, {.squared_distances = squared});
//
//     feature    the lowest-dimensional feature that holds the closest point: at a corner the
//                vertex, on a side the edge, inside the face
//     triangle   the lowest id incident to that feature, by topology
//     ties       by squared distance as computed, then kind (vertex < edge < face), then id
//
// A point with a coordinate that is NaN or infinite has no closest feature, and nothing is within a
// radius that is NaN or below 0.
#pragma once

#include "proxima/execution.h"
#include "proxima/export.h"
#include "proxima/geometry.h"
#include "proxima/mesh_index.h"
#include "proxima/result.h"
#include "proxima/topology.h"
#include "proxima/triangle_mesh.h"

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>

namespace PROXIMA_EXPORT proxima {

/// The feature of a mesh closest to a point. Lengths in the mesh's unit.
struct ClosestFeature {
    Feature feature = {};
    TriangleId triangle{};
    Vec3 point = Vec3::Zero();              ///< of the feature, up to rounding
    std::array<double, 3> barycentric = {}; ///< of `point` in `triangle`: in [0, 1], sum 1
    double squared_distance = 0.0;          ///< from the query to `point`
};

/// What a batch answers where the index has no triangles: numbers are NaN, the triangle is no_triangle, and
/// the feature none of any mesh. Distances that are asked for alone are infinite.
[[nodiscard]] inline ClosestFeature no_closest_feature() noexcept
{
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    return {{FeatureKind::vertex, std::numeric_limits<std::uint32_t>::max()},
            no_triangle,
            Vec3::Constant(nan),
            {nan, nan, nan},
            nan};
}

/// Whether there is an answer.
[[nodiscard]] inline bool is_found(const ClosestFeature& closest) noexcept
{
    return !std::isnan(closest.squared_distance);
}

struct ClosestFeatureOptions {
    /// Nothing farther is found. None is where it is NaN or below 0.
    double radius = std::numeric_limits<double>::infinity();
    /// An answer for a point nearby: less work. Any answer will do, of another mesh as well; the
    /// nearer its point is to the closest one, the better.
    const ClosestFeature* start_from = nullptr;
};

/// The feature closest to `p`; nothing where p is not finite. Real-time safe: noexcept, no
/// allocation, no lock; any number of threads. 0.5 to 5 us; longer where many triangles are as
/// near but for rounding, as seen from a sphere's centre. With closest-feature lists (with_lists)
/// 0.1 to 1 us, bounded where a list answers; the same answer. Meshes of any size: where squares of
/// distances leave the doubles, squared_distance is 0 or infinite and all else is right. From
/// farther than 2^500 times the mesh's size all is as far, and the first vertex is the answer.
[[nodiscard]] std::optional<ClosestFeature>
closest_feature(const MeshIndex& index, const Vec3& p,
                const ClosestFeatureOptions& options = {}) noexcept;

/// In which order the points of a batch are searched for.
enum class BatchOrder : std::uint8_t {
    automatic, ///< sorted where that is likely to pay: many scattered points
    as_given,
    sorted ///< along a curve through the octree, 2^18 points at a time
};

struct BatchOptions {
    BatchOrder order = BatchOrder::automatic;
    Execution execution = {}; ///< stage "closest features", steps are points
};

/// Where a batch writes: each span is empty or has an element for every point.
struct ClosestOutputs {
    std::span<ClosestFeature> answers = {};   ///< in full
    std::span<double> squared_distances = {}; ///< these and triangles alone are quicker
    std::span<TriangleId> triangles = {};
    std::span<double> distances = {}; ///< the roots of squared distances
    std::span<Vec3> points = {};
    std::span<FeatureKind> feature_kinds = {};
    std::span<std::uint32_t> feature_ids = {};
    std::span<std::array<double, 3>> barycentrics = {};
};

/// closest_feature() of many points, several at a time, so that their memory accesses overlap, and
/// scattered ones in an order in which each starts from the last one's answer. Answers are those of
/// single queries. Allocates; errors: invalid_argument (sizes differ, a point is not finite:
/// which), cancelled.
[[nodiscard]] Status closest_features(const MeshIndex& index, std::span<const Vec3> points,
                                      const ClosestOutputs& outputs,
                                      const BatchOptions& options = {});

} // namespace proxima
