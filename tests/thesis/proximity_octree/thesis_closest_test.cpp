// Closest features by the thesis's octree against all features one by one, in 113-bit numbers.
#include "thesis/proximity_octree/thesis_closest.h"

#include "code_of.h"
#include "counted_allocations.h"
#include "geometry/exact_predicates.h"
#include "index/lists/region_oracle.h"
#include "proxima/thesis.h"
#include "thesis/proximity_octree/convex_meshes.h"

#include <gtest/gtest.h>
#include <limits>

namespace proxima::thesis_closest_test {
namespace {

using oracle::Quad;
using oracle::QuadPoint;

Quad distance_to(const TriangleMesh& mesh, const Topology& topology, Feature feature, const Vec3& p)
{
    switch (feature.kind) {
    case FeatureKind::vertex: {
        const QuadPoint gap = QuadPoint(p) - QuadPoint(mesh.position(VertexId{feature.id}));
        return dot(gap, gap);
    }
    case FeatureKind::edge: {
        const auto [a, b] = topology.vertices(EdgeId{feature.id});
        return oracle::squared_distance(QuadPoint(p), QuadPoint(mesh.position(a)),
                                        QuadPoint(mesh.position(b)));
    }
    case FeatureKind::face:
        break;
    }
    return oracle::squared_distance(QuadPoint(p), mesh.triangle(TriangleId{feature.id}));
}

Quad brute_distance(const TriangleMesh& mesh, const Topology& topology, const Vec3& p)
{
    Quad best = -1;
    for (std::uint32_t t = 0; t < mesh.triangle_count(); ++t) {
        const Quad squared = distance_to(mesh, topology, {FeatureKind::face, t}, p);
        if (best < 0 || squared < best) best = squared;
    }
    return best;
}

bool is_behind_all_faces(const TriangleMesh& mesh, const Vec3& p)
{
    for (std::uint32_t t = 0; t < mesh.triangle_count(); ++t) {
        const Triangle triangle = mesh.triangle(TriangleId{t});
        if (orient3d(triangle[0], triangle[1], triangle[2], p) >= 0) return false;
    }
    return true;
}

/// Barycentric coordinates are those of the point, on the feature, in the lowest triangle there.
void expect_consistent(const TriangleMesh& mesh, const Topology& topology,
                       const ClosestFeature& found, double tolerance)
{
    const auto& corners = mesh.triangles()[to_index(found.triangle)];
    Vec3 point = Vec3::Zero();
    double sum = 0;
    for (std::size_t i = 0; i < 3; ++i) {
        EXPECT_GE(found.barycentric[i], 0);
        sum += found.barycentric[i];
        point += found.barycentric[i] * mesh.positions()[corners[i]];
    }
    EXPECT_NEAR(sum, 1, 1e-12);
    EXPECT_LE((point - found.point).norm(), tolerance);
    std::size_t zeros = 0;
    for (const double weight : found.barycentric) zeros += weight == 0 ? 1U : 0U;
    switch (found.feature.kind) {
    case FeatureKind::vertex:
        EXPECT_EQ(found.triangle, topology.triangles(VertexId{found.feature.id}).front());
        EXPECT_EQ(found.point, mesh.position(VertexId{found.feature.id}));
        EXPECT_EQ(zeros, 2U);
        break;
    case FeatureKind::edge:
        EXPECT_EQ(found.triangle, topology.triangles(EdgeId{found.feature.id}).front());
        EXPECT_GE(zeros, 1U);
        break;
    case FeatureKind::face:
        EXPECT_EQ(to_index(found.triangle), found.feature.id);
        break;
    }
}

TEST(ThesisClosest, AgreesWithBruteForce)
{
    std::mt19937 random(11);
    std::uniform_real_distribution<double> part(-0.02, 1.02);
    std::array<std::size_t, 3> kinds = {};
    for (const auto& [name, mesh] : test::convex_meshes()) {
        SCOPED_TRACE(name);
        const Topology topology = *build_topology(mesh);
        const auto octree = build_thesis_proximity_octree(mesh, topology, {.max_depth = 4});
        ASSERT_TRUE(octree) << describe(octree.error());
        const Box root = cell_box(octree->frame(), CellKey{});
        const double size = bounding_box(mesh).extent().norm() + mesh.positions()[0].norm();
        std::size_t outside = 0;
        for (int i = 0; i < 600; ++i) {
            Vec3 p = root.lower +
                     Vec3{part(random), part(random), part(random)}.cwiseProduct(root.extent());
            if (i % 3 == 0) { // about the surface
                const Vec3 start = mesh.positions()[mesh.triangles()[i % mesh.triangle_count()][0]];
                p = start + std::pow(10.0, -1.0 - i % 7) * (p - start);
            }
            const auto found = closest_feature(*octree, mesh, topology, p);
            const bool expected = root.contains(p) && !is_behind_all_faces(mesh, p);
            ASSERT_EQ(found.has_value(), expected) << p.transpose();
            if (!found) continue;
            ++outside;
            ++kinds[static_cast<std::size_t>(found->feature.kind)];
            const long double best = oracle::root(brute_distance(mesh, topology, p));
            const long double by_feature =
                oracle::root(distance_to(mesh, topology, found->feature, p));
            EXPECT_NEAR(static_cast<double>(by_feature - best), 0, 1e-13 * size);
            EXPECT_NEAR(std::sqrt(found->squared_distance), static_cast<double>(best),
                        1e-13 * size);
            EXPECT_NEAR((p - found->point).norm(), static_cast<double>(best), 1e-13 * size);
            expect_consistent(mesh, topology, *found, 1e-12 * size);
        }
        EXPECT_GT(outside, 150U);
    }
    for (const std::size_t count : kinds) EXPECT_GT(count, 500U);
}

/// Where faces count as one plane at large angles, no edge is listed: those beside it answer.
TEST(ThesisClosest, AgreesWithBruteForceOverEdgesThatCountAsFlat)
{
    std::mt19937 random(14);
    std::uniform_real_distribution<double> part(0, 1);
    const TriangleMesh mesh = make_icosphere(1);
    const Topology topology = *build_topology(mesh);
    const auto octree =
        *build_thesis_proximity_octree(mesh, topology, {.max_depth = 5, .flat_sine = 0.9});
    const Box root = cell_box(octree.frame(), CellKey{});
    std::size_t edges = 0;
    for (int i = 0; i < 800; ++i) {
        const Vec3 p =
            root.lower + Vec3(part(random), part(random), part(random)).cwiseProduct(root.extent());
        if (is_behind_all_faces(mesh, p)) continue;
        const auto found = closest_feature(octree, mesh, topology, p);
        ASSERT_TRUE(found) << p.transpose();
        const long double best = oracle::root(brute_distance(mesh, topology, p));
        EXPECT_NEAR(std::sqrt(found->squared_distance), static_cast<double>(best), 1e-13)
            << p.transpose();
        edges += found->feature.kind == FeatureKind::edge ? 1U : 0U;
    }
    EXPECT_GT(edges, 100U);
}

TEST(ThesisClosest, IsAtDistanceZeroOnTheSurface)
{
    const TriangleMesh mesh = make_cube();
    const Topology topology = *build_topology(mesh);
    const auto octree = *build_thesis_proximity_octree(mesh, topology);
    const auto found = [&](const Vec3& p) { return closest_feature(octree, mesh, topology, p); };
    EXPECT_EQ(found({1, 1, 1})->feature.kind, FeatureKind::vertex);
    EXPECT_EQ(found({1, 1, 0.25})->feature.kind, FeatureKind::edge);
    EXPECT_EQ(found({1, 0.5, 0.25})->feature.kind, FeatureKind::face);
    EXPECT_EQ(found({1, 0.5, 0.25})->squared_distance, 0);
    EXPECT_EQ(found({1.25, 1.25, 0})->feature.kind, FeatureKind::edge);
    EXPECT_EQ(found({1.25, 1.25, 1.25})->feature.kind, FeatureKind::vertex);
    // On the diagonal of a side, which is not listed but is an answer.
    const auto diagonal = found({1.25, 0.5, 0.5});
    const auto other = found({1.25, 0.5, -0.5});
    EXPECT_TRUE(diagonal->feature.kind == FeatureKind::edge ||
                other->feature.kind == FeatureKind::edge);
    EXPECT_FALSE(found({0.999, 0.5, 0.25}));
    EXPECT_FALSE(found({0, 0, 0}));
    EXPECT_FALSE(found({2, 0, 0}));
    EXPECT_FALSE(found({std::numeric_limits<double>::quiet_NaN(), 0, 0}));
}

/// Smaller ones, where squares of distances are 0, are a limitation.
TEST(ThesisClosest, FindsFeaturesOfTinyAndHugeMeshes)
{
    for (const double size : {1e-150, 1e-75, 1.0, 1e90}) {
        SCOPED_TRACE(size);
        const auto proximity = build_thesis_proximity(
            test::mapped(make_cube(), [&](const Vec3& p) { return Vec3(size * p); }),
            {.max_depth = 2});
        ASSERT_TRUE(proximity) << describe(proximity.error());
        const auto beside_face = closest_feature(*proximity, size * Vec3(1.25, 0.25, 0.125));
        ASSERT_TRUE(beside_face);
        EXPECT_EQ(beside_face->feature.kind, FeatureKind::face);
        EXPECT_LE((beside_face->point / size - Vec3(1, 0.25, 0.125)).norm(), 1e-12);
        const auto beside_edge = closest_feature(*proximity, size * Vec3(0.25, -1.25, 1.25));
        ASSERT_TRUE(beside_edge);
        EXPECT_EQ(beside_edge->feature.kind, FeatureKind::edge);
        EXPECT_LE((beside_edge->point / size - Vec3(0.25, -1, 1)).norm(), 1e-12);
    }
}

TEST(ThesisClosest, IsTheSameWithItsOwnCopyOfTheMesh)
{
    const TriangleMesh mesh = make_sphere(12, 16);
    const Topology topology = *build_topology(mesh);
    const auto octree = *build_thesis_proximity_octree(mesh, topology);
    const auto proximity = build_thesis_proximity(make_sphere(12, 16));
    ASSERT_TRUE(proximity.has_value());
    EXPECT_EQ(proximity->depth_reached(), octree.depth_reached());
    EXPECT_EQ(proximity->bytes(), octree.bytes());
    for (int i = 0; i < 500; ++i) {
        const Vec3 p(1.4 * std::sin(i), 1.4 * std::cos(3 * i), std::sin(7 * i));
        const auto truth = closest_feature(octree, mesh, topology, p);
        const auto found = closest_feature(*proximity, p);
        ASSERT_EQ(found.has_value(), truth.has_value());
        if (!truth) continue;
        EXPECT_EQ(found->feature, truth->feature);
        EXPECT_EQ(found->squared_distance, truth->squared_distance);
    }
    EXPECT_EQ(code_of(build_thesis_proximity(TriangleMesh())), ErrorCode::invalid_mesh);
}

/// The mesh with a vertex that no triangle uses, which takes that id.
TriangleMesh with_stray_vertex(const TriangleMesh& mesh, std::uint32_t id)
{
    std::vector<Vec3> positions(mesh.positions().begin(), mesh.positions().end());
    positions.insert(positions.begin() + id, Vec3::Zero());
    std::vector<TriangleCorners> triangles(mesh.triangles().begin(), mesh.triangles().end());
    for (TriangleCorners& corners : triangles)
        for (std::uint32_t& corner : corners) corner += corner >= id ? 1U : 0U;
    return make_triangle_mesh(std::move(positions), std::move(triangles)).value();
}

TEST(ThesisClosest, FitsTheMeshItWasBuiltFromAndNoneThatLeadsItAstray)
{
    const auto fits = [](const ThesisProximityOctree& octree, const TriangleMesh& mesh) {
        return fits_mesh(octree, mesh, *build_topology(mesh));
    };
    for (const auto& [name, mesh] : test::convex_meshes()) {
        SCOPED_TRACE(name);
        for (const double margin : {0.0, 0.5, 3.0}) {
            const auto octree =
                build_thesis_proximity_octree(mesh, {.max_depth = 2, .margin = margin});
            ASSERT_TRUE(octree) << describe(octree.error());
            EXPECT_TRUE(fits(*octree, mesh));
        }
    }
    const TriangleMesh plain = make_octahedron();
    // Another shape with the same features and the same root.
    const TriangleMesh squashed =
        test::mapped(plain, [](const Vec3& p) { return Vec3(0.5 * p.x(), p.y(), p.z()); });
    EXPECT_FALSE(fits(*build_thesis_proximity_octree(plain), squashed));
    const auto last = static_cast<std::uint32_t>(plain.vertex_count());
    const TriangleMesh stray_first = with_stray_vertex(plain, 0);
    const TriangleMesh stray_last = with_stray_vertex(plain, last);
    const auto octree = build_thesis_proximity_octree(stray_first);
    ASSERT_TRUE(octree) << describe(octree.error());
    EXPECT_TRUE(fits(*octree, stray_first));
    EXPECT_FALSE(fits(*octree, stray_last));
    EXPECT_FALSE(fits(*octree, plain));
    // Forged: it lists the last vertex, which has no triangle here.
    ThesisProximityOctree::Parts parts = octree->parts();
    parts.fingerprint = mesh_fingerprint(stray_last);
    EXPECT_FALSE(fits(ThesisProximityOctree(parts), stray_last));
    // Forged: as many features, but edges of one triangle and of three.
    std::vector<TriangleCorners> triangles(plain.triangles().begin(), plain.triangles().end());
    triangles[0] = triangles[1];
    const auto doubled =
        make_triangle_mesh({plain.positions().begin(), plain.positions().end()}, triangles);
    parts = build_thesis_proximity_octree(plain)->parts();
    parts.fingerprint = mesh_fingerprint(*doubled);
    EXPECT_FALSE(fits(ThesisProximityOctree(parts), *doubled));
}

TEST(ThesisClosest, DoesNotAllocate)
{
    const TriangleMesh mesh = make_sphere(20, 20);
    const Topology topology = *build_topology(mesh);
    const std::size_t at_first = testing::allocation_count();
    const auto octree = *build_thesis_proximity_octree(mesh, topology);
    ASSERT_EQ(testing::allocation_count() > at_first, testing::allocations_are_counted());
    const std::size_t before = testing::allocation_count();
    double sum = 0;
    for (int i = 0; i < 1000; ++i) {
        const Vec3 p(1.4 * std::sin(i), 1.4 * std::cos(3 * i), std::sin(7 * i));
        if (const auto found = closest_feature(octree, mesh, topology, p))
            sum += found->squared_distance;
    }
    EXPECT_EQ(testing::allocation_count(), before);
    EXPECT_GT(sum, 0);
}

} // namespace
} // namespace proxima::thesis_closest_test
