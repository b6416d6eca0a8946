// On which side of a facet a direction points, exactly, for any scalar.
#pragma once

#include "minkowski/scalar_vector.h"
#include "proxima/convex_polyhedron.h"

#include <cmath>
#include <cstdint>
#include <limits>

namespace proxima {

/// The sign of a facet's outward normal . direction. Exact. The filter runs on Scalar: double, or
/// one that counts what is done to it (operation_counts.h).
struct PROXIMA_HIDDEN FacetSign {
    /// \pre |direction| <= 2^302
    template <class Scalar>
    [[nodiscard]] static int of(const ConvexPolyhedron& polyhedron, std::uint32_t facet,
                                const Displacement& direction) noexcept
    {
        using std::abs;
        // Where this filter fails, exact numbers decide.
        const ConvexPolyhedron::Facet& plane = polyhedron.facets_[facet];
        const Vector3<Scalar> d =
            to_scalar<Scalar>(direction.to) - to_scalar<Scalar>(direction.from);
        const Scalar value = dot(to_scalar<Scalar>(plane.normal), d);
        const Scalar error = Scalar(plane.tolerance) * (abs(d.x()) + abs(d.y()) + abs(d.z())) +
                             Scalar(underflow_slack);
        if (value > error) return 1;
        if (value < -error) return -1;
        return exact(polyhedron, facet, direction);
    }

private:
    /// More than the three products of a normal and a direction lose by underflow, 2^-1075 each.
    static constexpr double underflow_slack = std::numeric_limits<double>::min();

    [[nodiscard]] static int exact(const ConvexPolyhedron& polyhedron, std::uint32_t facet,
                                   const Displacement& direction) noexcept;
};

template <class Scalar = double>
[[nodiscard]] int normal_sign(const ConvexPolyhedron& polyhedron, std::uint32_t facet,
                              const Displacement& direction) noexcept
{
    return FacetSign::of<Scalar>(polyhedron, facet, direction);
}

} // namespace proxima
