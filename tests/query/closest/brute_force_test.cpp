#include "query/closest/brute_force.h"

#include "index/test_meshes.h"
#include "oracles/quad_distance.h"
#include "query/closest/feature_distance.h"

#include <array>
#include <gtest/gtest.h>

namespace proxima::brute_force_test {
namespace {

using namespace testing;

double size_of_numbers(const TriangleMesh& mesh, const Vec3& p)
{
    double size = p.cwiseAbs().maxCoeff();
    for (const Vec3& position : mesh.positions()) {
        size = std::max(size, position.cwiseAbs().maxCoeff());
    }
    return size;
}

long double quad_distance(const TriangleMesh& mesh, const Vec3& p, double unit)
{
    oracle::Quad best = -1;
    for (std::uint32_t i = 0; i < mesh.triangle_count(); ++i) {
        Triangle triangle = mesh.triangle(TriangleId{i});
        for (Vec3& vertex : triangle.vertices) vertex *= unit;
        const oracle::Quad squared =
            oracle::squared_distance(oracle::QuadPoint(unit * p), triangle);
        if (best < 0 || squared < best) best = squared;
    }
    return oracle::root(best);
}

/// The vertex ids of a feature, by counting edges anew.
std::vector<std::uint32_t> ids_of(const TriangleMesh& mesh, const Feature& feature)
{
    if (feature.kind == FeatureKind::vertex) return {feature.id};
    if (feature.kind == FeatureKind::face) {
        const auto& corners = mesh.triangles()[feature.id];
        return {corners.begin(), corners.end()};
    }
    std::vector<std::array<std::uint32_t, 2>> edges;
    for (const auto& corners : mesh.triangles()) {
        for (std::size_t k = 0; k < 3; ++k) {
            const std::array<std::uint32_t, 2> ends = {std::min(corners[k], corners[(k + 1) % 3]),
                                                       std::max(corners[k], corners[(k + 1) % 3])};
            if (ends[0] == ends[1] || std::ranges::find(edges, ends) != edges.end()) continue;
            edges.push_back(ends);
            if (edges.size() == feature.id + 1) return {ends[0], ends[1]};
        }
    }
    return {};
}

TEST(BruteForce, FindsTheTrueDistance)
{
    for (const NamedMesh& named : proximity_meshes()) {
        SCOPED_TRACE(named.name);
        const TriangleMesh& mesh = named.mesh;
        const Topology topology = build_topology(mesh).value();
        for (const Vec3& p : proximity_points(mesh, mesh.triangle_count() > 200 ? 30 : 150, 1)) {
            const double size = size_of_numbers(mesh, p);
            const double unit = std::ldexp(1.0, -std::ilogb(size));
            const ClosestFeature found = closest_feature_by_brute_force(mesh, topology, p);
            const long double truth = quad_distance(mesh, p, unit);
            EXPECT_NEAR(static_cast<double>(unit * std::sqrt(found.squared_distance) - truth), 0,
                        4e-15);
        }
    }
}

TEST(BruteForce, LocatesTheClosestPoint)
{
    for (const NamedMesh& named : proximity_meshes()) {
        SCOPED_TRACE(named.name);
        const TriangleMesh& mesh = named.mesh;
        const Topology topology = build_topology(mesh).value();
        for (const Vec3& p : proximity_points(mesh, mesh.triangle_count() > 100 ? 12 : 100, 2)) {
            const ClosestFeature found = closest_feature_by_brute_force(mesh, topology, p);
            // The point is rounded to its coordinates, the distance is not.
            EXPECT_NEAR(std::sqrt(found.squared_distance), (found.point - p).norm(),
                        4e-15 * size_of_numbers(mesh, p));

            const std::vector<std::uint32_t> ids = ids_of(mesh, found.feature);
            ASSERT_EQ(ids.size(), static_cast<std::size_t>(found.feature.kind) + 1);
            std::uint32_t lowest = 0;
            const auto has_all = [&](const TriangleCorners& corners) {
                return std::ranges::all_of(ids, [&](std::uint32_t id) {
                    return std::ranges::find(corners, id) != corners.end();
                });
            };
            if (found.feature.kind == FeatureKind::face) {
                lowest = found.feature.id;
            } else {
                while (!has_all(mesh.triangles()[lowest])) ++lowest;
            }
            EXPECT_EQ(to_index(found.triangle), lowest);

            // The weights name the feature's vertices, and the point.
            const Triangle triangle = mesh.triangle(found.triangle);
            Vec3 sum = Vec3::Zero();
            double total = 0;
            std::size_t named_vertices = 0;
            for (std::size_t k = 0; k < 3; ++k) {
                const double weight = found.barycentric[k];
                EXPECT_GE(weight, 0);
                EXPECT_LE(weight, 1);
                total += weight;
                sum += weight * triangle.vertices[k];
                if (weight == 0) continue;
                ++named_vertices;
                EXPECT_NE(std::ranges::find(ids, mesh.triangles()[lowest][k]), ids.end());
            }
            EXPECT_EQ(named_vertices, ids.size());
            EXPECT_NEAR(total, 1, 4e-16);
            EXPECT_LE((sum - found.point).norm(), 4e-15 * size_of_numbers(mesh, p));
        }
    }
}

/// A squared distance of points with whole coordinates.
struct Rational {
    std::int64_t over = 0;
    std::int64_t under = 0; ///< 0: the feature does not count

    [[nodiscard]] bool counts() const { return under > 0; }
    friend bool operator<(const Rational& a, const Rational& b)
    {
        return static_cast<__int128>(a.over) * b.under < static_cast<__int128>(b.over) * a.under;
    }
};

using Whole = Eigen::Matrix<std::int64_t, 3, 1>;

Rational exact_distance(const TriangleMesh& mesh, const Feature& feature, const Whole& p)
{
    const auto ids = ids_of(mesh, feature);
    const auto at = [&](std::size_t i) -> Whole {
        return mesh.position(VertexId{ids[i]}).cast<std::int64_t>();
    };
    if (ids.size() == 1) return {(p - at(0)).squaredNorm(), 1};
    const Whole u = at(1) - at(0);
    const Whole x = p - at(0);
    if (ids.size() == 2) {
        const std::int64_t along = x.dot(u);
        if (along <= 0 || along >= u.squaredNorm()) return {};
        return {x.cross(u).squaredNorm(), u.squaredNorm()};
    }
    const Whole normal = u.cross(at(2) - at(0));
    for (std::size_t k = 0; k < 3; ++k) {
        const Whole side = at((k + 1) % 3) - at(k);
        if (side.cross(p - at(k)).dot(normal) <= 0) return {};
    }
    return {x.dot(normal) * x.dot(normal), normal.squaredNorm()};
}

TEST(BruteForce, FindsTheExactlyClosestFeature)
{
    for (std::uint32_t seed = 0; seed < 300; ++seed) {
        SCOPED_TRACE(seed);
        const TriangleMesh mesh = grid_mesh(seed);
        const Topology topology = build_topology(mesh).value();
        std::mt19937 random(seed);
        for (int i = 0; i < 40; ++i) {
            const auto coordinate = [&] { return static_cast<std::int64_t>(random() % 9) - 2; };
            const Whole p(coordinate(), coordinate(), coordinate());
            const ClosestFeature found =
                closest_feature_by_brute_force(mesh, topology, p.cast<double>());
            const Rational squared = exact_distance(mesh, found.feature, p);
            ASSERT_TRUE(squared.counts());
            const auto expect_no_better = [&](FeatureKind kind, std::size_t count) {
                for (std::uint32_t id = 0; id < count; ++id) {
                    if (kind == FeatureKind::vertex && topology.triangles(VertexId{id}).empty())
                        continue;
                    const Rational other = exact_distance(mesh, {kind, id}, p);
                    EXPECT_FALSE(other.counts() && other < squared)
                        << "point " << p.transpose() << " feature " << static_cast<int>(kind) << ' '
                        << id;
                }
            };
            expect_no_better(FeatureKind::vertex, mesh.vertex_count());
            expect_no_better(FeatureKind::edge, topology.edge_count());
            expect_no_better(FeatureKind::face, mesh.triangle_count());
        }
    }
}

TEST(BruteForce, BreaksTiesByKindAndId)
{
    // From the centre all six sides of a cube are equally close, at their diagonals.
    const TriangleMesh cube = cube_mesh(Vec3::Zero(), 1.0);
    const Topology topology = build_topology(cube).value();
    const ClosestFeature centre = closest_feature_by_brute_force(cube, topology, Vec3::Zero());
    EXPECT_EQ(centre.feature, (Feature{FeatureKind::edge, 2})); // (v2 v0) of triangle 0
    EXPECT_EQ(centre.squared_distance, 1.0);

    // Of two triangles at one place the first; of an edge and a vertex at one place the vertex.
    const TriangleMesh twice = mesh_of(
        {Vec3(0, 0, 0), Vec3(4, 0, 0), Vec3(0, 4, 0), Vec3(0, 0, 0), Vec3(2, 0, 0), Vec3(2, -1, 0)},
        {{0, 1, 2}, {1, 2, 0}, {3, 1, 2}, {4, 5, 5}});
    const Topology of_twice = build_topology(twice).value();
    const auto closest = [&](const Vec3& p) {
        return closest_feature_by_brute_force(twice, of_twice, p).feature;
    };
    EXPECT_EQ(closest(Vec3(1, 1, 3)), (Feature{FeatureKind::face, 0}));
    EXPECT_EQ(closest(Vec3(-1, -1, 3)), (Feature{FeatureKind::vertex, 0}));
    EXPECT_EQ(closest(Vec3(2, 0, 1)), (Feature{FeatureKind::vertex, 4}));
}

TEST(BruteForce, IgnoresVerticesWithoutATriangle)
{
    const TriangleMesh mesh =
        mesh_of({Vec3(9, 9, 9), Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)}, {{1, 2, 3}});
    const Topology topology = build_topology(mesh).value();
    EXPECT_EQ(closest_feature_by_brute_force(mesh, topology, Vec3(9, 9, 9)).feature.kind,
              FeatureKind::edge);
}

TEST(BruteForce, AnswersEvenWhereSquaresOverflow)
{
    const TriangleMesh mesh = cube_mesh(Vec3::Zero(), 1.0);
    const Topology topology = build_topology(mesh).value();
    const ClosestFeature far =
        closest_feature_by_brute_force(mesh, topology, Vec3(1e300, -1.7e308, 0));
    EXPECT_EQ(far.feature, (Feature{FeatureKind::vertex, 0}));
    EXPECT_EQ(far.squared_distance, std::numeric_limits<double>::infinity());
    EXPECT_EQ(far.barycentric[0] + far.barycentric[1] + far.barycentric[2], 1.0);
}

TEST(FeatureDistance, OfATriangleIsTheLeastOfItsFeatures)
{
    for (const NamedMesh& named : proximity_meshes()) {
        SCOPED_TRACE(named.name);
        const TriangleMesh& mesh = named.mesh;
        const Topology topology = build_topology(mesh).value();
        for (const Vec3& p : proximity_points(mesh, 30, 3)) {
            const RowScale scale = row_scale_of(mesh);
            NearestFeature best;
            for (std::uint32_t i = 0; i < mesh.triangle_count(); ++i) {
                offer_triangle(mesh, topology, TriangleId{i}, p, scale, best);
            }
            const ClosestFeature truth = closest_feature_by_brute_force(mesh, topology, p);
            EXPECT_EQ(best.feature, truth.feature);
            EXPECT_EQ(scale.unscale_squared(best.squared), truth.squared_distance);
        }
    }
}

} // namespace
} // namespace proxima::brute_force_test
