#include "proxima/minkowski_sum.h"

#include "base/check.h"
#include "geometry/exact_predicates.h"
#include "minkowski/sum_by_arcs.h"

#include <cmath>

namespace proxima {

MinkowskiSum MinkowskiSum::scaled(double lambda) const noexcept
{
    PROXIMA_CHECK(lambda > 0 && std::isfinite(lambda));
    MinkowskiSum result = *this;
    result.scale_ = lambda;
    return result;
}

Vec3 MinkowskiSum::position(std::uint32_t vertex) const noexcept
{
    const SumCorner& made_of = corner(vertex);
    switch (made_of.kind) {
    case SumCorner::Kind::ray_of_a:
        return a().vertex(made_of.a);
    case SumCorner::Kind::ray_of_b:
        return b().vertex(made_of.b);
    case SumCorner::Kind::point:
        break;
    }
    return a().vertex(made_of.a) + scale_ * b().vertex(made_of.b);
}

ConvexPolyhedron::NormalFactors MinkowskiSum::normal_factors(std::uint32_t facet) const noexcept
{
    const SumFacet& source = this->facet(facet);
    switch (source.origin) {
    case FacetOrigin::a:
    case FacetOrigin::both:
        return a().normal_factors(source.a);
    case FacetOrigin::b:
        return b().normal_factors(source.b);
    case FacetOrigin::swept:
        break;
    }
    const Displacement along_a = a().direction(a().edges()[source.a]);
    const Displacement along_b = b().direction(b().edges()[source.b]);
    if (source.turn > 0) return {along_a, along_b};
    return {along_b, along_a};
}

HalfSpace MinkowskiSum::half_space(std::uint32_t facet) const noexcept
{
    const ConvexPolyhedron::NormalFactors factors = normal_factors(facet);
    const Vec3 normal = unit_normal(factors.u, factors.v);
    const SumCorner& rest = support(facet);
    return {normal, normal.dot(a().vertex(rest.a)) + scale_ * normal.dot(b().vertex(rest.b))};
}

Result<MinkowskiSum> minkowski_sum(const ConvexPolyhedron& a, const ConvexPolyhedron& b,
                                   const MinkowskiOptions& options)
{
    return detail::sum_by_arcs<double>(a, b, options.execution.progress);
}

} // namespace proxima
