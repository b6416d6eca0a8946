// Winding numbers from clusters of triangles, wherever the triangles are kept [jacobson-2013].
//
//     clusters   a binary tree, parents before children: a leaf is followed by the next one
//     order      the triangles of a leaf are a run of it, as numbers that the caller understands
//
// From far away a cluster is its multipole expansion up to the third order [barill-2018], with a
// proven bound on what that leaves out (winding_number.cpp); from near, its triangles are summed
// exactly. The functions take the triangles as `triangle_at(order[i])`, which returns a Triangle.
#pragma once

#include "geometry/solid_angle.h"
#include "proxima/geometry.h"

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <span>

namespace proxima {

/// A winding number and how far it can be from the true one, unless the point is within 1e-3 of a
/// triangle's size from one of its edges: there rounded corners are seen at other angles, by 1e-16
/// of the size over the distance from the edge.
struct WindingEstimate {
    double value = 0.0;
    double error = 0.0; ///< |value - truth| <= error
};

/// Triangles `first` to `first + count` of the order, seen from far away. Lengths are in units of
/// WindingClusters::unit. Without padding: files hold it as it is.
struct WindingCluster {
    std::array<double, 3> center{};     ///< centre of area, in the mesh's coordinates
    std::array<double, 3> dipole{};     ///< integral of the normal n
    std::array<double, 6> quadrupole{}; ///< of s n, symmetric and trace-free, s from center
    std::array<double, 10> octupole{};  ///< of s s n, symmetric and trace-free
    double radius = 0.0;                ///< no point is farther from the centre
    double remainder = 0.0;             ///< bound's factor, see winding_number.cpp
    std::uint32_t first = 0;
    std::uint32_t count = 0;
    std::uint32_t next = 0; ///< the cluster after all below this one, which follow it
    std::uint32_t zero = 0;
};
static_assert(sizeof(WindingCluster) == 208);

/// What queries read. Refers to the arrays.
struct WindingClusters {
    std::span<const WindingCluster> clusters;
    std::span<const std::uint32_t> order;
    double unit = 1.0; ///< factor from the mesh's lengths to those of clusters, a power of two

    [[nodiscard]] bool is_leaf(std::size_t cluster) const noexcept
    {
        return clusters[cluster].next == cluster + 1;
    }
};

namespace winding {

inline constexpr double rounding_error = 1e-12;
inline constexpr double inverse_sphere = 0.25 * std::numbers::inv_pi;
/// A little below 1/2, so that a half by symmetry does not depend on rounding.
inline constexpr double inside_limit = 0.5 - 0x1p-40;

/// Solid angle of the cluster over 4 pi, from `eye` relative to its centre.
[[nodiscard]] inline double far_field(const WindingCluster& cluster, const Vec3& eye,
                                      double squared_distance) noexcept
{
    const double x = eye[0];
    const double y = eye[1];
    const double z = eye[2];
    const auto& q = cluster.quadrupole;
    const auto& o = cluster.octupole;
    const double xx = x * x;
    const double yy = y * y;
    const double zz = z * z;
    const double xy = x * y;
    const double first = Vec3(cluster.dipole.data()).dot(eye);
    const double second =
        q[0] * xx + q[1] * yy + q[2] * zz + 2.0 * (q[3] * xy + q[4] * (x * z) + q[5] * (y * z));
    const double third = o[0] * (xx * x) + o[1] * (yy * y) + o[2] * (zz * z) +
                         3.0 * (xx * (o[3] * y + o[4] * z) + yy * (o[5] * x + o[6] * z) +
                                zz * (o[7] * x + o[8] * y)) +
                         6.0 * (o[9] * (xy * z));
    const double inverse = 1.0 / squared_distance;
    const double inverse_3 = inverse * std::sqrt(inverse);
    return -inverse_sphere * inverse_3 *
           (first + inverse * (3.0 * second + inverse * (7.5 * third)));
}

/// One pass down the clusters: expansions where their bound is below `tolerance`.
template <class TriangleAt>
[[nodiscard]] WindingEstimate estimate(const WindingClusters& of, const TriangleAt& triangle_at,
                                       const Vec3& point, double tolerance) noexcept
{
    WindingEstimate sum{0.0, rounding_error};
    SolidAngleSum near;
    for (std::size_t at = 0; at < of.clusters.size();) {
        const WindingCluster& cluster = of.clusters[at];
        const Vec3 eye = (point - Vec3(cluster.center.data())) * of.unit;
        const double squared_distance = eye.squaredNorm();
        const double distance = std::sqrt(squared_distance);
        const double gap = distance - cluster.radius;
        if (gap > 0.0) {
            // remainder (4 - 3t) / (1 - t)^2 / R^5, multiplied out
            const double bound = cluster.remainder * (4.0 * distance - 3.0 * cluster.radius) /
                                 (gap * gap * squared_distance * squared_distance);
            if (bound <= tolerance) {
                sum.value += far_field(cluster, eye, squared_distance);
                sum.error += bound;
                at = cluster.next;
                continue;
            }
        }
        if (of.is_leaf(at)) {
            for (const std::uint32_t number : of.order.subspan(cluster.first, cluster.count)) {
                near.add(triangle_at(number), point, of.unit);
            }
        }
        ++at;
    }
    sum.value += near.winding();
    return sum;
}

/// Whether sign w + offset is at least 1/2, with as little work as decides it.
template <class TriangleAt>
[[nodiscard]] bool exceeds(const WindingClusters& of, const TriangleAt& triangle_at,
                           const Vec3& point, double sign, double offset) noexcept
{
    double tolerance = 0.006;
    while (tolerance > rounding_error) {
        const WindingEstimate found = estimate(of, triangle_at, point, tolerance);
        const double value = sign * found.value + offset;
        if (std::abs(value - inside_limit) > found.error) return value >= inside_limit;
        tolerance /= 16.0;
    }
    return sign * estimate(of, triangle_at, point, 0.0).value + offset >= inside_limit;
}

} // namespace winding

/// Whether the winding number at `point` is at least 1/2: the estimate is sharpened until its error
/// cannot change the answer. Values within 2^-40 below 1/2 count as 1/2. No allocation, thread safe.
/// \pre point is finite
template <class TriangleAt>
[[nodiscard]] bool is_inside(const WindingClusters& of, const TriangleAt& triangle_at,
                             const Vec3& point) noexcept
{
    return winding::exceeds(of, triangle_at, point, 1.0, 0.0);
}

} // namespace proxima
