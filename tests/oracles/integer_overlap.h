// The slow, plain truth for whole coordinates: separating axes in 128-bit integers, and
// triangle-box pairs that touch, nearly touch, or degenerate.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <random>

namespace proxima::oracle {

__extension__ using Wide = __int128;

using Point = std::array<std::int64_t, 3>;

struct IntegerTriangle {
    std::array<Point, 3> vertices;
};

struct IntegerBox {
    Point lower;
    Point upper;
};

[[nodiscard]] inline Point subtract(const Point& a, const Point& b)
{
    return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

[[nodiscard]] inline Point cross(const Point& a, const Point& b)
{
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

[[nodiscard]] inline Wide dot(const Point& a, const Point& b)
{
    return static_cast<Wide>(a[0]) * b[0] + static_cast<Wide>(a[1]) * b[1] +
           static_cast<Wide>(a[2]) * b[2];
}

[[nodiscard]] inline Point corner(const IntegerBox& box, unsigned bits)
{
    return {(bits & 1U) != 0 ? box.upper[0] : box.lower[0],
            (bits & 2U) != 0 ? box.upper[1] : box.lower[1],
            (bits & 4U) != 0 ? box.upper[2] : box.lower[2]};
}

/// A direction with room for products of two coordinates.
using Axis = std::array<Wide, 3>;

[[nodiscard]] inline Axis axis_across(const Point& a, const Point& b)
{
    const auto minor = [&](std::size_t u, std::size_t w) {
        return static_cast<Wide>(a[u]) * b[w] - static_cast<Wide>(a[w]) * b[u];
    };
    return {minor(1, 2), minor(2, 0), minor(0, 1)};
}

[[nodiscard]] inline Wide dot(const Axis& a, const Point& b)
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/// Whether the projections on the axis have a gap. \pre |coordinates| <= 2^40, axis below 2^84
[[nodiscard]] inline bool axis_separates(const IntegerTriangle& triangle, const IntegerBox& box,
                                         const Axis& axis)
{
    Wide triangle_low = dot(axis, triangle.vertices[0]);
    Wide triangle_high = triangle_low;
    for (const Point& vertex : triangle.vertices) {
        const Wide value = dot(axis, vertex);
        if (value < triangle_low) triangle_low = value;
        if (value > triangle_high) triangle_high = value;
    }
    Wide box_low = dot(axis, corner(box, 0));
    Wide box_high = box_low;
    for (unsigned bits = 1; bits < 8; ++bits) {
        const Wide value = dot(axis, corner(box, bits));
        if (value < box_low) box_low = value;
        if (value > box_high) box_high = value;
    }
    return triangle_high < box_low || triangle_low > box_high;
}

/// 13 axes: 3 of the box, the normal, 9 products. Closed sets; degenerate triangles included (then
/// the products with one edge and its negative are all that a segment needs).
/// \pre |coordinates| <= 2^40
[[nodiscard]] inline bool overlaps(const IntegerTriangle& triangle, const IntegerBox& box)
{
    const std::array<Point, 3> axes = {Point{1, 0, 0}, Point{0, 1, 0}, Point{0, 0, 1}};
    for (const Point& axis : axes)
        if (axis_separates(triangle, box, {axis[0], axis[1], axis[2]})) return false;
    const auto& v = triangle.vertices;
    const std::array<Point, 3> edges = {subtract(v[1], v[0]), subtract(v[2], v[1]),
                                        subtract(v[0], v[2])};
    if (axis_separates(triangle, box, axis_across(edges[0], edges[1]))) return false;
    for (const Point& axis : axes) {
        for (const Point& edge : edges)
            if (axis_separates(triangle, box, axis_across(axis, edge))) return false;
    }
    return true;
}

struct IntegerPair {
    IntegerTriangle triangle;
    IntegerBox box;
};

/// Random pairs with coordinates in [0, size], most of them touching, nearly touching or
/// degenerate.
class PairGenerator {
public:
    PairGenerator(std::uint64_t seed, std::int64_t size) : random_(seed), size_(size) {}

    [[nodiscard]] IntegerPair operator()()
    {
        IntegerPair pair;
        pair.box = random_box();
        for (Point& vertex : pair.triangle.vertices) vertex = random_point();
        auto& v = pair.triangle.vertices;
        switch (below(8)) {
        case 0:
            break; // anything
        case 1:    // an edge through an edge of the box
        case 2: {
            const Point touched = point_on_box();
            const Point direction = random_direction();
            v[0] = along(touched, direction, 1 + below(3));
            v[1] = along(touched, direction, -1 - below(3));
            break;
        }
        case 3: { // a plane through a corner
            const Point touched = corner(pair.box, static_cast<unsigned>(below(8)));
            const Point first = random_direction();
            const Point second = random_direction();
            v[0] = along(touched, first, 1 + below(3));
            v[1] = along(touched, second, 1 + below(3));
            for (std::size_t k = 0; k < 3; ++k) v[2][k] = 3 * touched[k] - v[0][k] - v[1][k];
            break;
        }
        case 4: // in a plane of the box, or parallel to it
            for (Point& vertex : v) vertex[plane_axis_] = plane_value();
            break;
        case 5: // a sliver or a segment
            for (std::size_t k = 0; k < 3; ++k) v[2][k] = (v[0][k] + v[1][k]) / 2;
            break;
        case 6:
            v[1] = v[0];
            break; // a segment
        default:   // a vertex on the box
            v[0] = point_on_box();
            break;
        }
        if (below(2) == 0) nudge(v[static_cast<std::size_t>(below(3))]);
        if (below(64) == 0) v[1] = v[2] = v[0]; // a point
        std::shuffle(v.begin(), v.end(), random_);
        return pair;
    }

    [[nodiscard]] std::int64_t below(std::int64_t count)
    {
        return std::uniform_int_distribution<std::int64_t>(0, count - 1)(random_);
    }

    [[nodiscard]] Point random_point()
    {
        return {below(size_ + 1), below(size_ + 1), below(size_ + 1)};
    }

private:
    [[nodiscard]] IntegerBox random_box()
    {
        const Point a = random_point();
        const Point b = random_point();
        for (std::size_t k = 0; k < 3; ++k) {
            box_.lower[k] = std::min(a[k], b[k]);
            box_.upper[k] = std::max(a[k], b[k]);
        }
        plane_axis_ = static_cast<std::size_t>(below(3));
        return box_;
    }

    [[nodiscard]] std::int64_t plane_value()
    {
        return below(2) == 0 ? box_.lower[plane_axis_] : box_.upper[plane_axis_];
    }

    [[nodiscard]] Point point_on_box()
    {
        Point point = corner(box_, static_cast<unsigned>(below(8)));
        for (int free = static_cast<int>(below(3)); free > 0; --free) {
            const auto k = static_cast<std::size_t>(below(3));
            point[k] = box_.lower[k] + below(box_.upper[k] - box_.lower[k] + 1);
        }
        return point;
    }

    [[nodiscard]] Point random_direction()
    {
        const std::int64_t reach = size_ / 4 + 1;
        Point direction;
        for (std::int64_t& component : direction) component = below(2 * reach + 1) - reach;
        return direction;
    }

    [[nodiscard]] static Point along(const Point& from, const Point& direction, std::int64_t steps)
    {
        return {from[0] + steps * direction[0], from[1] + steps * direction[1],
                from[2] + steps * direction[2]};
    }

    void nudge(Point& point) { point[static_cast<std::size_t>(below(3))] += below(3) - 1; }

    std::mt19937_64 random_;
    std::int64_t size_;
    IntegerBox box_ = {};
    std::size_t plane_axis_ = 0;
};

} // namespace proxima::oracle
