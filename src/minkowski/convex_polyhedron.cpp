#include "proxima/convex_polyhedron.h"

#include "geometry/exact_predicates.h"
#include "minkowski/facet_sign.h"

#include <algorithm>

namespace proxima {

HalfSpace ConvexPolyhedron::half_space(std::uint32_t facet) const noexcept
{
    const NormalFactors factors = normal_factors(facet);
    const Vec3 normal = unit_normal(factors.u, factors.v);
    // Uses the farthest corner of the loop, so that no corner lies outside by more than rounding.
    double offset = -std::numeric_limits<double>::infinity();
    for (const std::uint32_t corner : facet_loop(facet)) {
        if (!is_ray(corner)) offset = std::max(offset, normal.dot(vertices_[corner]));
    }
    return {normal, offset};
}

PolyhedronSupport ConvexPolyhedron::support(const Vec3& direction) const noexcept
{
    PolyhedronSupport best = {-std::numeric_limits<double>::infinity(), 0};
    for (std::uint32_t p = 0; p < point_count_; ++p) {
        const double value = direction.dot(vertices_[p]);
        if (value > best.value) best = {value, p};
    }
    for (const Vec3& ray : rays()) {
        const double rounding =
            8 * std::numeric_limits<double>::epsilon() * direction.cwiseAbs().dot(ray.cwiseAbs());
        if (direction.dot(ray) > rounding) best.value = std::numeric_limits<double>::infinity();
    }
    return best;
}

ConvexPolyhedron::NormalFactors ConvexPolyhedron::normal_factors(std::uint32_t facet) const noexcept
{
    const auto [a, b, c] = facets_[facet].corners;
    const auto to = [&, a = a](std::uint32_t corner) {
        return is_ray(corner) ? Displacement{Vec3::Zero(), vertices_[corner]}
                              : Displacement{vertices_[a], vertices_[corner]};
    };
    return {to(b), to(c)};
}

int ConvexPolyhedron::normal_sign(std::uint32_t facet, const Displacement& direction) const noexcept
{
    return FacetSign::of<double>(*this, facet, direction);
}

int FacetSign::exact(const ConvexPolyhedron& polyhedron, std::uint32_t facet,
                     const Displacement& direction) noexcept
{
    const ConvexPolyhedron::NormalFactors normal = polyhedron.normal_factors(facet);
    return determinant_sign(normal.u, normal.v, direction);
}

} // namespace proxima
