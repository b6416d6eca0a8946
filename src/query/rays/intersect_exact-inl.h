// intersect_exact() in vectors, for leaves that hold the mesh's own coordinates. Included once per
// target.
//
//     lane   3  2  1  0
//            v0 v2 v1 v0        corners; each step is that of intersect() (ray_triangle-inl.h), so
//                               that bits are the same

#if defined(PROXIMA_QUERY_ASK_TRIANGLE_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef PROXIMA_QUERY_ASK_TRIANGLE_INL_H
#undef PROXIMA_QUERY_ASK_TRIANGLE_INL_H
#else
#define PROXIMA_QUERY_ASK_TRIANGLE_INL_H
#endif

#include "geometry/ray_triangle-inl.h"
#include "index/index_parts.h"
#include "query/rays/prepare_ray.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace proxima::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

#if HWY_MAX_BYTES >= 32 // four doubles, eight floats at once

using CornerTag = hn::CappedTag<double, 4>;
using CornerDoubles = hn::Vec<CornerTag>;

/// In each of the first three lanes, the number of the next corner, and of the one after it.
HWY_INLINE CornerDoubles of_next(CornerDoubles numbers)
{
    alignas(32) static constexpr std::int64_t lanes[4] = {1, 2, 0, 1};
    return hn::TableLookupLanes(numbers, hn::SetTableIndices(CornerTag(), lanes));
}
HWY_INLINE CornerDoubles of_last(CornerDoubles numbers)
{
    alignas(32) static constexpr std::int64_t lanes[4] = {2, 0, 1, 2};
    return hn::TableLookupLanes(numbers, hn::SetTableIndices(CornerTag(), lanes));
}

/// What the quick test of intersect() says.
enum class QuickAnswer : std::uint8_t { missed, hit, unsure };

/// intersect() of the corners that corners_on(axis) gives in lanes 0, 1, 2 and 0.
template <class CornersOn>
HWY_INLINE QuickAnswer intersect_quickly(const CornersOn& corners_on, const SearchedRay& searched,
                                         RayHit& hit)
{
    const CornerTag d;
    const RayShear& shear = searched.shear;
    const auto about = [&](std::uint32_t axis) {
        return hn::Sub(corners_on(axis), hn::Set(d, searched.ray->origin.data()[axis]));
    };
    const auto about_x = about(shear.x);
    const auto about_y = about(shear.y);
    const auto about_z = about(shear.z);
    const auto x = hn::Sub(about_x, hn::Mul(hn::Set(d, shear.slope_x), about_z));
    const auto y = hn::Sub(about_y, hn::Mul(hn::Set(d, shear.slope_y), about_z));
    const auto depths = hn::Mul(about_z, hn::Set(d, shear.inverse_z));
    const auto size =
        hn::MaxOfLanes(d, hn::Max(hn::Max(hn::Abs(about_x), hn::Abs(about_y)), hn::Abs(about_z)));
    const auto reach = hn::MaxOfLanes(d, hn::Max(hn::Abs(x), hn::Abs(y)));
    const auto weights = hn::Sub(hn::Mul(of_next(x), of_last(y)), hn::Mul(of_next(y), of_last(x)));
    const auto errors = hn::Mul(hn::Mul(hn::Set(d, detail::error_factor), size),
                                hn::Add(reach, hn::Mul(hn::Set(d, detail::own_error), size)));
    const double error = hn::GetLane(errors);
    if (!(error >= detail::safe_error && error <= detail::greatest_error))
        return QuickAnswer::unsure;
    const auto above = hn::Gt(weights, errors);
    const auto below = hn::Lt(weights, hn::Neg(errors));
    const bool is_positive = hn::AllTrue(d, above);
    if (!is_positive && !hn::AllTrue(d, below)) {
        return hn::AllFalse(d, above) || hn::AllFalse(d, below) ? QuickAnswer::unsure
                                                                : QuickAnswer::missed;
    }
    const double sum = hn::GetLane(hn::Add(hn::Add(weights, of_next(weights)), of_last(weights)));
    if (!(std::abs(sum) > detail::sure_sum * error)) return QuickAnswer::unsure;
    if (!detail::is_wanted(shear.inverse_z > 0 ? sum : -sum, searched.faces))
        return QuickAnswer::missed;
    const auto shares = hn::Div(weights, hn::Set(d, sum));
    const auto parts = hn::Mul(shares, depths);
    const double t = hn::GetLane(hn::Add(hn::Add(parts, of_next(parts)), of_last(parts)));
    const double first = hn::GetLane(depths);
    const double second = hn::GetLane(of_next(depths));
    const double third = hn::GetLane(of_last(depths));
    const double own = std::clamp(t, std::min(std::min(first, second), third),
                                  std::max(std::max(first, second), third));
    if (!(std::abs(own) <= farthest_hit)) return QuickAnswer::unsure;
    const double doubt = detail::doubt_of({first, second, third});
    if (std::abs(own) <= doubt && searched.ray->t_min <= doubt) return QuickAnswer::unsure;
    if (!(searched.ray->t_min <= own && own <= searched.ray->t_max)) return QuickAnswer::missed;
    hit.t = own;
    hit.u = hn::GetLane(of_next(shares));
    hit.v = hn::GetLane(of_last(shares));
    return QuickAnswer::hit;
}

HWY_INLINE QuickAnswer ask_leaf(const IndexParts& index, const IndexLeaf& leaf, std::uint32_t lane,
                                const SearchedRay& searched, RayHit& hit)
{
    const CornerTag d;
    const hn::CappedTag<float, 8> f;
    const hn::RebindToUnsigned<decltype(f)> words;
    const hn::Rebind<std::uint8_t, decltype(f)> bytes;
    const std::uint64_t packed =
        leaf.corners[0][lane] | std::uint32_t{leaf.corners[1][lane]} << 8U |
        std::uint32_t{leaf.corners[2][lane]} << 16U | std::uint32_t{leaf.corners[0][lane]} << 24U;
    const auto corners = hn::IndicesFromVec(
        f, hn::PromoteTo(words,
                         hn::BitCast(bytes, hn::Set(hn::CappedTag<std::uint64_t, 1>(), packed))));
    const auto unscale = hn::Set(d, index.unscale());
    const auto corners_on = [&](std::uint32_t axis) {
        const auto own = hn::TableLookupLanes(hn::Load(f, leaf.coordinates[axis].data()), corners);
        return hn::Add(hn::Mul(hn::PromoteTo(d, hn::LowerHalf(own)), unscale),
                       hn::Set(d, index.center().data()[axis]));
    };
    return intersect_quickly(corners_on, searched, hit);
}

HWY_INLINE QuickAnswer ask_double_row(const TriangleRow<double>& row, const SearchedRay& searched,
                                      RayHit& hit)
{
    const CornerTag d;
    alignas(32) static constexpr std::int64_t lanes[4] = {0, 1, 2, 0};
    const auto corners_on = [&](std::uint32_t axis) {
        return hn::TableLookupLanes(hn::LoadU(d, row.coordinates[axis]), // and what comes next
                                    hn::SetTableIndices(d, lanes));
    };
    return intersect_quickly(corners_on, searched, hit);
}

#endif

HWY_INLINE bool ask_any_triangle(const IndexParts& index, RayTriangle triangle,
                                 const SearchedRay& searched, RayHit& hit)
{
#if HWY_MAX_BYTES >= 32
    const IndexLeaf& leaf = index.blocks()[triangle.leaf].leaf;
    const std::uint32_t row = leaf.first_row + triangle.lane;
    QuickAnswer answer = QuickAnswer::unsure;
    if (index.has_exact_leaves()) {
        answer = ask_leaf(index, leaf, triangle.lane, searched, hit);
    } else if (!index.double_rows().empty()) {
        answer = ask_double_row(index.double_rows()[row], searched, hit);
    }
    if (answer == QuickAnswer::hit) hit.triangle = index.ids()[row];
    if (answer != QuickAnswer::unsure) return answer == QuickAnswer::hit;
#endif
    return intersect_exact(index, triangle, searched, hit);
}

} // namespace proxima::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
