#include "thesis/octree_generation/overlap_pairwise.h"

#include "minkowski/operation_counts.h"
#include "minkowski/scalar_vector.h"

#include <cmath>
#include <span>

namespace proxima {
namespace {

/// What is known of a <= b when b - a has been computed with at most this error.
struct Bound {
    bool surely_holds = false;
    bool surely_fails = false;

    Bound(double difference, double error) noexcept
        : surely_holds(difference > error), surely_fails(-difference > error)
    {}
};

} // namespace

/// The planes of one cell: lower x, y, z, then upper x, y, z.
template <class Scalar>
struct BasicPairwiseTest<Scalar>::CellPlanes {
    std::array<Scalar, 3> lower;
    std::array<Scalar, 3> upper;
    std::array<Vector3<Scalar>, 6> normals; ///< outward
    std::array<Scalar, 6> offsets;          ///< normal . x <= offset in the cell

    CellPlanes(const Vector3<Scalar>& centre, const Vector3<Scalar>& half) noexcept
    {
        for (int axis = 0; axis < 3; ++axis) {
            const auto k = static_cast<std::size_t>(axis);
            lower[k] = centre[axis] - half[axis];
            upper[k] = centre[axis] + half[axis];
            normals[k] = to_scalar<Scalar>(-Vec3::Unit(axis));
            normals[k + 3] = to_scalar<Scalar>(Vec3::Unit(axis));
            offsets[k] = -lower[k];
            offsets[k + 3] = upper[k];
        }
    }
};

template <class Scalar>
BasicPairwiseTest<Scalar>::BasicPairwiseTest(const Triangle& triangle) noexcept
    : features_(triangle_features<Scalar>(triangle)),
      plane_offset_(dot(features_.normal, features_.vertices[0])), bounds_maker_(triangle)
{
    for (std::size_t i = 0; i < 3; ++i) {
        const Vec3 plain_edge = triangle.vertices[(i + 1) % 3] - triangle.vertices[i];
        side_normals_[i] = cross(features_.edges[i], features_.normal);
        side_offsets_[i] = dot(side_normals_[i], features_.vertices[i]);
        side_magnitudes_[i] = cross_magnitude(plain_edge, features_.normal_magnitude);
    }
}

template <class Scalar>
void BasicPairwiseTest<Scalar>::set_half_size(const Vec3& half_size) noexcept
{
    const RoundingBounds bounds = bounds_maker_.next(half_size);
    centres_ = bounds.centres;
    half_size_ = to_scalar<Scalar>(half_size);
    for (int k = 0; k < 3; ++k) {
        cell_edge_[k] = Scalar(2) * half_size_[k];
        cell_edge_products_[k] = features_.normal[k] * cell_edge_[k];
        vertex_error_[k] = bounds.tolerance(Vec3::Unit(k), bounds.reach);
    }
    // x = p + t u inherits the error of t along u.
    for (std::size_t i = 0; i < 3; ++i) {
        for (int k = 0; k < 3; ++k) {
            HitError& error = triangle_edge_errors_[i][static_cast<std::size_t>(k)];
            error.parameter = vertex_error_[k] / std::abs(to_double(features_.edges[i][k]));
            for (int j = 0; j < 3; ++j) {
                error.border[j] =
                    vertex_error_[j] + error.parameter * std::abs(to_double(features_.edges[i][j]));
            }
        }
    }
    // The plane's tolerance covers n.p. n.u is off by at most seven times as much, half size
    // included.
    const double plane_error = 8 * bounds.tolerance(features_.normal_magnitude, bounds.reach);
    for (int k = 0; k < 3; ++k) {
        HitError& error = cell_edge_errors_[static_cast<std::size_t>(k)];
        error.parameter = plane_error / std::abs(to_double(cell_edge_products_[k]));
        for (int i = 0; i < 3; ++i) {
            const Vec3& magnitude = side_magnitudes_[static_cast<std::size_t>(i)];
            error.border[i] = 2 * bounds.tolerance(magnitude, bounds.reach) +
                              magnitude[k] * error.parameter * to_double(cell_edge_[k]);
        }
    }
}

template <class Scalar>
Overlap BasicPairwiseTest<Scalar>::overlap(const Vec3& centre) const noexcept
{
    const CellPlanes cell(to_scalar<Scalar>(centre), half_size_);
    const Verdict vertices = test_vertices(cell);
    if (vertices.overlaps) return centres_.judge({true, vertices.certain}, centre);
    const Verdict triangle_edges = test_triangle_edges(cell);
    if (triangle_edges.overlaps) return centres_.judge({true, triangle_edges.certain}, centre);
    const Verdict cell_edges = test_cell_edges(cell);
    if (cell_edges.overlaps) return centres_.judge({true, cell_edges.certain}, centre);
    const bool certain = vertices.certain && triangle_edges.certain && cell_edges.certain;
    return centres_.judge({false, certain}, centre);
}

template <class Scalar>
auto BasicPairwiseTest<Scalar>::test_vertices(const CellPlanes& cell) const noexcept -> Verdict
{
    Verdict verdict;
    for (const Vector3<Scalar>& vertex : features_.vertices) {
        bool inside = true;
        bool surely_inside = true;
        bool surely_outside = false;
        for (int axis = 0; axis < 3; ++axis) {
            const auto k = static_cast<std::size_t>(axis);
            inside = inside && cell.lower[k] <= vertex[axis] && vertex[axis] <= cell.upper[k];
            const double coordinate = to_double(vertex[axis]);
            const Bound above(coordinate - to_double(cell.lower[k]), vertex_error_[axis]);
            const Bound below(to_double(cell.upper[k]) - coordinate, vertex_error_[axis]);
            surely_inside = surely_inside && above.surely_holds && below.surely_holds;
            surely_outside = surely_outside || above.surely_fails || below.surely_fails;
        }
        if (surely_inside) return {true, true};
        verdict.overlaps = verdict.overlaps || inside;
        verdict.certain = verdict.certain && surely_outside;
    }
    return verdict;
}

template <class Scalar>
auto BasicPairwiseTest<Scalar>::test_triangle_edges(const CellPlanes& cell) const noexcept
    -> Verdict
{
    Verdict verdict;
    for (std::size_t i = 0; i < 3; ++i) {
        const Vector3<Scalar>& p = features_.vertices[i];
        const Vector3<Scalar>& u = features_.edges[i];
        for (std::size_t face = 0; face < 6; ++face) {
            const std::size_t axis = face % 3;
            const Scalar& along = u[static_cast<int>(axis)];
            if (along == Scalar(0)) continue;
            const HitError& error = triangle_edge_errors_[i][axis];

            const Scalar product = face < 3 ? -along : along;
            const Scalar t = (cell.offsets[face] - dot(cell.normals[face], p)) / product;
            const bool in_range = t >= Scalar(0) && t <= Scalar(1);
            const Bound after_start(to_double(t), error.parameter);
            const Bound before_end(1 - to_double(t), error.parameter);
            if (after_start.surely_fails || before_end.surely_fails) continue;

            const Vector3<Scalar> x = p + u * t;
            bool hit = in_range;
            bool surely_hit = after_start.surely_holds && before_end.surely_holds;
            bool surely_missed = false;
            for (std::size_t side = 0; side < 6 && !surely_missed; ++side) {
                if (side % 3 == axis) continue;
                const Scalar product_at_side = dot(cell.normals[side], x);
                hit = hit && product_at_side <= cell.offsets[side];
                const Bound within(to_double(cell.offsets[side]) - to_double(product_at_side),
                                   error.border[static_cast<int>(side % 3)]);
                surely_hit = surely_hit && within.surely_holds;
                surely_missed = within.surely_fails;
            }
            if (surely_missed) continue;
            if (hit) return {true, surely_hit};
            verdict.certain = false;
        }
    }
    return verdict;
}

template <class Scalar>
auto BasicPairwiseTest<Scalar>::test_cell_edges(const CellPlanes& cell) const noexcept -> Verdict
{
    Verdict verdict;
    for (int axis = 0; axis < 3; ++axis) {
        const auto k = static_cast<std::size_t>(axis);
        const Scalar& product = cell_edge_products_[axis];
        if (product == Scalar(0)) {
            verdict.certain = verdict.certain && features_.normal_magnitude[axis] == 0;
            continue;
        }
        const HitError& error = cell_edge_errors_[k];
        const int first = (axis + 1) % 3;
        const int second = (axis + 2) % 3;
        for (unsigned corner = 0; corner < 4; ++corner) {
            const auto at = [&](int other, bool upper) {
                return upper ? cell.upper[static_cast<std::size_t>(other)]
                             : cell.lower[static_cast<std::size_t>(other)];
            };
            Vector3<Scalar> x;
            x[axis] = cell.lower[k];
            x[first] = at(first, (corner & 1U) != 0);
            x[second] = at(second, (corner & 2U) != 0);

            const Scalar t = (plane_offset_ - dot(features_.normal, x)) / product;
            const bool in_range = t >= Scalar(0) && t <= Scalar(1);
            const Bound after_start(to_double(t), error.parameter);
            const Bound before_end(1 - to_double(t), error.parameter);
            if (after_start.surely_fails || before_end.surely_fails) continue;

            x[axis] = x[axis] + t * cell_edge_[axis];
            bool hit = in_range;
            bool surely_hit = after_start.surely_holds && before_end.surely_holds;
            bool surely_missed = false;
            for (std::size_t side = 0; side < 3 && !surely_missed; ++side) {
                const Scalar product_at_side = dot(side_normals_[side], x);
                hit = hit && product_at_side <= side_offsets_[side];
                const Bound within(to_double(side_offsets_[side]) - to_double(product_at_side),
                                   error.border[static_cast<int>(side)]);
                surely_hit = surely_hit && within.surely_holds;
                surely_missed = within.surely_fails;
            }
            if (surely_missed) continue;
            if (hit) return {true, surely_hit};
            verdict.certain = false;
        }
    }
    return verdict;
}

template class BasicPairwiseTest<double>;
template class BasicPairwiseTest<Counted>;

} // namespace proxima
