// Which of a node's eight boxes may meet a box of the other mesh: by fifteen axes, six for the box
// of a leaf, eight boxes at once (thesis section 5.2). Included once per target, after <hwy/highway.h>.
//
//     axis . d beyond the sum of both boxes' reaches along it: apart, d from box to box
//
//     own faces    e_i          h_i + sum_j |R_ij| g_j                            [gottschalk-1996]
//     its faces    R_j          sum_i h_i |R_ij| + g_j
//     edges        e_i x R_j    h_k |R_lj| + h_l |R_kj| + g_m |R_in| + g_n |R_im|

#if defined(PROXIMA_QUERY_BOX_PAIRS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef PROXIMA_QUERY_BOX_PAIRS_INL_H
#undef PROXIMA_QUERY_BOX_PAIRS_INL_H
#else
#define PROXIMA_QUERY_BOX_PAIRS_INL_H
#endif

#include "index/index_parts.h"
#include "query/contact/contact_search.h"
#include "query/contact/eight_points-inl.h"

#include <cstddef>
#include <cstdint>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace proxima::HWY_NAMESPACE {

HWY_INLINE bool is_leaf(const PairBox& box)
{
    return (box.reference & index_leaf_bit) != 0;
}

/// The boxes of a node's children in its mesh's frame.
struct MetBoxes {
    Eight center[3];
    Eight half[3];
    Eight most; ///< by how much the axis that parts most exceeds the radii

    HWY_INLINE void store(const IndexNode& node, PairBox (&to)[8]) const
    {
        static_assert(sizeof(PairBox) == 8 * sizeof(float));
        const EightWordTag words;
        Eight references;
        Eight size = (half[0] + half[1]) + half[2];
        for (std::size_t i = 0; i < eight_parts; ++i) {
            const auto word = hn::LoadU(words, node.children.data() + eight_lanes * i);
            references.part[i] = hn::BitCast(EightTag(), word);
            size.part[i] = hn::IfNegativeThenElse(references.part[i],
                                                  hn::Set(EightTag(), leaf_size), size.part[i]);
        }
        store_rows({center[0], center[1], center[2], half[0], half[1], half[2], references, size},
                   to[0].center.data());
    }
};

/// Which number of a box goes where: its centre is 0 to 2, its half sizes 3 to 5.
struct BoxIndices {
    HWY_ALIGN std::uint8_t columns[3][8] = {
        {0, 0, 0, 0, 3, 3, 3, 3}, {1, 1, 1, 1, 4, 4, 4, 4}, {2, 2, 2, 2, 5, 5, 5, 5}};
    HWY_ALIGN std::uint8_t edges[4][8] = {{4, 4, 4, 4, 5, 5, 5, 5},
                                          {5, 5, 5, 5, 3, 3, 3, 3},
                                          {3, 3, 3, 3, 3, 4, 5, 5},
                                          {4, 4, 4, 4, 3, 3, 3, 3}};
};
inline constexpr BoxIndices box_indices;

/// What a box of the other mesh brings to the axes.
struct OtherBox {
    HWY_ALIGN float at[8];       ///< its centre in this frame, 0, then radii of axes e_i
    HWY_ALIGN float edges[2][8]; ///< radii of e_i x R_0 and e_i x R_1; of e_i x R_2 and of R_j

    HWY_INLINE OtherBox(const PairFrame& frame, const PairBox& box)
    {
        const Eight numbers = load_eight(box.center.data());
        const auto product = [&](const std::array<float, 8>& factors, const std::uint8_t* indices,
                                 const Eight& sum) {
            return multiply_add(load_eight(factors.data()),
                                look_up(numbers, indices_of_bytes(indices)), sum);
        };
        Eight sum = load_eight(frame.offset.data());
        for (std::size_t j = 0; j < 3; ++j)
            sum = product(frame.columns[j], box_indices.columns[j], sum);
        store_eight(sum, at);
        for (std::size_t k = 0; k < 2; ++k) {
            const Eight first =
                product(frame.edges[2 * k], box_indices.edges[2 * k], eight(frame.slack));
            store_eight(product(frame.edges[2 * k + 1], box_indices.edges[2 * k + 1], first),
                        edges[k]);
        }
    }
    HWY_INLINE float face(std::size_t i) const { return at[4 + i]; }
    HWY_INLINE float other_face(std::size_t j) const { return edges[1][4 + j]; }
    HWY_INLINE float edge(std::size_t i, std::size_t j) const
    {
        return edges[j / 2][4 * (j % 2) + i];
    }
};

/// Bit i: the box of child i is not surely apart from `other`, a box of the other mesh. Writes
/// `boxes` where there is such a child.
PROXIMA_STEP std::uint32_t meet_boxes(const IndexNode& node, float unit, const PairFrame& frame,
                                      const PairBox& box, MetBoxes& boxes)
{
    const OtherBox other(frame, box);
    Eight(&center)[3] = boxes.center;
    Eight(&half)[3] = boxes.half;
    Eight& most = boxes.most;
    Eight off[3];
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const Eight lower = eight_of_bytes(node.planes[axis].data());
        const Eight upper = eight_of_bytes(node.planes[axis].data() + 8);
        const Eight half_step = eight(node.step[axis] * (0.5F * unit));
        const float origin = (node.origin[axis] + 32768.0F * node.step[axis]) * unit;
        center[axis] = multiply_add(lower + upper, half_step, eight(origin));
        half[axis] = (upper - lower) * half_step;
        off[axis] = eight(other.at[axis]) - center[axis];
        const Eight beyond = size_of(off[axis]) - (half[axis] + eight(other.face(axis)));
        // Places without a child have their planes the wrong way round.
        most = axis == 0 ? maximum(beyond, -half[0]) : maximum(most, beyond);
    }
    const Eight none = eight(0);
    if ((most > none).bits() == 0xFFU) return 0;
    const auto number = [&](std::size_t i, std::size_t j) { return eight(frame.columns[j][i]); };
    const auto size = [&](std::size_t i, std::size_t j) { return eight(frame.columns[j][4 + i]); };
    for (std::size_t j = 0; j < 3; ++j) {
        const Eight along = multiply_add(off[0], number(0, j),
                                         multiply_add(off[1], number(1, j), off[2] * number(2, j)));
        const Eight radius = multiply_add(
            half[0], size(0, j),
            multiply_add(half[1], size(1, j),
                         multiply_add(half[2], size(2, j), eight(other.other_face(j)))));
        most = maximum(most, size_of(along) - radius);
    }
    const std::uint32_t met = ~(most > none).bits() & 0xFFU;
    // A leaf's slab (meet_slab) parts more than edges of its box would, and costs less.
    if (met == 0 || is_leaf(box)) return met;
    for (std::size_t i = 0; i < 3; ++i) {
        const std::size_t k = (i + 1) % 3;
        const std::size_t l = (i + 2) % 3;
        Eight beyond[3];
        for (std::size_t j = 0; j < 3; ++j) {
            const Eight along = multiply_subtract(off[l], number(k, j), off[k] * number(l, j));
            const Eight radius = multiply_add(
                half[k], size(l, j), multiply_add(half[l], size(k, j), eight(other.edge(i, j))));
            beyond[j] = size_of(along) - radius;
        }
        // Not one by one: each would wait for the last.
        most = maximum(most, maximum(maximum(beyond[0], beyond[1]), beyond[2]));
    }
    return ~(most > none).bits() & 0xFFU;
}

} // namespace proxima::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
