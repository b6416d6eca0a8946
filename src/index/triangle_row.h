// One triangle as the recheck in doubles reads it: corners and the names of its features side by
// side, in Morton order.
//
//     float row    x 3 | y 3 | z 3, 4 bytes each | triangle | vertices 3 | edges 3       64 bytes
//     double row   x 3 | y 3 | z 3, 8 bytes each | triangle | vertices 3 | edges 3 | 0  104 bytes
//
// Most scans were written as floats: their rows hold the doubles exactly in half the space.
#pragma once

#include "proxima/geometry.h"
#include "proxima/topology.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>

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
    [[nodiscard]] Triangle corners() const noexcept { return {{corner(0), corner(1), corner(2)}}; }
};
static_assert(sizeof(TriangleRow<float>) == 64);
static_assert(sizeof(TriangleRow<double>) == 104);

/// A vertex's or edge's lowest triangle and where it is there: what answers name.
///
///     vertex   triangle 28 | corner 2
///     edge     triangle 28 | side 2 | 1 where the side goes from its higher to its lower vertex id
namespace incidence {
inline constexpr std::uint32_t none = 0xFFFFFFFF; ///< of a vertex without a triangle

[[nodiscard]] constexpr std::uint32_t make(std::uint32_t triangle, std::uint32_t corner,
                                           bool backward) noexcept
{
    return triangle | corner << 28U | static_cast<std::uint32_t>(backward) << 30U;
}
[[nodiscard]] constexpr std::uint32_t triangle(std::uint32_t word) noexcept
{
    return word & ((1U << 28U) - 1);
}
[[nodiscard]] constexpr std::size_t corner(std::uint32_t word) noexcept
{
    return word >> 28U & 3U;
}
[[nodiscard]] constexpr bool backward(std::uint32_t word) noexcept
{
    return (word >> 30U & 1U) != 0;
}
} // namespace incidence

/// A power of two that brings the mesh's size to about 1, so that sixth powers of lengths do not
/// leave the doubles, and its inverse.
struct RowScale {
    double up = 1;
    double down = 1;

    /// In the mesh's unit: infinite or 0 where the doubles end.
    [[nodiscard]] double unscale_squared(double squared) const noexcept
    {
        return squared * down * down;
    }
};

/// Where a row's vertex is in it: the first of its corners. \pre it is one of them
template <class Scalar>
[[nodiscard]] std::size_t corner_of(const TriangleRow<Scalar>& row, std::uint32_t vertex) noexcept
{
    return row.vertices[0] == vertex ? 0 : row.vertices[1] == vertex ? 1 : 2;
}

/// Which side of a row an edge is: the one between the first corners of its vertices. \pre it is
/// one of them
template <class Scalar>
[[nodiscard]] std::size_t side_of(const TriangleRow<Scalar>& row, std::uint32_t edge) noexcept
{
    for (std::size_t k = 0; k < 2; ++k) {
        const std::size_t next = k + 1;
        if (row.edges[k] == edge && corner_of(row, row.vertices[k]) == k &&
            corner_of(row, row.vertices[next]) == next)
            return k;
    }
    return 2;
}

/// What a triangle's closest feature is chosen by, and what its point is made from.
struct RowDistance {
    double squared = std::numeric_limits<double>::infinity(); ///< in units of RowScale
    std::uint64_t feature = ~std::uint64_t{0};                ///< kind << 32 | id
    std::uint32_t rank = 0;                                   ///< of the row
    double along[4] = {}; ///< feet on the sides, from the lower vertex id
    double parts[4] = {}; ///< of a foot inside: of the corners 2, 0, 1, not normalised

    /// The order of answers: squared distance, kind, id; and of rows with the same, the first, so that
    /// which one it is does not follow the order of a search.
    [[nodiscard]] bool before(const RowDistance& other) const noexcept
    {
        if (squared != other.squared) return squared < other.squared;
        return feature != other.feature ? feature < other.feature : rank < other.rank;
    }
    [[nodiscard]] bool found() const noexcept { return feature != ~std::uint64_t{0}; }
    [[nodiscard]] FeatureKind kind() const noexcept
    {
        return static_cast<FeatureKind>(feature >> 32U);
    }
    [[nodiscard]] std::uint32_t id() const noexcept { return static_cast<std::uint32_t>(feature); }
};

} // namespace proxima
