#include "index/lists/local_region.h"

#include <cmath>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "index/lists/local_region.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
// After them: it is read once for every instruction set.
#include "index/lists/eight_corners-inl.h"

HWY_BEFORE_NAMESPACE();
namespace proxima::HWY_NAMESPACE {

/// A plane as seen from the cell: n . (x - center) <= -excess.
struct SeenPlane {
    float normal[3];
    float excess; ///< positive where the cell's centre is beyond the plane
};

/// Children that are not wholly beyond the plane.
HWY_INLINE std::uint32_t children_within(const float* n, float excess, float quarter)
{
    const float reach = quarter * (std::abs(n[0]) + std::abs(n[1]) + std::abs(n[2]));
    return at_most(eight(quarter) * dot_corners(n) + eight(excess - reach), eight(0));
}

/// The planes that pairs make without one of the axes.
HWY_INLINE std::uint32_t children_within_pair(const SeenPlane& one, const SeenPlane& other,
                                              float quarter, std::uint32_t children)
{
    for (int axis = 0; axis < 3 && children != 0; ++axis) {
        if (!(one.normal[axis] * other.normal[axis] < 0)) continue;
        const float a = std::abs(other.normal[axis]);
        const float b = std::abs(one.normal[axis]);
        // The sums' own roundings are in proportion to a and b.
        const float excess = a * one.excess + b * other.excess - (a + b) * (float_margin / 2);
        if (!(excess > 0)) continue; // the centre, a corner of every child, is within
        float y[3];
        for (int k = 0; k < 3; ++k) y[k] = a * one.normal[k] + b * other.normal[k];
        y[axis] = 0;
        children &= children_within(y, excess, quarter);
    }
    return children;
}

void find_children_in_reach(const LocalFeatures& features, const std::uint32_t* list,
                            std::size_t count, const FrameCell& cell, std::uint8_t* masks)
{
    const float quarter = 0.5F * cell.half;
    SeenPlane planes[max_vertex_planes];
    for (std::size_t k = 0; k < count; ++k) {
        const LocalFeature& feature = features.features[list[k]];
        const float* const numbers = features.planes(feature);
        std::uint32_t children = 0xFF;
        std::uint32_t beyond = 0;
        for (std::uint32_t i = 0; i < feature.planes; ++i) {
            const float* const n = numbers + std::size_t{plane_floats} * i;
            SeenPlane& plane = planes[i];
            for (int axis = 0; axis < 3; ++axis) plane.normal[axis] = n[axis];
            plane.excess =
                n[0] * cell.center[0] + n[1] * cell.center[1] + n[2] * cell.center[2] - n[3];
            if (!(plane.excess > 0)) continue;
            beyond |= 1U << i;
            children &= children_within(n, plane.excess, quarter);
            if (children == 0) break;
        }
        for (std::uint32_t i = 0; i < feature.planes && children != 0; ++i) {
            if ((beyond >> i & 1U) == 0) continue;
            for (std::uint32_t j = 0; j < feature.planes && children != 0; ++j) {
                const bool done = j == i || (j < i && (beyond >> j & 1U) != 0);
                if (!done) {
                    children = children_within_pair(planes[i], planes[j], quarter, children);
                }
            }
        }
        masks[k] = static_cast<std::uint8_t>(children);
    }
}

} // namespace proxima::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace proxima {

HWY_EXPORT(find_children_in_reach);

void find_children_in_reach(const LocalFeatures& features, std::span<const std::uint32_t> list,
                            const FrameCell& cell, std::uint8_t* masks)
{
    HWY_DYNAMIC_DISPATCH(find_children_in_reach)(features, list.data(), list.size(), cell, masks);
}

} // namespace proxima

#endif
