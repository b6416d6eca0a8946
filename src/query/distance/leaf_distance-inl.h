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

#include "index/index_parts.h"
#include "query/distance/triangle_bounds-inl.h"

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
    template <class T>
    HWY_INLINE T all(const T (&values)[8]) const
    {
        return *std::max_element(values, values + 8);
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
    template <class T>
    HWY_INLINE T all(const T (&values)[8]) const
    {
        return *std::min_element(values, values + 8);
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
PROXIMA_STEP std::uint64_t pairs_within(const LeafPoints<T>& a, const LeafPoints<T>& b,
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

/// The least or the greatest of n . p for a leaf's vertices.
template <class T, class Choose>
PROXIMA_STEP T extreme_of(const IndexLeaf& leaf, const Vec3& direction, const Choose& choose)
{
    const PairTag<T> d;
    T on[8];
    for (std::size_t at = 0; at < 8; at += pair_lanes<T>) {
        auto sum = hn::Zero(d);
        for (std::size_t k = 0; k < 3; ++k) {
            const T number = static_cast<T>(direction[static_cast<Eigen::Index>(k)]);
            sum = hn::Add(
                sum, hn::Mul(load_lanes<T>(leaf.coordinates[k].data() + at), hn::Set(d, number)));
        }
        hn::StoreU(sum, d, on + at);
    }
    return choose.all(on);
}

/// Whether the vertices of two leaves may be within the limit: their gap along a direction is.
template <class T>
HWY_INLINE bool may_be_near(const DistanceSearch& search, const IndexLeaf& a, const IndexLeaf& b,
                            const Vec3& direction)
{
    const Vec3 on_a = direction * double{search.a_scale};
    const Vec3 on_b = search.rotation.transpose() * direction * double{search.b_scale};
    const auto apart = static_cast<T>(direction.dot(search.offset));
    const T gap = apart + extreme_of<T>(b, on_b, Less()) - extreme_of<T>(a, on_a, Greater());
    return gap <= lane_limit<T>(search.limit());
}

/// Looks at all pairs of triangles of two leaves, given their centers' difference. Returns true
/// where two touch.
template <class T>
HWY_INLINE bool ask_leaves(DistanceSearch& search, const PoseLanes<T>& pose,
                           const IndexLeaf& leaf_a, const IndexLeaf& leaf_b, const Vec3& between)
{
    const bool has_direction = !search.direction().isZero();
    if (has_direction && !may_be_near<T>(search, leaf_a, leaf_b, search.direction())) return false;
    const double length = between.norm();
    const Vec3 along = length > 0 ? Vec3(between / length) : Vec3::UnitX();
    if (!may_be_near<T>(search, leaf_a, leaf_b, along)) return false;

    const LeafPoints<T> a(leaf_a, search.a_scale);
    const LeafPoints<T> b(leaf_b, search.b_scale, pose);
    std::uint64_t left = pairs_within(a, b, along, search.limit());
    if (has_direction) left &= pairs_within(a, b, search.direction(), search.limit());
    while (left != 0) {
        PairIndex pairs[8];
        std::size_t count = 0;
        for (; left != 0 && count < 8; left &= left - 1)
            pairs[count++] = static_cast<PairIndex>(std::countr_zero(left));
        for (std::size_t i = count; i < 8; ++i) pairs[i] = pairs[0];
        EightDistances<T> known;
        bound_eight(a, b, pairs, known);
        for (std::size_t i = 0; i < count; ++i) {
            if (known.least[i] > lane_limit<T>(search.limit())) continue;
            const Vec3 nearest(known.nearest[0][i], known.nearest[1][i], known.nearest[2][i]);
            if (search.note({known.least[i], known.most[i], a.leaf.first_row + pairs[i] / 8,
                             b.leaf.first_row + pairs[i] % 8},
                            nearest))
                return true;
        }
    }
    return false;
}

} // namespace proxima::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
