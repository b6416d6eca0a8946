// Looks up floats in a table of 32: in registers where the instruction set can, in memory
// elsewhere. Included once per target, after <hwy/highway.h>.

#if defined(PROXIMA_BASE_LOOKUP_LANES_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef PROXIMA_BASE_LOOKUP_LANES_INL_H
#undef PROXIMA_BASE_LOOKUP_LANES_INL_H
#else
#define PROXIMA_BASE_LOOKUP_LANES_INL_H
#endif

#include "base/compress-inl.h"

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
#elif HWY_TARGET == HWY_AVX2
        for (std::size_t i = 0; i < 4; ++i) quarters_[i] = load(8 * i);
#else
        for (std::size_t i = 0; i < 32; i += hn::Lanes(tag)) hn::Store(load(i), tag, values_ + i);
#endif
    }

    /// Entry `index` mod 32 in each lane.
    HWY_INLINE hn::Vec<LookupTag> at(hn::Vec<LookupIndexTag> index) const
    {
#if HWY_TARGET <= HWY_AVX3 && HWY_ARCH_X86
        return hn::Vec<LookupTag>{_mm512_permutex2var_ps(low_.raw, index.raw, high_.raw)};
#elif HWY_TARGET == HWY_AVX2
        // Looking up reads three bits of each index; bits 3 and 4 choose among the quarters.
        const LookupTag tag;
        const auto quarter = [&](std::size_t i) {
            return hn::TableLookupLanes(quarters_[i], hn::Indices256<float>{index.raw});
        };
        const auto is_odd = hn::MaskFromVec(hn::BitCast(tag, hn::ShiftLeft<28>(index)));
        const auto is_upper = hn::MaskFromVec(hn::BitCast(tag, hn::ShiftLeft<27>(index)));
        return hn::IfThenElse(is_upper, hn::IfThenElse(is_odd, quarter(3), quarter(2)),
                              hn::IfThenElse(is_odd, quarter(1), quarter(0)));
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
#elif HWY_TARGET == HWY_AVX2
    hn::Vec<LookupTag> quarters_[4];
#else
    alignas(64) float values_[32];
#endif
};

/// Of 32 numbers of 16 bits those that a mask names, at most sixteen, as lanes from the first on.
/// What the other lanes hold is any of the numbers or 0. 64 bytes are read.
class NamedNumbers {
public:
    HWY_INLINE NamedNumbers(const std::uint16_t* numbers, std::uint32_t mask)
    {
#if HWY_TARGET <= HWY_AVX3 && HWY_ARCH_X86
        const LookupIndexTag wide;
        const hn::Rebind<std::uint16_t, LookupTag> narrow;
        const auto low = hn::PromoteTo(wide, hn::LoadU(narrow, numbers));
        const auto high = hn::PromoteTo(wide, hn::LoadU(narrow, numbers + 16));
        const auto low_mask = static_cast<__mmask16>(mask & 0xFFFFU);
        const auto high_mask = static_cast<__mmask16>(mask >> 16U);
        // Those of the upper half move behind those of the lower one.
        const auto count = static_cast<unsigned>(__builtin_popcount(mask & 0xFFFFU));
        const auto indices = hn::Sub(hn::Iota(wide, 0), hn::Set(wide, static_cast<int>(count)));
        const auto behind =
            _mm512_permutexvar_epi32(indices.raw, _mm512_maskz_compress_epi32(high_mask, high.raw));
        const auto first = static_cast<__mmask16>((1U << count) - 1);
        lanes_ = hn::Vec<LookupIndexTag>{
            _mm512_mask_mov_epi32(behind, first, _mm512_maskz_compress_epi32(low_mask, low.raw))};
#elif HWY_TARGET == HWY_AVX2
        const LookupIndexTag wide;
        const hn::Rebind<std::uint16_t, LookupTag> narrow;
        for (std::size_t i = 0; i < 16; i += 8) hn::Store(hn::Zero(wide), wide, values_ + i);
        std::size_t count = 0;
        for (std::size_t i = 0; i < 32; i += 8) {
            const std::uint32_t named = mask >> i & 0xFFU;
            const auto group = hn::PromoteTo(wide, hn::LoadU(narrow, numbers + i));
            hn::StoreU(compress_eight(group, named), wide, values_ + count);
            count += static_cast<std::size_t>(__builtin_popcount(named));
        }
#else
        std::size_t count = 0;
        for (std::uint32_t left = mask; left != 0 && count < 16; left &= left - 1)
            values_[count++] = numbers[__builtin_ctz(left)];
        for (; count < 16; ++count) values_[count] = 0;
#endif
    }

    /// Lanes from `first` on. \pre a multiple of the number of lanes, below 16
    HWY_INLINE hn::Vec<LookupIndexTag> from(std::size_t first) const
    {
#if HWY_TARGET <= HWY_AVX3 && HWY_ARCH_X86
        (void)first;
        return lanes_;
#elif HWY_TARGET == HWY_AVX2
        return hn::Load(LookupIndexTag(), values_ + first);
#else
        const LookupIndexTag wide;
        const hn::Rebind<std::uint16_t, LookupTag> narrow;
        return hn::PromoteTo(wide, hn::Load(narrow, values_ + first));
#endif
    }

private:
#if HWY_TARGET <= HWY_AVX3 && HWY_ARCH_X86
    hn::Vec<LookupIndexTag> lanes_;
#elif HWY_TARGET == HWY_AVX2
    alignas(64) std::int32_t values_[24]; // sixteen, and what the last store writes behind them
#else
    alignas(64) std::uint16_t values_[16];
#endif
};

} // namespace proxima::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
