// Distances and depths in 113-bit numbers, by trying all pairs of features and all axes.
#pragma once

#include "geometry/closest_point.h"
#include "proxima/geometry.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

namespace proxima::oracle {

#ifdef __SIZEOF_FLOAT128__
__extension__ using Quad = __float128;
#else
using Quad = long double; // on Arm
static_assert(std::numeric_limits<Quad>::digits == 113);
#endif

struct QuadPoint {
    Quad x = 0;
    Quad y = 0;
    Quad z = 0;

    QuadPoint() = default;
    QuadPoint(Quad px, Quad py, Quad pz) : x(px), y(py), z(pz) {}
    // NOLINTNEXTLINE(google-explicit-constructor): formulas take plain points too
    QuadPoint(const Vec3& v) : x(v.x()), y(v.y()), z(v.z()) {}

    friend QuadPoint operator+(const QuadPoint& a, const QuadPoint& b)
    {
        return {a.x + b.x, a.y + b.y, a.z + b.z};
    }
    friend QuadPoint operator-(const QuadPoint& a, const QuadPoint& b)
    {
        return {a.x - b.x, a.y - b.y, a.z - b.z};
    }
    friend QuadPoint operator*(Quad s, const QuadPoint& a) { return {s * a.x, s * a.y, s * a.z}; }
};

[[nodiscard]] inline Quad dot(const QuadPoint& a, const QuadPoint& b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
[[nodiscard]] inline QuadPoint cross(const QuadPoint& a, const QuadPoint& b)
{
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
/// The square root to 64 bits. Scaled, so that squares of tiny lengths do not underflow.
[[nodiscard]] inline long double root(Quad square)
{
    return std::sqrt(static_cast<long double>(square));
}
[[nodiscard]] inline Quad clamped(Quad t)
{
    if (t < 0) return 0;
    return t > 1 ? Quad(1) : t;
}

[[nodiscard]] inline Quad squared_distance(const QuadPoint& p, const QuadPoint& a,
                                           const QuadPoint& b)
{
    const QuadPoint u = b - a;
    const Quad length = dot(u, u);
    const Quad t = length > 0 ? clamped(dot(p - a, u) / length) : Quad(0);
    const QuadPoint gap = p - (a + t * u);
    return dot(gap, gap);
}

[[nodiscard]] inline Quad squared_distance(const QuadPoint& p, const Triangle& triangle)
{
    const QuadPoint a(triangle[0]);
    const QuadPoint b(triangle[1]);
    const QuadPoint c(triangle[2]);
    Quad best =
        std::min({squared_distance(p, a, b), squared_distance(p, b, c), squared_distance(p, c, a)});
    const QuadPoint n = cross(b - a, c - a);
    const Quad area = dot(n, n);
    if (area == 0) return best;
    const bool inside = dot(cross(b - a, p - a), n) >= 0 && dot(cross(c - b, p - b), n) >= 0 &&
                        dot(cross(a - c, p - c), n) >= 0;
    if (inside) {
        const Quad height = dot(p - a, n);
        best = std::min(best, height * height / area);
    }
    return best;
}

[[nodiscard]] inline Quad squared_distance(const Segment& first, const Segment& second)
{
    const QuadPoint p(first.from);
    const QuadPoint q(second.from);
    const QuadPoint u = QuadPoint(first.to) - p;
    const QuadPoint w = QuadPoint(second.to) - q;
    Quad best = std::min({squared_distance(p, q, q + w), squared_distance(p + u, q, q + w),
                          squared_distance(q, p, p + u), squared_distance(q + w, p, p + u)});
    const QuadPoint n = cross(u, w);
    const Quad area = dot(n, n);
    if (area == 0) return best;
    const Quad s = dot(cross(q - p, w), n) / area;
    const Quad t = dot(cross(q - p, u), n) / area;
    if (s >= 0 && s <= 1 && t >= 0 && t <= 1) {
        const Quad height = dot(q - p, n);
        best = std::min(best, height * height / area);
    }
    return best;
}

[[nodiscard]] inline Vec3 box_corner(const Box& box, int corner)
{
    Vec3 point = box.lower;
    for (int axis = 0; axis < 3; ++axis)
        if ((corner >> axis & 1) != 0) point[axis] = box.upper[axis];
    return point;
}

/// Of shapes that are apart.
[[nodiscard]] inline Quad squared_distance(const Triangle& triangle, const Box& box)
{
    Quad best = -1;
    const auto offer = [&](Quad squared) {
        if (best < 0 || squared < best) best = squared;
    };
    for (const Vec3& vertex : triangle.vertices) {
        const QuadPoint gap =
            QuadPoint(vertex) - QuadPoint(vertex.cwiseMax(box.lower).cwiseMin(box.upper));
        offer(dot(gap, gap));
    }
    for (int corner = 0; corner < 8; ++corner) {
        offer(squared_distance(QuadPoint(box_corner(box, corner)), triangle));
        for (int axis = 0; axis < 3; ++axis) {
            if ((corner >> axis & 1) != 0) continue;
            const Segment edge = {box_corner(box, corner), box_corner(box, corner | 1 << axis)};
            for (int i = 0; i < 3; ++i)
                offer(squared_distance(Segment{triangle[i], triangle[(i + 1) % 3]}, edge));
        }
    }
    return best;
}

/// A direction, and how far the triangle must move along it, in its own length, to pass the box.
struct QuadMotion {
    QuadPoint direction;
    Quad motion = 0;
};

/// Along both ways of the 13 axes that may separate triangle and box.
[[nodiscard]] inline std::vector<QuadMotion> motions(const Triangle& triangle, const Box& box)
{
    const std::array<QuadPoint, 3> axes = {QuadPoint(1, 0, 0), {0, 1, 0}, {0, 0, 1}};
    std::array<QuadPoint, 3> edges;
    for (int i = 0; i < 3; ++i) {
        edges[static_cast<std::size_t>(i)] =
            QuadPoint(triangle[(i + 1) % 3]) - QuadPoint(triangle[i]);
    }
    std::vector<QuadPoint> candidates(axes.begin(), axes.end());
    candidates.push_back(cross(edges[0], edges[1]));
    for (const QuadPoint& axis : axes)
        for (const QuadPoint& edge : edges) candidates.push_back(cross(axis, edge));
    std::vector<QuadMotion> result;
    for (const QuadPoint& candidate : candidates) {
        if (dot(candidate, candidate) == 0) continue;
        for (const int sign : {1, -1}) {
            const QuadPoint direction = Quad(sign) * candidate;
            Quad box_far = dot(direction, box_corner(box, 0));
            for (int corner = 1; corner < 8; ++corner)
                box_far = std::max(box_far, dot(direction, box_corner(box, corner)));
            Quad triangle_near = dot(direction, triangle[0]);
            for (const Vec3& vertex : triangle.vertices)
                triangle_near = std::min(triangle_near, dot(direction, vertex));
            result.push_back({direction, box_far - triangle_near});
        }
    }
    return result;
}

} // namespace proxima::oracle
