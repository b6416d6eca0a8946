// Eight floats as one value, in as many registers as the instruction set needs. Included once per
// target, after <hwy/highway.h>.

#if defined(PROXIMA_BASE_EIGHT_LANES_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef PROXIMA_BASE_EIGHT_LANES_INL_H
#undef PROXIMA_BASE_EIGHT_LANES_INL_H
#else
#define PROXIMA_BASE_EIGHT_LANES_INL_H
#endif

#include "base/inline_steps-inl.h"

#include <cstddef>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace proxima::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using EightTag = hn::CappedTag<float, 8>;
inline constexpr std::size_t eight_lanes = HWY_MIN(8, HWY_LANES(float)); ///< of a register
inline constexpr std::size_t eight_parts = 8 / eight_lanes;

struct Eight {
    hn::Vec<EightTag> part[eight_parts];
};

/// By register: make(i) is that of lanes eight_lanes * i on.
template <class Make>
HWY_INLINE Eight make_eight(const Make& make)
{
    Eight result;
    for (std::size_t i = 0; i < eight_parts; ++i) result.part[i] = make(i);
    return result;
}

PROXIMA_LANE_OP Eight eight(float value)
{
    return make_eight([&](std::size_t) { return hn::Set(EightTag(), value); });
}
PROXIMA_LANE_OP Eight load_eight(const float* from)
{
    return make_eight([&](std::size_t i) { return hn::LoadU(EightTag(), from + eight_lanes * i); });
}
PROXIMA_LANE_OP void store_eight(const Eight& value, float* to)
{
    for (std::size_t i = 0; i < eight_parts; ++i)
        hn::StoreU(value.part[i], EightTag(), to + eight_lanes * i);
}

PROXIMA_LANE_OP Eight operator+(const Eight& a, const Eight& b)
{
    return make_eight([&](std::size_t i) { return hn::Add(a.part[i], b.part[i]); });
}
PROXIMA_LANE_OP Eight operator-(const Eight& a, const Eight& b)
{
    return make_eight([&](std::size_t i) { return hn::Sub(a.part[i], b.part[i]); });
}
PROXIMA_LANE_OP Eight operator*(const Eight& a, const Eight& b)
{
    return make_eight([&](std::size_t i) { return hn::Mul(a.part[i], b.part[i]); });
}
PROXIMA_LANE_OP Eight minimum(const Eight& a, const Eight& b)
{
    return make_eight([&](std::size_t i) { return hn::Min(a.part[i], b.part[i]); });
}
PROXIMA_LANE_OP Eight maximum(const Eight& a, const Eight& b)
{
    return make_eight([&](std::size_t i) { return hn::Max(a.part[i], b.part[i]); });
}

} // namespace proxima::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
