// Whether a cell's centre lies in a Minkowski sum: one dot product per bounding plane
// (thesis 3.6.1).
#pragma once

#include "minkowski/scalar_vector.h"
#include "thesis/octree_generation/rounding_bounds.h"

#include <array>
#include <cstddef>
#include <span>

namespace proxima {

/// The half-spaces of one triangle's sum with the cells of one depth.
template <class Scalar>
class HalfSpaceTest {
public:
    [[nodiscard]] std::size_t size() const noexcept { return count_; }
    void clear() noexcept { count_ = 0; }

    /// Adds normal . x <= offset, where rounding may have moved either side, the tolerance in all.
    void add(const Vector3<Scalar>& normal, const Scalar& offset, double tolerance) noexcept
    {
        half_spaces_[count_++] = {normal, offset, tolerance};
    }

    /// Moves a half-space along its normal. \pre index < size()
    void set_support(std::size_t index, const Vector3<Scalar>& support) noexcept
    {
        half_spaces_[index].offset = dot(half_spaces_[index].normal, support);
    }

    /// The answer for one centre. Stops at the first half-space that does not hold it.
    [[nodiscard]] Overlap overlap(const Vec3& centre, const BoundedCentres& centres) const noexcept
    {
        const Vector3<Scalar> point = to_scalar<Scalar>(centre);
        bool certain = true;
        for (const HalfSpace& half_space : std::span(half_spaces_).first(count_)) {
            const Scalar product = dot(half_space.normal, point);
            const double depth = to_double(half_space.offset) - to_double(product);
            if (product > half_space.offset) {
                return centres.judge({false, -depth > half_space.tolerance}, centre);
            }
            certain = certain && depth >= half_space.tolerance;
        }
        return centres.judge({true, certain}, centre);
    }

private:
    struct HalfSpace {
        Vector3<Scalar> normal;
        Scalar offset;
        double tolerance = 0;
    };

    std::array<HalfSpace, GeometricSum<Scalar>::max_planes> half_spaces_;
    std::size_t count_ = 0;
};

} // namespace proxima
