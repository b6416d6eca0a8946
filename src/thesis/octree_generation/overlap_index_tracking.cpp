#include "thesis/octree_generation/overlap_index_tracking.h"

#include "minkowski/operation_counts.h"
#include "minkowski/scalar_vector.h"

namespace proxima {

template <class Scalar>
BasicIndexTrackingTest<Scalar>::BasicIndexTrackingTest(const Triangle& triangle) noexcept
    : features_(triangle_features<Scalar>(triangle)), bounds_maker_(triangle)
{}

template <class Scalar>
void BasicIndexTrackingTest<Scalar>::find_supports(const RoundingBounds& bounds,
                                                   const Vec3& half_size) noexcept
{
    constexpr int cube_vertices = GeometricSum<Scalar>::cube_vertices;
    const auto sum = geometric_sum<Scalar>(features_, to_scalar<Scalar>(half_size));
    for (const SupportPlane<Scalar>& plane : sum.planes()) {
        supports_[test_.size()] = {static_cast<std::uint8_t>(plane.support % cube_vertices),
                                   static_cast<std::uint8_t>(plane.support / cube_vertices)};
        // Among near ties rounding may choose a support that lies behind the true one, at every
        // depth by no more than the error at this one; the bounds of later depths are smaller. So
        // twice this depth's tolerance covers them all.
        test_.add(plane.normal, plane.offset, 2 * bounds.tolerance(plane.magnitude, bounds.reach));
    }
}

template <class Scalar>
void BasicIndexTrackingTest<Scalar>::set_half_size(const Vec3& half_size) noexcept
{
    const RoundingBounds bounds = bounds_maker_.next(half_size);
    centres_ = bounds.centres;
    if (test_.size() == 0) {
        find_supports(bounds, half_size);
        return;
    }
    const Vector3<Scalar> half = to_scalar<Scalar>(half_size);
    for (std::size_t plane = 0; plane < test_.size(); ++plane) {
        const auto [i, j] = supports_[plane];
        test_.set_support(plane, cube_vertex<Scalar>(i, half) + features_.vertices[j]);
    }
}

template <class Scalar>
Overlap BasicIndexTrackingTest<Scalar>::overlap(const Vec3& centre) const noexcept
{
    return test_.overlap(centre, centres_);
}

template class BasicIndexTrackingTest<double>;
template class BasicIndexTrackingTest<Counted>;

} // namespace proxima
