// Eight floats, one per child or corner of a cell. Included once per target, after <hwy/highway.h>.
// Octant bit 0 = x, 1 = y, 2 = z, set in the upper half.
//
// No multiply-add: decisions have the same bits everywhere.

#if defined(PROXIMA_PROXIMITY_EIGHT_CORNERS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef PROXIMA_PROXIMITY_EIGHT_CORNERS_INL_H
#undef PROXIMA_PROXIMITY_EIGHT_CORNERS_INL_H
#else
#define PROXIMA_PROXIMITY_EIGHT_CORNERS_INL_H
#endif

#include "base/eight_lanes-inl.h"

#include <cstddef>
#include <cstdint>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace proxima::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

PROXIMA_LANE_OP Eight square_root(const Eight& a)
{
    return make_eight([&](std::size_t i) { return hn::Sqrt(a.part[i]); });
}
PROXIMA_LANE_OP Eight absolute(const Eight& a)
{
    return make_eight([&](std::size_t i) { return hn::Abs(a.part[i]); });
}
/// Bit i: a[i] <= b[i].
PROXIMA_LANE_OP std::uint32_t at_most(const Eight& a, const Eight& b)
{
    std::uint32_t bits = 0;
    for (std::size_t i = 0; i < eight_parts; ++i) {
        std::uint8_t part[8] = {};
        (void)hn::StoreMaskBits(EightTag(), hn::Le(a.part[i], b.part[i]), part);
        bits |= static_cast<std::uint32_t>(part[0]) << (i * hn::Lanes(EightTag()));
    }
    return bits;
}
/// a where `if_a` <= `if_b`, otherwise b.
PROXIMA_LANE_OP Eight choose(const Eight& if_a, const Eight& if_b, const Eight& a, const Eight& b)
{
    return make_eight([&](std::size_t i) {
        return hn::IfThenElse(hn::Le(if_a.part[i], if_b.part[i]), a.part[i], b.part[i]);
    });
}

/// One coordinate of the eight corners about the origin: -1 or 1 by the octant's bit.
alignas(32) inline constexpr float corner_signs[3][8] = {
    {-1, 1, -1, 1, -1, 1, -1, 1}, {-1, -1, 1, 1, -1, -1, 1, 1}, {-1, -1, -1, -1, 1, 1, 1, 1}};

/// n . corner for the eight corners (+-1, +-1, +-1).
PROXIMA_LANE_OP Eight dot_corners(const float* n)
{
    return eight(n[0]) * load_eight(corner_signs[0]) + eight(n[1]) * load_eight(corner_signs[1]) +
           eight(n[2]) * load_eight(corner_signs[2]);
}

/// Calls visit(corner, opposite, n . corner) for four corners (+-1, +-1, +-1), of eight n in lanes;
/// that of the opposite corner is the same with the other sign.
template <class Visit>
HWY_INLINE void for_corner_pairs(const Eight& x, const Eight& y, const Eight& z, const Visit& visit)
{
    const Eight same = x + y;
    const Eight other = x - y;
    visit(7, 0, same + z);
    visit(5, 2, other + z);
    visit(1, 6, other - z);
    visit(3, 4, same - z);
}

} // namespace proxima::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
