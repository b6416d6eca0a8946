// Overlap by Minkowski sums found with the pseudocode of thesis section 3.2 as it is printed.
//
//     step 3.1    both lists of extreme vertices start empty, v_1 in neither
//     step 3.3    a vertex that ties with the largest product is not offered to the other list
//     ties        equality of floating-point numbers
//
// So a facet that rests on v_1 may keep fewer than three vertices and is lost: the sum is too large,
// and cells list triangles that do not touch them. geometric_method.h has the method put right.
// Each of the three can be put right here by itself, to see what it does to the thesis's Table 2.1.
#pragma once

#include "proxima/geometry.h"
#include "proxima/octree.h"
#include "thesis/octree_generation/overlap_tests.h"

#include <array>
#include <cstdint>

namespace proxima {

/// Which lists hold v_1 before the first comparison.
enum class FirstVertex : std::uint8_t { in_neither_list, in_maximal_list, in_both_lists };

/// Whether a vertex that joins one list may join the other too.
enum class ListOffers : std::uint8_t { one_list, both_lists };

enum class FloatWidth : std::uint8_t { float_32, float_64 };

/// The pseudocode as printed, or with parts of it put right.
struct PrintedRules {
    FirstVertex first_vertex = FirstVertex::in_neither_list;
    ListOffers offers = ListOffers::one_list;
    double tie_tolerance = 0; ///< products that differ by no more count as equal
    FloatWidth width = FloatWidth::float_64;
};

/// An OverlapTest, never certain.
template <class Real>
class AsPrintedTest {
public:
    explicit AsPrintedTest(const Triangle& triangle, const PrintedRules& rules = {}) noexcept;

    /// Computes the sum anew.
    void set_half_size(const Vec3& half_size) noexcept;

    /// \pre set_half_size was called
    [[nodiscard]] Overlap overlap(const Vec3& centre) const noexcept;

    /// How many planes bound the sum.
    [[nodiscard]] std::size_t plane_count() const noexcept { return count_; }

private:
    using Vector = Eigen::Matrix<Real, 3, 1>;
    struct Plane {
        Vector normal;
        Real offset = 0;
    };

    void push(const Vector& normal, const std::array<Vector, 24>& sums) noexcept;

    std::array<Vector, 3> vertices_;
    PrintedRules rules_;
    std::array<Plane, 26> planes_;
    std::size_t count_ = 0;
};

/// Like build_octree_by with OverlapMethod::minkowski, by these rules. Errors as build_octree_by.
[[nodiscard]] Result<Octree> build_octree_as_printed(const TriangleMesh& mesh,
                                                     const PrintedRules& rules = {},
                                                     const OctreeOptions& options = {});

} // namespace proxima
