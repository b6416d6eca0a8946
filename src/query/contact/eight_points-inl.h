// Eight points as one value, masks of eight, and looking up by eight indices. Included once per
// target, after <hwy/highway.h>.

#if defined(PROXIMA_QUERY_EIGHT_POINTS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef PROXIMA_QUERY_EIGHT_POINTS_INL_H
#undef PROXIMA_QUERY_EIGHT_POINTS_INL_H
#else
#define PROXIMA_QUERY_EIGHT_POINTS_INL_H
#endif

#include "base/eight_lanes-inl.h"

#include <cstddef>
#include <cstdint>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace proxima::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using EightWordTag = hn::RebindToUnsigned<EightTag>;
using EightByteTag = hn::Rebind<std::uint8_t, EightTag>;

/// Bit i: lane i.
struct EightMask {
    hn::Mask<EightTag> part[eight_parts];

    HWY_INLINE std::uint32_t bits() const
    {
        std::uint32_t bits = 0;
        for (std::size_t i = 0; i < eight_parts; ++i) {
            std::uint8_t bytes[8] = {};
            (void)hn::StoreMaskBits(EightTag(), part[i], bytes);
            bits |= static_cast<std::uint32_t>(bytes[0]) << (eight_lanes * i);
        }
        return bits;
    }
};

/// Eight whole numbers below 8.
struct EightIndices {
    hn::Vec<EightWordTag> part[eight_parts];
};

template <class Make>
HWY_INLINE EightMask make_mask(const Make& make)
{
    EightMask result;
    for (std::size_t i = 0; i < eight_parts; ++i) result.part[i] = make(i);
    return result;
}

PROXIMA_LANE_OP Eight eight_of_bytes(const std::uint8_t* bytes)
{
    const hn::RebindToSigned<EightTag> whole;
    return make_eight([&](std::size_t i) {
        const auto narrow = hn::LoadU(EightByteTag(), bytes + eight_lanes * i);
        return hn::ConvertTo(EightTag(), hn::PromoteTo(whole, narrow));
    });
}

PROXIMA_LANE_OP Eight operator-(const Eight& a)
{
    return make_eight([&](std::size_t i) { return hn::Neg(a.part[i]); });
}
/// a b + c, a b - c, c - a b.
PROXIMA_LANE_OP Eight multiply_add(const Eight& a, const Eight& b, const Eight& c)
{
    return make_eight([&](std::size_t i) { return hn::MulAdd(a.part[i], b.part[i], c.part[i]); });
}
PROXIMA_LANE_OP Eight multiply_subtract(const Eight& a, const Eight& b, const Eight& c)
{
    return make_eight([&](std::size_t i) { return hn::MulSub(a.part[i], b.part[i], c.part[i]); });
}
PROXIMA_LANE_OP Eight subtract_product(const Eight& a, const Eight& b, const Eight& c)
{
    return make_eight(
        [&](std::size_t i) { return hn::NegMulAdd(a.part[i], b.part[i], c.part[i]); });
}
PROXIMA_LANE_OP Eight size_of(const Eight& a)
{
    return make_eight([&](std::size_t i) { return hn::Abs(a.part[i]); });
}
PROXIMA_LANE_OP EightMask operator>(const Eight& a, const Eight& b)
{
    return make_mask([&](std::size_t i) { return hn::Gt(a.part[i], b.part[i]); });
}
PROXIMA_LANE_OP EightMask operator<(const Eight& a, const Eight& b)
{
    return make_mask([&](std::size_t i) { return hn::Lt(a.part[i], b.part[i]); });
}
PROXIMA_LANE_OP EightMask operator&(const EightMask& a, const EightMask& b)
{
    return make_mask([&](std::size_t i) { return hn::And(a.part[i], b.part[i]); });
}
PROXIMA_LANE_OP EightMask operator|(const EightMask& a, const EightMask& b)
{
    return make_mask([&](std::size_t i) { return hn::Or(a.part[i], b.part[i]); });
}

/// Eight bytes, below 8.
PROXIMA_LANE_OP EightIndices indices_of_bytes(const std::uint8_t* bytes)
{
    EightIndices result;
    for (std::size_t i = 0; i < eight_parts; ++i) {
        result.part[i] =
            hn::PromoteTo(EightWordTag(), hn::LoadU(EightByteTag(), bytes + eight_lanes * i));
    }
    return result;
}
/// By lane the value at its index.
PROXIMA_LANE_OP Eight look_up(const Eight& values, const EightIndices& indices)
{
    const EightTag d;
    if constexpr (eight_parts == 1) {
        return make_eight([&](std::size_t i) {
            return hn::TableLookupLanes(values.part[i], hn::IndicesFromVec(d, indices.part[i]));
        });
    } else {
        HWY_ALIGN float memory[8];
        store_eight(values, memory);
        const hn::RebindToSigned<EightTag> whole;
        return make_eight([&](std::size_t i) {
            return hn::GatherIndex(d, memory, hn::BitCast(whole, indices.part[i]));
        });
    }
}

/// Eight points, or vectors.
struct Eight3 {
    Eight x;
    Eight y;
    Eight z;
};

PROXIMA_LANE_OP Eight3 operator-(const Eight3& a, const Eight3& b)
{
    return {a.x - b.x, a.y - b.y, a.z - b.z};
}
PROXIMA_LANE_OP Eight3 cross(const Eight3& a, const Eight3& b)
{
    return {subtract_product(a.z, b.y, a.y * b.z), subtract_product(a.x, b.z, a.z * b.x),
            subtract_product(a.y, b.x, a.x * b.y)};
}
PROXIMA_LANE_OP Eight dot(const Eight3& a, const Eight3& b)
{
    return multiply_add(a.x, b.x, multiply_add(a.y, b.y, a.z * b.z));
}
PROXIMA_LANE_OP Eight3 look_up(const Eight3& values, const EightIndices& indices)
{
    return {look_up(values.x, indices), look_up(values.y, indices), look_up(values.z, indices)};
}

} // namespace proxima::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
