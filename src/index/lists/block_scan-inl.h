// Finds the triangles of a block that may be closest to a point. Included once per target.

#if defined(PROXIMA_PROXIMITY_BLOCK_SCAN_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef PROXIMA_PROXIMITY_BLOCK_SCAN_INL_H
#undef PROXIMA_PROXIMITY_BLOCK_SCAN_INL_H
#else
#define PROXIMA_PROXIMITY_BLOCK_SCAN_INL_H
#endif

#include "base/inline_steps-inl.h"
#include "base/lookup_lanes-inl.h"
#include "index/lists/block.h"

#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace proxima::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

/// A block's candidates for the closest triangle.
struct BlockCandidates {
    alignas(64) std::int32_t indices[list_triangles]; ///< of the triangles asked for
    const std::byte* ranks = nullptr;
    std::uint32_t lanes = 0; ///< bit i: triangle indices[i] of the block
    std::uint32_t base = 0;
    bool wide = false;

    HWY_INLINE std::uint32_t rank(int lane) const
    {
        const std::ptrdiff_t i = indices[lane];
        if (wide) {
            std::uint32_t value = 0;
            std::memcpy(&value, ranks + 4 * i, 4);
            return base + value;
        }
        std::uint16_t value = 0;
        std::memcpy(&value, ranks + 2 * i, 2);
        return base + value;
    }
};

/// Three lanes of coordinates.
struct LanePoint {
    hn::Vec<LookupTag> x;
    hn::Vec<LookupTag> y;
    hn::Vec<LookupTag> z;
};

HWY_INLINE LanePoint operator-(const LanePoint& a, const LanePoint& b)
{
    return {hn::Sub(a.x, b.x), hn::Sub(a.y, b.y), hn::Sub(a.z, b.z)};
}
HWY_INLINE hn::Vec<LookupTag> dot(const LanePoint& a, const LanePoint& b)
{
    return hn::MulAdd(a.z, b.z, hn::MulAdd(a.y, b.y, hn::Mul(a.x, b.x)));
}
/// a - t b
HWY_INLINE LanePoint less(const LanePoint& a, hn::Vec<LookupTag> t, const LanePoint& b)
{
    return {hn::NegMulAdd(t, b.x, a.x), hn::NegMulAdd(t, b.y, a.y), hn::NegMulAdd(t, b.z, a.z)};
}

/// 1 / a to some 2^-22, of numbers of at least 1.
HWY_INLINE hn::Vec<LookupTag> inverse(hn::Vec<LookupTag> a)
{
    const LookupTag tag;
    const auto guess = hn::ApproximateReciprocal(a);
    const auto better = hn::Mul(guess, hn::NegMulAdd(a, guess, hn::Set(tag, 2.0F)));
#if HWY_TARGET <= HWY_AVX3 && HWY_ARCH_X86
    return better; // from 14 bits
#else
    return hn::Mul(better, hn::NegMulAdd(a, better, hn::Set(tag, 2.0F)));
#endif
}

/// Squared distances from points `p` (relative to the first corner) to triangles with these sides
/// from it: of points of the triangles, whatever the rounding.
HWY_INLINE hn::Vec<LookupTag> squared_distances(const LanePoint& p, const LanePoint& ab,
                                                const LanePoint& ac)
{
    const LookupTag tag;
    const auto zero = hn::Zero(tag);
    const auto one = hn::Set(tag, 1.0F);
    const auto clamped = [&](hn::Vec<LookupTag> t) { return hn::Min(hn::Max(t, zero), one); };
    const auto bb = dot(ab, ab);
    const auto bc = dot(ab, ac);
    const auto cc = dot(ac, ac);
    const auto pb = dot(p, ab);
    const auto pc = dot(p, ac);
    // Sides are whole numbers: squared at least 1, or 0, where the numerator is 0 as well.
    const LanePoint to_ab = less(p, clamped(hn::Mul(pb, inverse(hn::Max(bb, one)))), ab);
    const LanePoint to_ac = less(p, clamped(hn::Mul(pc, inverse(hn::Max(cc, one)))), ac);
    const LanePoint side = ac - ab;
    const LanePoint q = p - ab;
    const auto along = hn::Mul(dot(q, side), inverse(hn::Max(dot(side, side), one)));
    const LanePoint to_side = less(q, clamped(along), side);
    const auto sides =
        hn::Min(hn::Min(dot(to_ab, to_ab), dot(to_ac, to_ac)), dot(to_side, to_side));

    const auto determinant = hn::NegMulAdd(bc, bc, hn::Mul(bb, cc));
    const auto scale = inverse(hn::Max(determinant, one));
    const auto v = hn::Mul(hn::NegMulAdd(bc, pc, hn::Mul(cc, pb)), scale);
    const auto w = hn::Mul(hn::NegMulAdd(bc, pb, hn::Mul(bb, pc)), scale);
    const auto u = hn::Sub(hn::Sub(one, v), w);
    const auto inside = hn::Ge(hn::Min(hn::Min(v, w), u), zero);
    const LanePoint rest = less(less(p, v, ab), w, ac);
    return hn::IfThenElse(inside, hn::Min(dot(rest, rest), sides), sides);
}

/// What a scan starts from: a point in the block's units.
struct BlockPoint {
    float x = 0;
    float y = 0;
    float z = 0;
    float error = 0; ///< of a distance, as computed against the true one, in units
};

HWY_INLINE BlockPoint to_block(const BlockHeader& header, const Vec3& p)
{
    const auto units = static_cast<double>(header.inverse_unit);
    BlockPoint point;
    point.x = static_cast<float>((p[0] - static_cast<double>(header.origin[0])) * units);
    point.y = static_cast<float>((p[1] - static_cast<double>(header.origin[1])) * units);
    point.z = static_cast<float>((p[2] - static_cast<double>(header.origin[2])) * units);
    // No corner is farther. Grid: sqrt(3)/2. Floats: less than 32 roundings of that length.
    const float farthest =
        1.7320509F *
        (HWY_MAX(HWY_MAX(std::abs(point.x), std::abs(point.y)), std::abs(point.z)) + 65536.0F);
    const auto half_float = [](std::uint16_t upper) {
        return std::bit_cast<float>(static_cast<std::uint32_t>(upper) << 16U);
    };
    point.error = 0.8660255F + half_float(header.slack_size) +
                  (0x1p-19F + half_float(header.slack_reach)) * farthest;
    return point;
}

/// All indices of a block.
alignas(64) inline constexpr std::uint16_t block_indices[block_triangles] = {
    0,  1,  2,  3,  4,  5,  6,  7,  8,  9,  10, 11, 12, 13, 14, 15,
    16, 17, 18, 19, 20, 21, 22, 23, 24, 25, 26, 27, 28, 29, 30, 31};

/// Of the block's triangles that `mask` names, at most 16, those that no other one of them is
/// surely closer than. With `bound`, a distance in units, only those that may be closer than it.
template <bool HasBound>
PROXIMA_STEP void scan_block(const std::byte* block, std::uint32_t mask, const Vec3& p,
                             double bound, BlockCandidates& candidates)
{
    BlockHeader header;
    std::memcpy(&header, block, sizeof(header));
    const BlockLayout layout = block_layout(header.vertices, header.triangles, header.wide != 0);
    const auto* const corners = reinterpret_cast<const std::uint16_t*>(block + layout.corners);
    const auto count = static_cast<std::size_t>(std::popcount(mask));
    const NamedNumbers listed(corners, mask);
    const NamedNumbers listed_indices(block_indices, mask);
    const BlockPoint point = to_block(header, p);
    const auto numbers = [&](std::size_t axis) {
        return reinterpret_cast<const std::uint16_t*>(block + sizeof(BlockHeader) +
                                                      2 * axis * header.vertices);
    };
    const LookupTable xs(numbers(0));
    const LookupTable ys(numbers(1));
    const LookupTable zs(numbers(2));

    const LookupTag tag;
    const LookupIndexTag wide;
    const LanePoint query{hn::Set(tag, point.x), hn::Set(tag, point.y), hn::Set(tag, point.z)};
    constexpr std::size_t lanes = HWY_MIN(16, HWY_LANES(float));
    const std::size_t parts = (count + lanes - 1) / lanes;
    hn::Vec<LookupTag> squared[list_triangles / lanes];
    auto least = hn::Set(tag, std::numeric_limits<float>::max());
    for (std::size_t part = 0; part < parts; ++part) {
        const auto indices = listed.from(part * lanes);
        hn::Store(listed_indices.from(part * lanes), wide, candidates.indices + part * lanes);
        const auto at = [&](hn::Vec<LookupIndexTag> index) {
            return LanePoint{xs.at(index), ys.at(index), zs.at(index)};
        };
        const LanePoint a = at(indices);
        const LanePoint ab = at(hn::ShiftRight<5>(indices)) - a;
        const LanePoint ac = at(hn::ShiftRight<10>(indices)) - a;
        const auto used = hn::FirstN(tag, count - part * lanes);
        squared[part] = hn::IfThenElse(used, squared_distances(query - a, ab, ac),
                                       hn::Set(tag, std::numeric_limits<float>::max()));
        least = hn::Min(least, squared[part]);
    }
    // Beyond the least distance by more than both errors: surely farther.
    float limit = std::sqrt(hn::GetLane(hn::MinOfLanes(tag, least)));
    if (HasBound) limit = HWY_MIN(limit, static_cast<float>(bound) - point.error);
    limit += 2 * point.error;
    const auto limit_squared = hn::Set(tag, limit > 0 ? limit * limit * (1 + 0x1p-20F) : -1.0F);
    candidates.lanes = 0;
    candidates.ranks = block + layout.ranks;
    candidates.base = header.base;
    candidates.wide = header.wide != 0;
    for (std::size_t part = 0; part < parts; ++part) {
        std::uint8_t bits[8] = {};
        (void)hn::StoreMaskBits(tag, hn::Le(squared[part], limit_squared), bits);
        const std::uint32_t found = bits[0] | static_cast<std::uint32_t>(bits[1]) << 8U;
        candidates.lanes |= found << (part * lanes);
    }
    // In forged blocks all may be as good as infinitely far, and lanes without a triangle within the
    // limit, too; or no distance a number: then any may be the closest.
    const std::uint32_t all = (1U << count) - 1;
    candidates.lanes &= all;
    if (!HasBound && candidates.lanes == 0) candidates.lanes = all;
}

} // namespace proxima::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
