// How far boxes of two meshes are from each other at least, eight pairs at a time. Included once
// per target, after <hwy/highway.h>. No multiply-add: the same bits on every instruction set.
//
//     axes of A    |d| - half a - |R| half b          gaps, as the sides of a box
//     along d      |d| - reach of a's box and slab - reach of b's
//
// d is the difference of the centers. The greater of the two is the bound.

#if defined(PROXIMA_QUERY_PAIR_BOUNDS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef PROXIMA_QUERY_PAIR_BOUNDS_INL_H
#undef PROXIMA_QUERY_PAIR_BOUNDS_INL_H
#else
#define PROXIMA_QUERY_PAIR_BOUNDS_INL_H
#endif

#include "base/inline_steps-inl.h"
#include "index/index_parts.h"
#include "index/slabs/block_slab.h"
#include "query/distance/distance_search.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <hwy/highway.h>
#include <limits>

HWY_BEFORE_NAMESPACE();
namespace proxima::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

/// Eight lanes of a scalar in as many registers as that takes.
template <class T>
using PairTag = hn::CappedTag<T, 8>;
template <class T>
inline constexpr std::size_t pair_lanes = HWY_MIN(8, HWY_LANES(T));

/// Floats as lanes of T.
template <class T>
HWY_INLINE hn::Vec<PairTag<T>> load_lanes(const float* values)
{
    const PairTag<T> d;
    if constexpr (sizeof(T) == sizeof(float)) {
        return hn::LoadU(d, values);
    } else {
        return hn::PromoteTo(d, hn::LoadU(hn::Rebind<float, PairTag<T>>(), values));
    }
}

/// The pose, ready for lanes.
template <class T>
struct PoseLanes {
    T rotation[3][3];
    T sizes[3][3]; ///< of the rotation's numbers
    T offset[3];

    explicit PoseLanes(const DistanceSearch& search)
    {
        for (int i = 0; i < 3; ++i) {
            offset[i] = static_cast<T>(search.offset[i]);
            for (int k = 0; k < 3; ++k) {
                rotation[i][k] = static_cast<T>(search.rotation(i, k));
                sizes[i][k] = std::abs(rotation[i][k]);
            }
        }
    }
};

/// The boxes of a node's children; half extents below zero where there is none.
struct ChildBoxes {
    HWY_ALIGN float center[3][8];
    HWY_ALIGN float half[3][8];

    HWY_INLINE ChildBoxes(const IndexNode& node, float scale)
    {
        const hn::CappedTag<float, 8> d;
        const hn::RebindToSigned<decltype(d)> words;
        const hn::Rebind<std::uint8_t, decltype(d)> bytes;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const float half_step = 0.5F * node.step[axis] * scale;
            const auto base = hn::Set(d, (node.origin[axis] + 32768.0F * node.step[axis]) * scale);
            for (std::size_t at = 0; at < 8; at += pair_lanes<float>) {
                const auto plane = [&](std::size_t first) {
                    return hn::PromoteTo(words,
                                         hn::LoadU(bytes, node.planes[axis].data() + first + at));
                };
                const auto lower = plane(0);
                const auto upper = plane(8);
                const auto sum = hn::ConvertTo(d, hn::Add(lower, upper));
                const auto extent = hn::ConvertTo(d, hn::Sub(upper, lower));
                const auto step = hn::Set(d, half_step);
                hn::Store(hn::Add(base, hn::Mul(sum, step)), d, center[axis] + at);
                hn::Store(hn::Mul(extent, step), d, half[axis] + at);
            }
        }
    }
    HWY_INLINE BlockBox operator[](std::size_t slot) const
    {
        return {{center[0][slot], center[1][slot], center[2][slot]},
                {half[0][slot], half[1][slot], half[2][slot]}};
    }
};

/// Slabs: normals, and how far from the box's center they reach in units of the box's reach. Zeros
/// where the index has none: then boxes alone bound.
struct ChildSlabs {
    HWY_ALIGN float normal[3][8] = {};
    HWY_ALIGN float lower[8] = {};
    HWY_ALIGN float upper[8] = {};

    HWY_INLINE ChildSlabs() = default;
    HWY_INLINE ChildSlabs(const IndexParts& index, const IndexNode& node)
    {
        if (index.slabs().empty()) return;
        const hn::CappedTag<float, 8> d;
        const hn::RebindToSigned<decltype(d)> words;
        // Children lie side by side in the order of their slots, which not all have one.
        std::uint32_t first = 0;
        for (std::size_t slot = 8; slot-- > 0;) {
            const std::uint32_t block = node.children[slot] & ~index_leaf_bit;
            if (block != 0) first = block;
        }
        const BlockSlab* const slabs = index.slabs().data() + first;
        HWY_ALIGN std::int32_t normals[8];
        HWY_ALIGN std::int32_t extents[8];
        if constexpr (pair_lanes<float> == 8) {
            hn::Vec<decltype(words)> normal_words;
            hn::Vec<decltype(words)> extent_words;
            hn::LoadInterleaved2(words, reinterpret_cast<const std::int32_t*>(slabs), normal_words,
                                 extent_words);
            const hn::RebindToUnsigned<decltype(d)> numbers;
            const auto slots =
                hn::And(hn::Sub(hn::LoadU(numbers, node.children.data()), hn::Set(numbers, first)),
                        hn::Set(numbers, 7U));
            const auto lanes = hn::IndicesFromVec(words, slots);
            hn::Store(hn::TableLookupLanes(normal_words, lanes), words, normals);
            hn::Store(hn::TableLookupLanes(extent_words, lanes), words, extents);
        } else {
            for (std::size_t slot = 0; slot < 8; ++slot) {
                const BlockSlab& slab = slabs[(node.children[slot] - first) & 7U];
                normals[slot] = static_cast<std::int32_t>(slab.normal);
                extents[slot] = static_cast<std::int32_t>(slab.extent);
            }
        }
        for (std::size_t at = 0; at < 8; at += pair_lanes<float>) {
            const auto n = hn::Load(words, normals + at);
            const auto e = hn::Load(words, extents + at);
            const auto number = [&](auto bits, float unit) HWY_ATTR {
                return hn::Mul(hn::ConvertTo(d, bits), hn::Set(d, unit));
            };
            hn::Store(number(hn::ShiftRight<22>(n), 0x1p-9F), d, normal[0] + at);
            hn::Store(number(hn::ShiftRight<22>(hn::ShiftLeft<10>(n)), 0x1p-9F), d, normal[1] + at);
            hn::Store(number(hn::ShiftRight<22>(hn::ShiftLeft<20>(n)), 0x1p-9F), d, normal[2] + at);
            hn::Store(number(hn::ShiftRight<16>(e), 0x1p-15F), d, upper + at);
            hn::Store(number(hn::ShiftRight<16>(hn::ShiftLeft<16>(e)), 0x1p-15F), d, lower + at);
        }
    }
};

/// The slab of one block.
struct OneSlab {
    float normal[3] = {};
    float lower = 0;
    float upper = 0;

    HWY_INLINE OneSlab(const IndexParts& index, std::uint32_t reference)
    {
        if (index.slabs().empty()) return;
        const SlabNumbers slab = read_slab(index.slabs()[reference & ~index_leaf_bit]);
        std::copy(slab.normal.begin(), slab.normal.end(), normal);
        lower = slab.lower;
        upper = slab.upper;
    }
};

/// Boxes, one for each lane.
template <class T>
struct LaneBoxes {
    const ChildBoxes& boxes;
    const ChildSlabs& slabs;
    HWY_INLINE hn::Vec<PairTag<T>> center(std::size_t axis, std::size_t first) const
    {
        return load_lanes<T>(boxes.center[axis] + first);
    }
    HWY_INLINE hn::Vec<PairTag<T>> half(std::size_t axis, std::size_t first) const
    {
        return load_lanes<T>(boxes.half[axis] + first);
    }
    HWY_INLINE hn::Vec<PairTag<T>> normal(std::size_t axis, std::size_t first) const
    {
        return load_lanes<T>(slabs.normal[axis] + first);
    }
    HWY_INLINE hn::Vec<PairTag<T>> lower(std::size_t first) const
    {
        return load_lanes<T>(slabs.lower + first);
    }
    HWY_INLINE hn::Vec<PairTag<T>> upper(std::size_t first) const
    {
        return load_lanes<T>(slabs.upper + first);
    }
};

/// One box for all lanes.
template <class T>
struct OneBox {
    const BlockBox& box;
    const OneSlab& slabs;
    HWY_INLINE hn::Vec<PairTag<T>> center(std::size_t axis, std::size_t /*first*/) const
    {
        return hn::Set(PairTag<T>(), static_cast<T>(box.center[axis]));
    }
    HWY_INLINE hn::Vec<PairTag<T>> half(std::size_t axis, std::size_t /*first*/) const
    {
        return hn::Set(PairTag<T>(), static_cast<T>(box.half[axis]));
    }
    HWY_INLINE hn::Vec<PairTag<T>> normal(std::size_t axis, std::size_t /*first*/) const
    {
        return hn::Set(PairTag<T>(), static_cast<T>(slabs.normal[axis]));
    }
    HWY_INLINE hn::Vec<PairTag<T>> lower(std::size_t /*first*/) const
    {
        return hn::Set(PairTag<T>(), static_cast<T>(slabs.lower));
    }
    HWY_INLINE hn::Vec<PairTag<T>> upper(std::size_t /*first*/) const
    {
        return hn::Set(PairTag<T>(), static_cast<T>(slabs.upper));
    }
};

/// How far what is in boxes and slabs reaches from the boxes' centers along v, times |v|; v and the
/// boxes in the same axes. v = l n + r, n the slab's normal: the slab bounds l n . p, the box r .
/// p.
template <class T, class Boxes>
PROXIMA_STEP hn::Vec<PairTag<T>> reach_along(const hn::Vec<PairTag<T>> (&v)[3], const Boxes& boxes,
                                             std::size_t first)
{
    auto on_normal = hn::Mul(v[0], boxes.normal(0, first));
    auto reach = hn::Mul(hn::Abs(boxes.normal(0, first)), boxes.half(0, first));
    auto by_box = hn::Mul(hn::Abs(v[0]), boxes.half(0, first));
    for (std::size_t k = 1; k < 3; ++k) {
        const auto normal = boxes.normal(k, first);
        on_normal = hn::Add(on_normal, hn::Mul(v[k], normal));
        reach = hn::Add(reach, hn::Mul(hn::Abs(normal), boxes.half(k, first)));
        by_box = hn::Add(by_box, hn::Mul(hn::Abs(v[k]), boxes.half(k, first)));
    }
    auto by_slab = hn::Mul(reach, hn::Max(hn::Mul(on_normal, boxes.lower(first)),
                                          hn::Mul(on_normal, boxes.upper(first))));
    for (std::size_t k = 0; k < 3; ++k) {
        const auto rest = hn::Sub(v[k], hn::Mul(on_normal, boxes.normal(k, first)));
        by_slab = hn::Add(by_slab, hn::Mul(hn::Abs(rest), boxes.half(k, first)));
    }
    return hn::Min(by_box, by_slab);
}

/// Squared bounds on the distances of eight pairs of boxes. Returns bits for those within the
/// limit.
template <class T, class BoxesA, class BoxesB>
PROXIMA_STEP std::uint32_t bound_pairs(const PoseLanes<T>& pose, const BoxesA& a, const BoxesB& b,
                                       T limit, T (&squared)[8])
{
    std::uint32_t within = 0;
    const PairTag<T> d;
    using Lanes = hn::Vec<PairTag<T>>;
    const auto zero = hn::Zero(d);
    for (std::size_t first = 0; first < 8; first += pair_lanes<T>) {
        Lanes half_a[3];
        Lanes half_b[3];
        Lanes center_b[3];
        for (std::size_t k = 0; k < 3; ++k) {
            half_a[k] = a.half(k, first);
            half_b[k] = b.half(k, first);
            center_b[k] = b.center(k, first);
        }
        // sum of v_k m_k
        const auto dot = [&](const Lanes(&v)[3], T m0, T m1, T m2) HWY_ATTR {
            return hn::Add(hn::Add(hn::Mul(v[0], hn::Set(d, m0)), hn::Mul(v[1], hn::Set(d, m1))),
                           hn::Mul(v[2], hn::Set(d, m2)));
        };
        Lanes difference[3];
        auto length = zero; // of d, squared
        auto gaps = zero;
        for (std::size_t k = 0; k < 3; ++k) {
            const T(&row)[3] = pose.rotation[k];
            const T(&sizes)[3] = pose.sizes[k];
            const auto moved =
                hn::Add(dot(center_b, row[0], row[1], row[2]), hn::Set(d, pose.offset[k]));
            difference[k] = hn::Sub(moved, a.center(k, first));
            const auto size = hn::Abs(difference[k]);
            const auto reach = hn::Add(half_a[k], dot(half_b, sizes[0], sizes[1], sizes[2]));
            const auto gap = hn::Max(hn::Sub(size, reach), zero);
            gaps = hn::Add(gaps, hn::Mul(gap, gap));
            length = hn::Add(length, hn::Mul(size, size));
        }
        Lanes back[3]; // from B to A, along B's axes
        for (std::size_t k = 0; k < 3; ++k) {
            const auto& r = pose.rotation;
            back[k] = hn::Neg(dot(difference, r[0][k], r[1][k], r[2][k]));
        }
        const auto reaches =
            hn::Add(reach_along<T>(difference, a, first), reach_along<T>(back, b, first));
        const auto rest = hn::Max(hn::Sub(length, reaches), zero);
        const auto tiny = hn::Set(d, std::numeric_limits<T>::min());
        const auto along = hn::Div(hn::Mul(rest, rest), hn::Max(length, tiny));
        const auto bound = hn::Max(gaps, along);
        hn::StoreU(bound, d, squared + first);
        const auto exists = hn::Ge(hn::Min(half_a[0], half_b[0]), zero);
        std::uint8_t bits[8] = {};
        (void)hn::StoreMaskBits(d, hn::And(exists, hn::Le(bound, hn::Set(d, limit))), bits);
        within |= static_cast<std::uint32_t>(bits[0]) << first;
    }
    return within;
}

} // namespace proxima::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
