// What samples say for sure of how far one mesh is from another: slow oracles of the deviation.
#pragma once

#include "geometry/closest_point.h"
#include "proxima/mesh_deviation.h"
#include "proxima/triangle_mesh.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace proxima::testing {

/// The distance of a point from all triangles, one after the other.
inline double distance_from(const TriangleMesh& mesh, const Vec3& p)
{
    double least = HUGE_VAL;
    for (std::uint32_t i = 0; i < mesh.triangle_count(); ++i)
        least = std::min(least, (closest_point(mesh.triangle(TriangleId{i}), p).point - p).norm());
    return least;
}

/// What samples say for sure: a distance grows by no more than the way from a sample.
struct SampledBounds {
    DistanceBounds greatest;
    DistanceBounds mean;
    DistanceBounds square;
    double area = 0;
};

/// Cuts each triangle into cuts^2 of its shape, and visits their corners.
template <class Visit>
void visit_small_triangles(const TriangleMesh& a, int cuts, const Visit& visit)
{
    for (std::uint32_t i = 0; i < a.triangle_count(); ++i) {
        const Triangle triangle = a.triangle(TriangleId{i});
        const Vec3 u = (triangle[1] - triangle[0]) / cuts;
        const Vec3 w = (triangle[2] - triangle[0]) / cuts;
        for (int j = 0; j < cuts; ++j) {
            for (int k = 0; j + k < cuts; ++k) {
                const Vec3 p = triangle[0] + j * u + k * w;
                visit(p, Vec3(p + u), Vec3(p + w));
                if (j + k + 1 < cuts) visit(Vec3(p + u), Vec3(p + u + w), Vec3(p + w));
            }
        }
    }
}

template <class Visit>
void visit_samples(const TriangleMesh& a, int cuts, const Visit& visit)
{
    visit_small_triangles(a, cuts, [&](const Vec3& p, const Vec3& q, const Vec3& r) {
        for (const Vec3& corner : {p, q, r}) visit(corner);
    });
}

inline SampledBounds sampled(const TriangleMesh& a, const TriangleMesh& b, int cuts)
{
    SampledBounds bounds;
    visit_small_triangles(a, cuts, [&](const Vec3& p, const Vec3& q, const Vec3& r) {
        const Vec3 middle = (p + q + r) / 3;
        const double reach =
            std::max({(p - middle).norm(), (q - middle).norm(), (r - middle).norm()});
        const double distance = distance_from(b, middle);
        const double area = 0.5 * (q - p).cross(r - p).norm();
        const double least = std::max(distance - reach, 0.0);
        const double most = distance + reach;
        bounds.greatest.lower = std::max(bounds.greatest.lower, distance);
        bounds.greatest.upper = std::max(bounds.greatest.upper, most);
        bounds.area += area;
        bounds.mean.lower += area * least;
        bounds.mean.upper += area * most;
        bounds.square.lower += area * least * least;
        bounds.square.upper += area * most * most;
    });
    return bounds;
}

inline double size_of(const TriangleMesh& a, const TriangleMesh& b)
{
    Box box = bounding_box(a);
    box.extend(bounding_box(b).lower);
    box.extend(bounding_box(b).upper);
    return box.extent().norm() + box.lower.cwiseAbs().maxCoeff() + box.upper.cwiseAbs().maxCoeff();
}

} // namespace proxima::testing
