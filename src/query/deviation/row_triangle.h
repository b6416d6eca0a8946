// A triangle of B near a part of A, prepared for many distances, and what one point says of it.
//
// With the origin near the part: coordinates are small, and products of them exact enough. Distances
// are those of points that surely are on the triangle, so they are never too small; bounds from below
// are those of slabs, true whatever the direction:
//
//     distance of x  >=  x . w - max over corners v of v . w,   |w| <= 1
//
// So it does no harm but width where rounding names a point that is not the closest.
#pragma once

#include "index/index_parts.h"
#include "proxima/geometry.h"

#include <array>
#include <cstddef>
#include <cstdint>

namespace proxima {

/// What a point says of a triangle.
struct TriangleFoot {
    Vec3 direction = Vec3::Zero(); ///< from the foot to the point, of length 1 at most
    double support = 0;            ///< the largest of the triangle's corners in that direction
    double distance = 0;           ///< from the foot
    double height = 0;             ///< above the plane; 0 for thin triangles

    /// No more than the triangle's distance from a point.
    [[nodiscard]] double below(const Vec3& p) const noexcept { return direction.dot(p) - support; }
};

/// The ids of the edges of a row.
[[nodiscard]] std::array<std::uint32_t, 3> edges_of(const IndexParts& index,
                                                    std::uint32_t row) noexcept;

class RowTriangle {
public:
    /// Row `row` of B, whose sides have these edges' ids.
    RowTriangle(const Triangle& triangle, const Vec3& origin, std::uint32_t row,
                const std::array<std::uint32_t, 3>& edges) noexcept;

    [[nodiscard]] std::uint32_t row() const noexcept { return row_; }
    [[nodiscard]] const std::array<std::uint32_t, 3>& edges() const noexcept { return edges_; }
    [[nodiscard]] const Vec3& corner(std::size_t i) const noexcept { return corners_[i]; }

    [[nodiscard]] double distance(const Vec3& p) const noexcept
    {
        return (p - closest(p).point).norm();
    }
    [[nodiscard]] TriangleFoot foot(const Vec3& p) const noexcept;
    /// The bound by another direction, of any length but 0: the slab of its unit vector.
    [[nodiscard]] TriangleFoot slab(const Vec3& direction) const noexcept;

    /// In the plane, across a side and to the inside; as long as the side, or 0 for thin triangles.
    [[nodiscard]] Vec3 inward(std::size_t side) const noexcept;

private:
    struct Closest {
        Vec3 point = Vec3::Zero();
        bool is_inside = false;
    };
    [[nodiscard]] Closest closest(const Vec3& p) const noexcept;
    void set_support(TriangleFoot& foot) const noexcept;

    std::array<Vec3, 3> corners_;
    Vec3 u_; ///< to corner 1
    Vec3 w_; ///< to corner 2
    double uu_ = 0;
    double uw_ = 0;
    double ww_ = 0;
    Vec3 normal_ = Vec3::Zero(); ///< of length 1; 0 for thin triangles
    std::uint32_t row_ = 0;
    std::array<std::uint32_t, 3> edges_{};
    bool is_thin_ = false;
};

} // namespace proxima
