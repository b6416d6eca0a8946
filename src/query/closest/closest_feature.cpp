#include "query/closest/closest_feature.h"

#include "query/closest/describe_closest.h"

#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "query/closest/closest_feature.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
// After them: it is read once for every instruction set.
#include "query/closest/search_octree-inl.h"

HWY_BEFORE_NAMESPACE();
namespace proxima::HWY_NAMESPACE {

RowDistance search_octree(const ProximityOctree& octree, const Vec3& p, double known,
                          QuerySteps& steps)
{
    const ProximityArrays& arrays = octree.arrays();
    return arrays.double_rows.empty() ? search(octree, arrays.float_rows, p, known, steps)
                                      : search(octree, arrays.double_rows, p, known, steps);
}

} // namespace proxima::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace proxima {

HWY_EXPORT(search_octree);

namespace {

/// Of the distance of a search that starts from scratch.
constexpr double nothing_known = std::numeric_limits<double>::infinity();

} // namespace

ClosestFeature closest_feature(const ProximityOctree& octree, const Vec3& p,
                               QuerySteps& steps) noexcept
{
    return describe_closest(octree,
                            HWY_DYNAMIC_DISPATCH(search_octree)(octree, p, nothing_known, steps));
}

ClosestFeature closest_feature(const ProximityOctree& octree, const Vec3& p) noexcept
{
    QuerySteps steps;
    return closest_feature(octree, p, steps);
}

ClosestFeature closest_feature(const ProximityOctree& octree, const Vec3& p,
                               const ClosestFeature& earlier, QuerySteps& steps) noexcept
{
    // The earlier point is of the mesh up to the rounding of its coordinates.
    const RootFrame& frame = octree.frame();
    const double rounding = 0x1p-46 * (frame.center.cwiseAbs().maxCoeff() + frame.half);
    const double known = (p - earlier.point).norm() + rounding;
    if (!(known < nothing_known)) return closest_feature(octree, p, steps);
    const RowDistance found = HWY_DYNAMIC_DISPATCH(search_octree)(octree, p, known, steps);
    // Nothing that near: it was no point of this mesh, and what was passed over may be nearer.
    const ClosestFeature closest = describe_closest(octree, found);
    if (!(closest.squared_distance <= known * known)) return closest_feature(octree, p, steps);
    return closest;
}

ClosestFeature closest_feature(const ProximityOctree& octree, const Vec3& p,
                               const ClosestFeature& earlier) noexcept
{
    QuerySteps steps;
    return closest_feature(octree, p, earlier, steps);
}

std::optional<ClosestFeature> closest_feature(const ProximityOctree& octree, const Vec3& p,
                                              double radius) noexcept
{
    if (!(radius >= 0)) return std::nullopt;
    const ClosestFeature closest = closest_feature(octree, p);
    if (!(closest.squared_distance <= radius * radius)) return std::nullopt;
    return closest;
}

} // namespace proxima

#endif
