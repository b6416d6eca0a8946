// The octree's answers are those of brute force, for any mesh, budget, place and instruction set.
#include "index/lists/build_proximity_octree.h"

#include "base/simd.h"
#include "cancellation.h"
#include "counted_allocations.h"
#include "index/test_meshes.h"
#include "proxima/sample_meshes.h"
#include "query/closest/brute_force.h"

#include <cmath>
#include <cstring>
#include <gtest/gtest.h>
#include <limits>
#include <random>

namespace proxima {
namespace {

using testing::NamedMesh;
using testing::proximity_meshes;
using testing::proximity_points;

ProximityOctree build(const TriangleMesh& mesh, const ProximityOptions& options = {})
{
    auto octree = build_proximity_octree(mesh, options);
    EXPECT_TRUE(octree) << describe(octree.error());
    return std::move(*octree);
}

/// Points where cells and regions meet: corners of cells, points straight above vertices and sides.
std::vector<Vec3> boundary_points(const TriangleMesh& mesh, const RootFrame& frame, int count,
                                  unsigned seed)
{
    std::mt19937_64 random(seed);
    std::vector<Vec3> points;
    for (int i = 0; i < count; ++i) {
        Vec3 point;
        for (int axis = 0; axis < 3; ++axis) {
            const double cells = std::ldexp(1.0, static_cast<int>(random() % 10));
            const double part =
                static_cast<double>(random() % static_cast<std::uint64_t>(cells + 1));
            point[axis] = frame.center[axis] + frame.half * (2 * part / cells - 1);
        }
        points.push_back(point);
        const Triangle triangle =
            mesh.triangle(TriangleId{static_cast<std::uint32_t>(random() % mesh.triangle_count())});
        const Vec3 normal = scaled_normal(triangle);
        const double length = normal.norm();
        if (!(length > 0)) continue;
        const double height = frame.half * std::ldexp(1.0, -static_cast<int>(random() % 12));
        points.emplace_back(triangle[0] + height / length * normal);
        points.emplace_back(0.5 * triangle[0] + 0.5 * triangle[1] - height / length * normal);
    }
    return points;
}

/// Compares with brute force: the distance, and that the answer is consistent with itself.
void expect_answers(const ProximityOctree& octree, const TriangleMesh& mesh,
                    const Topology& topology, std::span<const Vec3> points)
{
    const Box box = bounding_box(mesh);
    const double diagonal = box.extent().norm();
    for (const Vec3& p : points) {
        const ClosestFeature truth = closest_feature_by_brute_force(mesh, topology, p);
        QuerySteps steps;
        const ClosestFeature found = closest_feature(octree, p, steps);
        const double scale = diagonal + (p - box.center()).norm() +
                             1e-3 * box.lower.cwiseAbs().cwiseMax(box.upper.cwiseAbs()).maxCoeff();
        const double distance = std::sqrt(found.squared_distance);
        ASSERT_NEAR(distance, std::sqrt(truth.squared_distance), 1e-12 * scale)
            << "at " << p.transpose();
        ASSERT_NEAR((found.point - p).norm(), distance, 1e-12 * scale);
        const Triangle triangle = mesh.triangle(found.triangle);
        Vec3 weighted = Vec3::Zero();
        double sum = 0;
        for (int i = 0; i < 3; ++i) {
            const double weight = found.barycentric[static_cast<std::size_t>(i)];
            ASSERT_GE(weight, 0);
            sum += weight;
            weighted += weight * triangle[i];
        }
        ASSERT_NEAR(sum, 1, 1e-15);
        ASSERT_NEAR((weighted - found.point).norm(), 0, 1e-12 * scale);
        // Another feature only where it is as close, up to rounding.
        if (found.feature != truth.feature) {
            ASSERT_NEAR(distance, std::sqrt(truth.squared_distance), 0.5e-12 * scale);
        } else {
            ASSERT_EQ(found.triangle, truth.triangle);
        }
        if (octree.frame().contains(p)) {
            ASSERT_LE(steps.steps, octree.statistics().worst_case_steps);
            ASSERT_LE(steps.blocks, octree.statistics().worst_case_blocks);
        }
    }
}

TEST(ProximityOctree, AnswersAsBruteForceDoes)
{
    for (const NamedMesh& named : proximity_meshes()) {
        SCOPED_TRACE(named.name);
        const auto topology = build_topology(named.mesh);
        ASSERT_TRUE(topology);
        for (const std::uint64_t bytes_per_triangle : {200ULL, 400ULL, 600ULL, 12000ULL}) {
            SCOPED_TRACE(bytes_per_triangle);
            ProximityOptions options;
            options.budget_bytes = bytes_per_triangle * named.mesh.triangle_count() + 4096;
            const ProximityOctree octree = build(named.mesh, options);
            EXPECT_LE(octree.bytes(), options.budget_bytes);
            expect_answers(octree, named.mesh, *topology, proximity_points(named.mesh, 200, 1));
            expect_answers(octree, named.mesh, *topology,
                           boundary_points(named.mesh, octree.frame(), 60, 2));
        }
    }
}

TEST(ProximityOctree, AnswersAtAnyScale)
{
    const TriangleMesh sphere = testing::sphere_mesh(Vec3(0.1, 0.2, 0.3), 1.0, 12, 16);
    for (const double scale : {1e-120, 1e-30, 1e-6, 1e6, 1e30, 1e120}) {
        SCOPED_TRACE(scale);
        const TriangleMesh mesh =
            testing::moved(sphere, [&](const Vec3& p) { return Vec3(scale * p); });
        const auto topology = build_topology(mesh);
        ASSERT_TRUE(topology);
        const ProximityOctree octree = build(mesh);
        expect_answers(octree, mesh, *topology, proximity_points(mesh, 300, 3));
    }
}

TEST(ProximityOctree, TiesGoToTheLowestDimensionAndId)
{
    const TriangleMesh cube = sample_mesh("cube").value();
    const auto topology = build_topology(cube);
    const ProximityOctree octree = build(cube);
    const Box box = bounding_box(cube);
    // The centre is as far from all faces; points on the diagonals from three of them.
    for (int i = 0; i < 27; ++i) {
        const Vec3 at(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1);
        const Vec3 p = box.center() + 0.25 * box.extent().cwiseProduct(at);
        const ClosestFeature truth = closest_feature_by_brute_force(cube, *topology, p);
        const ClosestFeature found = closest_feature(octree, p);
        EXPECT_EQ(found.feature, truth.feature) << p.transpose();
        EXPECT_EQ(found.triangle, truth.triangle);
        EXPECT_EQ(found.squared_distance, truth.squared_distance);
    }
}

/// Whether two answers have the same bits.
bool same_answer(const ClosestFeature& a, const ClosestFeature& b)
{
    return a.feature == b.feature && a.triangle == b.triangle && a.point == b.point &&
           a.barycentric == b.barycentric && a.squared_distance == b.squared_distance;
}

TEST(ProximityOctree, HasTheSameBitsForAnyThreadsAndInstructionSet)
{
    const TriangleMesh mesh = sample_mesh("torus:24x36").value();
    const std::vector<Vec3> points = proximity_points(mesh, 500, 4);
    const ProximityOctree one = build(mesh, {.execution = {.threads = {1}}});
    std::vector<ClosestFeature> answers(points.size());
    ASSERT_TRUE(closest_features(one, points, answers));
    const auto expect_same = [&](const ProximityOctree& other) {
        const ProximityArrays& a = one.arrays();
        const ProximityArrays& b = other.arrays();
        EXPECT_TRUE(std::ranges::equal(a.table, b.table));
        EXPECT_TRUE(std::ranges::equal(a.nodes, b.nodes));
        EXPECT_TRUE(std::ranges::equal(a.arena, b.arena));
        EXPECT_EQ(one.statistics(), other.statistics());
        for (std::size_t i = 0; i < points.size(); ++i)
            ASSERT_TRUE(same_answer(answers[i], closest_feature(other, points[i]))) << i;
    };
    for (const int threads : {2, 3, 8})
        expect_same(build(mesh, {.execution = {.threads = {threads}}}));
    for (const SimdTarget& target : simd_targets()) {
        SCOPED_TRACE(target.name);
        force_simd_target(target);
        expect_same(build(mesh, {.execution = {.threads = {2}}}));
        restore_simd_targets();
    }
}

TEST(ProximityOctree, BatchesAnswerAsSingleQueries)
{
    const TriangleMesh mesh = sample_mesh("spaceship:1300").value();
    const ProximityOctree octree = build(mesh);
    const std::vector<Vec3> points = proximity_points(mesh, 9001, 5);
    std::vector<ClosestFeature> answers(points.size());
    for (const int threads : {1, 2}) {
        for (const BatchOrder order :
             {BatchOrder::automatic, BatchOrder::as_given, BatchOrder::sorted}) {
            std::ranges::fill(answers, ClosestFeature{});
            ASSERT_TRUE(closest_features(octree, points, answers,
                                         {.order = order, .execution = {.threads = {threads}}}));
            for (std::size_t i = 0; i < points.size(); ++i)
                ASSERT_TRUE(same_answer(answers[i], closest_feature(octree, points[i]))) << i;
        }
    }
}

TEST(ProximityOctree, RefusesBatchesThatCannotBe)
{
    const ProximityOctree octree = build(sample_mesh("cube").value());
    std::vector<Vec3> points(5000, Vec3::Zero());
    std::vector<ClosestFeature> answers(points.size());
    EXPECT_EQ(closest_features(octree, points, std::span(answers).first(3)).error().code,
              ErrorCode::invalid_argument);
    points[4321][1] = std::numeric_limits<double>::quiet_NaN();
    points[4999][1] = std::numeric_limits<double>::infinity();
    for (const BatchOrder order : {BatchOrder::automatic, BatchOrder::sorted}) {
        const Status status = closest_features(octree, points, answers,
                                               {.order = order, .execution = {.threads = {2}}});
        ASSERT_FALSE(status);
        EXPECT_NE(status.error().message.find("4321"), std::string::npos) << status.error().message;
    }
}

TEST(ProximityOctree, FindsNothingBeyondTheRadius)
{
    const ProximityOctree octree = build(sample_mesh("cube").value());
    const double edge = octree.frame().half;
    const Vec3 p = octree.frame().center + Vec3(10 * edge, 0, 0);
    const double distance = std::sqrt(closest_feature(octree, p).squared_distance);
    EXPECT_FALSE(closest_feature(octree, p, 0.999 * distance));
    EXPECT_TRUE(closest_feature(octree, p, 1.001 * distance));
}

TEST(ProximityOctree, SearchesLessFromAnEarlierAnswer)
{
    const TriangleMesh mesh = sample_mesh("torus:60x40").value();
    const ProximityOctree octree = build(mesh, {.budget_bytes = 200 * mesh.triangle_count()});
    std::mt19937_64 random(9);
    std::uniform_real_distribution<double> part(-1, 1);
    const auto step = [&](double length) {
        return Vec3(length * part(random), length * part(random), length * part(random));
    };
    QuerySteps cold;
    QuerySteps warm;
    for (int i = 0; i < 2000; ++i) {
        const Vec3 p = step(4);
        const Vec3 near = p + step(1e-3);
        const ClosestFeature earlier = closest_feature(octree, near);
        const ClosestFeature found = closest_feature(octree, p, cold);
        const ClosestFeature again = closest_feature(octree, p, earlier, warm);
        ASSERT_EQ(again.feature, found.feature);
        ASSERT_EQ(again.squared_distance, found.squared_distance);
    }
    EXPECT_LT(warm.groups + warm.blocks, cold.groups + cold.blocks);
    EXPECT_LT(warm.rechecks, cold.rechecks);
}

TEST(ProximityOctree, QueriesDoNotAllocate)
{
    const TriangleMesh mesh = sample_mesh("sphere:20x20").value();
    const ProximityOctree octree = build(mesh, {.budget_bytes = 250 * mesh.triangle_count()});
    const std::vector<Vec3> points = proximity_points(mesh, 500, 6);
    const std::size_t before = testing::allocation_count();
    double sum = 0;
    for (const Vec3& p : points) sum += closest_feature(octree, p).squared_distance;
    EXPECT_EQ(testing::allocation_count(), before);
    EXPECT_GT(sum, 0);
}

TEST(ProximityOctree, RefusesWhatItCannotBuild)
{
    const TriangleMesh cube = sample_mesh("cube").value();
    const auto code = [](const Result<ProximityOctree>& result) { return result.error().code; };
    EXPECT_EQ(code(build_proximity_octree(TriangleMesh())), ErrorCode::invalid_mesh);
    const double nan = std::numeric_limits<double>::quiet_NaN();
    const TriangleMesh broken =
        make_triangle_mesh({Vec3(0, 0, nan), Vec3(1, 0, 0), Vec3(0, 1, 0)}, {{0, 1, 2}}).value();
    EXPECT_EQ(code(build_proximity_octree(broken)), ErrorCode::invalid_mesh);
    EXPECT_EQ(code(build_proximity_octree(cube, {.margin = -1})), ErrorCode::invalid_argument);
    EXPECT_EQ(code(build_proximity_octree(cube, {.margin = nan})), ErrorCode::invalid_argument);
    EXPECT_EQ(code(build_proximity_octree(cube, {.max_depth = 15})), ErrorCode::invalid_argument);
    const auto small = build_proximity_octree(cube, {.budget_bytes = 100});
    EXPECT_EQ(code(small), ErrorCode::budget_exceeded);
    EXPECT_NE(small.error().message.find("at least"), std::string::npos);
    const auto topology = build_topology(sample_mesh("octahedron").value());
    EXPECT_EQ(code(build_proximity_octree(cube, *topology)), ErrorCode::invalid_argument);
}

TEST(ProximityOctree, StopsWhenAskedTo)
{
    const TriangleMesh mesh = sample_mesh("torus:30x40").value();
    testing::cancel_at_every_stage(
        [&](Progress& progress) {
            return build_proximity_octree(mesh, {.execution = {.progress = &progress}});
        },
        [] { return true; });
}

} // namespace
} // namespace proxima
