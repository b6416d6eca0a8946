// Points of the snapped grid in vector lanes. Read once for every instruction set, after highway.h.
#if defined(PROXIMA_OCTREE_SNAPPED_LANES_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef PROXIMA_OCTREE_SNAPPED_LANES_INL_H
#undef PROXIMA_OCTREE_SNAPPED_LANES_INL_H
#else
#define PROXIMA_OCTREE_SNAPPED_LANES_INL_H
#endif

#include <cstddef>
#include <cstdint>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace proxima::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using FloatTag = hn::ScalableTag<float>;
using IntTag = hn::RebindToSigned<FloatTag>;
using MaskTag = hn::RebindToUnsigned<FloatTag>;
using Floats = hn::Vec<FloatTag>;
using Ints = hn::Vec<IntTag>;
using Words = hn::Vec<MaskTag>;

#if HWY_TARGET == HWY_SCALAR

/// Coordinates of one point per lane, by axis; point(lane) is where lane's point lies.
template <class PointOf>
HWY_INLINE void load_points(const PointOf& point, Ints (&coordinates)[3])
{
    const IntTag di;
    for (int axis = 0; axis < 3; ++axis) {
        coordinates[axis] = hn::Set(di, (*point(std::size_t{0}))[static_cast<std::size_t>(axis)]);
    }
}

#else

/// Four numbers from each of the positions that lanes 4 L + row stand for, one per 128-bit block L.
template <std::size_t Count, class PointOf>
HWY_INLINE auto load_rows(const PointOf& point, std::size_t lane)
{
    const hn::FixedTag<std::int32_t, Count> tag;
    if constexpr (Count == 4) {
        return hn::LoadU(tag, point(lane)->data());
    } else {
        return hn::Combine(tag, load_rows<Count / 2>(point, lane + Count / 2),
                           load_rows<Count / 2>(point, lane));
    }
}

/// Coordinates of one point per lane, by axis; point(lane) is where lane's point lies. Whole points
/// are loaded and turned: several times faster than gathering numbers one by one.
template <class PointOf>
HWY_INLINE void load_points(const PointOf& point, Ints (&coordinates)[3])
{
    constexpr std::size_t lanes = HWY_MAX_BYTES / sizeof(std::int32_t);
    const IntTag di;
    const hn::Repartition<std::int64_t, IntTag> pairs;
    const auto a = load_rows<lanes>(point, 0);
    const auto b = load_rows<lanes>(point, 1);
    const auto c = load_rows<lanes>(point, 2);
    const auto d = load_rows<lanes>(point, 3);
    const auto xy_ab = hn::BitCast(pairs, hn::InterleaveLower(di, a, b));
    const auto xy_cd = hn::BitCast(pairs, hn::InterleaveLower(di, c, d));
    const auto zw_ab = hn::BitCast(pairs, hn::InterleaveUpper(di, a, b));
    const auto zw_cd = hn::BitCast(pairs, hn::InterleaveUpper(di, c, d));
    coordinates[0] = hn::BitCast(di, hn::InterleaveLower(pairs, xy_ab, xy_cd));
    coordinates[1] = hn::BitCast(di, hn::InterleaveUpper(pairs, xy_ab, xy_cd));
    coordinates[2] = hn::BitCast(di, hn::InterleaveLower(pairs, zw_ab, zw_cd));
}

#endif

} // namespace proxima::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
