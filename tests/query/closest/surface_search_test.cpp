#include "query/closest/surface_search.h"

#include "base/simd.h"
#include "counted_allocations.h"
#include "index/test_meshes.h"
#include "index/triangle_lanes.h"
#include "query/closest/brute_force.h"

#include <gtest/gtest.h>

namespace proxima {
namespace {

using namespace testing;

void expect_same(const ClosestFeature& found, const ClosestFeature& truth)
{
    EXPECT_EQ(found.feature, truth.feature);
    EXPECT_EQ(found.triangle, truth.triangle);
    EXPECT_EQ(found.point, truth.point);
    EXPECT_EQ(found.barycentric, truth.barycentric);
    EXPECT_EQ(found.squared_distance, truth.squared_distance);
}

TEST(SurfaceSearch, AnswersAsBruteForceToTheLastBit)
{
    for (const NamedMesh& named : proximity_meshes()) {
        SCOPED_TRACE(named.name);
        const Topology topology = build_topology(named.mesh).value();
        const auto search = build_surface_search(named.mesh, topology);
        ASSERT_TRUE(search);
        for (const Vec3& p : proximity_points(named.mesh, 600, 8)) {
            expect_same(closest_feature(*search, p),
                        closest_feature_by_brute_force(named.mesh, topology, p));
        }
    }
}

TEST(SurfaceSearch, AnswersAsBruteForceOnManyRandomMeshes)
{
    for (std::uint32_t seed = 100; seed < 400; ++seed) {
        SCOPED_TRACE(seed);
        const TriangleMesh mesh = seed % 2 == 0 ? nasty_mesh(seed) : grid_mesh(seed);
        const Topology topology = build_topology(mesh).value();
        const auto search = build_surface_search(mesh, topology).value();
        for (const Vec3& p : proximity_points(mesh, 60, seed)) {
            expect_same(closest_feature(search, p),
                        closest_feature_by_brute_force(mesh, topology, p));
        }
    }
}

TEST(SurfaceSearch, AnswersAsBruteForceFarAway)
{
    const TriangleMesh mesh = sample_mesh("torus:20x10").value();
    const Topology topology = build_topology(mesh).value();
    const auto search = build_surface_search(mesh, topology).value();
    for (const double far : {1e2, 1e5, 1e8, 1e12, 1e15, 1e17, 1e60, 1e149, 1e155, 1.7e308}) {
        SCOPED_TRACE(far);
        for (const Vec3& toward : proximity_points(mesh, 30, 9)) {
            const Vec3 p = far * toward.normalized();
            expect_same(closest_feature(search, p),
                        closest_feature_by_brute_force(mesh, topology, p));
        }
    }
}

TEST(SurfaceSearch, TakesARadius)
{
    const TriangleMesh mesh = sample_mesh("spaceship:1300").value();
    const Topology topology = build_topology(mesh).value();
    const auto search = build_surface_search(mesh, topology).value();
    for (const Vec3& p : proximity_points(mesh, 200, 10)) {
        const ClosestFeature truth = closest_feature_by_brute_force(mesh, topology, p);
        const double distance = std::sqrt(truth.squared_distance);
        for (const double radius : {0.0, 0.5 * distance, std::nextafter(distance, 1e9),
                                    2 * distance, std::numeric_limits<double>::infinity()}) {
            const auto found = closest_feature(search, p, radius);
            ASSERT_EQ(found.has_value(), truth.squared_distance <= radius * radius);
            if (found) expect_same(*found, truth);
        }
    }
}

TEST(SurfaceSearch, StartsFromWhatIsKnown)
{
    const TriangleMesh mesh = sample_mesh("spaceship:1300").value();
    const Topology topology = build_topology(mesh).value();
    const auto search = build_surface_search(mesh, topology).value();
    NearestFeature last;
    for (const Vec3& p : proximity_points(mesh, 200, 11)) {
        NearestFeature best;
        if (last.feature.kind == FeatureKind::vertex) {
            const double scale = search.tree().scale();
            best = {squared_distance(mesh.position(VertexId{last.feature.id}), p,
                                     {scale, 1 / scale}),
                    last.feature};
        }
        find_closest(search, p, best);
        EXPECT_EQ(best.feature, closest_feature_by_brute_force(mesh, topology, p).feature);
        last = best;
    }
}

TEST(SurfaceSearch, HasTheSameAnswersOnEveryInstructionSetWithoutAllocating)
{
    const TriangleMesh mesh = sample_mesh("spaceship:20000").value();
    const Topology topology = build_topology(mesh).value();
    const auto search = build_surface_search(mesh, topology).value();
    const std::vector<Vec3> points = proximity_points(mesh, 300, 12);
    std::vector<ClosestFeature> first;
    for (const Vec3& p : points) first.push_back(closest_feature(search, p));
    for (const SimdTarget& target : simd_targets()) {
        SCOPED_TRACE(target.name);
        force_simd_target(target);
        std::uint64_t allocations = 0;
        for (std::size_t i = 0; i < points.size(); ++i) {
            const std::size_t before = allocation_count();
            const ClosestFeature found = closest_feature(search, points[i]);
            allocations += allocation_count() - before;
            expect_same(found, first[i]);
        }
        EXPECT_EQ(allocations, 0U);
    }
    restore_simd_targets();
}

TEST(SurfaceSearch, PassesOnWhyThereIsNone)
{
    EXPECT_EQ(build_surface_search(TriangleMesh{}, Topology{}).error().code,
              ErrorCode::invalid_mesh);
    const TriangleMesh huge =
        moved(cube_mesh(Vec3::Zero(), 1.0), [](const Vec3& p) { return Vec3(1e308 * p); });
    const Topology topology = build_topology(huge).value();
    EXPECT_EQ(build_surface_search(huge, topology).error().code, ErrorCode::invalid_mesh);
    const TriangleMesh mesh = sample_mesh("cube").value();
    Progress progress;
    progress.cancel();
    EXPECT_EQ(build_surface_search(mesh, topology, {.progress = &progress}).error().code,
              ErrorCode::cancelled);
}

TEST(TriangleLanes, AreRightUpToTheirLimit)
{
    for (const NamedMesh& named : proximity_meshes()) {
        SCOPED_TRACE(named.name);
        const TriangleMesh& mesh = named.mesh;
        const Topology topology = build_topology(mesh).value();
        const auto search = build_surface_search(mesh, topology).value();
        const double scale = search.tree().scale();
        int slivers = 0;
        int total = 0;
        for (const Vec3& p : proximity_points(mesh, 60, 13)) {
            const auto first = static_cast<std::uint32_t>(total) % mesh.triangle_count();
            const TriangleId id{static_cast<std::uint32_t>(first)};
            std::array<double, 8> squared{};
            triangle_distances(mesh, std::span(&id, 1), p, scale, squared);
            NearestFeature truth;
            offer_triangle(mesh, topology, id, p, {scale, 1 / scale}, truth);
            const double exact = truth.squared;
            EXPECT_FALSE(squared[0] > triangle_distance_limit(exact, search.tree().reach()));
            ++total;
            if (squared[0] == 0 && exact > 0) {
                ++slivers;
            } else if (exact > 1e-6 && search.tree().reach() < 10) {
                EXPECT_GE(squared[0], exact * (1 - 1e-6)); // or it spares nothing
            }
        }
        if (named.name == "sphere") {
            EXPECT_EQ(slivers, 0);
        }
    }
    const TriangleMesh sharp =
        mesh_of({Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(1, 0.01, 0)}, {{0, 1, 2}, {1, 2, 0}});
    const std::array<TriangleId, 2> ids = {TriangleId{0}, TriangleId{1}};
    std::array<double, 8> squared{};
    triangle_distances(sharp, ids, Vec3(0.5, 0, 1), 1.0, squared);
    EXPECT_EQ(squared[0], 0.0);
    EXPECT_NEAR(squared[1], 1.0, 1e-12);
}

} // namespace
} // namespace proxima
