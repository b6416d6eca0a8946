#include "thesis/octree_generation/overlap_separating_axis.h"

#include "minkowski/operation_counts.h"
#include "minkowski/scalar_vector.h"

#include <cmath>

namespace proxima {
namespace {

template <class Scalar>
[[nodiscard]] Scalar smaller(const Scalar& a, const Scalar& b) noexcept
{
    return b < a ? b : a;
}

template <class Scalar>
[[nodiscard]] Scalar larger(const Scalar& a, const Scalar& b) noexcept
{
    return a < b ? b : a;
}

} // namespace

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
        // Only n has components with cancellation; the offsets of products inherit it.
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
    // Whether an axis separates, given the triangle's least and greatest projection as seen from
    // the cell's centre: `outside` is how far its nearer end lies from there.
    bool surely_apart = false;
    const auto separates = [&](const Axis& axis, const Scalar& low, const Scalar& high) {
        const Scalar outside = larger(low, -high);
        const double gap = to_double(outside) - to_double(axis.radius);
        surely_apart = gap > axis.tolerance;
        certain = certain && -gap >= axis.tolerance;
        return outside > axis.radius;
    };
    for (std::size_t i = 0; i < axis_count; ++i) {
        const Axis& axis = axes_[i];
        const Scalar p0 = dot(axis.direction, d);
        Scalar low = p0;
        Scalar high = p0;
        if (i >= one_projection) {
            const Scalar p1 = p0 + axis.offset;
            low = smaller(p0, p1);
            high = larger(p0, p1);
        }
        if (i >= one_projection && i < three_projections) {
            const Scalar p2 = p0 + axis.other_offset;
            low = smaller(low, p2);
            high = larger(high, p2);
        }
        if (separates(axis, low, high)) return centres_.judge({false, surely_apart}, centre);
    }
    return centres_.judge({true, certain}, centre);
}

template class BasicSeparatingAxisTest<double>;
template class BasicSeparatingAxisTest<Counted>;

} // namespace proxima
