// The triangles of two leaves, eight times eight: which pairs may be closer than the best one.
// Included once per target, after <hwy/highway.h>.
//
//     n . x      A's triangles ---|         |--- B's triangles: pairs whose gap along a direction n
//                          greatest  gap  least   is beyond the limit are out
//
// The direction across a pair's closest points is the best one for its neighbours, too.

#if defined(PROXIMA_QUERY_LEAF_PAIR_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef PROXIMA_QUERY_LEAF_PAIR_INL_H
#undef PROXIMA_QUERY_LEAF_PAIR_INL_H
#else
#define PROXIMA_QUERY_LEAF_PAIR_INL_H
#endif

#include "proxima/query/pair_bounds-inl.h"

#include <algorithm>
#include <bit>

HWY_BEFORE_NAMESPACE();
namespace proxima::HWY_NAMESPACE {

/// The vertices of a leaf in the frame, and its triangles' corners.
template <class T>
struct LeafPoints {
    HWY_ALIGN T x[3][8];
    const RayLeaf& leaf;

    /// Of A.
    HWY_INLINE LeafPoints(const RayLeaf& from, float scale) : leaf(from)
    {
        const PairTag<T> d;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            for (std::size_t at = 0; at < 8; at += pair_lanes<T>) {
                hn::Store(hn::Mul(load_lanes<T>(leaf.coordinates[axis].data() + at),
                                  hn::Set(d, static_cast<T>(scale))),
                          d, x[axis] + at);
            }
        }
    }
    /// Of B.
    HWY_INLINE LeafPoints(const RayLeaf& from, float scale, const PoseLanes<T>& pose) : leaf(from)
    {
        const PairTag<T> d;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            for (std::size_t at = 0; at < 8; at += pair_lanes<T>) {
                auto sum = hn::Set(d, pose.offset[axis]);
                for (std::size_t k = 0; k < 3; ++k) {
                    const auto y = hn::Mul(load_lanes<T>(leaf.coordinates[k].data() + at),
                                           hn::Set(d, static_cast<T>(scale)));
                    sum = hn::Add(sum, hn::Mul(y, hn::Set(d, pose.rotation[axis][k])));
                }
                hn::Store(sum, d, x[axis] + at);
            }
        }
    }

    /// Along n, per triangle: of its corners the one that `choose` takes.
    template <class Choose>
    HWY_INLINE void project(const T (&n)[3], T (&result)[8], const Choose& choose) const
    {
        const PairTag<T> d;
        if constexpr (sizeof(T) == sizeof(float) && pair_lanes<T> == 8) {
            const auto on = projections(d, n, 0);
            const hn::RebindToUnsigned<PairTag<T>> words;
            const hn::Rebind<std::uint8_t, PairTag<T>> bytes;
            const auto corner = [&](std::size_t i) HWY_ATTR {
                const auto places = hn::PromoteTo(words, hn::LoadU(bytes, leaf.corners[i].data()));
                return hn::TableLookupLanes(on, hn::IndicesFromVec(d, places));
            };
            hn::StoreU(choose.lanes(choose.lanes(corner(0), corner(1)), corner(2)), d, result);
        } else {
            T on[8];
            for (std::size_t at = 0; at < 8; at += pair_lanes<T>)
                hn::StoreU(projections(d, n, at), d, on + at);
            for (std::size_t i = 0; i < 8; ++i) {
                result[i] = choose.one(choose.one(on[leaf.corners[0][i]], on[leaf.corners[1][i]]),
                                       on[leaf.corners[2][i]]);
            }
        }
    }

private:
    HWY_INLINE hn::Vec<PairTag<T>> projections(PairTag<T> d, const T (&n)[3], std::size_t at) const
    {
        auto sum = hn::Mul(hn::Load(d, x[0] + at), hn::Set(d, n[0]));
        sum = hn::Add(sum, hn::Mul(hn::Load(d, x[1] + at), hn::Set(d, n[1])));
        return hn::Add(sum, hn::Mul(hn::Load(d, x[2] + at), hn::Set(d, n[2])));
    }
};

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

/// Of the pairs 8 i + k (of A's triangle i and B's k), those whose gap along the unit vector n is
/// at most the limit; gaps are written down.
template <class T>
HWY_INLINE std::uint64_t pairs_within(const LeafPoints<T>& a, const LeafPoints<T>& b,
                                      const Vec3& direction, double limit, T (&gaps)[64])
{
    const PairTag<T> d;
    const T n[3] = {static_cast<T>(direction[0]), static_cast<T>(direction[1]),
                    static_cast<T>(direction[2])};
    T greatest[8];
    HWY_ALIGN T least[8];
    a.project(n, greatest, Greater());
    b.project(n, least, Less());
    // Three roundings of n's numbers make it longer than 1.
    const auto most =
        hn::Set(d, static_cast<T>(limit) * (1 + 8 * std::numeric_limits<T>::epsilon()));
    std::uint64_t pairs = 0;
    for (std::size_t i = 0; i < a.leaf.count; ++i) {
        for (std::size_t at = 0; at < 8; at += pair_lanes<T>) {
            const auto gap = hn::Sub(hn::Load(d, least + at), hn::Set(d, greatest[i]));
            hn::StoreU(gap, d, gaps + 8 * i + at);
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
    T gaps[64];
    if (search.found() && pairs_within(a, b, search.direction, search.limit(), gaps) == 0)
        return false;
    const double length = between.norm();
    const Vec3 along = length > 0 ? Vec3(between / length) : Vec3::UnitX();
    std::uint64_t left = pairs_within(a, b, along, search.limit(), gaps);
    while (left != 0) {
        auto nearest = static_cast<std::uint32_t>(std::countr_zero(left));
        for (std::uint64_t others = left & (left - 1); others != 0; others &= others - 1) {
            const auto other = static_cast<std::uint32_t>(std::countr_zero(others));
            if (gaps[other] < gaps[nearest]) nearest = other;
        }
        if (search.ask(a.leaf.first_row + nearest / 8, b.leaf.first_row + nearest % 8)) return true;
        left &= ~(std::uint64_t{1} << nearest);
        if (left != 0) left &= pairs_within(a, b, search.direction, search.limit(), gaps);
    }
    return false;
}

} // namespace proxima::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
