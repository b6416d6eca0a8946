// prepare_ray() in vectors, for the rays that are met most. Included once per target.

#if defined(PROXIMA_QUERY_OPEN_RAY_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef PROXIMA_QUERY_OPEN_RAY_INL_H
#undef PROXIMA_QUERY_OPEN_RAY_INL_H
#else
#define PROXIMA_QUERY_OPEN_RAY_INL_H
#endif

#include "base/inline_steps-inl.h"
#include "index/index_parts.h"
#include "query/rays/prepare_ray.h"

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace proxima::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

#if HWY_MAX_BYTES >= 32 // four doubles at once

/// As prepare_ray, where the ray is valid, of ordinary size and not from far away; false elsewhere.
/// `misses` where it says so.
HWY_INLINE bool open_near_ray(const IndexParts& index, const Ray& ray, Faces faces,
                              RayTraversal& open, bool& misses)
{
    const hn::CappedTag<double, 4> d;
    const hn::Rebind<float, decltype(d)> f;
    static_assert(sizeof(Ray) == 8 * sizeof(double)); // the fourth lanes are within it
    const auto first_three = hn::FirstN(d, 3);
    const auto direction = hn::IfThenElseZero(first_three, hn::LoadU(d, ray.direction.data()));
    const auto sizes = hn::Abs(direction);
    const auto tiny = hn::Set(d, RayUnit::least_component); // so that nothing is infinite
    const auto inverse = hn::Div(hn::Set(d, 1.0), hn::CopySign(hn::Max(sizes, tiny), direction));
    const auto center = hn::LoadU(d, index.center().data());
    auto origin =
        hn::Mul(hn::Sub(hn::LoadU(d, ray.origin.data()), center), hn::Set(d, index.scale()));
    origin = hn::IfThenElseZero(first_three, origin);
    const RayShear shear(ray.direction);
    const double largest = std::abs(ray.direction.data()[shear.z]);
    const RayUnit unit(index, largest);
    // False for what is not finite: direction of which a component is greater than the largest.
    const auto distances = hn::Abs(origin);
    const auto usual = hn::And(hn::Le(distances, hn::Set(d, RayTraversal::far)),
                               hn::Le(sizes, hn::Set(d, largest)));
    if (!(unit.is_near_one() && ray.t_min <= ray.t_max && hn::AllTrue(d, usual))) return false;
    const auto one = hn::Mul(hn::Sub(hn::Load(d, index.root_box().lower.data()), origin), inverse);
    const auto other =
        hn::Mul(hn::Sub(hn::Load(d, index.root_box().upper.data()), origin), inverse);
    // In the fourth lane these are far out: the origin there is 0, the inverse 2^1000.
    const auto enters = hn::MaxOfLanes(d, hn::Min(one, other));
    const auto leaves = hn::MinOfLanes(d, hn::Max(one, other));
    RayTraversal::Range range;
    range.t_off = 0x1p-50 * hn::GetLane(hn::MaxOfLanes(d, distances));
    range.moved = range.t_off;
    range.rate = unit.rate;
    misses = !range.clip(ray.t_min * unit.rate, ray.t_max * unit.rate,
                         hn::GetLane(enters) * unit.unscale, hn::GetLane(leaves) * unit.unscale);
    if (misses) return true;
    origin = hn::MulAdd(hn::Set(d, range.shift * unit.scale), direction, origin);
    const auto most_inverse = hn::Set(d, RayTraversal::most_inverse);
    const auto inverses = hn::DemoteTo(
        f, hn::CopySign(hn::Min(hn::Abs(hn::Mul(inverse, hn::Set(d, unit.unscale))), most_inverse),
                        inverse));
    const auto origins = hn::DemoteTo(f, origin);
    const auto starts = hn::Neg(hn::Mul(origins, inverses));
    std::uint8_t negative[8] = {};
    (void)hn::StoreMaskBits(d, hn::Lt(inverse, hn::Zero(d)), negative);
    open.octant = negative[0] & 7U;
    const hn::CappedTag<float, 8> lanes;
    const auto store_all = [&](auto values, std::array<RayLanes, 3>& to) {
        const auto twice = hn::Combine(lanes, values, values);
        hn::Store(hn::Broadcast<0>(twice), lanes, to[0].lanes);
        hn::Store(hn::Broadcast<1>(twice), lanes, to[1].lanes);
        hn::Store(hn::Broadcast<2>(twice), lanes, to[2].lanes);
    };
    store_all(inverses, open.inverse);
    store_all(starts, open.start);
    HWY_ALIGN float floats[4];
    hn::Store(origins, f, floats);
    open.shear = shear;
    open.axes = {shear.x, shear.y, shear.z};
    open.origin = {floats[shear.x], floats[shear.y], floats[shear.z]};
    open.slope_x = static_cast<float>(shear.slope_x);
    open.slope_y = static_cast<float>(shear.slope_y);
    open.inverse_z = static_cast<float>(shear.inverse_z * unit.unscale);
    open.set_range(index, ray, faces, range);
    return true;
}

#endif

PROXIMA_STEP RayStart open_any_ray(const IndexParts& index, const Ray& ray, Faces faces,
                                   RayTraversal& open)
{
#if HWY_MAX_BYTES >= 32
    bool misses = false;
    if (index.triangle_count() > 0 && open_near_ray(index, ray, faces, open, misses))
        return misses ? RayStart::misses : RayStart::ready;
#endif
    return prepare_ray(index, ray, faces, open);
}

} // namespace proxima::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
