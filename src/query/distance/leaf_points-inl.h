// The vertices of a leaf in the frame of a search, and its triangles in lanes. Included once per
// target, after <hwy/highway.h>. No multiply-add: the same bits on every instruction set.

#if defined(PROXIMA_QUERY_LEAF_POINTS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef PROXIMA_QUERY_LEAF_POINTS_INL_H
#undef PROXIMA_QUERY_LEAF_POINTS_INL_H
#else
#define PROXIMA_QUERY_LEAF_POINTS_INL_H
#endif

#include "index/index_parts.h"
#include "query/distance/pair_bounds-inl.h"

HWY_BEFORE_NAMESPACE();
namespace proxima::HWY_NAMESPACE {

/// Of two leaves' triangles, 8 times A's index plus B's.
using PairIndex = std::uint32_t;

/// A vector per lane.
template <class T>
struct VectorLanes {
    using Lanes = hn::Vec<PairTag<T>>;
    Lanes x;
    Lanes y;
    Lanes z;
};

/// A triangle per lane.
template <class T>
struct TriangleLanes {
    VectorLanes<T> corner[3];
};

/// The vertices of a leaf in the frame, and its triangles' corners.
template <class T>
struct LeafPoints {
    HWY_ALIGN T x[3][8];
    const IndexLeaf& leaf;

    /// Of A.
    HWY_INLINE LeafPoints(const IndexLeaf& from, float scale) : leaf(from)
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
    HWY_INLINE LeafPoints(const IndexLeaf& from, float scale, const PoseLanes<T>& pose) : leaf(from)
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

    /// The triangles of pairs: `FirstBit` is that of their index there.
    template <unsigned FirstBit>
    HWY_INLINE TriangleLanes<T> triangles(const PairIndex* pairs) const
    {
        const PairTag<T> d;
        TriangleLanes<T> result;
        if constexpr (has_lookup) {
            const hn::RebindToUnsigned<PairTag<T>> words;
            const hn::Rebind<std::uint8_t, PairTag<T>> bytes;
            const auto indices =
                hn::And(hn::ShiftRight<FirstBit>(hn::LoadU(words, pairs)), hn::Set(words, 7U));
            for (std::size_t i = 0; i < 3; ++i) {
                const auto corners = hn::PromoteTo(words, hn::LoadU(bytes, leaf.corners[i].data()));
                const auto corner = hn::IndicesFromVec(
                    d, hn::TableLookupLanes(corners, hn::IndicesFromVec(words, indices)));
                const auto axis = [&](std::size_t k) HWY_ATTR {
                    return hn::TableLookupLanes(hn::Load(d, x[k]), corner);
                };
                result.corner[i] = {axis(0), axis(1), axis(2)};
            }
        } else {
            for (std::size_t i = 0; i < 3; ++i) {
                HWY_ALIGN T found[3][8];
                for (std::size_t lane = 0; lane < pair_lanes<T>; ++lane) {
                    const std::uint8_t corner = leaf.corners[i][pairs[lane] >> FirstBit & 7U];
                    for (std::size_t k = 0; k < 3; ++k) found[k][lane] = x[k][corner];
                }
                result.corner[i] = {hn::Load(d, found[0]), hn::Load(d, found[1]),
                                    hn::Load(d, found[2])};
            }
        }
        return result;
    }

    /// Along n, per triangle: of its corners the one that `choose` takes.
    template <class Choose>
    HWY_INLINE void project(const T (&n)[3], T (&result)[8], const Choose& choose) const
    {
        const PairTag<T> d;
        if constexpr (has_lookup) {
            const auto on = projections(d, n, 0);
            const hn::RebindToUnsigned<PairTag<T>> words;
            const hn::Rebind<std::uint8_t, PairTag<T>> bytes;
            const auto corner = [&](std::size_t i) HWY_ATTR {
                const auto indices = hn::PromoteTo(words, hn::LoadU(bytes, leaf.corners[i].data()));
                return hn::TableLookupLanes(on, hn::IndicesFromVec(d, indices));
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
    static constexpr bool has_lookup = sizeof(T) == sizeof(float) && pair_lanes<T> == 8;

    HWY_INLINE hn::Vec<PairTag<T>> projections(PairTag<T> d, const T (&n)[3], std::size_t at) const
    {
        auto sum = hn::Mul(hn::Load(d, x[0] + at), hn::Set(d, n[0]));
        sum = hn::Add(sum, hn::Mul(hn::Load(d, x[1] + at), hn::Set(d, n[1])));
        return hn::Add(sum, hn::Mul(hn::Load(d, x[2] + at), hn::Set(d, n[2])));
    }
};

} // namespace proxima::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
