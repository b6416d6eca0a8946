#include "haptics/surface/groups_along_segment.h"

#include "base/check.h"

#include <cmath>

#ifndef PROXIMA_HAPTICS_GROUPS_ALONG_SEGMENT_ONCE
#define PROXIMA_HAPTICS_GROUPS_ALONG_SEGMENT_ONCE

namespace proxima {

/// A motion in units, and the distance from it, larger by more than rounding.
struct BoxQuery {
    float position[3]; ///< from the boxes' origin
    float motion[3];
    float limit;
};

} // namespace proxima

#endif

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "haptics/surface/groups_along_segment.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
// After them: it is read once for every instruction set.
#include "base/compress-inl.h"

HWY_BEFORE_NAMESPACE();
namespace proxima::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

/// The part of a motion before which it comes within the limit of no point of each box, by a plane
/// across the direction to the box's middle; 0 where that plane decides nothing.
template <class Lanes>
HWY_INLINE Lanes box_time(const Lanes (&lower)[3], const Lanes (&upper)[3], const float* motion,
                          Lanes limit)
{
    const hn::DFromV<Lanes> d;
    auto squared = hn::Zero(d);
    auto aside = hn::Zero(d);
    auto swept = hn::Zero(d);
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto middle = hn::Add(lower[axis], upper[axis]);
        squared = hn::MulAdd(middle, middle, squared);
        aside = hn::MulAdd(hn::Abs(middle), hn::Sub(upper[axis], lower[axis]), aside);
        swept = hn::MulAdd(middle, hn::Set(d, 2 * motion[axis]), swept);
    }
    // All lengths are doubled. The sums are rounded.
    const auto rounding = hn::Mul(hn::Add(squared, aside), hn::Set(d, 0x1p-20F));
    const auto length = hn::Sqrt(squared);
    const auto left =
        hn::Sub(hn::Sub(hn::Sub(squared, aside), rounding), hn::Mul(hn::Add(limit, limit), length));
    const auto least = hn::Max(swept, hn::Mul(left, hn::Set(d, 0.5F)));
    const auto time = hn::Mul(hn::Div(left, least), hn::Set(d, 1 - 0x1p-18F));
    const auto tells = hn::And(hn::Gt(left, hn::Zero(d)), hn::Gt(squared, hn::Set(d, 1e-30F)));
    return hn::IfThenElseZero(tells, time);
}

/// Writes the ids of groups whose boxes may be within the distance of the motion, and the part of
/// it before which none is. Returns how many. \pre ids and times take whole vectors
std::size_t groups_along_segment(const GroupBoxes& boxes, const BoxQuery& query, std::uint32_t* ids,
                                 float* times)
{
    const hn::CappedTag<float, 16> d;
    const hn::Rebind<std::uint32_t, decltype(d)> di;
    using Lanes = hn::Vec<decltype(d)>;
    static_assert(GroupBoxes::capacity % 16 == 0);
    constexpr float least_motion = 1e-20F; // along an axis; smaller ones are no divisors
    const auto limit = hn::Set(d, query.limit);
    std::size_t count = 0;
    for (std::size_t first = 0; first < boxes.count; first += hn::Lanes(d)) {
        auto near = hn::FirstN(d, HWY_MIN(hn::Lanes(d), boxes.count - first));
        auto enter = hn::Zero(d);
        auto leave = hn::Set(d, 2.0F);
        Lanes lower[3];
        Lanes upper[3];
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const auto position = hn::Set(d, query.position[axis]);
            lower[axis] = hn::Sub(hn::LoadU(d, boxes.lower[axis].data() + first), position);
            upper[axis] = hn::Sub(hn::LoadU(d, boxes.upper[axis].data() + first), position);
            const float motion = query.motion[axis];
            const float size = std::abs(motion);
            const auto ahead = hn::Sub(motion < 0 ? hn::Neg(upper[axis]) : lower[axis], limit);
            const auto behind = hn::Add(motion < 0 ? hn::Neg(lower[axis]) : upper[axis], limit);
            if (size > least_motion) {
                const auto parts = hn::Set(d, 1 / size);
                enter = hn::Max(enter, hn::Mul(ahead, parts));
                leave = hn::Min(leave, hn::Mul(behind, parts));
            } else {
                near = hn::And(near, hn::And(hn::Le(ahead, hn::Zero(d)), //
                                             hn::Ge(behind, hn::Zero(d))));
            }
        }
        near = hn::And(near, hn::Le(enter, leave));
        enter = hn::Max(enter, box_time(lower, upper, query.motion, limit));
        near = hn::And(near, hn::Le(enter, hn::Set(d, 1.0F)));
        // Compressing stores are slow on some processors.
        const auto all_ids = hn::LoadU(di, boxes.ids.data() + first);
        hn::StoreU(compress(all_ids, hn::RebindMask(di, near)), di, ids + count);
        hn::StoreU(compress(enter, near), d, times + count);
        count += hn::CountTrue(d, near);
    }
    return count;
}

} // namespace proxima::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace proxima {

HWY_EXPORT(groups_along_segment);

void groups_along_segment(const GroupBoxes& boxes, const GroupQuery& query,
                          GroupsAlongSegment& groups) noexcept
{
    PROXIMA_CHECK_LE(boxes.count, GroupBoxes::capacity);
    const Vec3 position = (query.position - query.origin) * query.scale;
    const Vec3 motion = query.motion * query.scale;
    const double distance = query.distance * query.scale;
    BoxQuery lanes{};
    for (int axis = 0; axis < 3; ++axis) {
        lanes.position[axis] = static_cast<float>(position[axis]);
        lanes.motion[axis] = static_cast<float>(motion[axis]);
    }
    // Bounds the rounding of the three as floats, and of the lanes' arithmetic.
    const double size = position.cwiseAbs().maxCoeff() + motion.cwiseAbs().maxCoeff() + distance;
    lanes.limit = static_cast<float>(distance + 0x1p-20 * size + query.rounding * query.scale);
    groups.count = HWY_DYNAMIC_DISPATCH(groups_along_segment)(boxes, lanes, groups.ids.data(),
                                                              groups.times.data());
}

} // namespace proxima

#endif
