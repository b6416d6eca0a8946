// Which of a node's eight boxes may meet a box of the other mesh: by fifteen axes, eight boxes at
// once (thesis section 5.2). Included once per target, after <hwy/highway.h>.
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

#include "proxima/query/eight_lanes-inl.h"
#include "proxima/query/open_pair.h"

#include <cstddef>
#include <cstdint>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace proxima::HWY_NAMESPACE {

/// The boxes of a node's children in its mesh's frame, by axis.
struct ChildBoxes {
    HWY_ALIGN float center[3][8];
    HWY_ALIGN float half[3][8];

    HWY_INLINE void copy(const RayNode& node, std::uint32_t slot, PairBox& to) const
    {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            to.center[axis] = center[axis][slot];
            to.half[axis] = half[axis][slot];
        }
        to.reference = node.children[slot];
        to.size = to.half[0] + to.half[1] + to.half[2];
    }
};

/// Bit i: the box of child i is not surely apart from `other`, a box of the other mesh. Writes
/// `boxes` where there is such a child.
HWY_INLINE std::uint32_t meet_boxes(const RayNode& node, float unit, const PairFrame& frame,
                                    float slack, const PairBox& other, ChildBoxes& boxes)
{
    // The other box in this frame, and what it adds to the radii.
    HWY_ALIGN float at[4];
    HWY_ALIGN float reach[4];
    HWY_ALIGN float edge_reach[3][4];
    for (std::size_t i = 0; i < 4; ++i) {
        at[i] = frame.offset[i] +
                (frame.columns[0][i] * other.center[0] +
                 (frame.columns[1][i] * other.center[1] + frame.columns[2][i] * other.center[2]));
    }
    for (std::size_t i = 0; i < 4; ++i) {
        reach[i] =
            slack +
            (frame.column_sizes[0][i] * other.half[0] +
             (frame.column_sizes[1][i] * other.half[1] + frame.column_sizes[2][i] * other.half[2]));
    }
    Eight center[3];
    Eight half[3];
    Eight off[3];
    Eight most; // by how much the axis that parts most exceeds the radii
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const Eight lower = eight_of_bytes(node.planes[axis].data());
        const Eight upper = eight_of_bytes(node.planes[axis].data() + 8);
        const Eight half_step = all_eight(node.step[axis] * (0.5F * unit));
        const float origin = (node.origin[axis] + 32768.0F * node.step[axis]) * unit;
        center[axis] = multiply_add(lower + upper, half_step, all_eight(origin));
        half[axis] = (upper - lower) * half_step;
        off[axis] = all_eight(at[axis]) - center[axis];
        const Eight beyond = size_of(off[axis]) - (half[axis] + all_eight(reach[axis]));
        // Places without a child have their planes the wrong way round.
        most = axis == 0 ? most_of(beyond, -half[0]) : most_of(most, beyond);
    }
    const Eight none = all_eight(0);
    if ((most > none).bits() == 0xFFU) return 0;
    for (std::size_t j = 0; j < 3; ++j) {
        const auto& column = frame.columns[j];
        const auto& size = frame.column_sizes[j];
        const Eight along =
            multiply_add(off[0], all_eight(column[0]),
                         multiply_add(off[1], all_eight(column[1]), off[2] * all_eight(column[2])));
        const Eight radius =
            multiply_add(half[0], all_eight(size[0]),
                         multiply_add(half[1], all_eight(size[1]),
                                      multiply_add(half[2], all_eight(size[2]),
                                                   all_eight(other.half[j] + slack))));
        most = most_of(most, size_of(along) - radius);
    }
    if ((most > none).bits() == 0xFFU) return 0;
    for (std::size_t j = 0; j < 3; ++j) {
        const auto& next = frame.column_sizes[(j + 1) % 3];
        const auto& last = frame.column_sizes[(j + 2) % 3];
        for (std::size_t i = 0; i < 4; ++i) {
            edge_reach[j][i] =
                slack + (other.half[(j + 1) % 3] * last[i] + other.half[(j + 2) % 3] * next[i]);
        }
    }
    for (std::size_t i = 0; i < 3; ++i) {
        const std::size_t k = (i + 1) % 3;
        const std::size_t l = (i + 2) % 3;
        for (std::size_t j = 0; j < 3; ++j) {
            const auto& column = frame.columns[j];
            const auto& size = frame.column_sizes[j];
            const Eight along =
                multiply_subtract(off[l], all_eight(column[k]), off[k] * all_eight(column[l]));
            const Eight radius = multiply_add(
                half[k], all_eight(size[l]),
                multiply_add(half[l], all_eight(size[k]), all_eight(edge_reach[j][i])));
            most = most_of(most, size_of(along) - radius);
        }
    }
    const std::uint32_t met = ~(most > none).bits() & 0xFFU;
    if (met == 0) return 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        store_eight(center[axis], boxes.center[axis]);
        store_eight(half[axis], boxes.half[axis]);
    }
    return met;
}

} // namespace proxima::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
