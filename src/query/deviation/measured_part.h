// A triangle of A or a part of one whose corners' distances from B are known.
#pragma once

#include "query/deviation/surface_pair.h"

#include <array>
#include <cstddef>
#include <cstdint>

namespace proxima {

/// A value at each corner of a triangle.
using CornerValues = std::array<double, 3>;

[[nodiscard]] constexpr std::size_t next_corner(std::size_t corner) noexcept
{
    return corner == 2 ? 0 : corner + 1;
}
[[nodiscard]] constexpr double corner_sum(const CornerValues& values) noexcept
{
    return values[0] + values[1] + values[2];
}

/// The longest side of a triangle goes from this corner to the next.
[[nodiscard]] std::size_t longest_side_of(const std::array<Vec3, 3>& corners) noexcept;

/// A triangle of A or a part of one.
struct MeasuredPart {
    std::array<Vec3, 3> corners;
    std::array<NearestRow, 3> nearest{}; ///< of the corners: what is closest, or almost
    double weight = 1;                   ///< its part of the triangle's area
    std::uint32_t cuts = 0;

    /// From B to a point, at most.
    [[nodiscard]] double reach(const Vec3& p) const noexcept;
    /// Both halves, across the longest side, and what is closest to the new corner.
    struct Halves;
    [[nodiscard]] Halves halves(const SurfacePair& pair) const noexcept;
};

struct MeasuredPart::Halves {
    std::array<MeasuredPart, 2> parts;
    Vec3 corner = Vec3::Zero();
    NearestRow nearest;
};

/// A part and a bound of its points' distances from B.
struct BoundedPart {
    MeasuredPart part;
    std::uint32_t row_a = 0;
    double upper = 0;
};

/// By the rows closest to its corners.
[[nodiscard]] BoundedPart bounded_part(const SurfacePair& pair, const MeasuredPart& part,
                                       std::uint32_t row_a) noexcept;
/// A triangle of A.
[[nodiscard]] BoundedPart bounded_triangle(const SurfacePair& pair,
                                           const MeasuredVertices& vertices,
                                           std::uint32_t row_a) noexcept;
/// The distance of the part's farthest corner from a row: no point of the part is farther.
[[nodiscard]] double upper_by(const SurfacePair& pair, const MeasuredPart& part,
                              std::uint32_t row) noexcept;
/// Whether a triangle's corners are those of a row of B, bit for bit: then all distances are 0.
[[nodiscard]] bool is_row_of_b(const SurfacePair& pair, const std::array<Vec3, 3>& corners,
                               std::uint32_t row) noexcept;

/// Of parts or pieces: which is to be cut later.
struct HasLowerBound {
    template <class Bounded>
    bool operator()(const Bounded& one, const Bounded& other) const noexcept
    {
        return one.upper < other.upper;
    }
};

} // namespace proxima
