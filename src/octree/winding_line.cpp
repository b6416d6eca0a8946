#include "octree/winding_line.h"

#include "geometry/exact_predicates.h"

#include <algorithm>

namespace proxima {

namespace {

constexpr int up = 2; // the axis of lines

int sign_of(double a, double b) noexcept
{
    return a < b ? -1 : a > b ? 1 : 0;
}

Vec2 flat(const Vec3& point, int first, int second) noexcept
{
    return {point[first], point[second]};
}

/// On which side of the edge from a to b the line passes, seen from above; 0 only where the edge
/// is vertical.
int side_of_edge(const Vec3& a, const Vec3& b, const Vec2& line) noexcept
{
    const int side = orient2d(flat(a, 0, 1), flat(b, 0, 1), line);
    if (side != 0) return side;
    const int along_x = sign_of(a[1], b[1]);
    return along_x != 0 ? along_x : sign_of(b[0], a[0]);
}

/// 1 where a triangle that the line crosses is counter-clockwise from above, -1 where it is
/// clockwise, 0 where the line passes it by.
int turn_around_line(const Triangle& triangle, const Vec2& line) noexcept
{
    int sum = 0;
    for (std::size_t k = 0; k < 3; ++k) {
        sum += side_of_edge(triangle.vertices[k], triangle.vertices[(k + 1) % 3], line);
    }
    return sum == 3 ? 1 : sum == -3 ? -1 : 0;
}

/// On which side of a triangle's plane the line is at height z: 1 in front, -1 behind.
/// \pre the line crosses the triangle
int side_of_plane(const Triangle& triangle, int turn, const Vec2& line, double z) noexcept
{
    const int side = orient3d(triangle[0], triangle[1], triangle[2], Vec3(line[0], line[1], z));
    if (side != 0) return side;
    // Off the plane by the step along x, else by that along y, else by one upwards.
    for (int axis = 0; axis < 2; ++axis) {
        const int u = (axis + 1) % 3;
        const int v = (axis + 2) % 3;
        const int normal =
            orient2d(flat(triangle[0], u, v), flat(triangle[1], u, v), flat(triangle[2], u, v));
        if (normal != 0) return normal;
    }
    return turn;
}

/// +1 or -1 where the line crosses the triangle between the two heights, and outwards or inwards.
int crossing(const Triangle& triangle, const Vec2& line, double low, double high) noexcept
{
    for (int axis = 0; axis < 2; ++axis) {
        const double first = triangle[0][axis];
        const double second = triangle[1][axis];
        const double third = triangle[2][axis];
        if (std::max({first, second, third}) < line[axis] ||
            std::min({first, second, third}) > line[axis]) {
            return 0;
        }
    }
    const int turn = turn_around_line(triangle, line);
    if (turn == 0) return 0;
    const int before = side_of_plane(triangle, turn, line, low);
    const int after = side_of_plane(triangle, turn, line, high);
    return before == after ? 0 : after;
}

} // namespace

WindingLine winding_line(const OctreeFrame& frame, int max_depth, CellKey cell) noexcept
{
    const auto shift = static_cast<unsigned>(max_depth - depth(cell));
    const std::uint32_t half = (1U << shift) / 2;
    const std::array<std::uint32_t, 3> at = cell_coordinates(cell);
    WindingLine line;
    for (std::size_t axis = 0; axis < 2; ++axis) {
        line.column[axis] = (at[axis] << shift) + half;
    }
    line.first_plane = (at[up] + 1) << shift;
    line.x = frame.plane(0, line.column[0], max_depth);
    line.y = frame.plane(1, line.column[1], max_depth);
    return line;
}

std::int64_t count_crossings(const Octree& octree, const TriangleMesh& mesh,
                             const WindingLine& line) noexcept
{
    const int deepest = octree.parameters().max_depth;
    const Vec2 at(line.x, line.y);
    std::int64_t sum = 0;
    for (std::uint32_t plane = line.first_plane; plane < 1U << static_cast<unsigned>(deepest);) {
        Cell cell = octree.root();
        auto down = static_cast<unsigned>(deepest);
        while (!octree.is_leaf(cell)) {
            --down;
            const std::uint32_t octant = (line.column[0] >> down & 1U) |
                                         (line.column[1] >> down & 1U) << 1U |
                                         (plane >> down & 1U) << 2U;
            cell = octree.child(cell, static_cast<int>(octant));
        }
        const std::uint32_t end = ((plane >> down) + 1) << down;
        const double low = octree.frame().plane(up, plane, deepest);
        const double high = octree.frame().plane(up, end, deepest);
        for (const TriangleId id : octree.triangles(cell)) {
            sum += crossing(mesh.triangle(id), at, low, high);
        }
        plane = end;
    }
    return sum;
}

std::int64_t count_crossings(const OctreeFrame& frame, int max_depth, const TriangleMesh& mesh,
                             const WindingLine& line) noexcept
{
    const double low = frame.plane(up, line.first_plane, max_depth);
    const double high = frame.plane(up, 1U << static_cast<unsigned>(max_depth), max_depth);
    std::int64_t sum = 0;
    for (std::uint32_t i = 0; i < mesh.triangle_count(); ++i) {
        sum += crossing(mesh.triangle(TriangleId{i}), {line.x, line.y}, low, high);
    }
    return sum;
}

} // namespace proxima
