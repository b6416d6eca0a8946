#include "thesis/octree_generation/overlap_minkowski.h"

#include "minkowski/operation_counts.h"
#include "minkowski/scalar_vector.h"

namespace proxima {

template <class Scalar>
BasicMinkowskiTest<Scalar>::BasicMinkowskiTest(const Triangle& triangle) noexcept
    : features_(triangle_features<Scalar>(triangle)), bounds_maker_(triangle)
{}

template <class Scalar>
void BasicMinkowskiTest<Scalar>::set_half_size(const Vec3& half_size) noexcept
{
    const RoundingBounds bounds = bounds_maker_.next(half_size);
    centres_ = bounds.centres;
    const auto sum = geometric_sum<Scalar>(features_, to_scalar<Scalar>(half_size));
    test_.clear();
    for (const SupportPlane<Scalar>& plane : sum.planes()) {
        test_.add(plane.normal, plane.offset, bounds.tolerance(plane.magnitude, bounds.reach));
    }
}

template <class Scalar>
Overlap BasicMinkowskiTest<Scalar>::overlap(const Vec3& centre) const noexcept
{
    return test_.overlap(centre, centres_);
}

template class BasicMinkowskiTest<double>;
template class BasicMinkowskiTest<Counted>;

} // namespace proxima
