#include "proxima/geometry/triangle_contact.h"

#include "proxima/geometry/exact_predicates.h"

#include <algorithm>
#include <array>

namespace proxima {
namespace {

/// Without one coordinate.
Vec2 shadow(const Vec3& point, int axis) noexcept
{
    return axis == 0   ? Vec2(point.y(), point.z())
           : axis == 1 ? Vec2(point.z(), point.x())
                       : Vec2(point.x(), point.y());
}

bool is_between(const Vec2& p, const Vec2& a, const Vec2& b) noexcept
{
    return (p.array() >= a.array().min(b.array())).all() &&
           (p.array() <= a.array().max(b.array())).all();
}

bool segments_meet(const Vec2& a, const Vec2& b, const Vec2& p, const Vec2& q) noexcept
{
    const int p_side = orient2d(a, b, p);
    const int q_side = orient2d(a, b, q);
    const int a_side = orient2d(p, q, a);
    const int b_side = orient2d(p, q, b);
    if (p_side * q_side < 0 && a_side * b_side < 0) return true;
    return (p_side == 0 && is_between(p, a, b)) || (q_side == 0 && is_between(q, a, b)) ||
           (a_side == 0 && is_between(a, p, q)) || (b_side == 0 && is_between(b, p, q));
}

/// In one plane: seen along an axis that keeps the triangle's area.
bool meet_in_plane(const Vec3& p, const Vec3& q, const Triangle& triangle) noexcept
{
    std::array<Vec2, 3> corners;
    int axis = 0;
    int turn = 0;
    for (; axis < 3; ++axis) {
        for (std::size_t i = 0; i < 3; ++i) corners[i] = shadow(triangle.vertices[i], axis);
        turn = orient2d(corners[0], corners[1], corners[2]);
        if (turn != 0) break;
    }
    const Vec2 from = shadow(p, axis);
    const Vec2 to = shadow(q, axis);
    bool inside = true;
    for (std::size_t i = 0; i < 3; ++i) {
        const Vec2& a = corners[i];
        const Vec2& b = corners[(i + 1) % 3];
        if (segments_meet(a, b, from, to)) return true;
        inside = inside && orient2d(a, b, from) * turn > 0;
    }
    return inside;
}

/// Whether all corners are on one side of the other's plane, and none on it.
bool is_apart(const Triangle& triangle, const Triangle& other) noexcept
{
    const int side = orient3d(other[0], other[1], other[2], triangle[0]);
    return side != 0 && orient3d(other[0], other[1], other[2], triangle[1]) == side &&
           orient3d(other[0], other[1], other[2], triangle[2]) == side;
}

} // namespace

bool segment_meets_triangle(const Vec3& p, const Vec3& q, const Triangle& triangle) noexcept
{
    const int p_side = orient3d(triangle[0], triangle[1], triangle[2], p);
    const int q_side = orient3d(triangle[0], triangle[1], triangle[2], q);
    if (p_side * q_side > 0) return false;
    if (p_side == 0 && q_side == 0) return meet_in_plane(p, q, triangle);
    // The line passes through where it turns one way round all sides.
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
    if (is_apart(a, b) || is_apart(b, a)) return false;
    for (int i = 0; i < 3; ++i) {
        if (segment_meets_triangle(a[i], a[(i + 1) % 3], b)) return true;
        if (segment_meets_triangle(b[i], b[(i + 1) % 3], a)) return true;
    }
    return false;
}

} // namespace proxima
