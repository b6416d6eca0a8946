#include "index/triangle_lanes.h"

#include <algorithm>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "index/triangle_lanes.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace proxima::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using Lanes = hn::CappedTag<double, 8>;
using Doubles = hn::Vec<Lanes>;

/// Coordinates of eight corners, by axis.
using CornerLanes = double[3][8];

struct TriangleVectors {
    Doubles x, y, z;
};

HWY_INLINE Doubles dot(const TriangleVectors& a, const TriangleVectors& b)
{
    return hn::Add(hn::Add(hn::Mul(a.x, b.x), hn::Mul(a.y, b.y)), hn::Mul(a.z, b.z));
}

HWY_INLINE TriangleVectors difference(const TriangleVectors& a, const TriangleVectors& b)
{
    return {hn::Sub(a.x, b.x), hn::Sub(a.y, b.y), hn::Sub(a.z, b.z)};
}

/// Squared distance from the origin to the segment from a, along u. A point where u is zero.
HWY_INLINE Doubles side_distance(const TriangleVectors& a, const TriangleVectors& u)
{
    const Lanes d;
    const auto zero = hn::Zero(d);
    const auto one = hn::Set(d, 1.0);
    const auto length = dot(u, u);
    const auto along = hn::Neg(dot(a, u));
    const auto part = hn::Div(along, hn::Max(length, hn::Set(d, 1e-300)));
    const auto t = hn::Min(hn::Max(part, zero), one);
    const TriangleVectors at = {hn::Add(a.x, hn::Mul(t, u.x)), hn::Add(a.y, hn::Mul(t, u.y)),
                                hn::Add(a.z, hn::Mul(t, u.z))};
    return dot(at, at);
}

/// Squared distances from the origin, corners given relative to p.
HWY_INLINE Doubles corner_distances(const TriangleVectors& a, const TriangleVectors& b,
                                    const TriangleVectors& c)
{
    const Lanes d;
    const auto zero = hn::Zero(d);
    const TriangleVectors u = difference(b, a);
    const TriangleVectors w = difference(c, a);
    const TriangleVectors v = difference(c, b);
    const auto sides =
        hn::Min(side_distance(a, u), hn::Min(side_distance(a, w), side_distance(b, v)));

    const TriangleVectors n = {hn::Sub(hn::Mul(u.y, w.z), hn::Mul(u.z, w.y)),
                               hn::Sub(hn::Mul(u.z, w.x), hn::Mul(u.x, w.z)),
                               hn::Sub(hn::Mul(u.x, w.y), hn::Mul(u.y, w.x))};
    const auto nn = dot(n, n);
    const auto uu = dot(u, u);
    const auto ww = dot(w, w);
    const auto uw = dot(u, w);
    const auto au = dot(a, u);
    const auto aw = dot(a, w);
    // The foot is a + (at_b u + at_c w) / nn.
    const auto at_b = hn::Sub(hn::Mul(uw, aw), hn::Mul(ww, au));
    const auto at_c = hn::Sub(hn::Mul(uw, au), hn::Mul(uu, aw));
    const auto inside =
        hn::And(hn::And(hn::Ge(at_b, zero), hn::Ge(at_c, zero)), hn::Le(hn::Add(at_b, at_c), nn));
    const auto height = dot(n, a);
    const auto plane = hn::Div(hn::Mul(height, height), hn::Max(nn, hn::Set(d, 1e-300)));
    // At corners below two degrees the normal is not to be trusted.
    const auto sliver = hn::Lt(nn, hn::Mul(hn::Mul(uu, ww), hn::Set(d, 0x1p-10)));
    return hn::IfThenElse(sliver, zero, hn::IfThenElse(inside, plane, sides));
}

HWY_INLINE TriangleVectors load_corner(const CornerLanes& corner, const Vec3& p, double scale,
                                       std::size_t lane)
{
    const Lanes d;
    const auto unit = hn::Set(d, scale);
    return {hn::Mul(hn::Sub(hn::Load(d, corner[0] + lane), hn::Set(d, p.x())), unit),
            hn::Mul(hn::Sub(hn::Load(d, corner[1] + lane), hn::Set(d, p.y())), unit),
            hn::Mul(hn::Sub(hn::Load(d, corner[2] + lane), hn::Set(d, p.z())), unit)};
}

void triangle_distances(const CornerLanes (&corners)[3], const Vec3& p, double scale,
                        double* squared)
{
    const Lanes d;
    for (std::size_t lane = 0; lane < 8; lane += hn::Lanes(d)) {
        const TriangleVectors a = load_corner(corners[0], p, scale, lane);
        const TriangleVectors b = load_corner(corners[1], p, scale, lane);
        const TriangleVectors c = load_corner(corners[2], p, scale, lane);
        hn::StoreU(corner_distances(a, b, c), d, squared + lane);
    }
}

} // namespace proxima::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace proxima {

HWY_EXPORT(triangle_distances);

void triangle_distances(const TriangleMesh& mesh, std::span<const TriangleId> ids, const Vec3& p,
                        double scale, std::array<double, 8>& squared) noexcept
{
    alignas(64) double corners[3][3][8];
    for (std::size_t lane = 0; lane < 8; ++lane) {
        const std::size_t item = std::min(lane, ids.size() - 1);
        const TriangleCorners& triangle = mesh.triangles()[to_index(ids[item])];
        for (std::size_t corner = 0; corner < 3; ++corner) {
            const Vec3& position = mesh.positions()[triangle[corner]];
            corners[corner][0][lane] = position.x();
            corners[corner][1][lane] = position.y();
            corners[corner][2][lane] = position.z();
        }
    }
    HWY_DYNAMIC_DISPATCH(triangle_distances)(corners, p, scale, squared.data());
}

namespace {

template <class Scalar>
void distances_of_rows(std::span<const TriangleRow<Scalar>> rows, const Vec3& p, double scale,
                       std::array<double, 8>& squared)
{
    alignas(64) double corners[3][3][8];
    for (std::size_t lane = 0; lane < 8; ++lane) {
        const TriangleRow<Scalar>& row = rows[std::min(lane, rows.size() - 1)];
        for (std::size_t corner = 0; corner < 3; ++corner) {
            for (std::size_t axis = 0; axis < 3; ++axis)
                corners[corner][axis][lane] = static_cast<double>(row.coordinates[axis][corner]);
        }
    }
    HWY_DYNAMIC_DISPATCH(triangle_distances)(corners, p, scale, squared.data());
}

} // namespace

void triangle_distances(std::span<const TriangleRow<float>> rows, const Vec3& p, double scale,
                        std::array<double, 8>& squared) noexcept
{
    distances_of_rows(rows, p, scale, squared);
}

void triangle_distances(std::span<const TriangleRow<double>> rows, const Vec3& p, double scale,
                        std::array<double, 8>& squared) noexcept
{
    distances_of_rows(rows, p, scale, squared);
}

} // namespace proxima

#endif
