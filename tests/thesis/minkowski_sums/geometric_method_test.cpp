#include "thesis/minkowski_sums/geometric_method.h"
#include "thesis/minkowski_sums/incremental_hull.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <random>
#include <set>
#include <vector>

namespace proxima::geometric_method_test {
namespace {

/// A facet's plane in lowest terms: its whole normal divided by the greatest common divisor.
using WholePlane = std::array<std::int64_t, 4>;

WholePlane whole_plane(const Vec3& normal, double offset)
{
    WholePlane plane{};
    std::int64_t divisor = 0;
    for (int k = 0; k < 3; ++k) {
        plane[static_cast<std::size_t>(k)] = std::llround(normal[k]);
        divisor = std::gcd(divisor, plane[static_cast<std::size_t>(k)]);
    }
    EXPECT_NE(divisor, 0);
    plane[3] = std::llround(offset);
    EXPECT_EQ(plane[3] % divisor, 0);
    for (std::int64_t& term : plane) term /= divisor;
    return plane;
}

std::vector<Vec3> sum_points(const Triangle& triangle, const Vec3& half_size)
{
    std::vector<Vec3> points;
    for (const Vec3& vertex : triangle.vertices) {
        for (int i = 0; i < 8; ++i) points.push_back(cube_vertex(i, half_size) + vertex);
    }
    return points;
}

GeometricSum<double> sum_of(const Triangle& triangle, const Vec3& half_size)
{
    return geometric_sum(triangle_features<double>(triangle), half_size);
}

Triangle random_whole_triangle(std::mt19937& random, int size)
{
    std::uniform_int_distribution<int> coordinate(-size, size);
    Triangle triangle;
    for (Vec3& vertex : triangle.vertices) {
        vertex = Eigen::Vector3i{coordinate(random), coordinate(random), coordinate(random)}
                     .cast<double>();
    }
    return triangle;
}

Triangle random_triangle(std::mt19937& random)
{
    std::uniform_real_distribution<double> coordinate(-1, 1);
    Triangle triangle;
    for (Vec3& vertex : triangle.vertices) {
        vertex = Vec3{coordinate(random), coordinate(random), coordinate(random)};
    }
    return triangle;
}

TEST(GeometricMethod, HasTheFacetsOfTheConvexHullForIntegers)
{
    std::map<std::size_t, int> facet_counts;
    for (unsigned seed = 0; seed < 4000; ++seed) {
        SCOPED_TRACE(seed);
        std::mt19937 random(seed);
        // Small sizes are full of axis-parallel edges, segments and points; large ones general.
        const int size = seed % 4 == 0 ? 1 : seed % 4 == 1 ? 3 : 1000;
        const Triangle triangle = random_whole_triangle(random, size);
        std::uniform_int_distribution<int> half(1, 5);
        const Vec3 half_size =
            Eigen::Vector3i{half(random), half(random), half(random)}.cast<double>();

        const auto hull = incremental_hull<double>(sum_points(triangle, half_size));
        ASSERT_TRUE(hull);
        std::set<WholePlane> expected;
        for (const auto& face : *hull) expected.insert(whole_plane(face.normal, face.offset));
        std::set<WholePlane> found;
        const auto sum = sum_of(triangle, half_size);
        for (const auto& plane : sum.planes()) {
            if (plane.normal == Vec3::Zero()) { // of a segment, kept as possibly rounded to zero
                EXPECT_EQ(plane.offset, 0);
                continue;
            }
            found.insert(whole_plane(plane.normal, plane.offset));
        }
        EXPECT_EQ(found, expected);
        if (size == 1000) ++facet_counts[found.size()];
    }
    // 17 facets in general position, fewer where an edge is parallel to an axis; never 26.
    EXPECT_LE(facet_counts.rbegin()->first, 17U);
    EXPECT_GT(facet_counts[17], 1980);
}

TEST(GeometricMethod, FindsSeventeenFacetsInGeneralPosition)
{
    std::mt19937 random(7);
    int with_seventeen = 0;
    constexpr int triangles = 5000;
    for (int i = 0; i < triangles; ++i) {
        const auto sum = sum_of(random_triangle(random), Vec3::Constant(0.125));
        EXPECT_GE(sum.count, 17); // rounding may add a plane, never lose a facet
        with_seventeen += sum.count == 17 ? 1 : 0;
    }
    EXPECT_EQ(with_seventeen, triangles);
}

TEST(GeometricMethod, HasTheFacetsOfTheConvexHullForRandomNumbers)
{
    for (unsigned seed = 0; seed < 1000; ++seed) {
        SCOPED_TRACE(seed);
        std::mt19937 random(seed);
        const Triangle triangle = random_triangle(random);
        const Vec3 half_size(0.3, 0.2, 0.1);
        const auto hull = incremental_hull<double>(sum_points(triangle, half_size));
        ASSERT_TRUE(hull);
        const auto sum = sum_of(triangle, half_size);
        const auto is_same = [](const Vec3& n, double o, const Vec3& m, double p) {
            const double length = m.norm() / n.norm();
            return (n * length - m).norm() < 1e-9 * m.norm() &&
                   std::abs(o * length - p) < 1e-9 * m.norm();
        };
        for (const auto& face : *hull) {
            EXPECT_TRUE(std::ranges::any_of(sum.planes(), [&](const auto& plane) {
                return is_same(plane.normal, plane.offset, face.normal, face.offset);
            }));
        }
        for (const auto& plane : sum.planes()) {
            EXPECT_TRUE(std::ranges::any_of(*hull, [&](const auto& face) {
                return is_same(plane.normal, plane.offset, face.normal, face.offset);
            }));
        }
    }
}

TEST(GeometricMethod, SupportsAreVerticesOnTheirPlanes)
{
    for (unsigned seed = 0; seed < 500; ++seed) {
        SCOPED_TRACE(seed);
        std::mt19937 random(seed);
        const Triangle triangle = random_whole_triangle(random, 100);
        const Vec3 half_size(1, 2, 3);
        const std::vector<Vec3> points = sum_points(triangle, half_size);
        const auto sum = sum_of(triangle, half_size);
        for (const auto& plane : sum.planes()) {
            EXPECT_EQ(plane.normal.dot(points[static_cast<std::size_t>(plane.support)]),
                      plane.offset);
            for (const Vec3& point : points) EXPECT_LE(plane.normal.dot(point), plane.offset);
        }
    }
}

/// Figures 3.12 to 3.14: sums at all depths have the same planes with the same support indices.
TEST(GeometricMethod, TopologyDoesNotDependOnTheSizeOfTheCube)
{
    for (unsigned seed = 0; seed < 500; ++seed) {
        SCOPED_TRACE(seed);
        std::mt19937 random(seed);
        const bool is_rounded = seed % 2 == 0;
        const Triangle triangle =
            is_rounded ? random_triangle(random) : random_whole_triangle(random, 9);
        const auto sum = sum_of(triangle, Vec3::Constant(1));
        for (int depth = 1; depth <= 12; ++depth) {
            const auto smaller = sum_of(triangle, Vec3::Constant(std::ldexp(1.0, -depth)));
            ASSERT_EQ(smaller.count, sum.count);
            for (int i = 0; i < sum.count; ++i) {
                const auto& a = sum.planes()[static_cast<std::size_t>(i)];
                const auto& b = smaller.planes()[static_cast<std::size_t>(i)];
                EXPECT_EQ(a.normal, b.normal);
                if (a.support == b.support) continue;
                // The supports of a facet tie; only rounding may choose another one of them.
                EXPECT_TRUE(is_rounded);
                const Vec3 tracked =
                    cube_vertex<double>(a.support % 8, Vec3::Constant(std::ldexp(1.0, -depth))) +
                    triangle.vertices[static_cast<std::size_t>(a.support / 8)];
                EXPECT_NEAR(b.normal.dot(tracked), b.offset, 1e-14);
            }
        }
    }
}

/// Pushing serves any pair of small polyhedra: an octahedron and a cube (thesis 3.2.1,
/// Figure 3.11).
TEST(GeometricMethod, AddsAnOctahedronAndACube)
{
    const std::vector<Vec3> octahedron = {{2, 0, 0},  {-2, 0, 0}, {0, 2, 0},
                                          {0, -2, 0}, {0, 0, 2},  {0, 0, -2}};
    std::vector<Vec3> cube;
    for (int i = 0; i < 8; ++i) cube.push_back(cube_vertex<double>(i, Vec3::Ones()));
    std::vector<Vec3> sums(octahedron.size() * cube.size());
    form_sum_vertices<double>(cube, octahedron, sums);

    const std::vector<Vec3> axes = {Vec3::UnitX(), Vec3::UnitY(), Vec3::UnitZ()};
    const std::vector<Vec3> edges = {{1, 1, 0},  {1, -1, 0}, {1, 0, 1},
                                     {1, 0, -1}, {0, 1, 1},  {0, 1, -1}};
    std::vector<CandidateNormal<double>> normals(axes.size() * edges.size());
    form_edge_normals<double>(axes, edges, normals);
    for (const Vec3& axis : axes) normals.push_back({axis, axis, NormalSource::face});
    for (int i = 0; i < 4; ++i) {
        const Vec3 diagonal(1, (i & 1) != 0 ? 1 : -1, (i & 2) != 0 ? 1 : -1);
        normals.push_back({diagonal, diagonal.cwiseAbs(), NormalSource::face});
    }
    std::vector<SupportPlane<double>> planes(2 * normals.size());
    const int count = push_planes<48, double>({cube, octahedron, sums}, normals, planes);

    std::set<WholePlane> found;
    for (const auto& plane : std::span(planes).first(static_cast<std::size_t>(count))) {
        found.insert(whole_plane(plane.normal, plane.offset));
    }
    std::set<WholePlane> expected;
    const auto hull = incremental_hull<double>(sums);
    ASSERT_TRUE(hull);
    for (const auto& face : *hull) expected.insert(whole_plane(face.normal, face.offset));
    EXPECT_EQ(found, expected);
    EXPECT_EQ(found.size(), 26U); // 6 + 8 + 12
}

} // namespace
} // namespace proxima::geometric_method_test
