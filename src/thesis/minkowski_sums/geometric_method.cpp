#include "thesis/minkowski_sums/geometric_method.h"

#include "minkowski/operation_counts.h"
#include "minkowski/scalar_vector.h"

namespace proxima {

template <class Scalar>
TriangleFeatures<Scalar> triangle_features(const Triangle& triangle) noexcept
{
    TriangleFeatures<Scalar> features;
    for (std::size_t i = 0; i < 3; ++i) {
        features.vertices[i] = to_scalar<Scalar>(triangle.vertices[i]);
    }
    for (std::size_t i = 0; i < 3; ++i) {
        features.edges[i] = features.vertices[(i + 1) % 3] - features.vertices[i];
    }
    features.normal = cross(features.edges[0], features.edges[1]);
    features.normal_magnitude = cross_magnitude(triangle.vertices[1] - triangle.vertices[0],
                                                triangle.vertices[2] - triangle.vertices[1]);
    return features;
}

template <class Scalar>
GeometricSum<Scalar> geometric_sum(const TriangleFeatures<Scalar>& triangle,
                                   const Vector3<Scalar>& half_size) noexcept
{
    using Sum = GeometricSum<Scalar>;

    // 1. The vertex set V.
    std::array<Vector3<Scalar>, Sum::cube_vertices> cube;
    for (int i = 0; i < Sum::cube_vertices; ++i) {
        cube[static_cast<std::size_t>(i)] = cube_vertex(i, half_size);
    }
    std::array<Vector3<Scalar>, 3 * Sum::cube_vertices> sums;
    form_sum_vertices<Scalar>(cube, triangle.vertices, sums);

    // 2. The normal set N: of the triangle, of the cube, of pairs of edges.
    const std::array<Vector3<Scalar>, 3> axes = {to_scalar<Scalar>(Vec3::UnitX()),
                                                 to_scalar<Scalar>(Vec3::UnitY()),
                                                 to_scalar<Scalar>(Vec3::UnitZ())};
    std::array<CandidateNormal<Scalar>, Sum::max_planes / 2> normals;
    normals[0] = {triangle.normal, triangle.normal_magnitude, NormalSource::face};
    for (std::size_t k = 0; k < 3; ++k) {
        normals[1 + k] = {axes[k], Vec3::Unit(static_cast<int>(k)), NormalSource::face};
    }
    form_edge_normals<Scalar>(axes, triangle.edges, std::span(normals).template subspan<4>());

    // 3. The facets.
    Sum sum;
    sum.count = push_planes<3 * Sum::cube_vertices, Scalar>({cube, triangle.vertices, sums},
                                                            normals, sum.storage);
    return sum;
}

template TriangleFeatures<double> triangle_features(const Triangle&) noexcept;
template TriangleFeatures<Counted> triangle_features(const Triangle&) noexcept;
template GeometricSum<double> geometric_sum(const TriangleFeatures<double>&, const Vec3&) noexcept;
template GeometricSum<Counted> geometric_sum(const TriangleFeatures<Counted>&,
                                             const Vector3<Counted>&) noexcept;

} // namespace proxima
