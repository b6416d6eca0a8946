// The closest feature of one triangle, in doubles. Included once per target.
//
// The three corners are lanes, and so are the three sides. A side is looked at from its vertex with
// the lower id, so that both its triangles see the same numbers: a vertex's and an edge's distance
// has the same bits from every triangle that has it. No multiply-add: the same bits everywhere.

#if defined(PROXIMA_PROXIMITY_ROW_DISTANCE_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef PROXIMA_PROXIMITY_ROW_DISTANCE_INL_H
#undef PROXIMA_PROXIMITY_ROW_DISTANCE_INL_H
#else
#define PROXIMA_PROXIMITY_ROW_DISTANCE_INL_H
#endif

#include "proxima/geometry/closest_point.h"
#include "proxima/proximity/triangle_row.h"

#include <bit>
#include <cstddef>
#include <cstdint>
#include <hwy/highway.h>
#include <limits>

HWY_BEFORE_NAMESPACE();
namespace proxima::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

/// Squared distances to corners and sides; of a side infinite unless the foot of the perpendicular
/// is strictly within.
struct RimDistances {
    alignas(64) double corners[4];
    alignas(64) double sides[4];
    alignas(64) double along[4]; ///< of the foot, 0 to 1 from the lower vertex
};

/// Three lanes or parts of them.
template <class V>
struct Lanes3 {
    V x;
    V y;
    V z;
};

template <class V>
HWY_INLINE V squares(const Lanes3<V>& a)
{
    return hn::Add(hn::Add(hn::Mul(a.x, a.x), hn::Mul(a.y, a.y)), hn::Mul(a.z, a.z));
}

/// Distances for the lanes from `first` on: corners, and sides from `from` to `to`.
template <class Tag, class V>
HWY_INLINE void measure_lanes(Tag tag, const Vec3& p, const Lanes3<V>& corner,
                              const Lanes3<V>& from, const Lanes3<V>& to, std::size_t first,
                              RimDistances& rim)
{
    const Lanes3<V> query{hn::Set(tag, p[0]), hn::Set(tag, p[1]), hn::Set(tag, p[2])};
    const auto less = [](const Lanes3<V>& a, const Lanes3<V>& b) {
        return Lanes3<V>{hn::Sub(a.x, b.x), hn::Sub(a.y, b.y), hn::Sub(a.z, b.z)};
    };
    hn::Store(squares(less(query, corner)), tag, rim.corners + first);
    const Lanes3<V> d = less(query, from);
    const Lanes3<V> side = less(to, from);
    const V length = squares(side);
    const V part =
        hn::Add(hn::Add(hn::Mul(d.x, side.x), hn::Mul(d.y, side.y)), hn::Mul(d.z, side.z));
    const auto within = hn::And(hn::Gt(part, hn::Zero(tag)), hn::Lt(part, length));
    const V t = hn::Div(part, length);
    const V foot = squares(less(d, {hn::Mul(t, side.x), hn::Mul(t, side.y), hn::Mul(t, side.z)}));
    const V infinite = hn::Set(tag, std::numeric_limits<double>::infinity());
    hn::Store(hn::IfThenElse(within, foot, infinite), tag, rim.sides + first);
    hn::Store(t, tag, rim.along + first);
}

/// Lanes 0 to 3 are corners 0, 1, 2, 0 and the sides from them.
template <class Scalar>
HWY_INLINE void measure_rim(const TriangleRow<Scalar>& row, const Vec3& p, RimDistances& rim)
{
#if HWY_TARGET <= HWY_AVX2 && HWY_ARCH_X86
    using Tag = hn::CappedTag<double, 4>;
    const Tag tag;
    const hn::RebindToSigned<Tag> whole;
    using V = hn::Vec<Tag>;
    alignas(32) static constexpr std::int64_t same[4] = {0, 1, 2, 0};
    alignas(32) static constexpr std::int64_t next[4] = {1, 2, 0, 1};
    alignas(32) static constexpr std::int64_t bits[4] = {
        TriangleRow<Scalar>::side_bit, TriangleRow<Scalar>::side_bit << 1U,
        TriangleRow<Scalar>::side_bit << 2U, TriangleRow<Scalar>::side_bit};
    const auto same_lanes = hn::SetTableIndices(tag, same);
    const auto next_lanes = hn::SetTableIndices(tag, next);
    const auto backward = hn::MaskFromVec(hn::BitCast(
        tag, hn::VecFromMask(whole, hn::TestBit(hn::Set(whole, std::int64_t{row.triangle}),
                                                hn::Load(whole, bits)))));
    // Four numbers are read: what follows the third stays within the row and is not used.
    const auto load = [&](std::size_t axis) -> V {
        if constexpr (sizeof(Scalar) == 4) {
            const hn::Rebind<float, Tag> narrow;
            return hn::PromoteTo(tag, hn::LoadU(narrow, row.coordinates[axis]));
        } else
            return hn::LoadU(tag, row.coordinates[axis]);
    };
    Lanes3<V> corner;
    Lanes3<V> from;
    Lanes3<V> to;
    const auto set = [&](std::size_t axis, V& c, V& f, V& t) {
        const V read = load(axis);
        c = hn::TableLookupLanes(read, same_lanes);
        const V other = hn::TableLookupLanes(read, next_lanes);
        f = hn::IfThenElse(backward, other, c);
        t = hn::IfThenElse(backward, c, other);
    };
    set(0, corner.x, from.x, to.x);
    set(1, corner.y, from.y, to.y);
    set(2, corner.z, from.z, to.z);
    measure_lanes(tag, p, corner, from, to, 0, rim);
#else
    using Tag = hn::CappedTag<double, 1>;
    const Tag tag;
    using V = hn::Vec<Tag>;
    for (std::size_t i = 0; i < 3; ++i) {
        const std::size_t k = i == 2 ? 0 : i + 1;
        const auto at = [&](std::size_t c) {
            const auto set = [&](std::size_t axis) {
                return hn::Set(tag, static_cast<double>(row.coordinates[axis][c]));
            };
            return Lanes3<V>{set(0), set(1), set(2)};
        };
        const bool backward = row.backward(i);
        measure_lanes(tag, p, at(i), at(backward ? k : i), at(backward ? i : k), i, rim);
    }
#endif
}

/// A power of two that brings coordinates' differences to about 1, so that their fourth powers do
/// not leave the doubles, and its inverse.
struct RowScale {
    double up = 1;
    double down = 1;
};

/// The inside, infinite unless the foot of the perpendicular is strictly within.
struct InsideDistance {
    double squared = std::numeric_limits<double>::infinity();
    double v = 0;
    double w = 0;
};

template <class Scalar>
HWY_INLINE InsideDistance measure_inside(const TriangleRow<Scalar>& row, const Vec3& p,
                                         const RowScale& scale)
{
    InsideDistance inside;
    if (row.thin()) [[unlikely]] {
        const TrianglePoint found =
            closest_point(Triangle{{row.corner(0), row.corner(1), row.corner(2)}}, p);
        if (found.part != TrianglePart::inside) return inside;
        return {(p - found.point).squaredNorm(), found.weights[1], found.weights[2]};
    }
    double ab[3];
    double ac[3];
    double rest[3];
    for (int axis = 0; axis < 3; ++axis) {
        const auto a = static_cast<double>(row.coordinates[axis][0]);
        ab[axis] = (static_cast<double>(row.coordinates[axis][1]) - a) * scale.up;
        ac[axis] = (static_cast<double>(row.coordinates[axis][2]) - a) * scale.up;
        rest[axis] = (p[axis] - a) * scale.up;
    }
    const auto dot = [](const double* a, const double* b) {
        return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    };
    const double bb = dot(ab, ab);
    const double bc = dot(ab, ac);
    const double cc = dot(ac, ac);
    const double inverse = 1 / (bb * cc - bc * bc);
    double v = 0;
    double w = 0;
    // Twice: the first try may be off by the square of the condition, the second mends that.
    for (int again = 0; again < 2; ++again) {
        const double pb = dot(rest, ab);
        const double pc = dot(rest, ac);
        const double dv = (cc * pb - bc * pc) * inverse;
        const double dw = (bb * pc - bc * pb) * inverse;
        v += dv;
        w += dw;
        for (int axis = 0; axis < 3; ++axis)
            rest[axis] = rest[axis] - dv * ab[axis] - dw * ac[axis];
    }
    for (double& component : rest) component *= scale.down;
    if (v > 0 && w > 0 && v + w < 1) inside = {dot(rest, rest), v, w};
    return inside;
}

/// The closest feature of one triangle: within a few roundings of the largest difference of
/// coordinates, for triangles of any shape.
template <class Scalar>
HWY_INLINE FeatureDistance closest_of_row(const TriangleRow<Scalar>& row, std::uint32_t rank,
                                          const Vec3& p, const RowScale& scale)
{
    RimDistances rim;
    measure_rim(row, p, rim);
    const InsideDistance inside = measure_inside(row, p, scale);
    const double corner = HWY_MIN(HWY_MIN(rim.corners[0], rim.corners[1]), rim.corners[2]);
    const double side = HWY_MIN(HWY_MIN(rim.sides[0], rim.sides[1]), rim.sides[2]);
    const double least = HWY_MIN(HWY_MIN(corner, side), inside.squared);
    FeatureDistance found;
    found.squared = least;
    found.rank = rank;
    if (inside.squared == least && side != least && corner != least) {
        found.feature = {FeatureKind::face, row.triangle_id()};
        found.weights = {1 - inside.v - inside.w, inside.v, inside.w};
        return found;
    }
    // Of equal ones the lowest id.
    const bool is_corner = corner == least;
    const double* const squared = is_corner ? rim.corners : rim.sides;
    const std::uint32_t* const ids = is_corner ? row.vertices : row.edges;
    std::size_t best = 3;
    for (std::size_t i = 0; i < 3; ++i)
        if (squared[i] == least && (best == 3 || ids[i] < ids[best])) best = i;
    if (is_corner) {
        found.feature = {FeatureKind::vertex, ids[best]};
        found.weights[best] = 1;
        return found;
    }
    found.feature = {FeatureKind::edge, ids[best]};
    const std::size_t next = best == 2 ? 0 : best + 1;
    const bool forward = !row.backward(best);
    found.weights[forward ? best : next] = 1 - rim.along[best];
    found.weights[forward ? next : best] = rim.along[best];
    return found;
}

} // namespace proxima::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
