// Overlap by separating axes (thesis 3.6.3, Table 3.1).
//
//     axis l       p0 = l . d      other projections     R, cell's half width on l
//     n            n . d           -                     s0 |n.a0| + s1 |n.a1| + s2 |n.a2|
//     a_k          a_k . d         p0 + a_k.e0, a_k.e1   s_k
//     a_k x e_0    ...             p0 + a_k.n            s_i |a_j.e0| + s_j |a_i.e0|
//     a_k x e_1    ...             p0 - a_k.n            s_i |a_j.e1| + s_j |a_i.e1|
//     a_k x e_2    ...             p0 - a_k.n            s_i |a_j.e2| + s_j |a_i.e2|
//
//     d = v0 - c, e0 = v1 - v0, e1 = v2 - v0, e2 = v2 - v1, n = e0 x e1
//
// The table was derived anew and is right, with a_0..a_2 for the text's a_1..a_3. Only the thesis's
// e2 = e1 - e0 is not rounded so: v2 - v1 is the same vector with one rounding instead of three,
// and is exactly zero in a component exactly when the edge is.
#pragma once

#include "minkowski/scalar_vector.h"
#include "thesis/octree_generation/rounding_bounds.h"

#include <array>

namespace proxima {

/// An OverlapTest. Instantiated for double and Counted.
template <class Scalar>
class BasicSeparatingAxisTest {
public:
    explicit BasicSeparatingAxisTest(const Triangle& triangle) noexcept;

    /// Updates the 13 radii R, nothing else.
    void set_half_size(const Vec3& half_size) noexcept;

    /// At most 13 dot products and 18 sums, 83 flops. \pre set_half_size was called
    [[nodiscard]] Overlap overlap(const Vec3& centre) const noexcept;

private:
    /// How many projections of the triangle's vertices on an axis differ.
    static constexpr std::size_t one_projection = 1;    ///< 0: the normal
    static constexpr std::size_t three_projections = 4; ///< 1 to 3: the cell's axes
    static constexpr std::size_t axis_count = 13;       ///< 4 to 12, two projections: the products

    struct Axis {
        Vector3<Scalar> direction;
        Scalar offset;       ///< of another projection from p0
        Scalar other_offset; ///< of the third, for the cell's axes
        Scalar radius;
        double tolerance = 0; ///< what rounding may do to projections and radius together
    };

    Vector3<Scalar> first_vertex_;
    std::array<Axis, axis_count> axes_;
    Vec3 normal_magnitude_; ///< bounds |n| before cancellation
    RoundingBoundsMaker bounds_maker_;
    BoundedCentres centres_;
};

using SeparatingAxisTest = BasicSeparatingAxisTest<double>;
static_assert(OverlapTest<SeparatingAxisTest>);

} // namespace proxima
