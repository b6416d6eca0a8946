// Looks up floats in a table of 32: in registers where the instruction set can, in memory
// elsewhere. Included once per target, after <hwy/highway.h>.

#if defined(PROXIMA_BASE_LOOKUP_LANES_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef PROXIMA_BASE_LOOKUP_LANES_INL_H
#undef PROXIMA_BASE_LOOKUP_LANES_INL_H
#else
#define PROXIMA_BASE_LOOKUP_LANES_INL_H
#endif

#include <cstddef>
#include <cstdint>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace proxima::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

/// At most sixteen lanes.
using LookupTag = hn::CappedTag<float, 16>;
using LookupIndexTag = hn::RebindToSigned<LookupTag>;

/// Thirty-two numbers of 16 bits as floats. 64 bytes are read.
class LookupTable {
public:
    HWY_INLINE explicit LookupTable(const std::uint16_t* numbers)
    {
        const LookupTag tag;
        const hn::Rebind<std::uint16_t, LookupTag> narrow;
        const LookupIndexTag wide;
        const auto load = [&](std::size_t first) {
            return hn::ConvertTo(tag, hn::PromoteTo(wide, hn::LoadU(narrow, numbers + first)));
        };
#if HWY_TARGET <= HWY_AVX3 && HWY_ARCH_X86
        low_ = load(0);
        high_ = load(16);
#else
        for (std::size_t i = 0; i < 32; i += hn::Lanes(tag)) hn::Store(load(i), tag, values_ + i);
#endif
    }

    /// Entry `index` mod 32 in each lane.
    HWY_INLINE hn::Vec<LookupTag> at(hn::Vec<LookupIndexTag> index) const
    {
#if HWY_TARGET <= HWY_AVX3 && HWY_ARCH_X86
        return hn::Vec<LookupTag>{_mm512_permutex2var_ps(low_.raw, index.raw, high_.raw)};
#else
        const LookupTag tag;
        const LookupIndexTag index_tag;
        return hn::GatherIndex(tag, values_, hn::And(index, hn::Set(index_tag, 31)));
#endif
    }

private:
#if HWY_TARGET <= HWY_AVX3 && HWY_ARCH_X86
    hn::Vec<LookupTag> low_;
    hn::Vec<LookupTag> high_;
#else
    alignas(64) float values_[32];
#endif
};

} // namespace proxima::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
