#include "proxima/octree/overlap_separating_axis.h"

#include "proxima/minkowski/operation_counts.h"

#include <algorithm>
#include <cmath>

namespace proxima {

template <class Scalar>
BasicSeparatingAxisTest<Scalar>::BasicSeparatingAxisTest(const Triangle& triangle) noexcept
    : first_vertex_(to_scalar<Scalar>(triangle[0])),
      normal_magnitude_(cross_magnitude(triangle[1] - triangle[0], triangle[2] - triangle[0])),
      bounds_maker_(triangle)
{
    const auto vertex = [&](int i) { return to_scalar<Scalar>(triangle[i]); };
    const std::array<Vector3<Scalar>, 3> edges = {vertex(1) - vertex(0), vertex(2) - vertex(0),
                                                  vertex(2) - vertex(1)};
    const Vector3<Scalar> normal = cross(edges[0], edges[1]);

    axes_[0].direction = normal;
    std::size_t product = three_projections;
    for (int k = 0; k < 3; ++k) {
        const Vector3<Scalar> cell_axis = to_scalar<Scalar>(Vec3::Unit(k));
        Axis& box_axis = axes_[one_projection + static_cast<std::size_t>(k)];
        box_axis.direction = cell_axis;
        box_axis.offset = edges[0][k];
        box_axis.other_offset = edges[1][k];
        for (std::size_t i = 0; i < 3; ++i) {
            Axis& axis = axes_[product++];
            axis.direction = cross(cell_axis, edges[i]);
            axis.offset = i == 0 ? normal[k] : -normal[k];
        }
    }
}

template <class Scalar>
void BasicSeparatingAxisTest<Scalar>::set_half_size(const Vec3& half_size) noexcept
{
    const RoundingBounds bounds = bounds_maker_.next(half_size);
    centres_ = bounds.centres;
    const Vector3<Scalar> half = to_scalar<Scalar>(half_size);
    for (std::size_t i = 0; i < axis_count; ++i) {
        using std::abs;
        Axis& axis = axes_[i];
        const Vector3<Scalar>& l = axis.direction;
        axis.radius = half.x() * abs(l.x()) + half.y() * abs(l.y()) + half.z() * abs(l.z());
        // Only n has components in which something cancelled; the offsets of products are its.
        const Vec3 magnitude =
            i < one_projection
                ? normal_magnitude_
                : Vec3(to_double(l.x()), to_double(l.y()), to_double(l.z())).cwiseAbs();
        axis.tolerance = bounds.tolerance(magnitude, bounds.spread);
        if (i >= three_projections) {
            const auto k = static_cast<int>((i - three_projections) / 3);
            axis.tolerance += 32 * unit_roundoff * normal_magnitude_[k];
        }
    }
}

template <class Scalar>
Overlap BasicSeparatingAxisTest<Scalar>::overlap(const Vec3& centre) const noexcept
{
    const Vector3<Scalar> d = first_vertex_ - to_scalar<Scalar>(centre);
    bool certain = true;
    for (std::size_t i = 0; i < axis_count; ++i) {
        const Axis& axis = axes_[i];
        // The least and the greatest projection of the triangle, seen from the cell's centre.
        Scalar low = dot(axis.direction, d);
        Scalar high = low;
        const auto include = [&](const Scalar& projection) {
            if (projection < low) {
                low = projection;
            } else if (projection > high) {
                high = projection;
            }
        };
        if (i >= one_projection) {
            const Scalar p0 = low;
            include(p0 + axis.offset);
            if (i < three_projections) include(p0 + axis.other_offset);
        }
        const bool separates = low > axis.radius || -high > axis.radius;
        // How far the nearer end of the triangle lies outside the cell, or inside it.
        const double gap = std::max(to_double(low), -to_double(high)) - to_double(axis.radius);
        if (separates) return centres_.judge(false, gap > axis.tolerance, centre);
        certain = certain && -gap >= axis.tolerance;
    }
    return centres_.judge(true, certain, centre);
}

template class BasicSeparatingAxisTest<double>;
template class BasicSeparatingAxisTest<Counted>;

} // namespace proxima
