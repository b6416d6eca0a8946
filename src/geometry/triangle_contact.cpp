#include "geometry/triangle_contact.h"

#include "geometry/exact_predicates.h"
#include "geometry/triangle_intersection.h"

#include <algorithm>
#include <array>
#include <utility>

namespace proxima {
namespace {

using Sides = std::array<int, 3>;

bool boxes_apart(const Triangle& a, const Triangle& b) noexcept
{
    const Vec3 a_low = a[0].cwiseMin(a[1]).cwiseMin(a[2]);
    const Vec3 b_low = b[0].cwiseMin(b[1]).cwiseMin(b[2]);
    const Vec3 a_high = a[0].cwiseMax(a[1]).cwiseMax(a[2]);
    const Vec3 b_high = b[0].cwiseMax(b[1]).cwiseMax(b[2]);
    return (a_high.array() < b_low.array()).any() || (b_high.array() < a_low.array()).any();
}

/// On which sides of the other triangle's plane the corners lie. All zero means in the plane, or
/// that the other triangle has no area.
Sides sides_of(const Triangle& triangle, const Triangle& other) noexcept
{
    Sides sides{};
    for (std::size_t i = 0; i < 3; ++i)
        sides[i] = orient3d(other[0], other[1], other[2], triangle.vertices[i]);
    return sides;
}

bool are_all(const Sides& sides, int side) noexcept
{
    return sides[0] == side && sides[1] == side && sides[2] == side;
}

/// Turns the triangle round until corner 0 is alone on its side of a plane, the others being on the
/// other one or in it; corner 0 is in the plane only where both others are off it. Returns the side
/// of corner 0, or of the others with the opposite sign. \pre the sides are neither all the same
int put_lone_corner_first(Triangle& triangle, const Sides& sides) noexcept
{
    for (std::size_t i = 0; i < 3; ++i) {
        const int lone = sides[i];
        const int next = sides[(i + 1) % 3];
        const int last = sides[(i + 2) % 3];
        const bool alone = lone == 0 ? next == last : lone * next <= 0 && lone * last <= 0;
        if (!alone) continue;
        std::rotate(triangle.vertices.begin(),
                    triangle.vertices.begin() + static_cast<std::ptrdiff_t>(i),
                    triangle.vertices.end());
        return lone != 0 ? lone : -next;
    }
    return 0;
}

/// Each plane cuts the other triangle. The triangles cut two intervals out of the planes' common
/// line, each between the two edges of the lone corner.
bool stretches_meet(Triangle a, const Sides& sides_of_a, Triangle b,
                    const Sides& sides_of_b) noexcept
{
    const int side_of_a = put_lone_corner_first(a, sides_of_a);
    const int side_of_b = put_lone_corner_first(b, sides_of_b);
    // Orients the planes so that both lone corners are above.
    if (side_of_a < 0) std::swap(b.vertices[1], b.vertices[2]);
    if (side_of_b < 0) std::swap(a.vertices[1], a.vertices[2]);
    return orient3d(a[1], b[0], a[0], b[1]) <= 0 && orient3d(a[0], b[0], a[2], b[2]) <= 0;
}

} // namespace

bool segment_meets_triangle(const Vec3& p, const Vec3& q, const Triangle& triangle) noexcept
{
    const int p_side = orient3d(triangle[0], triangle[1], triangle[2], p);
    const int q_side = orient3d(triangle[0], triangle[1], triangle[2], q);
    if (p_side * q_side > 0) return false;
    if (p_side == 0 && q_side == 0) return !intersect({{p, q, q}}, triangle).empty();
    // The line passes through the triangle where it turns the same way round all sides.
    int least = 0;
    int most = 0;
    for (int i = 0; i < 3; ++i) {
        const int turn = orient3d(p, q, triangle[i], triangle[(i + 1) % 3]);
        least = std::min(least, turn);
        most = std::max(most, turn);
    }
    return least == 0 || most == 0;
}

bool triangles_meet(const Triangle& a, const Triangle& b) noexcept
{
    if (boxes_apart(a, b)) return false;
    const Sides sides_of_a = sides_of(a, b);
    if (are_all(sides_of_a, 1) || are_all(sides_of_a, -1)) return false;
    const Sides sides_of_b = sides_of(b, a);
    if (are_all(sides_of_b, 1) || are_all(sides_of_b, -1)) return false;
    if (are_all(sides_of_a, 0) || are_all(sides_of_b, 0)) return !intersect(a, b).empty();
    return stretches_meet(a, sides_of_a, b, sides_of_b);
}

} // namespace proxima
