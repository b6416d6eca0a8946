#include "geometry/length.h"
#include "index/index_parts.h"
#include "proxima/closest_feature.h"
#include "query/closest/describe_closest.h"

#include <cmath>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "query/closest/closest_in_index.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
// After them: it is read once for every instruction set.
#include "query/closest/find_closest.h"
#include "query/closest/search_lists-inl.h"

HWY_BEFORE_NAMESPACE();
namespace proxima::HWY_NAMESPACE {

RowDistance search_one(const IndexParts& index, const Vec3& p, double known, QuerySteps& steps)
{
    return index.double_rows().empty()
               ? search_lists_or_tree(index, index.float_rows(), p, known, steps)
               : search_lists_or_tree(index, index.double_rows(), p, known, steps);
}

} // namespace proxima::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace proxima {

HWY_EXPORT(search_one);

namespace {

/// How far an earlier answer's point may be from the mesh: by the rounding of its coordinates.
double rounding_of_points(const IndexParts& index) noexcept
{
    return 0x1p-46 * (index.center().cwiseAbs().maxCoeff() + index.unscale());
}

} // namespace

RowDistance find_closest(const IndexParts& index, const Vec3& p, double known) noexcept
{
    QuerySteps steps;
    return HWY_DYNAMIC_DISPATCH(search_one)(index, p, known, steps);
}

std::optional<ClosestFeature> closest_feature(const MeshIndex& index, const Vec3& p,
                                              const ClosestFeatureOptions& options) noexcept
{
    QuerySteps steps;
    return closest_feature(index, p, options, steps);
}

std::optional<ClosestFeature> closest_feature(const MeshIndex& index, const Vec3& p,
                                              const ClosestFeatureOptions& options,
                                              QuerySteps& steps) noexcept
{
    const IndexParts& parts = index.parts();
    const double radius = options.radius;
    if (!(radius >= 0)) return std::nullopt; // lists do not look at it, and its square is no less
    double known = radius;
    if (options.start_from != nullptr) {
        const double distance = (p - options.start_from->point).norm() + rounding_of_points(parts);
        if (distance < known) known = distance;
    }
    RowDistance found = HWY_DYNAMIC_DISPATCH(search_one)(parts, p, known, steps);
    const auto within = [&](double size) {
        if (!found.found()) return false;
        const double scaled = size * parts.scale();
        const double squared = scaled * scaled;
        // Seen from afar, in the units of a mesh of denormal size.
        if (std::isfinite(size) && std::isinf(squared) && std::isinf(found.squared))
            return length_of(p - describe_closest(parts, found).point) <= size;
        return found.squared <= squared;
    };
    // Nothing that near: it was no point of this mesh, and what was passed over may be nearer.
    if (known < radius && !within(known))
        found = HWY_DYNAMIC_DISPATCH(search_one)(parts, p, radius, steps);
    if (!found.found() || !within(radius)) return std::nullopt;
    return describe_closest(parts, found);
}

} // namespace proxima

#endif
