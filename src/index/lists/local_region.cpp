#include "index/lists/local_region.h"

#include <cmath>
#include <limits>

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

/// Children of the cell that one feature's region may meet.
HWY_INLINE std::uint32_t children_in_reach(const LocalFeatures& features,
                                           const LocalFeature& feature, const FrameCell& cell)
{
    const float quarter = 0.5F * cell.half;
    SeenPlane planes[max_vertex_planes];
    const float* const numbers = features.planes(feature);
    std::uint32_t children = 0xFF;
    std::uint32_t beyond = 0;
    for (std::uint32_t i = 0; i < feature.planes; ++i) {
        const float* const n = numbers + std::size_t{plane_floats} * i;
        SeenPlane& plane = planes[i];
        for (int axis = 0; axis < 3; ++axis) plane.normal[axis] = n[axis];
        plane.excess = n[0] * cell.center[0] + n[1] * cell.center[1] + n[2] * cell.center[2] - n[3];
        if (!(plane.excess > 0)) continue;
        beyond |= 1U << i;
        children &= children_within(n, plane.excess, quarter);
        if (children == 0) return 0;
    }
    for (std::uint32_t i = 0; i < feature.planes && children != 0; ++i) {
        if ((beyond >> i & 1U) == 0) continue;
        for (std::uint32_t j = 0; j < feature.planes && children != 0; ++j) {
            const bool done = j == i || (j < i && (beyond >> j & 1U) != 0);
            if (!done) children = children_within_pair(planes[i], planes[j], quarter, children);
        }
    }
    return children;
}

/// Eight features with as many planes each, in lanes. Every step is that of children_in_reach().
class EightRegions {
public:
    /// \pre `count` of them, 1 to 8, all with `planes` planes
    HWY_INLINE EightRegions(const LocalFeatures& features, const std::uint32_t* ids,
                            std::size_t count, std::uint32_t planes, const FrameCell& cell)
        : planes_(planes), quarter_(eight(0.5F * cell.half))
    {
        for (std::uint32_t i = 0; i < planes; ++i) {
            HWY_ALIGN float numbers[plane_floats][8];
            for (std::size_t lane = 0; lane < 8; ++lane) {
                const LocalFeature& feature = features.features[ids[HWY_MIN(lane, count - 1)]];
                const float* const n = features.planes(feature) + std::size_t{plane_floats} * i;
                for (std::size_t k = 0; k < plane_floats; ++k) numbers[k][lane] = n[k];
            }
            for (std::size_t axis = 0; axis < 3; ++axis)
                normal_[i][axis] = load_eight(numbers[axis]);
            excess_[i] = normal_[i][0] * eight(cell.center[0]) +
                         normal_[i][1] * eight(cell.center[1]) +
                         normal_[i][2] * eight(cell.center[2]) - load_eight(numbers[3]);
        }
    }

    /// Byte i: the children that region i may meet.
    HWY_INLINE std::uint64_t children() const
    {
        Eight worst[8]; // by child: how far the nearest of it is beyond any plane
        for (Eight& one : worst) one = eight(-infinite);
        for (std::uint32_t i = 0; i < planes_; ++i) add_plane(i, worst);
        for (std::size_t axis = 0; axis < 3; ++axis) add_pairs(axis, worst);
        std::uint64_t lanes_of_children = 0;
        for (std::size_t c = 0; c < 8; ++c)
            lanes_of_children |= std::uint64_t{at_most(worst[c], eight(0))} << 8 * c;
        return transposed(lanes_of_children);
    }

private:
    static constexpr float infinite = std::numeric_limits<float>::infinity();

    /// How far all of a cell is beyond a plane, where its centre is; -infinity elsewhere.
    HWY_INLINE Eight beyond(const Eight& excess, const Eight& sum) const
    {
        return choose(excess, eight(0), eight(-infinite), excess - quarter_ * sum);
    }

    HWY_INLINE void add_plane(std::uint32_t i, Eight (&worst)[8]) const
    {
        const Eight& x = normal_[i][0];
        const Eight& y = normal_[i][1];
        const Eight& z = normal_[i][2];
        const Eight base = beyond(excess_[i], absolute(x) + absolute(y) + absolute(z));
        for_corner_pairs(x, y, z, [&](std::size_t child, std::size_t opposite, const Eight& sum) {
            worst[child] = maximum(worst[child], base + quarter_ * sum);
            worst[opposite] = maximum(worst[opposite], base - quarter_ * sum);
        });
    }

    /// The planes that pairs make without this axis.
    HWY_INLINE void add_pairs(std::size_t axis, Eight (&worst)[8]) const
    {
        const std::size_t u = axis == 0 ? 1 : 0;
        const std::size_t v = axis == 2 ? 1 : 2;
        Eight of[4]; // by the signs on u, then v
        for (Eight& one : of) one = eight(-infinite);
        for (std::uint32_t i = 0; i < planes_; ++i) {
            const Eight b = absolute(normal_[i][axis]);
            for (std::uint32_t j = i + 1; j < planes_; ++j) {
                const Eight a = absolute(normal_[j][axis]);
                // The sums' own roundings are in proportion to a and b.
                const Eight excess =
                    a * excess_[i] + b * excess_[j] - (a + b) * eight(float_margin / 2);
                const Eight y_u = a * normal_[i][u] + b * normal_[j][u];
                const Eight y_v = a * normal_[i][v] + b * normal_[j][v];
                const Eight base =
                    choose(eight(0), normal_[i][axis] * normal_[j][axis], eight(-infinite),
                           beyond(excess, absolute(y_u) + absolute(y_v)));
                const Eight same = quarter_ * (y_u + y_v);
                const Eight other = quarter_ * (y_u - y_v);
                of[0] = maximum(of[0], base - same);
                of[1] = maximum(of[1], base + other);
                of[2] = maximum(of[2], base - other);
                of[3] = maximum(of[3], base + same);
            }
        }
        for (std::size_t c = 0; c < 8; ++c) {
            const std::size_t signs = (c >> u & 1U) | (c >> v & 1U) << 1U;
            worst[c] = maximum(worst[c], of[signs]);
        }
    }

    /// Bit i of byte k becomes bit k of byte i.
    static HWY_INLINE std::uint64_t transposed(std::uint64_t bits)
    {
        const auto swap = [&](unsigned shift, std::uint64_t mask) {
            const std::uint64_t change = (bits ^ bits >> shift) & mask;
            bits ^= change ^ change << shift;
        };
        swap(7, 0x00AA00AA00AA00AAU);
        swap(14, 0x0000CCCC0000CCCCU);
        swap(28, 0x00000000F0F0F0F0U);
        return bits;
    }

    std::uint32_t planes_;
    Eight quarter_;
    Eight normal_[max_vertex_planes][3];
    Eight excess_[max_vertex_planes];
};

/// Features that wait until there are eight with as many planes.
struct WaitingRegions {
    std::size_t count = 0;
    std::uint32_t ids[8];
    std::size_t places[8]; ///< in the list
};

void find_children_in_reach(const LocalFeatures& features, const std::uint32_t* list,
                            std::size_t count, const FrameCell& cell, std::uint8_t* masks)
{
    WaitingRegions by_planes[max_vertex_planes + 1];
    const auto answer = [&](WaitingRegions& waiting, std::uint32_t planes) {
        const std::uint64_t children =
            EightRegions(features, waiting.ids, waiting.count, planes, cell).children();
        for (std::size_t i = 0; i < waiting.count; ++i)
            masks[waiting.places[i]] = static_cast<std::uint8_t>(children >> 8 * i);
        waiting.count = 0;
    };
    for (std::size_t k = 0; k < count; ++k) {
        const std::uint32_t planes = features.features[list[k]].planes;
        WaitingRegions& waiting = by_planes[planes];
        waiting.ids[waiting.count] = list[k];
        waiting.places[waiting.count] = k;
        if (++waiting.count == 8) answer(waiting, planes);
    }
    for (std::uint32_t planes = 0; planes <= max_vertex_planes; ++planes) {
        WaitingRegions& waiting = by_planes[planes];
        constexpr std::size_t fewest = 4; // that are quicker in lanes
        if (waiting.count >= fewest) answer(waiting, planes);
        for (std::size_t i = 0; i < waiting.count; ++i) {
            masks[waiting.places[i]] = static_cast<std::uint8_t>(
                children_in_reach(features, features.features[waiting.ids[i]], cell));
        }
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
