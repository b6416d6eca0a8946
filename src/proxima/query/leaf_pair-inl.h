// The triangles of two leaves, eight times eight: which pairs may be closer than the best one.
// Included once per target, after <hwy/highway.h>.
//
//     n . x      A's triangles ---|         |--- B's triangles: pairs whose gap along a direction n
//                          greatest  gap  least   is beyond the limit are out
//
// The direction across the closest points of one pair is good for its neighbours, too. What that
// leaves is bounded pair by pair, and what that leaves is noted, to be asked in doubles.

#if defined(PROXIMA_QUERY_LEAF_PAIR_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef PROXIMA_QUERY_LEAF_PAIR_INL_H
#undef PROXIMA_QUERY_LEAF_PAIR_INL_H
#else
#define PROXIMA_QUERY_LEAF_PAIR_INL_H
#endif

#include "proxima/query/triangle_bounds-inl.h"

#include <algorithm>
#include <bit>

HWY_BEFORE_NAMESPACE();
namespace proxima::HWY_NAMESPACE {

struct Greater {
    template <class V>
    HWY_INLINE V lanes(V a, V b) const
    {
        return hn::Max(a, b);
    }
    template <class T>
    HWY_INLINE T one(T a, T b) const
    {
        return std::max(a, b);
    }
};
struct Less {
    template <class V>
    HWY_INLINE V lanes(V a, V b) const
    {
        return hn::Min(a, b);
    }
    template <class T>
    HWY_INLINE T one(T a, T b) const
    {
        return std::min(a, b);
    }
};

/// Above the limit, as rounded, and after what makes a direction longer than 1.
template <class T>
HWY_INLINE T lane_limit(double limit)
{
    return static_cast<T>(limit) * (1 + 8 * std::numeric_limits<T>::epsilon());
}

/// Of the pairs 8 i + k (of A's triangle i and B's k), those whose gap along the unit vector n is
/// at most the limit.
template <class T>
HWY_INLINE std::uint64_t pairs_within(const LeafPoints<T>& a, const LeafPoints<T>& b,
                                      const Vec3& direction, double limit)
{
    const PairTag<T> d;
    const T n[3] = {static_cast<T>(direction[0]), static_cast<T>(direction[1]),
                    static_cast<T>(direction[2])};
    T greatest[8];
    HWY_ALIGN T least[8];
    a.project(n, greatest, Greater());
    b.project(n, least, Less());
    const auto most = hn::Set(d, lane_limit<T>(limit));
    std::uint64_t pairs = 0;
    for (std::size_t i = 0; i < a.leaf.count; ++i) {
        for (std::size_t at = 0; at < 8; at += pair_lanes<T>) {
            const auto gap = hn::Sub(hn::Load(d, least + at), hn::Set(d, greatest[i]));
            std::uint8_t bits[8] = {};
            (void)hn::StoreMaskBits(d, hn::Le(gap, most), bits);
            pairs |= static_cast<std::uint64_t>(bits[0]) << (8 * i + at);
        }
    }
    const std::uint64_t row = (1U << b.leaf.count) - 1;
    return pairs & row * 0x0101010101010101U;
}

/// Looks at all pairs of triangles of two leaves, given their centers' difference. Returns true
/// where two touch.
template <class T>
HWY_INLINE bool ask_leaves(PairSearch& search, const LeafPoints<T>& a, const LeafPoints<T>& b,
                           const Vec3& between)
{
    std::uint64_t left = ~std::uint64_t{0};
    if (!search.direction().isZero()) {
        left = pairs_within(a, b, search.direction(), search.limit());
        if (left == 0) return false;
    }
    const double length = between.norm();
    const Vec3 along = length > 0 ? Vec3(between / length) : Vec3::UnitX();
    left &= pairs_within(a, b, along, search.limit());
    if (left == 0) return false;

    while (left != 0) {
        PairPlace places[8];
        std::size_t count = 0;
        for (; left != 0 && count < 8; left &= left - 1)
            places[count++] = static_cast<PairPlace>(std::countr_zero(left));
        for (std::size_t i = count; i < 8; ++i) places[i] = places[0];
        EightDistances<T> known;
        bound_eight(a, b, places, known);
        for (std::size_t i = 0; i < count; ++i) {
            if (known.least[i] > lane_limit<T>(search.limit())) continue;
            const Vec3 nearest(known.nearest[0][i], known.nearest[1][i], known.nearest[2][i]);
            if (search.note({known.least[i], known.most[i], a.leaf.first_row + places[i] / 8,
                             b.leaf.first_row + places[i] % 8},
                            nearest))
                return true;
        }
    }
    return false;
}

} // namespace proxima::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
