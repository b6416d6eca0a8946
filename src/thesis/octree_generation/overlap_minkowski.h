// Overlap by Minkowski sums, a new sum for every depth (thesis 3.4, 3.6.1).
#pragma once

#include "thesis/octree_generation/half_space_test.h"

namespace proxima {

/// An OverlapTest: the cell meets the triangle iff its centre lies in the sum of the triangle and a
/// cell of that size about the origin. Instantiated for double and Counted.
template <class Scalar>
class BasicMinkowskiTest {
public:
    explicit BasicMinkowskiTest(const Triangle& triangle) noexcept;

    /// Computes the sum anew by the geometric method: 312 dot products.
    void set_half_size(const Vec3& half_size) noexcept;

    /// At most 26 dot products, 17 in general position. \pre set_half_size was called
    [[nodiscard]] Overlap overlap(const Vec3& centre) const noexcept;

private:
    TriangleFeatures<Scalar> features_;
    RoundingBoundsMaker bounds_maker_;
    BoundedCentres centres_;
    HalfSpaceTest<Scalar> test_;
};

using MinkowskiTest = BasicMinkowskiTest<double>;
static_assert(OverlapTest<MinkowskiTest>);

} // namespace proxima
