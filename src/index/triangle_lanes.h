// How near the triangles of a group can be, eight at a time: a filter before exact distances.
#pragma once

#include "index/triangle_row.h"
#include "proxima/triangle_mesh.h"

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>

namespace proxima {

/// Squared distances of up to eight triangles from p, times scale^2. Each is right up to rounding,
/// or 0 for a triangle with less than two degrees at its first corner; those beyond the ids are
/// any. The same bits on every instruction set. No allocation. About 50 ns. \pre 1 <= ids.size() <=
/// 8; the mesh's extent times scale is at most 2
void triangle_distances(const TriangleMesh& mesh, std::span<const TriangleId> ids, const Vec3& p,
                        double scale, std::array<double, 8>& squared) noexcept;

/// The same from rows.
void triangle_distances(std::span<const TriangleRow<float>> rows, const Vec3& p, double scale,
                        std::array<double, 8>& squared) noexcept;
void triangle_distances(std::span<const TriangleRow<double>> rows, const Vec3& p, double scale,
                        std::array<double, 8>& squared) noexcept;

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

/// Of up to eight triangles with these distances, those that may have a feature before the best
/// one: offered in turn, the nearest first. `limit()` is triangle_distance_limit of the best one,
/// `offer(i)` looks at triangle i in full.
template <class Limit, class Offer>
void offer_nearest(const std::array<double, 8>& squared, std::size_t count, const Limit& limit,
                   const Offer& offer)
{
    const auto within_limit = [&] {
        const double most = limit();
        std::uint32_t lanes = 0;
        for (std::size_t i = 0; i < squared.size(); ++i) {
            lanes |= (squared[i] > most ? 0U : 1U) << i;
        }
        return lanes;
    };
    std::uint32_t left = (1U << count) - 1;
    for (left &= within_limit(); left != 0; left &= within_limit()) {
        auto nearest = static_cast<std::size_t>(std::countr_zero(left));
        for (std::uint32_t others = left & (left - 1); others != 0; others &= others - 1) {
            const auto other = static_cast<std::size_t>(std::countr_zero(others));
            if (squared[other] < squared[nearest]) nearest = other;
        }
        left &= ~(1U << nearest);
        offer(nearest);
    }
}

} // namespace proxima
