// How often a surface winds round a point: 1 inside a closed outward mesh, 0 outside, in between
// near holes [jacobson-2013].
//
//     const auto winding = build_winding_number(mesh);            // once
//     const WindingEstimate w = winding_number(*winding, point);   // microseconds each
//
// Triangles in Morton order form a binary tree of clusters: winding_clusters.h.
#pragma once

#include "octree/winding_clusters.h"
#include "proxima/execution.h"
#include "proxima/result.h"
#include "proxima/triangle_mesh.h"

#include <cstdint>
#include <utility>
#include <vector>

namespace proxima {

struct WindingOptions {
    Execution execution = {};
};

/// The arrays of WindingClusters.
struct WindingStorage {
    std::vector<WindingCluster> clusters;
    std::vector<std::uint32_t> order; ///< triangle ids
    double unit = 1.0;

    [[nodiscard]] WindingClusters view() const noexcept { return {clusters, order, unit}; }
};

/// What queries read: immutable, any number of threads. Refers to the mesh, which must outlive it.
class WindingNumber {
public:
    [[nodiscard]] const TriangleMesh& mesh() const noexcept { return *mesh_; }
    [[nodiscard]] WindingClusters clusters() const noexcept { return storage_.view(); }

    /// The arrays, for an owner that keeps the triangles elsewhere.
    [[nodiscard]] WindingStorage release() && noexcept { return std::move(storage_); }

private:
    friend Result<WindingNumber> build_winding_number(const TriangleMesh& mesh,
                                                      const WindingOptions& options);
    const TriangleMesh* mesh_ = nullptr;
    WindingStorage storage_;
};

/// Sorts the triangles and sums their moments: O(triangles), about 45 bytes each.
/// Errors: invalid_mesh (empty, NaN), cancelled. Same bits for any number of threads.
[[nodiscard]] Result<WindingNumber> build_winding_number(const TriangleMesh& mesh,
                                                         const WindingOptions& options = {});

/// The winding number at `point` with error <= accuracy (but never below 1e-12, rounding).
/// Near the surface, where expansions cannot be that good, it sums triangles exactly. No
/// allocation, thread safe. \pre point is finite
[[nodiscard]] WindingEstimate winding_number(const WindingNumber& of, const Vec3& point,
                                             double accuracy = 1e-3) noexcept;

/// As is_inside of the clusters.
[[nodiscard]] bool is_inside(const WindingNumber& of, const Vec3& point) noexcept;

/// As is_inside, for a surface whose winding number is `whole` minus that of `caps`.
[[nodiscard]] bool is_inside_but_for(const WindingNumber& caps, const Vec3& point,
                                     int whole) noexcept;

/// The sum over all triangles: the oracle, O(triangles).
[[nodiscard]] double brute_winding_number(const TriangleMesh& mesh, const Vec3& point) noexcept;

/// As is_inside, by the sum over all triangles.
[[nodiscard]] bool brute_is_inside(const TriangleMesh& mesh, const Vec3& point) noexcept;

} // namespace proxima
