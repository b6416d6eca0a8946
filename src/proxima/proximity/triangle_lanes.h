// How near the triangles of a group can be, eight at a time: a filter before exact distances.
#pragma once

#include "proxima/mesh/triangle_mesh.h"

#include <array>
#include <span>

namespace proxima {

/// Squared distances of up to eight triangles from p, times scale^2. Each is right up to rounding,
/// or 0 for a triangle with less than two degrees at its first corner; those beyond the ids are
/// any. The same bits on every instruction set. No allocation. About 50 ns. \pre 1 <= ids.size() <=
/// 8; the mesh's extent times scale is at most 2
void triangle_distances(const TriangleMesh& mesh, std::span<const TriangleId> ids, const Vec3& p,
                        double scale, std::array<double, 8>& squared) noexcept;

/// A triangle whose squared distance from triangle_distances is above this has no feature whose
/// squared distance, as computed (feature_distance.h), is at most `squared` / scale^2.
/// `reach` is the largest |coordinate| of the mesh times scale.
[[nodiscard]] constexpr double triangle_distance_limit(double squared, double reach) noexcept
{
    // With e bounding the errors of both distances, (d - e)^2 > s where d^2 > s (1 + t) +
    // e^2 (1 + 1 / t). Lanes are off by 2^-40 of |corner - p|, which is at most 4 + d; features by
    // 2^-48 of their coordinates. What is in proportion to d is in t as well.
    const double error = 0x1p-38 + 0x1p-47 * reach;
    return squared * (1 + 0x1p-20) + error * error * (1 + 0x1p20);
}

} // namespace proxima
