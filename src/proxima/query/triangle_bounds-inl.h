// How far triangles of two leaves are from each other at least, eight pairs at a time. Included
// once per target, after <hwy/highway.h>. No multiply-add: the same bits on every instruction set.
//
// Whatever the direction, the gap along it between two triangles is at most their distance. Tried
// are both normals, the right ones where a corner is closest to the inside of the other triangle,
// and the line between the closest points of two sides, the nearest of nine pairs: the right one
// otherwise. So rounding of directions makes bounds lower, never wrong.

#if defined(PROXIMA_QUERY_TRIANGLE_BOUNDS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef PROXIMA_QUERY_TRIANGLE_BOUNDS_INL_H
#undef PROXIMA_QUERY_TRIANGLE_BOUNDS_INL_H
#else
#define PROXIMA_QUERY_TRIANGLE_BOUNDS_INL_H
#endif

#include "proxima/query/leaf_points-inl.h"

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

/// The difference of the closest points of two sides from p along u and from q along w, r = p - q.
/// `inverse_u` is 1 / u.u, `inverse_w` 1 / w.w, or 0 for sides that are points.
template <class T>
HWY_INLINE VectorLanes<T> between_sides(const VectorLanes<T>& r, const VectorLanes<T>& u,
                                        const VectorLanes<T>& w, hn::Vec<PairTag<T>> uu,
                                        hn::Vec<PairTag<T>> ww, hn::Vec<PairTag<T>> inverse_u,
                                        hn::Vec<PairTag<T>> inverse_w)
{
    const PairTag<T> d;
    const auto clamped = [&](auto t) HWY_ATTR {
        return hn::Min(hn::Max(t, hn::Zero(d)), hn::Set(d, T{1}));
    };
    const auto uw = dot(u, w);
    const auto ur = dot(u, r);
    const auto wr = dot(w, r);
    const auto across = hn::Sub(hn::Mul(uu, ww), hn::Mul(uw, uw));
    // On u as if both were lines, then the closest on w, then the closest to that on u.
    const auto start =
        clamped(hn::Mul(hn::Sub(hn::Mul(uw, wr), hn::Mul(ur, ww)), inverse_or_zero<T>(across)));
    const auto t = clamped(hn::Mul(hn::Add(hn::Mul(uw, start), wr), inverse_w));
    const auto s = clamped(hn::Mul(hn::Sub(hn::Mul(uw, t), ur), inverse_u));
    return r + scaled(u, s) - scaled(w, t);
}

/// The gap along n, from all of A's corners to all of B's as seen from A's first one. None if n is
/// next to nothing.
template <class T>
HWY_INLINE hn::Vec<PairTag<T>> gap_along(const VectorLanes<T>& n, const TriangleLanes<T>& a,
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
    return hn::Mul(gap, inverse_or_zero<T>(hn::Sqrt(dot(n, n))));
}

/// Bounds on the distances of the triangles in lanes.
template <class T>
HWY_INLINE hn::Vec<PairTag<T>> bound_triangles(const TriangleLanes<T>& a, const TriangleLanes<T>& b)
{
    using Lanes = hn::Vec<PairTag<T>>;
    const PairTag<T> d;
    VectorLanes<T> u[3];
    VectorLanes<T> w[3];
    Lanes uu[3];
    Lanes ww[3];
    Lanes inverse_u[3];
    Lanes inverse_w[3];
    for (std::size_t i = 0; i < 3; ++i) {
        u[i] = a.corner[(i + 1) % 3] - a.corner[i];
        w[i] = b.corner[(i + 1) % 3] - b.corner[i];
        uu[i] = dot(u[i], u[i]);
        ww[i] = dot(w[i], w[i]);
        inverse_u[i] = inverse_or_zero<T>(uu[i]);
        inverse_w[i] = inverse_or_zero<T>(ww[i]);
    }
    auto nearest = a.corner[0] - b.corner[0];
    auto least = dot(nearest, nearest);
    for (std::size_t i = 0; i < 3; ++i) {
        for (std::size_t k = 0; k < 3; ++k) {
            const auto between = between_sides<T>(a.corner[i] - b.corner[k], u[i], w[k], uu[i],
                                                  ww[k], inverse_u[i], inverse_w[k]);
            const auto squared = dot(between, between);
            const auto nearer = hn::Lt(squared, least);
            least = hn::Min(squared, least);
            nearest.x = hn::IfThenElse(nearer, between.x, nearest.x);
            nearest.y = hn::IfThenElse(nearer, between.y, nearest.y);
            nearest.z = hn::IfThenElse(nearer, between.z, nearest.z);
        }
    }
    const auto along_normals =
        hn::Max(gap_along(cross(u[0], u[1]), a, b), gap_along(cross(w[0], w[1]), a, b));
    return hn::Max(hn::Max(along_normals, gap_along(nearest, a, b)), hn::Zero(d));
}

/// The same of eight pairs of two leaves' triangles.
template <class T>
HWY_INLINE void bound_eight(const LeafPoints<T>& a, const LeafPoints<T>& b, const PairPlace* places,
                            T* bounds)
{
    const PairTag<T> d;
    for (std::size_t at = 0; at < 8; at += pair_lanes<T>) {
        const auto first = a.template triangles<3>(places + at);
        const auto second = b.template triangles<0>(places + at);
        hn::StoreU(bound_triangles(first, second), d, bounds + at);
    }
}

} // namespace proxima::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
