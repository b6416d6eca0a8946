// What every search for the closest feature answers (thesis chapter 4).
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
#include "proxima/geometry.h"
#include "proxima/result.h"
#include "proxima/topology.h"
#include "proxima/triangle_mesh.h"

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>

namespace proxima {

/// The feature of a mesh closest to a point. Lengths in the mesh's unit.
struct ClosestFeature {
    Feature feature = {};
    TriangleId triangle{};
    Vec3 point = Vec3::Zero();              ///< of the feature, up to rounding
    std::array<double, 3> barycentric = {}; ///< of `point` in `triangle`: in [0, 1], sum 1
    double squared_distance = 0.0;          ///< from the query to `point`
};

/// The answer to a point that is not finite: numbers are NaN, the triangle is no_triangle, and the
/// feature none of any mesh.
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

class MeshIndex;
class ProximityOctree;
struct RowDistance;

struct ClosestFeatureOptions {
    /// Nothing farther is found. None is where it is NaN or below 0.
    double radius = std::numeric_limits<double>::infinity();
    /// An answer for a point nearby: less work. Any answer will do, of another mesh as well; the
    /// nearer its point is to the closest one, the better.
    const ClosestFeature* start_from = nullptr;
};

/// The feature closest to `p`; nothing where p is not finite. Real-time safe: noexcept, no
/// allocation, no lock; any number of threads. 0.5 to 5 us; longer where many triangles are as
/// near but for rounding, as seen from a sphere's centre.
/// Meshes of any size: where squares of distances leave the doubles, squared_distance is 0 or
/// infinite and all else is right. From farther than 2^500 times the mesh's size all is as far, and
/// the first vertex is the answer.
[[nodiscard]] std::optional<ClosestFeature>
closest_feature(const MeshIndex& index, const Vec3& p,
                const ClosestFeatureOptions& options = {}) noexcept;

/// For searches that know a bound and go on with the row: the closest feature of the index's rows
/// by the order of answers, in the index's units. `known`, in the mesh's unit: nothing farther is
/// wanted, but may be found.
[[nodiscard]] RowDistance find_closest(const MeshIndex& index, const Vec3& p,
                                       double known) noexcept;

/// The feature closest to `p`. Real-time safe: noexcept, no allocation, no lock, at most
/// statistics().worst_case_steps words and worst_case_blocks blocks within the root, or, where the
/// budget left leaves without a list, search_groups() groups of triangles; any number of threads.
/// 0.1 to 1 us, searches 1 us and more. no_closest_feature() where p is not finite.
[[nodiscard]] ClosestFeature closest_feature(const ProximityOctree& octree, const Vec3& p) noexcept;

/// The same where it is not farther than `radius`; nothing also where p is not finite, or the
/// radius NaN or below 0.
[[nodiscard]] std::optional<ClosestFeature> closest_feature(const ProximityOctree& octree,
                                                            const Vec3& p, double radius) noexcept;

/// What a query costed: for tests of the worst case and for tuning.
struct QuerySteps {
    std::uint32_t steps = 0;    ///< words of table and nodes read
    std::uint32_t blocks = 0;   ///< of the leaf, scanned
    std::uint32_t groups = 0;   ///< of the tree's triangles, looked at: in leaves without a list
    std::uint32_t rechecks = 0; ///< triangles looked at in doubles
};

/// The same, counted.
[[nodiscard]] ClosestFeature closest_feature(const ProximityOctree& octree, const Vec3& p,
                                             QuerySteps& steps) noexcept;

/// The same, started from an answer for a point nearby: less work outside of the root and in leaves
/// of many blocks or without a list, the same in all others. Any answer will do, also of an octree
/// that was refitted since; the nearer to `p` its point, the better.
[[nodiscard]] ClosestFeature closest_feature(const ProximityOctree& octree, const Vec3& p,
                                             const ClosestFeature& earlier) noexcept;
[[nodiscard]] ClosestFeature closest_feature(const ProximityOctree& octree, const Vec3& p,
                                             const ClosestFeature& earlier,
                                             QuerySteps& steps) noexcept;

/// In which order the points of a batch are searched for.
enum class BatchOrder : std::uint8_t {
    automatic, ///< sorted where that is likely to pay: many scattered points, an octree beyond
               ///< caches
    as_given,
    sorted ///< along a curve through the octree, 2^18 points at a time
};

struct BatchOptions {
    BatchOrder order = BatchOrder::automatic;
    Execution execution = {}; ///< stage "closest features", steps are points
};

/// The same for many points, several at a time, so that their memory accesses overlap, and many
/// scattered ones in an order in which they meet again what is in the caches. Answers are those of
/// single queries. Allocates; errors: invalid_argument (sizes differ, a point is not
/// finite: which), cancelled.
[[nodiscard]] Status closest_features(const ProximityOctree& octree, std::span<const Vec3> points,
                                      std::span<ClosestFeature> answers,
                                      const BatchOptions& options = {});

/// Where a batch writes: each span is empty or has a place for every point.
struct ClosestOutputs {
    std::span<ClosestFeature> answers = {};   ///< in full
    std::span<double> squared_distances = {}; ///< these and triangles alone are quicker
    std::span<TriangleId> triangles = {};
};

/// closest_feature() of many points, several at a time, so that their memory accesses overlap, and
/// scattered ones in an order in which each starts from the last one's answer. Answers are those of
/// single queries. Allocates; errors: invalid_argument (sizes differ, a point is not finite:
/// which), cancelled.
[[nodiscard]] Status closest_features(const MeshIndex& index, std::span<const Vec3> points,
                                      const ClosestOutputs& outputs,
                                      const BatchOptions& options = {});

} // namespace proxima
