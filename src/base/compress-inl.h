// Moves the lanes that a mask names to the front of a vector. Included once per target, after
// <hwy/highway.h>.
//
// hn::Compress of Highway 1.0.3 has the tables that AVX2 and SSE need inside its functions. g++ 12
// copies them to the stack in every call, a kilobyte on AVX2. Here they are static.

#ifndef PROXIMA_BASE_COMPRESS_TABLES
#define PROXIMA_BASE_COMPRESS_TABLES

#include <array>
#include <cstddef>
#include <cstdint>

namespace proxima {

/// By mask of eight lanes: the lanes it names, then the others, each from the lowest up, as four
/// bits per lane.
inline constexpr std::array<std::uint32_t, 256> compressed_lanes = [] {
    std::array<std::uint32_t, 256> table{};
    for (std::uint32_t mask = 0; mask < table.size(); ++mask) {
        std::uint32_t count = 0;
        for (const std::uint32_t named : {1U, 0U}) {
            for (std::uint32_t lane = 0; lane < 8; ++lane) {
                if ((mask >> lane & 1U) == named) table[mask] |= lane << (4 * count++);
            }
        }
    }
    return table;
}();

/// By mask of four lanes, as the bytes of each lane.
inline constexpr std::array<std::array<std::uint8_t, 16>, 16> compressed_bytes = [] {
    std::array<std::array<std::uint8_t, 16>, 16> table{};
    for (std::size_t mask = 0; mask < table.size(); ++mask) {
        for (std::size_t byte = 0; byte < 16; ++byte) {
            const std::size_t lane = compressed_lanes[mask] >> (byte & ~std::size_t{3}) & 3U;
            table[mask][byte] = static_cast<std::uint8_t>(4 * lane + byte % 4);
        }
    }
    return table;
}();

} // namespace proxima

#endif

#if defined(PROXIMA_BASE_COMPRESS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef PROXIMA_BASE_COMPRESS_INL_H
#undef PROXIMA_BASE_COMPRESS_INL_H
#else
#define PROXIMA_BASE_COMPRESS_INL_H
#endif

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace proxima::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

#if HWY_TARGET == HWY_AVX2
/// The eight lanes that bits of `named` name, in their order, then the others. \pre named < 256
template <class V>
HWY_INLINE V compress_eight(V lanes, std::size_t named)
{
    using Tag = hn::DFromV<V>;
    const hn::RebindToUnsigned<Tag> words;
    alignas(32) static constexpr std::uint32_t shifts[8] = {0, 4, 8, 12, 16, 20, 24, 28};
    // Looking up reads three bits of each index.
    const auto indices = hn::Shr(hn::Set(words, compressed_lanes[named]), hn::Load(words, shifts));
    return hn::TableLookupLanes(lanes, hn::Indices256<hn::TFromD<Tag>>{indices.raw});
}
#endif

/// The lanes of the mask, of 32 bits each, in their order; then any of the others.
template <class V, class M>
HWY_INLINE V compress(V lanes, M mask)
{
    using Tag = hn::DFromV<V>;
    static_assert(sizeof(hn::TFromD<Tag>) == 4);
#if HWY_TARGET == HWY_AVX2 || HWY_TARGET == HWY_SSE4 || HWY_TARGET == HWY_SSSE3
    const Tag tag;
    const hn::Rebind<float, Tag> floats;
    const auto all = hn::BitCast(floats, hn::VecFromMask(tag, mask)).raw;
    if constexpr (hn::MaxLanes(tag) == 4) {
        const hn::Repartition<std::uint8_t, Tag> bytes;
        const auto named = static_cast<std::size_t>(_mm_movemask_ps(all));
        return hn::BitCast(tag,
                           hn::TableLookupBytes(hn::BitCast(bytes, lanes),
                                                hn::LoadU(bytes, compressed_bytes[named].data())));
    }
#if HWY_TARGET == HWY_AVX2
    if constexpr (hn::MaxLanes(tag) == 8)
        return compress_eight(lanes, static_cast<std::size_t>(_mm256_movemask_ps(all)));
#endif
#endif
    return hn::Compress(lanes, mask);
}

} // namespace proxima::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
