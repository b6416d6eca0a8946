// Overlap by Minkowski sums whose supports are found once and followed by index (thesis 3.5).
//
//     depth d      v_k = v_i of the cube of half size h     + v_j of the triangle
//     depth d + 1  v_k = v_i of the cube of half size h / 2 + v_j: same i = k mod 8, j = k div 8
#pragma once

#include "thesis/octree_generation/half_space_test.h"

#include <array>
#include <cstdint>

namespace proxima {

/// An OverlapTest: as MinkowskiTest, but only the first depth pushes planes over all 24 vertices;
/// later ones recompute one support per plane. Instantiated for double and Counted.
template <class Scalar>
class BasicIndexTrackingTest {
public:
    explicit BasicIndexTrackingTest(const Triangle& triangle) noexcept;

    /// 312 dot products the first time; later one sum and one dot product per plane.
    void set_half_size(const Vec3& half_size) noexcept;

    /// At most 26 dot products, 17 in general position. \pre set_half_size was called
    [[nodiscard]] Overlap overlap(const Vec3& centre) const noexcept;

private:
    /// Where a plane's support comes from: i and j of v_i + v_j.
    struct SupportIndex {
        std::uint8_t cube_vertex = 0;
        std::uint8_t triangle_vertex = 0;
    };

    void find_supports(const RoundingBounds& bounds, const Vec3& half_size) noexcept;

    TriangleFeatures<Scalar> features_;
    RoundingBoundsMaker bounds_maker_;
    BoundedCentres centres_;
    std::array<SupportIndex, GeometricSum<Scalar>::max_planes> supports_;
    HalfSpaceTest<Scalar> test_;
};

using IndexTrackingTest = BasicIndexTrackingTest<double>;
static_assert(OverlapTest<IndexTrackingTest>);

} // namespace proxima
