// One triangle as the recheck in doubles reads it: corners and the names of its features in one
// place, in Morton order.
//
//     float row    x 3 | y 3 | z 3, 4 bytes each | triangle | vertices 3 | edges 3    one cache
//     line double row   x 3 | y 3 | z 3, 8 bytes each | triangle | vertices 3 | edges 3 | 0     104
//     bytes
//
// Most scans were written as floats: their rows hold the doubles exactly in half the space.
#pragma once

#include "proxima/geometry/vec.h"
#include "proxima/mesh/feature.h"

#include <array>
#include <cstdint>

namespace proxima {

/// What fills a row up: nothing, or zeros, so that rows have no bytes without a value.
template <class Scalar>
struct TriangleRowEnd {};
template <>
struct TriangleRowEnd<double> {
    std::uint32_t zero = 0;
};

template <class Scalar>
struct TriangleRow {
    Scalar coordinates[3][3] = {}; ///< by axis, then corner
    std::uint32_t triangle = 0;    ///< its id, thin_bit, and a bit per side
    std::uint32_t vertices[3] = {};
    std::uint32_t edges[3] = {}; ///< edge k joins corner k and k + 1; no_edge where they are one
    [[no_unique_address]] TriangleRowEnd<Scalar> end = {};

    /// Set for triangles so thin that their inside wants care.
    static constexpr std::uint32_t thin_bit = 1U << 31U;

    /// Bit side_bit << k is set where side k goes from its higher to its lower vertex id.
    static constexpr std::uint32_t side_bit = 1U << 28U;

    [[nodiscard]] std::uint32_t triangle_id() const noexcept { return triangle & (side_bit - 1); }
    [[nodiscard]] bool backward(std::size_t side) const noexcept
    {
        return (triangle >> side & side_bit) != 0;
    }
    [[nodiscard]] bool thin() const noexcept { return (triangle & thin_bit) != 0; }
    [[nodiscard]] Vec3 corner(int i) const noexcept
    {
        return {static_cast<double>(coordinates[0][i]), static_cast<double>(coordinates[1][i]),
                static_cast<double>(coordinates[2][i])};
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

} // namespace proxima
