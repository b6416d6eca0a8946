#include "index/crossings.h"

#include "geometry/exact_predicates.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace proxima {

namespace {

/// On which side of the line from a to b the point is, seen along x, after a shift to larger y and
/// a much smaller one to larger z: never on it, unless a and b are one.
int side_of_shifted(const Vec3& a, const Vec3& b, const Vec3& point) noexcept
{
    const int side = orient2d({a.y(), a.z()}, {b.y(), b.z()}, {point.y(), point.z()});
    if (side != 0) return side;
    if (a.z() != b.z()) return a.z() > b.z() ? 1 : -1;
    return a.y() == b.y() ? 0 : a.y() < b.y() ? 1 : -1;
}

} // namespace

int crossing_ahead(const Triangle& t, const Vec3& point) noexcept
{
    for (const int axis : {1, 2}) {
        const auto [low, high] = std::minmax({t[0][axis], t[1][axis], t[2][axis]});
        if (point[axis] < low || point[axis] > high) return 0;
    }
    const int turn = side_of_shifted(t[0], t[1], point);
    if (turn == 0 || side_of_shifted(t[1], t[2], point) != turn ||
        side_of_shifted(t[2], t[0], point) != turn)
        return 0;
    return orient3d(t[0], t[1], t[2], point) * turn < 0 ? turn : 0;
}

RigidTransform turn_to_x(int axis) noexcept
{
    RigidTransform turn;
    turn.rotation.setZero();
    for (int i = 0; i < 3; ++i) turn.rotation(i, (i + axis) % 3) = 1;
    return turn;
}

RayAlongX::RayAlongX(const IndexParts& index, const Box& bounds, const RigidTransform& pose,
                     const Vec3& point) noexcept
    : turn_(pose.rotation * index.unscale()), from_point_(pose(index.center()) - point)
{
    // The center, corners as the pose rounds them, and what is computed here: each is a sum of
    // a few products no larger than this, and off by less than eight roundings of it. Boxes
    // hold the mesh's own corners, except in meshes beyond the largest scale of a frame.
    const double size =
        3 * std::max(bounds.lower.cwiseAbs().maxCoeff(), bounds.upper.cwiseAbs().maxCoeff()) *
            pose.rotation.cwiseAbs().maxCoeff() +
        pose.translation.cwiseAbs().maxCoeff() + point.cwiseAbs().maxCoeff();
    slack_ = size < 0x1p999 ? 0x1p-44 * size + 8 * std::numeric_limits<double>::min()
                            : std::numeric_limits<double>::infinity();
}

} // namespace proxima
