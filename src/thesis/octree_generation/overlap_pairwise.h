// Overlap edge against face, pair by pair (thesis 3.6.2).
//
//     a vertex of the triangle in the cell          3 comparisons each
//     edges of the triangle against faces of the cell     3 x 6 tests
//     edges of the cell against the triangle             12 x 1 tests
//
//     one test: t = (d - n.p) / (n.u), then x = p + t u against the planes at the face's sides
//
// Degenerate cases. The thesis takes only t inside (0, 1) and settles the rest by further tests it
// does not give. Cells and triangles are closed sets here, touching counts, so t = 0, t = 1 and
// points on a face's border are hits. This settles them all but one without more tests: where a
// closed triangle meets a closed cell,
// - a vertex of it lies in the cell (this is the further test: a triangle wholly inside), or
// - an edge enters the cell, through a face it is not parallel to: one lying in a face's plane
//   crosses the border of that face, which belongs to a neighbouring face too, or
// - the triangle cuts the cell with its interior alone, in a polygon, segment or point whose
//   corners lie on edges of the cell that it does not contain.
// So parallel pairs (n.u = 0) are skipped, and segments and points need no case of their own.
#pragma once

#include "minkowski/scalar_vector.h"
#include "thesis/octree_generation/rounding_bounds.h"

#include <array>

namespace proxima {

/// An OverlapTest. Instantiated for double and Counted.
template <class Scalar>
class BasicPairwiseTest {
public:
    explicit BasicPairwiseTest(const Triangle& triangle) noexcept;

    /// Updates the cell's edges n.u and, for `certain`, how far hits may be off.
    void set_half_size(const Vec3& half_size) noexcept;

    /// At most 30 edge-face tests. Stops at the first hit. \pre set_half_size was called
    [[nodiscard]] Overlap overlap(const Vec3& centre) const noexcept;

private:
    struct CellPlanes;

    /// What rounding may do to the hit of a line and a plane.
    struct HitError {
        double parameter = 0;       ///< to t
        Vec3 border = Vec3::Zero(); ///< to the distances from the planes at the sides
    };

    struct Verdict {
        bool overlaps = false;
        bool certain = true; ///< of a hit, or of having missed everything so far
    };

    [[nodiscard]] Verdict test_vertices(const CellPlanes& cell) const noexcept;
    [[nodiscard]] Verdict test_triangle_edges(const CellPlanes& cell) const noexcept;
    [[nodiscard]] Verdict test_cell_edges(const CellPlanes& cell) const noexcept;

    TriangleFeatures<Scalar> features_;
    Scalar plane_offset_;                         ///< n . v0
    std::array<Vector3<Scalar>, 3> side_normals_; ///< of the triangle's sides, in plane, outward
    std::array<Scalar, 3> side_offsets_;
    std::array<Vec3, 3> side_magnitudes_;
    Vector3<Scalar> half_size_;
    Vector3<Scalar> cell_edge_;          ///< 2 h
    Vector3<Scalar> cell_edge_products_; ///< n . u for the cell's edges in x, y, z
    Vec3 vertex_error_ = Vec3::Zero();
    std::array<std::array<HitError, 3>, 3> triangle_edge_errors_; ///< by edge, by axis of the face
    std::array<HitError, 3> cell_edge_errors_;                    ///< by direction of the edge
    RoundingBoundsMaker bounds_maker_;
    BoundedCentres centres_;
};

using PairwiseTest = BasicPairwiseTest<double>;
static_assert(OverlapTest<PairwiseTest>);

} // namespace proxima
