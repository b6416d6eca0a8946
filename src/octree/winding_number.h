// How often a surface winds round a point: 1 inside a closed outward mesh, 0 outside, in between
// near holes [jacobson-2013].
//
//     const auto winding = build_winding_number(mesh);            // once
//     const WindingEstimate w = winding_number(*winding, point);   // microseconds each
//
// Triangles in Morton order form a binary tree of clusters. From far away a cluster is its
// multipole expansion up to the third order [barill-2018], with a proven bound on what that leaves
// out; from near, its triangles are summed exactly.
#pragma once

#include "proxima/execution.h"
#include "proxima/result.h"
#include "proxima/triangle_mesh.h"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace proxima {

/// A winding number and how far it can be from the true one.
struct WindingEstimate {
    double value = 0.0;
    double error = 0.0; ///< |value - truth| <= error
};

struct WindingOptions {
    Execution execution = {};
};

/// Triangles `first` to `first + count` of WindingNumber::order, seen from far away. Lengths are in
/// units of WindingNumber::unit.
struct WindingCluster {
    Vec3 center = Vec3::Zero();         ///< centre of area, in the mesh's coordinates
    Vec3 dipole = Vec3::Zero();         ///< integral of the normal n
    std::array<double, 6> quadrupole{}; ///< of s n, symmetric and trace-free, s from center
    std::array<double, 10> octupole{};  ///< of s s n, symmetric and trace-free
    double radius = 0.0;                ///< no point is farther from the centre
    double remainder = 0.0;             ///< bound's factor, see winding_number.cpp
    std::uint32_t first = 0;
    std::uint32_t count = 0;
    std::uint32_t next = 0; ///< the cluster after all below this one, which follow it
};

/// What queries read: immutable, any number of threads. Refers to the mesh, which must outlive it.
class WindingNumber {
public:
    [[nodiscard]] const TriangleMesh& mesh() const noexcept { return *mesh_; }
    [[nodiscard]] std::span<const WindingCluster> clusters() const noexcept { return clusters_; }
    [[nodiscard]] std::span<const TriangleId> order() const noexcept { return order_; }
    /// Factor from the mesh's lengths to those of clusters, a power of two.
    [[nodiscard]] double unit() const noexcept { return unit_; }

private:
    friend Result<WindingNumber> build_winding_number(const TriangleMesh& mesh,
                                                      const WindingOptions& options);
    const TriangleMesh* mesh_ = nullptr;
    std::vector<WindingCluster> clusters_;
    std::vector<TriangleId> order_;
    double unit_ = 1.0;
};

/// Sorts the triangles and sums their moments: O(triangles), about 30 bytes each.
/// Errors: invalid_mesh (empty, NaN), cancelled. Same bits for any number of threads.
[[nodiscard]] Result<WindingNumber> build_winding_number(const TriangleMesh& mesh,
                                                         const WindingOptions& options = {});

/// The winding number at `point` with error <= accuracy (but never below 1e-12, rounding).
/// Near the surface, where expansions cannot be that good, it sums triangles exactly. No
/// allocation, thread safe. \pre point is finite
[[nodiscard]] WindingEstimate winding_number(const WindingNumber& winding, const Vec3& point,
                                             double accuracy = 1e-3) noexcept;

/// Whether the winding number at `point` is at least 1/2: the estimate is sharpened until its error
/// cannot change the answer. Values within 2^-40 below 1/2 count as 1/2.
[[nodiscard]] bool is_inside(const WindingNumber& winding, const Vec3& point) noexcept;

/// As is_inside, for a surface whose winding number is `whole` minus that of `caps`.
[[nodiscard]] bool is_inside_but_for(const WindingNumber& caps, const Vec3& point,
                                     int whole) noexcept;

/// The sum over all triangles: the oracle, O(triangles).
[[nodiscard]] double brute_winding_number(const TriangleMesh& mesh, const Vec3& point) noexcept;

/// As is_inside, by the sum over all triangles.
[[nodiscard]] bool brute_is_inside(const TriangleMesh& mesh, const Vec3& point) noexcept;

} // namespace proxima
