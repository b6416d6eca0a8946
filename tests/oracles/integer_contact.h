// The slow, plain truth about triangles with whole coordinates: they meet if and only if the
// origin lies in the hull of their nine differences, so in a simplex of at most four of these
// (Caratheodory). Degenerate triangles are no special case.
#pragma once

#include "geometry/exact_predicates.h"

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <array>
#include <cstdint>

namespace proxima::oracle {

using Whole = Eigen::Matrix<std::int64_t, 3, 1>;
using WholeTriangle = std::array<Whole, 3>;

[[nodiscard]] inline int sign_of(std::int64_t value)
{
    return static_cast<int>(value > 0) - static_cast<int>(value < 0);
}

[[nodiscard]] inline std::int64_t determinant(const Whole& u, const Whole& v, const Whole& w)
{
    return u.cross(v).dot(w);
}

/// Whether the origin lies in the closed segment. \pre on its line
[[nodiscard]] inline bool origin_between(const Whole& a, const Whole& b)
{
    return a.dot(b) <= 0;
}

[[nodiscard]] inline bool origin_in_segment(const Whole& a, const Whole& b)
{
    return a.cross(b).isZero() && origin_between(a, b);
}

/// False for triangles without an area: their sides say it.
[[nodiscard]] inline bool origin_in_triangle(const Whole& a, const Whole& b, const Whole& c)
{
    const Whole normal = (b - a).cross(c - a);
    if (normal.isZero() || normal.dot(a) != 0) return false;
    return a.cross(b).dot(normal) >= 0 && b.cross(c).dot(normal) >= 0 &&
           c.cross(a).dot(normal) >= 0;
}

/// False for tetrahedra without a volume: their faces say it.
[[nodiscard]] inline bool origin_in_tetrahedron(const Whole& a, const Whole& b, const Whole& c,
                                                const Whole& d)
{
    const int turn = sign_of(determinant(b - a, c - a, d - a));
    return turn != 0 && turn * sign_of(determinant(b, c, d)) >= 0 &&
           turn * sign_of(determinant(a, d, c)) >= 0 && turn * sign_of(determinant(a, b, d)) >= 0 &&
           turn * sign_of(determinant(a, c, b)) >= 0;
}

/// Whether two closed triangles have a point in common. \pre |coordinates| <= 2^18
[[nodiscard]] inline bool triangles_meet(const WholeTriangle& a, const WholeTriangle& b)
{
    std::array<Whole, 9> points;
    for (std::size_t i = 0; i < 9; ++i) points[i] = a[i / 3] - b[i % 3];
    for (std::size_t i = 0; i < 9; ++i) {
        if (points[i].isZero()) return true;
        for (std::size_t j = i + 1; j < 9; ++j) {
            if (origin_in_segment(points[i], points[j])) return true;
            for (std::size_t k = j + 1; k < 9; ++k) {
                if (origin_in_triangle(points[i], points[j], points[k])) return true;
                for (std::size_t l = k + 1; l < 9; ++l) {
                    if (origin_in_tetrahedron(points[i], points[j], points[k], points[l]))
                        return true;
                }
            }
        }
    }
    return false;
}

} // namespace proxima::oracle
