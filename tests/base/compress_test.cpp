#include "base/simd.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <vector>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "base/compress_test.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
// After them: it is read once for every instruction set.
#include "base/compress-inl.h"

HWY_BEFORE_NAMESPACE();
namespace proxima::HWY_NAMESPACE {

/// Of every mask, whether the lanes that it names come first and in order. Returns how many masks.
template <class Tag>
std::size_t check_masks(Tag tag)
{
    using Lane = hn::TFromD<Tag>;
    const std::size_t lanes = hn::Lanes(tag);
    std::vector<Lane> values(lanes);
    for (std::size_t i = 0; i < lanes; ++i) values[i] = static_cast<Lane>(100 + i);
    for (std::uint32_t mask = 0; mask < 1U << lanes; ++mask) {
        const std::uint8_t bits[8] = {static_cast<std::uint8_t>(mask),
                                      static_cast<std::uint8_t>(mask >> 8U)};
        std::vector<Lane> compressed(lanes);
        hn::StoreU(compress(hn::LoadU(tag, values.data()), hn::LoadMaskBits(tag, bits)), tag,
                   compressed.data());
        std::vector<Lane> named;
        for (std::size_t i = 0; i < lanes; ++i) {
            if ((mask >> i & 1U) != 0) named.push_back(values[i]);
        }
        compressed.resize(named.size());
        EXPECT_EQ(compressed, named) << "mask " << mask << " of " << lanes << " lanes";
    }
    return std::size_t{1} << lanes;
}

std::size_t check_vectors()
{
    return check_masks(hn::CappedTag<float, 4>()) + check_masks(hn::CappedTag<std::uint32_t, 8>()) +
           check_masks(hn::CappedTag<std::int32_t, 16>());
}

} // namespace proxima::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace proxima {

HWY_EXPORT(check_vectors);

namespace {

TEST(Compress, MovesTheLanesOfEveryMaskToTheFront)
{
    for (const SimdTarget& target : simd_targets()) {
        SCOPED_TRACE(target.name);
        force_simd_target(target);
        EXPECT_GE(HWY_DYNAMIC_DISPATCH(check_vectors)(), 6);
    }
    restore_simd_targets();
}

} // namespace
} // namespace proxima

#endif
