#include "proxima/minkowski/unbounded_sum.h"

#include "proxima/base/check.h"
#include "proxima/minkowski/convex_hull.h"

#include <algorithm>

namespace proxima {

ConvexPolyhedron cut_rays(const ConvexPolyhedron& polyhedron, double length)
{
    PROXIMA_CHECK_GT(length, 0);
    if (polyhedron.is_bounded()) return polyhedron;
    std::vector<Vec3> points(polyhedron.points().begin(), polyhedron.points().end());
    for (const PolyhedronEdge& edge : polyhedron.edges()) {
        if (polyhedron.is_ray(edge.to)) {
            points.emplace_back(polyhedron.vertex(edge.from) +
                                length * polyhedron.vertex(edge.to).stableNormalized());
        }
    }
    // Finite points: it cannot fail.
    return convex_hull(points).value();
}

Result<CutSum> sum_by_cutting(const ConvexPolyhedron& a, const ConvexPolyhedron& b, double length)
{
    auto intermediate = minkowski_sum(cut_rays(a, length), cut_rays(b, length));
    if (!intermediate) return tl::unexpected(intermediate.error());
    CutSum result = {std::move(*intermediate), {}, {}};
    const auto obstructs = [&](const Vec3& normal) {
        const auto leads_along = [&](const Vec3& ray) {
            return normal.dot(ray.stableNormalized()) > obstruction_tolerance;
        };
        return std::ranges::any_of(a.rays(), leads_along) ||
               std::ranges::any_of(b.rays(), leads_along);
    };
    for (std::uint32_t f = 0; f < result.intermediate.facet_count(); ++f) {
        auto& list = obstructs(result.intermediate.half_space(f).normal) ? result.obstructing
                                                                         : result.remaining;
        list.push_back(f);
    }
    return result;
}

} // namespace proxima
