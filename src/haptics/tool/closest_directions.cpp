#include "haptics/tool/closest_directions.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "haptics/tool/closest_directions.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
// After them: it is read once for every instruction set.
#include "query/distance/triangle_bounds-inl.h"

HWY_BEFORE_NAMESPACE();
namespace proxima::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using DirectionTag = PairTag<double>;
using DirectionLanes = VectorLanes<double>;

HWY_INLINE DirectionLanes load_corner(const double (&corner)[3][8], std::size_t at)
{
    const DirectionTag d;
    return {hn::Load(d, corner[0] + at), hn::Load(d, corner[1] + at), hn::Load(d, corner[2] + at)};
}

HWY_INLINE DirectionLanes moved(const RigidTransform& pose, const DirectionLanes& p)
{
    const DirectionTag d;
    const auto on_axis = [&](int axis) HWY_ATTR {
        const auto x = hn::Mul(p.x, hn::Set(d, pose.rotation(axis, 0)));
        const auto y = hn::Mul(p.y, hn::Set(d, pose.rotation(axis, 1)));
        const auto z = hn::Mul(p.z, hn::Set(d, pose.rotation(axis, 2)));
        return hn::Add(hn::Add(hn::Add(x, y), z), hn::Set(d, pose.translation[axis]));
    };
    return {on_axis(0), on_axis(1), on_axis(2)};
}

HWY_INLINE hn::Vec<DirectionTag> size_of(const DirectionLanes& v)
{
    return hn::Max(hn::Max(hn::Abs(v.x), hn::Abs(v.y)), hn::Abs(v.z));
}

void closest_directions(const EightTrianglePairs& pairs, const RigidTransform& pose,
                        EightDirections& directions)
{
    const DirectionTag d;
    for (std::size_t at = 0; at < 8; at += pair_lanes<double>) {
        // Seen from a corner and scaled to about 1, so that no square is beyond the range of doubles.
        const DirectionLanes origin = load_corner(pairs.scene[0], at);
        TriangleLanes<double> scene;
        TriangleLanes<double> tool;
        auto size = hn::Zero(d);
        for (std::size_t i = 0; i < 3; ++i) {
            scene.corner[i] = load_corner(pairs.scene[i], at) - origin;
            tool.corner[i] = moved(pose, load_corner(pairs.tool[i], at)) - origin;
            size = hn::Max(size, hn::Max(size_of(scene.corner[i]), size_of(tool.corner[i])));
        }
        const auto least = hn::Set(d, std::numeric_limits<double>::min());
        const auto unit = hn::Div(hn::Set(d, 1.0), hn::Max(size, least));
        for (std::size_t i = 0; i < 3; ++i) {
            scene.corner[i] = scaled(scene.corner[i], unit);
            tool.corner[i] = scaled(tool.corner[i], unit);
        }
        const DirectionLanes nearest =
            nearest_points(scene, SideLanes<double>(scene), tool, SideLanes<double>(tool));
        hn::Store(nearest.x, d, directions.across[0] + at);
        hn::Store(nearest.y, d, directions.across[1] + at);
        hn::Store(nearest.z, d, directions.across[2] + at);
    }
}

} // namespace proxima::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace proxima {

HWY_EXPORT(closest_directions);

void find_closest_directions(const EightTrianglePairs& pairs, const RigidTransform& pose,
                             EightDirections& directions) noexcept
{
    HWY_DYNAMIC_DISPATCH(closest_directions)(pairs, pose, directions);
}

} // namespace proxima

#endif
