// How far triangles of two leaves are from each other at least and at most, eight pairs at a time.
// Included once per target, after <hwy/highway.h>. No multiply-add: the same bits on every
// instruction set.
//
//     at most     the distance of any two points: of nine pairs of sides, the nearest; of six
//                 corners and the other triangle, where the foot is on its inside
//     at least    the gap along any direction: between the nearest of these points, and along both
//                 normals
//
// So rounding of points and directions makes bounds wider, never wrong.

#if defined(PROXIMA_QUERY_TRIANGLE_BOUNDS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef PROXIMA_QUERY_TRIANGLE_BOUNDS_INL_H
#undef PROXIMA_QUERY_TRIANGLE_BOUNDS_INL_H
#else
#define PROXIMA_QUERY_TRIANGLE_BOUNDS_INL_H
#endif

#include "query/distance/leaf_points-inl.h"

#include <limits>

HWY_BEFORE_NAMESPACE();
namespace proxima::HWY_NAMESPACE {

template <class T>
HWY_INLINE VectorLanes<T> operator-(const VectorLanes<T>& a, const VectorLanes<T>& b)
{
    return {hn::Sub(a.x, b.x), hn::Sub(a.y, b.y), hn::Sub(a.z, b.z)};
}
template <class T>
HWY_INLINE VectorLanes<T> operator+(const VectorLanes<T>& a, const VectorLanes<T>& b)
{
    return {hn::Add(a.x, b.x), hn::Add(a.y, b.y), hn::Add(a.z, b.z)};
}
template <class T>
HWY_INLINE VectorLanes<T> scaled(const VectorLanes<T>& a, hn::Vec<PairTag<T>> s)
{
    return {hn::Mul(s, a.x), hn::Mul(s, a.y), hn::Mul(s, a.z)};
}
template <class T>
HWY_INLINE hn::Vec<PairTag<T>> dot(const VectorLanes<T>& a, const VectorLanes<T>& b)
{
    return hn::Add(hn::Add(hn::Mul(a.x, b.x), hn::Mul(a.y, b.y)), hn::Mul(a.z, b.z));
}
template <class T>
HWY_INLINE VectorLanes<T> cross(const VectorLanes<T>& a, const VectorLanes<T>& b)
{
    const auto minor = [](auto p, auto q, auto r, auto s)
                           HWY_ATTR { return hn::Sub(hn::Mul(p, q), hn::Mul(r, s)); };
    return {minor(a.y, b.z, a.z, b.y), minor(a.z, b.x, a.x, b.z), minor(a.x, b.y, a.y, b.x)};
}

/// 1 / x, or 0 for next to nothing.
template <class T>
HWY_INLINE hn::Vec<PairTag<T>> inverse_or_zero(hn::Vec<PairTag<T>> x)
{
    const PairTag<T> d;
    const auto is_some = hn::Gt(x, hn::Set(d, T{0x1p-100}));
    return hn::IfThenElseZero(is_some, hn::Div(hn::Set(d, T{1}), x));
}

template <class T>
HWY_INLINE hn::Vec<PairTag<T>> clamped(hn::Vec<PairTag<T>> t)
{
    const PairTag<T> d;
    return hn::Min(hn::Max(t, hn::Zero(d)), hn::Set(d, T{1}));
}

/// A triangle's sides and what is computed of them once.
template <class T>
struct SideLanes {
    VectorLanes<T> side[3]; ///< from corner i to i + 1 mod 3
    hn::Vec<PairTag<T>> squared[3];
    hn::Vec<PairTag<T>> inverse[3]; ///< 1 / squared, or 0
    VectorLanes<T> normal;
    hn::Vec<PairTag<T>> inverse_area; ///< 1 / normal . normal, or 0

    HWY_INLINE explicit SideLanes(const TriangleLanes<T>& triangle)
    {
        for (std::size_t i = 0; i < 3; ++i) {
            side[i] = triangle.corner[(i + 1) % 3] - triangle.corner[i];
            squared[i] = dot(side[i], side[i]);
            inverse[i] = inverse_or_zero<T>(squared[i]);
        }
        normal = cross(side[0], side[1]);
        inverse_area = inverse_or_zero<T>(dot(normal, normal));
    }
};

/// The difference, from the first to the second, of the closest points of two sides from p along u
/// and from q along w, r = q - p.
template <class T>
PROXIMA_STEP VectorLanes<T> between_sides(const VectorLanes<T>& r, const SideLanes<T>& first,
                                          std::size_t i, const SideLanes<T>& second, std::size_t k)
{
    const VectorLanes<T>& u = first.side[i];
    const VectorLanes<T>& w = second.side[k];
    const auto uw = dot(u, w);
    const auto ur = dot(u, r);
    const auto wr = dot(w, r);
    const auto across = hn::Sub(hn::Mul(first.squared[i], second.squared[k]), hn::Mul(uw, uw));
    // On u as if both were lines, then the closest on w, then the closest to that on u.
    const auto on_line = hn::Sub(hn::Mul(ur, second.squared[k]), hn::Mul(uw, wr));
    const auto start = clamped<T>(hn::Mul(on_line, inverse_or_zero<T>(across)));
    const auto t = clamped<T>(hn::Mul(hn::Sub(hn::Mul(uw, start), wr), second.inverse[k]));
    const auto s = clamped<T>(hn::Mul(hn::Add(hn::Mul(uw, t), ur), first.inverse[i]));
    return r + scaled(w, t) - scaled(u, s);
}

/// The difference from a point of the triangle, the foot of p or a point of its sides, to p; r = p
/// - corner 0.
template <class T>
PROXIMA_STEP VectorLanes<T> from_inside(const VectorLanes<T>& r, const SideLanes<T>& sides)
{
    const PairTag<T> d;
    // r = s (v1 - v0) + t (v2 - v0) + n: by cross products with the normal.
    const VectorLanes<T>& u = sides.side[0];
    const VectorLanes<T> w = {hn::Neg(sides.side[2].x), hn::Neg(sides.side[2].y),
                              hn::Neg(sides.side[2].z)};
    const auto s = clamped<T>(hn::Mul(dot(cross(r, w), sides.normal), sides.inverse_area));
    const auto rest = hn::Sub(hn::Set(d, T{1}), s);
    const auto t =
        hn::Min(clamped<T>(hn::Mul(dot(cross(u, r), sides.normal), sides.inverse_area)), rest);
    return r - scaled(u, s) - scaled(w, t);
}

/// The gap along n, from all of A's corners to all of B's as seen from A's first one. None if n is
/// next to nothing.
template <class T>
PROXIMA_STEP hn::Vec<PairTag<T>> gap_along(const VectorLanes<T>& n, const TriangleLanes<T>& a,
                                           const TriangleLanes<T>& b)
{
    const PairTag<T> d;
    const auto on_a1 = dot(n, a.corner[1] - a.corner[0]);
    const auto on_a2 = dot(n, a.corner[2] - a.corner[0]);
    const auto on_b0 = dot(n, b.corner[0] - a.corner[0]);
    const auto on_b1 = dot(n, b.corner[1] - a.corner[0]);
    const auto on_b2 = dot(n, b.corner[2] - a.corner[0]);
    const auto a_least = hn::Min(hn::Min(on_a1, on_a2), hn::Zero(d));
    const auto a_most = hn::Max(hn::Max(on_a1, on_a2), hn::Zero(d));
    const auto b_least = hn::Min(hn::Min(on_b0, on_b1), on_b2);
    const auto b_most = hn::Max(hn::Max(on_b0, on_b1), on_b2);
    const auto gap = hn::Max(hn::Sub(b_least, a_most), hn::Sub(a_least, b_most));
    // The square of a shorter normal has few digits in floats: the gap would come out too wide.
    const auto squared = dot(n, n);
    const auto is_long = hn::Gt(squared, hn::Set(d, T{0x1p-96}));
    return hn::IfThenElseZero(is_long, hn::Div(gap, hn::Sqrt(squared)));
}

/// What is known of the distances of the triangles in lanes.
template <class T>
struct DistanceLanes {
    hn::Vec<PairTag<T>> least;
    hn::Vec<PairTag<T>> most;
    VectorLanes<T> nearest; ///< `most` long, from the first to the second
};

/// The difference, from the first to the second, of the nearest points of two triangles among the
/// closest of two sides and the feet of corners.
template <class T>
HWY_INLINE VectorLanes<T> nearest_points(const TriangleLanes<T>& a, const SideLanes<T>& first,
                                         const TriangleLanes<T>& b, const SideLanes<T>& second)
{
    auto nearest = b.corner[0] - a.corner[0];
    auto squared = dot(nearest, nearest);
    const auto offer = [&](const VectorLanes<T>& between) HWY_ATTR {
        const auto other = dot(between, between);
        const auto nearer = hn::Lt(other, squared);
        squared = hn::Min(other, squared);
        nearest.x = hn::IfThenElse(nearer, between.x, nearest.x);
        nearest.y = hn::IfThenElse(nearer, between.y, nearest.y);
        nearest.z = hn::IfThenElse(nearer, between.z, nearest.z);
    };
    for (std::size_t i = 0; i < 3; ++i) {
        for (std::size_t k = 0; k < 3; ++k)
            offer(between_sides(b.corner[k] - a.corner[i], first, i, second, k));
    }
    for (std::size_t i = 0; i < 3; ++i) {
        offer(from_inside(b.corner[i] - a.corner[0], first));
        const auto back = from_inside(a.corner[i] - b.corner[0], second);
        offer({hn::Neg(back.x), hn::Neg(back.y), hn::Neg(back.z)});
    }
    return nearest;
}

template <class T>
HWY_INLINE DistanceLanes<T> bound_triangles(const TriangleLanes<T>& a, const TriangleLanes<T>& b)
{
    const PairTag<T> d;
    const SideLanes<T> first(a);
    const SideLanes<T> second(b);
    const VectorLanes<T> nearest = nearest_points(a, first, b, second);
    const auto along_normals =
        hn::Max(gap_along(first.normal, a, b), gap_along(second.normal, a, b));
    const auto gap = hn::Max(along_normals, gap_along(nearest, a, b));
    return {hn::Max(gap, hn::Zero(d)), hn::Sqrt(dot(nearest, nearest)), nearest};
}

/// What is known of the distances of eight pairs of two leaves' triangles.
template <class T>
struct EightDistances {
    T least[8];
    T most[8];
    T nearest[3][8];
};

template <class T>
PROXIMA_STEP void bound_eight(const LeafPoints<T>& a, const LeafPoints<T>& b,
                              const PairIndex* pairs, EightDistances<T>& result)
{
    const PairTag<T> d;
    for (std::size_t at = 0; at < 8; at += pair_lanes<T>) {
        const DistanceLanes<T> distances = bound_triangles(a.template triangles<3>(pairs + at),
                                                           b.template triangles<0>(pairs + at));
        hn::StoreU(distances.least, d, result.least + at);
        hn::StoreU(distances.most, d, result.most + at);
        hn::StoreU(distances.nearest.x, d, result.nearest[0] + at);
        hn::StoreU(distances.nearest.y, d, result.nearest[1] + at);
        hn::StoreU(distances.nearest.z, d, result.nearest[2] + at);
    }
}

} // namespace proxima::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
