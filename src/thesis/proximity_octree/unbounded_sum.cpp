#include "thesis/proximity_octree/unbounded_sum.h"

#include "geometry/length.h"
#include "proxima/convex_polyhedron.h"

#include <algorithm>
#include <cmath>
#include <string>

namespace proxima {

Result<ConvexPolyhedron> cut_rays(const ConvexPolyhedron& polyhedron, double length,
                                  Progress* progress)
{
    if (!std::isfinite(length) || !(length > 0)) {
        return fail(ErrorCode::invalid_argument,
                    "rays are cut off at a finite length above 0, not at " +
                        std::to_string(length));
    }
    if (polyhedron.is_bounded()) return polyhedron;
    std::vector<Vec3> points(polyhedron.points().begin(), polyhedron.points().end());
    for (const PolyhedronEdge& edge : polyhedron.edges()) {
        if (polyhedron.is_ray(edge.to)) {
            points.emplace_back(polyhedron.vertex(edge.from) +
                                length * unit_of(polyhedron.vertex(edge.to)));
        }
    }
    const bool is_near = std::ranges::all_of(points, [](const Vec3& point) {
        return point.cwiseAbs().maxCoeff() <= max_polyhedron_coordinate;
    });
    if (!is_near) {
        return fail(ErrorCode::limit_exceeded,
                    "rays of this length end beyond 2^300, about 2e90: cut them off shorter");
    }
    return convex_hull(points, {}, {.progress = progress});
}

Result<CutSum> sum_by_cutting(const ConvexPolyhedron& a, const ConvexPolyhedron& b, double length,
                              Progress* progress)
{
    const auto cut_a = cut_rays(a, length, progress);
    if (!cut_a) return tl::unexpected(cut_a.error());
    const auto cut_b = cut_rays(b, length, progress);
    if (!cut_b) return tl::unexpected(cut_b.error());
    auto intermediate = minkowski_sum(*cut_a, *cut_b, {.execution = {.progress = progress}});
    if (!intermediate) return tl::unexpected(intermediate.error());
    CutSum result = {std::move(*intermediate), {}, {}};
    const auto obstructs = [&](const Vec3& normal) {
        const auto leads_along = [&](const Vec3& ray) {
            return normal.dot(unit_of(ray)) > obstruction_tolerance;
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
