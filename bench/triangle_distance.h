// Squared distance of a point and a triangle as the peers compute it, in float or double:
// [ericson-2005] 5.1.5, which leaves early where a corner or a side is closest.
//
// Its weights come from differences of products, so a thin triangle may be found too far away by
// more than rounding. is_thin() tells which those are; proxima::closest_point takes them.
#pragma once

#include "geometry/closest_point.h"
#include "proxima/triangle_mesh.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>
#include <vector>

namespace proxima::bench {

/// Corner a and the sides from it.
template <class T>
struct TriangleSides {
    std::array<T, 3> a;
    std::array<T, 3> ab;
    std::array<T, 3> ac;
};

template <class T>
T dot(const std::array<T, 3>& u, const std::array<T, 3>& v)
{
    return u[0] * v[0] + u[1] * v[1] + u[2] * v[2];
}

template <class T>
std::array<T, 3> difference(const std::array<T, 3>& u, const std::array<T, 3>& v)
{
    return {u[0] - v[0], u[1] - v[1], u[2] - v[2]};
}

/// Of a triangle about a centre: differences are taken in double, then rounded once to T.
template <class T>
TriangleSides<T> sides_of(const Triangle& triangle, const Vec3& centre)
{
    const auto rounded = [](const Vec3& v) {
        return std::array<T, 3>{static_cast<T>(v.x()), static_cast<T>(v.y()),
                                static_cast<T>(v.z())};
    };
    return {rounded(triangle[0] - centre), rounded(triangle[1] - triangle[0]),
            rounded(triangle[2] - triangle[0])};
}

/// True where the sine of some angle is below 1/16, and for degenerate triangles.
inline bool is_thin(const Triangle& triangle)
{
    const double area = scaled_normal(triangle).squaredNorm();
    const double ab = (triangle[1] - triangle[0]).squaredNorm();
    const double bc = (triangle[2] - triangle[1]).squaredNorm();
    const double ca = (triangle[0] - triangle[2]).squaredNorm();
    return !(256 * area > std::max({ab * bc, bc * ca, ca * ab}));
}

/// The squared distance of p, given about the same centre.
template <class T>
T squared_distance(const TriangleSides<T>& triangle, const std::array<T, 3>& p)
{
    const auto& [a, ab, ac] = triangle;
    const std::array<T, 3> ap = difference(p, a);
    const T d1 = dot(ab, ap);
    const T d2 = dot(ac, ap);
    if (d1 <= 0 && d2 <= 0) return dot(ap, ap);
    const std::array<T, 3> bp = difference(ap, ab);
    const T d3 = dot(ab, bp);
    const T d4 = dot(ac, bp);
    if (d3 >= 0 && d4 <= d3) return dot(bp, bp);
    const std::array<T, 3> cp = difference(ap, ac);
    const T d5 = dot(ab, cp);
    const T d6 = dot(ac, cp);
    if (d6 >= 0 && d5 <= d6) return dot(cp, cp);

    // The point a + v ab + w ac.
    T v = 0;
    T w = 0;
    const T vc = d1 * d4 - d3 * d2;
    const T vb = d5 * d2 - d1 * d6;
    const T va = d3 * d6 - d5 * d4;
    if (vc <= 0 && d1 >= 0 && d3 <= 0) {
        v = d1 / (d1 - d3);
    } else if (vb <= 0 && d2 >= 0 && d6 <= 0) {
        w = d2 / (d2 - d6);
    } else if (va <= 0 && d4 >= d3 && d5 >= d6) {
        w = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        v = 1 - w;
    } else {
        const T scale = 1 / (va + vb + vc);
        v = vb * scale;
        w = vc * scale;
    }
    std::array<T, 3> off;
    for (std::size_t k = 0; k < 3; ++k) off[k] = ap[k] - v * ab[k] - w * ac[k];
    return dot(off, off);
}

/// The triangles of a mesh in double, for a peer to find its winner's distance with.
class ExactTriangles {
public:
    ExactTriangles(const TriangleMesh& mesh, std::span<const TriangleId> order)
    {
        rows_.reserve(order.size());
        for (const TriangleId id : order) {
            const Triangle triangle = mesh.triangle(id);
            rows_.push_back({triangle, bench::is_thin(triangle)});
        }
    }

    /// Of the ith in the given order.
    [[nodiscard]] double squared_distance(std::size_t i, const Vec3& point) const
    {
        const Row& row = rows_[i];
        if (row.thin) return (closest_point(row.triangle, point).point - point).squaredNorm();
        return bench::squared_distance(sides_of<double>(row.triangle, Vec3::Zero()),
                                       {point.x(), point.y(), point.z()});
    }

    [[nodiscard]] bool is_thin(std::size_t i) const { return rows_[i].thin; }
    [[nodiscard]] std::size_t size() const { return rows_.size(); }
    [[nodiscard]] std::size_t bytes() const { return rows_.size() * sizeof(Row); }

private:
    struct Row {
        Triangle triangle;
        bool thin;
    };
    std::vector<Row> rows_;
};

} // namespace proxima::bench
