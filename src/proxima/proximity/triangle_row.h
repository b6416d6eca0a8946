// One triangle as the recheck in doubles reads it: corners and the names of its features in one
// place, in Morton order.
//
//     float row    corners 9 x 4 | triangle | vertices 3 | edges 3       64 bytes, one cache line
//     double row   corners 9 x 8 | triangle | vertices 3 | edges 3 | 0   104 bytes
//
// Most scans were written as floats: their rows hold the doubles exactly in half the space.
#pragma once

#include "proxima/geometry/vec.h"
#include "proxima/mesh/feature.h"

#include <array>
#include <cstdint>

namespace proxima {

template <class Scalar>
struct alignas(sizeof(Scalar) == 4 ? 64 : 8) TriangleRow {
    Scalar corners[3][3] = {};
    std::uint32_t triangle = 0; ///< its id, and thin_bit
    std::uint32_t vertices[3] = {};
    std::uint32_t edges[3] = {}; ///< edge k joins corner k and k + 1; no_edge where they are one

    /// Set for triangles so thin that their inside wants care.
    static constexpr std::uint32_t thin_bit = 1U << 31U;

    [[nodiscard]] std::uint32_t triangle_id() const noexcept { return triangle & ~thin_bit; }
    [[nodiscard]] bool thin() const noexcept { return (triangle & thin_bit) != 0; }
    [[nodiscard]] Vec3 corner(int i) const noexcept
    {
        return {static_cast<double>(corners[i][0]), static_cast<double>(corners[i][1]),
                static_cast<double>(corners[i][2])};
    }
};
static_assert(sizeof(TriangleRow<float>) == 64);
static_assert(sizeof(TriangleRow<double>) == 104);

/// The least of squared distance, kind, id: what the closest feature is chosen by.
struct FeatureDistance {
    double squared = 0;
    Feature feature = {};
    std::uint32_t rank = 0;             ///< of the row that it was found in
    std::array<double, 3> weights = {}; ///< of that row's corners

    [[nodiscard]] bool before(const FeatureDistance& other) const noexcept
    {
        if (squared != other.squared) return squared < other.squared;
        return feature < other.feature;
    }
};

/// The closest feature of one triangle. A vertex's and an edge's distance has the same bits from
/// every triangle that has it. Distances are within a few roundings of the largest difference of
/// coordinates, for triangles of any shape. About 20 ns.
template <class Scalar>
[[nodiscard]] FeatureDistance closest_of_row(const TriangleRow<Scalar>& row, std::uint32_t rank,
                                             const Vec3& p) noexcept;

} // namespace proxima
