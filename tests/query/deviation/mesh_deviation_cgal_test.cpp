// Bounds of deviations against CGAL: exact distances of points, and its Hausdorff distance with a bounded error.
#include "octree/small_meshes.h"
#include "proxima/mesh_deviation.h"
#include "proxima/mesh_index.h"
#include "proxima/sample_meshes.h"

#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized" // of CGAL's own spheres
#endif
#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/AABB_triangle_primitive.h>
#include <CGAL/Exact_predicates_exact_constructions_kernel.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/distance.h>
#include <CGAL/Surface_mesh.h>
#include <gtest/gtest.h>

#include <random>
#include <string>
#include <vector>

namespace proxima::mesh_deviation_cgal_test {
namespace {

using namespace testing;
using Exact = CGAL::Exact_predicates_exact_constructions_kernel;
using Inexact = CGAL::Exact_predicates_inexact_constructions_kernel;
using Surface = CGAL::Surface_mesh<Inexact::Point_3>;

Exact::Point_3 exact(const Vec3& p)
{
    return {p.x(), p.y(), p.z()};
}

/// Squared distances from a mesh without any rounding.
class ExactDistances {
public:
    explicit ExactDistances(const TriangleMesh& mesh)
    {
        for (std::uint32_t i = 0; i < mesh.triangle_count(); ++i) {
            const Triangle triangle = mesh.triangle(TriangleId{i});
            triangles_.emplace_back(exact(triangle[0]), exact(triangle[1]), exact(triangle[2]));
        }
        tree_.rebuild(triangles_.begin(), triangles_.end());
    }
    [[nodiscard]] Exact::FT squared(const Exact::Point_3& p) const
    {
        return tree_.squared_distance(p);
    }

private:
    using Triangles = std::vector<Exact::Triangle_3>;
    using Primitive = CGAL::AABB_triangle_primitive<Exact, Triangles::const_iterator>;
    Triangles triangles_;
    CGAL::AABB_tree<CGAL::AABB_traits<Exact, Primitive>> tree_;
};

Surface surface_of(const TriangleMesh& mesh)
{
    Surface surface;
    for (const Vec3& p : mesh.positions()) surface.add_vertex({p.x(), p.y(), p.z()});
    for (const TriangleCorners& corners : mesh.triangles()) {
        surface.add_face(Surface::Vertex_index(corners[0]), Surface::Vertex_index(corners[1]),
                         Surface::Vertex_index(corners[2]));
    }
    return surface;
}

TriangleMesh shaken(const TriangleMesh& mesh, double most, std::uint64_t seed)
{
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> unit(-most, most);
    return moved(mesh, [&](const Vec3& p) {
        return Vec3(p + Vec3(unit(random), unit(random), unit(random)));
    });
}

struct Pair {
    std::string name;
    TriangleMesh a;
    TriangleMesh b;
};

std::vector<Pair> pairs()
{
    const TriangleMesh ball = sample_mesh("icosphere:2").value();
    const TriangleMesh torus = sample_mesh("torus:16x8").value();
    std::vector<Pair> result = {
        {"balls", ball, sample_mesh("sphere:12x12").value()},
        {"cube in a ball", cube_mesh(Vec3(0.1, 0.2, 0), 0.5), ball},
        {"ball round a cube", ball, cube_mesh(Vec3(0.1, 0.2, 0), 0.5)},
        {"tori", torus, sample_mesh("torus:15x9").value()},
        {"offset", moved(ball, [](const Vec3& p) { return Vec3(1.01 * p); }), ball},
        {"far from 0", moved(ball, [](const Vec3& p) { return Vec3(p + Vec3(1e5, 2e5, -1e5)); }),
         moved(torus, [](const Vec3& p) { return Vec3(p + Vec3(1e5, 2e5, -1e5)); })}};
    for (std::uint64_t seed = 1; seed <= 4; ++seed) {
        const double most = std::pow(10.0, -static_cast<double>(seed));
        result.push_back({"seed " + std::to_string(seed), shaken(ball, most, seed),
                          shaken(ball, most, seed + 10)});
    }
    return result;
}

TEST(MeshDeviationAndCgal, NoPointIsFartherThanTheUpperBound)
{
    for (const auto& [name, a, b] : pairs()) {
        SCOPED_TRACE(name);
        const ExactDistances distances(b);
        const GreatestDeviation found =
            greatest_deviation(build_mesh_index(a).value(), build_mesh_index(b).value()).value();
        const Exact::FT upper = found.distance.upper;
        const Exact::FT lower = found.distance.lower;
        // Points of A to the last bit: barycentric coordinates of exact numbers.
        std::mt19937_64 random(99);
        for (int i = 0; i < 600; ++i) {
            const auto id = TriangleId{static_cast<std::uint32_t>(random() % a.triangle_count())};
            const Triangle triangle = a.triangle(id);
            const auto u = static_cast<int>(random() % 65);
            const auto w = static_cast<int>(random() % static_cast<std::uint64_t>(65 - u));
            const Exact::FT s = Exact::FT(u) / 64;
            const Exact::FT t = Exact::FT(w) / 64;
            const Exact::Point_3 o = exact(triangle[0]);
            const Exact::Point_3 p =
                o + s * (exact(triangle[1]) - o) + t * (exact(triangle[2]) - o);
            EXPECT_TRUE(distances.squared(p) <= upper * upper);
        }
        // And the point named is as far as the lower bound, but for its own rounding.
        const double reach = 1 + found.point_a.norm();
        const Exact::FT least = lower - 4e-15 * reach;
        EXPECT_TRUE(least <= 0 || distances.squared(exact(found.point_a)) >= least * least);
    }
}

TEST(MeshDeviationAndCgal, GiveTheSameHausdorffDistance)
{
    for (const auto& [name, a, b] : pairs()) {
        SCOPED_TRACE(name);
        constexpr double error = 1e-3;
        const double theirs =
            CGAL::Polygon_mesh_processing::bounded_error_Hausdorff_distance<CGAL::Sequential_tag>(
                surface_of(a), surface_of(b), error);
        const DistanceBounds ours =
            greatest_deviation(build_mesh_index(a).value(), build_mesh_index(b).value())
                .value()
                .distance;
        EXPECT_LE(ours.lower, theirs + error);
        EXPECT_GE(ours.upper, theirs - error);
        EXPECT_LT(ours.upper - ours.lower, 1e-5);
    }
}

TEST(MeshDeviationAndCgal, MeansHoldThoseOfExactDistances)
{
    // The distance changes by no more than the way: sums over small triangles bound the mean.
    for (const auto& [name, a, b] : pairs()) {
        SCOPED_TRACE(name);
        const ExactDistances distances(b);
        const MeanDeviation found =
            mean_deviation(build_mesh_index(a).value(), build_mesh_index(b).value()).value();
        double area = 0;
        double sum = 0;
        double squares = 0;
        double doubt = 0;
        double farthest = 0;
        const int cuts = a.triangle_count() < 100 ? 12 : 2;
        for (std::uint32_t i = 0; i < a.triangle_count(); ++i) {
            const Triangle triangle = a.triangle(TriangleId{i});
            const Vec3 u = (triangle[1] - triangle[0]) / cuts;
            const Vec3 w = (triangle[2] - triangle[0]) / cuts;
            const double each = 0.5 * u.cross(w).norm();
            const double radius = std::max({u.norm(), w.norm(), (u - w).norm()}) * 2 / 3;
            for (int j = 0; j < cuts; ++j) {
                for (int k = 0; j + k < cuts; ++k) {
                    for (int turned = 0; turned < (j + k + 1 < cuts ? 2 : 1); ++turned) {
                        const double shift = (1 + turned) / 3.0;
                        const Vec3 middle = triangle[0] + (j + shift) * u + (k + shift) * w;
                        const double distance =
                            std::sqrt(CGAL::to_double(distances.squared(exact(middle))));
                        area += each;
                        sum += each * distance;
                        squares += each * distance * distance;
                        doubt += each * radius;
                        farthest = std::max(farthest, distance + radius);
                    }
                }
            }
        }
        EXPECT_LE(found.mean.lower, (sum + doubt) / area);
        EXPECT_GE(found.mean.upper, (sum - doubt) / area);
        EXPECT_LE(found.root_mean_square.lower, std::sqrt((squares + 2 * farthest * doubt) / area));
        EXPECT_GE(found.root_mean_square.upper,
                  std::sqrt(std::max(squares - 2 * farthest * doubt, 0.0) / area));
        EXPECT_NEAR(found.area, area, 1e-9 * area);
    }
}

} // namespace
} // namespace proxima::mesh_deviation_cgal_test
