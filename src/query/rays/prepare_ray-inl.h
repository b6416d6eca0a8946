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
    const RayShear shear(ray.direction);
    const double largest = std::abs(ray.direction.data()[shear.z]);
    const RayUnit unit(index, largest);
    const auto center = hn::LoadU(d, index.center().data());
    auto origin =
        hn::Mul(hn::Sub(hn::LoadU(d, ray.origin.data()), center), hn::Set(d, index.scale()));
    origin = hn::IfThenElseZero(first_three, origin);
    const auto distances = hn::Abs(origin);
    // False for what is not finite: direction of which a component is greater than the largest.
    const auto sizes = hn::Abs(hn::LoadU(d, ray.direction.data()));
    const auto usual = hn::And(hn::Le(distances, hn::Set(d, RayTraversal::far)),
                               hn::Or(hn::Le(sizes, hn::Set(d, largest)), hn::Not(first_three)));
    if (!(unit.is_ordinary() && ray.t_min <= ray.t_max && hn::AllTrue(d, usual))) return false;
    const auto direction = hn::Mul(hn::LoadU(d, ray.direction.data()), hn::Set(d, unit.scale));
    const auto sign = hn::IfThenElseZero(first_three, direction);
    const auto tiny = hn::Set(d, 0x1p-500); // so that nothing is infinite
    const auto inverse = hn::Div(hn::Set(d, 1.0), hn::CopySign(hn::Max(hn::Abs(sign), tiny), sign));
    double least = ray.t_min * unit.rate;
    double most = ray.t_max * unit.rate;
    double shift = 0;
    double moved = 0;
    if (!hn::AllTrue(d, hn::Le(distances, hn::Set(d, RayTraversal::root_reach)))) {
        const auto one = hn::Mul(hn::Sub(hn::Set(d, -RayTraversal::root_reach), origin), inverse);
        const auto other = hn::Mul(hn::Sub(hn::Set(d, RayTraversal::root_reach), origin), inverse);
        // In the fourth lane these are far out: the origin there is 0, the inverse 2^500.
        least = HWY_MAX(least, hn::GetLane(hn::MaxOfLanes(d, hn::Min(one, other))));
        most = HWY_MIN(most, hn::GetLane(hn::MinOfLanes(d, hn::Max(one, other))));
        misses = !(least <= most);
        if (misses) return true;
        shift = least;
        moved = 0x1p-50 * hn::GetLane(hn::MaxOfLanes(d, distances));
        origin = hn::MulAdd(hn::Set(d, shift), sign, origin);
    }
    const auto most_inverse = hn::Set(d, RayTraversal::most_inverse);
    const auto inverses =
        hn::DemoteTo(f, hn::CopySign(hn::Min(hn::Abs(inverse), most_inverse), inverse));
    const auto origins = hn::DemoteTo(f, origin);
    const auto starts = hn::Neg(hn::Mul(origins, inverses));
    std::uint8_t negative[8] = {};
    (void)hn::StoreMaskBits(d, hn::Lt(inverse, hn::Zero(d)), negative);
    open.octant = negative[0] & 7U;
    hn::StoreU(hn::Broadcast<0>(inverses), f, open.inverse[0].data());
    hn::StoreU(hn::Broadcast<1>(inverses), f, open.inverse[1].data());
    hn::StoreU(hn::Broadcast<2>(inverses), f, open.inverse[2].data());
    hn::StoreU(hn::Broadcast<0>(starts), f, open.start[0].data());
    hn::StoreU(hn::Broadcast<1>(starts), f, open.start[1].data());
    hn::StoreU(hn::Broadcast<2>(starts), f, open.start[2].data());
    HWY_ALIGN float floats[4];
    hn::Store(origins, f, floats);
    open.shear = shear;
    open.axes = {shear.x, shear.y, shear.z};
    open.origin = {floats[shear.x], floats[shear.y], floats[shear.z]};
    open.slope_x = static_cast<float>(shear.slope_x);
    open.slope_y = static_cast<float>(shear.slope_y);
    open.inverse_z = static_cast<float>(shear.inverse_z * unit.unscale);
    open.set_range(index, ray, faces, {unit.rate, least, most, shift, moved, moved});
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
