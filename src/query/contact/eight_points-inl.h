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

/// The sum, the least and the most of eight lanes.
PROXIMA_LANE_OP float sum_of(const Eight& a)
{
    auto sum = a.part[0];
    for (std::size_t i = 1; i < eight_parts; ++i) sum = hn::Add(sum, a.part[i]);
    return hn::GetLane(hn::SumOfLanes(EightTag(), sum));
}
PROXIMA_LANE_OP float least_of(const Eight& a)
{
    auto least = a.part[0];
    for (std::size_t i = 1; i < eight_parts; ++i) least = hn::Min(least, a.part[i]);
    return hn::GetLane(hn::MinOfLanes(EightTag(), least));
}
PROXIMA_LANE_OP float most_of(const Eight& a)
{
    auto most = a.part[0];
    for (std::size_t i = 1; i < eight_parts; ++i) most = hn::Max(most, a.part[i]);
    return hn::GetLane(hn::MaxOfLanes(EightTag(), most));
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

/// Row i of the eight rows at `to` is lane i of all columns.
PROXIMA_LANE_OP void store_rows(const Eight (&columns)[8], float* to)
{
#if HWY_MAX_BYTES < 32
    HWY_ALIGN float column[8];
    for (std::size_t i = 0; i < 8; ++i) {
        store_eight(columns[i], column);
        for (std::size_t row = 0; row < 8; ++row) to[8 * row + i] = column[row];
    }
#else
    const EightTag d;
    const hn::RepartitionToWide<EightTag> pairs;
    using Vector = hn::Vec<EightTag>;
    // Two columns at a time, then four; each register has a row in either half.
    for (std::size_t upper = 0; upper < 2; ++upper) {
        const auto two = [&](std::size_t i) {
            const Vector a = columns[i].part[0];
            const Vector b = columns[i + 1].part[0];
            return hn::BitCast(pairs, upper == 0 ? hn::InterleaveLower(d, a, b)
                                                 : hn::InterleaveUpper(d, a, b));
        };
        const auto ab = two(0);
        const auto cd = two(2);
        const auto ef = two(4);
        const auto gh = two(6);
        const auto store = [&](std::size_t row, const auto& first, const auto& last) {
            const Vector low = hn::BitCast(d, first);
            const Vector high = hn::BitCast(d, last);
            hn::StoreU(hn::ConcatLowerLower(d, high, low), d, to + 8 * row);
            hn::StoreU(hn::ConcatUpperUpper(d, high, low), d, to + 8 * (row + 4));
        };
        store(2 * upper, hn::InterleaveLower(pairs, ab, cd), hn::InterleaveLower(pairs, ef, gh));
        store(2 * upper + 1, hn::InterleaveUpper(pairs, ab, cd),
              hn::InterleaveUpper(pairs, ef, gh));
    }
#endif
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
