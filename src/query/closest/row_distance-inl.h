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

#include "base/inline_steps-inl.h"
#include "index/triangle_row.h"
#include "query/closest/feature_distance.h"

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <hwy/highway.h>
#include <limits>

HWY_BEFORE_NAMESPACE();
namespace proxima::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

/// Three lanes or parts of them.
template <class V>
struct Lanes3 {
    V x;
    V y;
    V z;
};

template <class V>
HWY_INLINE V dot(const Lanes3<V>& a, const Lanes3<V>& b)
{
    return hn::Add(hn::Add(hn::Mul(a.x, b.x), hn::Mul(a.y, b.y)), hn::Mul(a.z, b.z));
}

template <class V>
HWY_INLINE Lanes3<V> operator-(const Lanes3<V>& a, const Lanes3<V>& b)
{
    return {hn::Sub(a.x, b.x), hn::Sub(a.y, b.y), hn::Sub(a.z, b.z)};
}

template <class V>
HWY_INLINE Lanes3<V> times(V factor, const Lanes3<V>& a)
{
    return {hn::Mul(factor, a.x), hn::Mul(factor, a.y), hn::Mul(factor, a.z)};
}

template <class V>
HWY_INLINE Lanes3<V> cross(const Lanes3<V>& a, const Lanes3<V>& b)
{
    return {hn::Sub(hn::Mul(a.y, b.z), hn::Mul(a.z, b.y)),
            hn::Sub(hn::Mul(a.z, b.x), hn::Mul(a.x, b.z)),
            hn::Sub(hn::Mul(a.x, b.y), hn::Mul(a.y, b.x))};
}

/// What lane i knows: corner i, the side from it, and the inside as seen from there. Lengths are
/// scaled.
template <class V, class M>
struct RowLanes {
    V corner; ///< squared distance
    V side;   ///< the same, infinite where the foot of the perpendicular is not strictly within
    M within; ///< whether it is
    V along;  ///< where, 0 to 1 from the lower vertex id
    V plane;  ///< squared distance of the plane
    V part;   ///< of the foot in the plane: of the corner across the side, not normalised
};

/// `next` and `last` are the corners after `corner`. Differences of coordinates are scaled before
/// anything else, so that products stay within the doubles for meshes of any size.
template <class Tag, class V, class M>
HWY_INLINE RowLanes<V, M> measure_lanes(Tag tag, const Vec3& p, const RowScale& scale,
                                        const Lanes3<V>& corner, const Lanes3<V>& next,
                                        const Lanes3<V>& last, M backward)
{
    const Lanes3<V> query{hn::Set(tag, p[0]), hn::Set(tag, p[1]), hn::Set(tag, p[2])};
    const auto choose = [&](const V& yes, const V& no) {
        return hn::IfThenElse(backward, yes, no);
    };
    const V up = hn::Set(tag, scale.up);
    const Lanes3<V> q = times(up, query - corner);
    const Lanes3<V> q_next = times(up, query - next);
    const Lanes3<V> e = times(up, next - corner);
    const Lanes3<V> d{choose(q_next.x, q.x), choose(q_next.y, q.y), choose(q_next.z, q.z)};
    const Lanes3<V> side{choose(hn::Neg(e.x), e.x), choose(hn::Neg(e.y), e.y),
                         choose(hn::Neg(e.z), e.z)};
    const V length = dot(side, side);
    const V ahead = dot(d, side);
    const auto within = hn::And(hn::Gt(ahead, hn::Zero(tag)), hn::Lt(ahead, length));
    const V along = hn::Div(ahead, length);
    const Lanes3<V> rest = d - times(along, side);

    const Lanes3<V> normal = cross(e, times(up, last - next));
    const V height = dot(normal, q);
    const V plane = hn::Div(hn::Mul(height, height), dot(normal, normal));
    return {dot(q, q),
            hn::IfThenElse(within, dot(rest, rest),
                           hn::Set(tag, std::numeric_limits<double>::infinity())),
            within,
            along,
            plane,
            dot(normal, cross(e, q))};
}

inline constexpr double edge_feature = 4294967296.0; // FeatureKind::edge << 32
inline constexpr double face_feature = 2 * edge_feature;
inline constexpr double no_feature = 8 * edge_feature;

#if HWY_TARGET <= HWY_AVX2 && HWY_ARCH_X86

/// All but the inside of thin triangles. Lanes 0 to 3 are corners 0, 1, 2, 0.
template <class Scalar>
HWY_INLINE void measure_row(const TriangleRow<Scalar>& row, const Vec3& p, const RowScale& scale,
                            RowDistance& found)
{
    using Tag = hn::CappedTag<double, 4>;
    const Tag tag;
    const hn::RebindToSigned<Tag> whole;
    using V = hn::Vec<Tag>;
    const auto lookup = [&](std::int64_t a, std::int64_t b, std::int64_t c, std::int64_t d) {
        alignas(32) const std::int64_t lanes[4] = {a, b, c, d};
        return hn::SetTableIndices(tag, lanes);
    };
    const auto same_lanes = lookup(0, 1, 2, 0);
    const auto next_lanes = lookup(1, 2, 0, 1);
    const auto last_lanes = lookup(2, 0, 1, 2);
    alignas(32) static constexpr std::int64_t bits[4] = {
        TriangleRow<Scalar>::side_bit, TriangleRow<Scalar>::side_bit << 1U,
        TriangleRow<Scalar>::side_bit << 2U, TriangleRow<Scalar>::side_bit};
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
    const Lanes3<V> read{load(0), load(1), load(2)};
    const auto permuted = [&](const auto& lanes) {
        return Lanes3<V>{hn::TableLookupLanes(read.x, lanes), hn::TableLookupLanes(read.y, lanes),
                         hn::TableLookupLanes(read.z, lanes)};
    };
    const auto lanes = measure_lanes(tag, p, scale, permuted(same_lanes), permuted(next_lanes),
                                     permuted(last_lanes), backward);
    hn::StoreU(lanes.along, tag, found.along);
    hn::StoreU(lanes.part, tag, found.parts);
    const auto inside = hn::Gt(hn::MinOfLanes(tag, lanes.part), hn::Zero(tag));
    const V infinite = hn::Set(tag, std::numeric_limits<double>::infinity());
    const V no_less = hn::Set(tag, row.thin() ? std::numeric_limits<double>::infinity() : 0.0);
    const V face = hn::Max(hn::IfThenElse(inside, lanes.plane, infinite), no_less);
    const V least = hn::MinOfLanes(tag, hn::Min(hn::Min(lanes.corner, lanes.side), face));
    // Names as doubles: exact, and numbers that lanes can compare. Ids are below 2^31. Edges are
    // read with the vertex before them, again to stay in the row.
    const hn::Rebind<std::int32_t, Tag> ids;
    static_assert(offsetof(TriangleRow<Scalar>, edges) ==
                  offsetof(TriangleRow<Scalar>, vertices) + 3 * sizeof(std::uint32_t));
    const auto names_at = [&](std::size_t bytes) {
        std::int32_t four[4];
        std::memcpy(four, reinterpret_cast<const std::byte*>(&row) + bytes, sizeof(four));
        return hn::PromoteTo(tag, hn::LoadU(ids, four));
    };
    constexpr std::size_t vertices = offsetof(TriangleRow<Scalar>, vertices);
    const V none = hn::Set(tag, no_feature);
    const V vertex_names = hn::IfThenElse(
        hn::Eq(lanes.corner, least), hn::TableLookupLanes(names_at(vertices), same_lanes), none);
    const V edges = hn::Add(
        hn::TableLookupLanes(names_at(vertices + 2 * sizeof(std::uint32_t)), lookup(1, 2, 3, 1)),
        hn::Set(tag, edge_feature));
    const V edge_names =
        hn::IfThenElse(hn::And(lanes.within, hn::Eq(lanes.side, least)), edges, none);
    const V face_name = hn::Set(tag, face_feature + row.triangle_id());
    found.squared = hn::GetLane(least);
    found.feature = static_cast<std::uint64_t>(
        hn::GetLane(hn::Min(face_name, hn::MinOfLanes(tag, hn::Min(vertex_names, edge_names)))));
}

#else

template <class Scalar>
HWY_INLINE void measure_row(const TriangleRow<Scalar>& row, const Vec3& p, const RowScale& scale,
                            RowDistance& found)
{
    using Tag = hn::CappedTag<double, 1>;
    const Tag tag;
    using V = hn::Vec<Tag>;
    const auto corner = [&](std::size_t i) {
        const auto set = [&](std::size_t axis) {
            return hn::Set(tag, static_cast<double>(row.coordinates[axis][i]));
        };
        return Lanes3<V>{set(0), set(1), set(2)};
    };
    double feature = no_feature;
    found.squared = std::numeric_limits<double>::infinity();
    const auto offer = [&](double squared, double name) {
        if (squared > found.squared || (squared == found.squared && name >= feature)) return;
        found.squared = squared;
        feature = name;
    };
    double plane = std::numeric_limits<double>::infinity();
    double least_part = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < 3; ++i) {
        const std::size_t next = i == 2 ? 0 : i + 1;
        const std::size_t last = next == 2 ? 0 : next + 1;
        const auto backward = hn::MaskFromVec(
            hn::Set(tag, row.backward(i) ? std::bit_cast<double>(~std::uint64_t{0}) : 0.0));
        const auto lane =
            measure_lanes(tag, p, scale, corner(i), corner(next), corner(last), backward);
        found.along[i] = hn::GetLane(lane.along);
        found.parts[i] = hn::GetLane(lane.part);
        plane = HWY_MIN(plane, hn::GetLane(lane.plane));
        least_part = HWY_MIN(least_part, found.parts[i]);
        offer(hn::GetLane(lane.corner), row.vertices[i]);
        if (hn::CountTrue(tag, lane.within) != 0)
            offer(hn::GetLane(lane.side), edge_feature + row.edges[i]);
    }
    if (least_part > 0 && !row.thin()) offer(plane, face_feature + row.triangle_id());
    found.feature = static_cast<std::uint64_t>(feature);
}

#endif

/// The inside of a triangle so thin that products of its sides say too little.
template <class Scalar>
HWY_NOINLINE void measure_thin_inside(const TriangleRow<Scalar>& row, const Vec3& p,
                                      const RowScale& scale, RowDistance& found)
{
    constexpr auto face = static_cast<std::uint64_t>(face_feature);
    const ThinInside inside = inside_of_thin(row.corners(), p, scale);
    if (!(inside.squared < found.squared)) return;
    found.squared = inside.squared;
    found.feature = face | row.triangle_id();
    for (std::size_t i = 0; i < 3; ++i) found.parts[i] = inside.weights[i == 2 ? 1 : 2 - 2 * i];
}

/// The closest feature of one triangle, its distance scaled: within a few roundings of the largest
/// difference of coordinates, for triangles of any shape.
template <class Scalar>
PROXIMA_STEP RowDistance closest_of_row(const TriangleRow<Scalar>& row, std::uint32_t rank,
                                        const Vec3& p, const RowScale& scale)
{
    RowDistance found;
    found.rank = rank;
    measure_row(row, p, scale, found);
    if (row.thin()) [[unlikely]]
        measure_thin_inside(row, p, scale, found);
    return found;
}

} // namespace proxima::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
