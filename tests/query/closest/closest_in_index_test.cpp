#include "base/simd.h"
#include "code_of.h"
#include "counted_allocations.h"
#include "index/listed_index.h"
#include "index/test_meshes.h"
#include "proxima/closest_feature.h"
#include "proxima/mesh_index.h"
#include "query/closest/brute_force.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <random>
#include <vector>

namespace proxima::closest_in_index_test {
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

void expect_same(const std::optional<ClosestFeature>& found, const ClosestFeature& truth)
{
    ASSERT_TRUE(found.has_value());
    expect_same(*found, truth);
}

void expect_answers_of_brute_force(const TriangleMesh& mesh, std::span<const Vec3> points)
{
    const Topology topology = build_topology(mesh).value();
    const MeshIndex index = build_mesh_index(mesh).value();
    for (const Vec3& p : points) {
        SCOPED_TRACE(p.transpose());
        expect_same(closest_feature(index, p), closest_feature_by_brute_force(mesh, topology, p));
    }
}

TEST(ClosestInIndex, AnswersLikeBruteForceToTheLastBit)
{
    for (const NamedMesh& named : proximity_meshes()) {
        SCOPED_TRACE(named.name);
        expect_answers_of_brute_force(named.mesh, proximity_points(named.mesh, 600, 8));
    }
}

TEST(ClosestInIndex, AnswersLikeBruteForceOnManyRandomMeshes)
{
    for (std::uint32_t seed = 100; seed < 400; ++seed) {
        SCOPED_TRACE(seed);
        const TriangleMesh mesh = seed % 2 == 0 ? nasty_mesh(seed) : grid_mesh(seed);
        expect_answers_of_brute_force(mesh, proximity_points(mesh, 60, seed));
    }
}

TEST(ClosestInIndex, AnswersLikeBruteForceAtEveryScale)
{
    for (const double scale : {1e-300, 1e-170, 1e-150, 1e-40, 1e40, 1e100, 1e160, 1e300}) {
        SCOPED_TRACE(scale);
        for (const NamedMesh& named : proximity_meshes()) {
            if (named.mesh.triangle_count() > 200) continue;
            SCOPED_TRACE(named.name);
            const TriangleMesh mesh =
                moved(named.mesh, [&](const Vec3& p) { return Vec3(scale * p); });
            if (!bounding_box(mesh).upper.allFinite()) continue;
            std::vector<Vec3> points;
            for (const Vec3& p : proximity_points(named.mesh, 30, 5))
                points.emplace_back(scale * p);
            expect_answers_of_brute_force(mesh, points);
        }
    }
}

// Half the least double is none, so the middle of this mesh is beside it.
TEST(ClosestInIndex, AnswersLikeBruteForceToAPointOfTheLeastDouble)
{
    const double least = std::numeric_limits<double>::denorm_min();
    const TriangleMesh mesh =
        mesh_of({Vec3(-least, -1, -13), Vec3(-least, -1, -13)}, {{0, 1, 0}, {1, 1, 1}});
    expect_answers_of_brute_force(mesh, std::array{Vec3(15.5, 4, -15), Vec3(0, -1, -13)});
}

TEST(ClosestInIndex, NamesTheSameFeatureAtEveryPowerOfTwo)
{
    const TriangleMesh mesh = sample_mesh("spaceship:1300").value();
    const MeshIndex index = build_mesh_index(mesh).value();
    const std::vector<Vec3> points = proximity_points(mesh, 200, 6);
    for (const int exponent : {-900, -540, -30, 30, 540, 900}) {
        SCOPED_TRACE(exponent);
        const double scale = std::ldexp(1.0, exponent);
        const MeshIndex other =
            build_mesh_index(moved(mesh, [&](const Vec3& p) { return Vec3(scale * p); })).value();
        for (const Vec3& p : points) {
            const auto found = closest_feature(index, p);
            const auto scaled = closest_feature(other, scale * p);
            ASSERT_TRUE(found && scaled);
            EXPECT_EQ(scaled->feature, found->feature);
            EXPECT_EQ(scaled->point, Vec3(scale * found->point));
            EXPECT_EQ(scaled->squared_distance, found->squared_distance * scale * scale);
        }
    }
}

TEST(ClosestInIndex, AnswersLikeBruteForceFarAway)
{
    const TriangleMesh mesh = sample_mesh("torus:20x10").value();
    for (const double far :
         {10., 60., 70., 1e2, 1e5, 1e8, 1e12, 1e15, 1e17, 1e60, 1e149, 1e155, 1.7e308}) {
        SCOPED_TRACE(far);
        std::vector<Vec3> points;
        for (const Vec3& toward : proximity_points(mesh, 30, 9))
            points.emplace_back(far * toward.normalized());
        expect_answers_of_brute_force(mesh, points);
    }
}

// The distance to the closest point as rounded, which the surface search once returned, is off by
// the rounding of coordinates: 1e-9 here. Differences of coordinates are exact.
TEST(ClosestInIndex, IsAsAccurateFarFromTheOriginAsNearIt)
{
    const TriangleMesh mesh = sample_mesh("torus:20x10").value();
    const Vec3 away(0x1p26, -0x1p25, 0x1p27);
    const TriangleMesh far = moved(mesh, [&](const Vec3& p) { return Vec3(p + away); });
    const TriangleMesh near = moved(far, [&](const Vec3& p) { return Vec3(p - away); }); // exactly
    const MeshIndex far_index = build_mesh_index(far).value();
    const MeshIndex near_index = build_mesh_index(near).value();
    const MeshIndex listed = with_lists(far_index).value();
    for (const Vec3& at : proximity_points(near, 300, 21)) {
        const Vec3 p = at + away;
        const auto found = closest_feature(far_index, p);
        const auto truth = closest_feature(near_index, p - away);
        ASSERT_TRUE(found && truth);
        EXPECT_EQ(found->squared_distance, truth->squared_distance);
        EXPECT_EQ(found->feature, truth->feature);
        EXPECT_EQ(found->barycentric, truth->barycentric);
        expect_same(found, closest_feature(listed, p).value());
    }
}

// The sides of a plate so thin that the builder of lists cannot tell where they face.
TEST(ClosestInIndex, AnswersLikeListsOnSlivers)
{
    for (const double height : {1e-9, 1e-11, 1e-12, 1e-14}) {
        SCOPED_TRACE(height);
        const TriangleMesh plate = moved(cube_mesh(Vec3::Zero(), 1), [&](const Vec3& p) {
            return Vec3(p.x(), p.y(), height * p.z());
        });
        const MeshIndex index = build_mesh_index(plate).value();
        const MeshIndex listed = with_lists(index).value();
        for (const Vec3& p : proximity_points(plate, 600, 5))
            expect_same(closest_feature(listed, p), closest_feature(index, p).value());
    }
}

// Triangles whose corners are one point for the builder of lists, far from the middle of the mesh: some of them have
// no vertex and no edge that no other one has.
TEST(ClosestInIndex, AnswersLikeListsOnTrianglesThatArePointsBesideTheMesh)
{
    const TriangleMesh large = sphere_mesh(Vec3(1, 0.5, 2), 1.0, 20, 20);
    for (const double size : {1e-18, 1e-24, 1e-40}) {
        SCOPED_TRACE(size);
        const TriangleMesh tiny = sphere_mesh(Vec3::Zero(), size, 8, 8);
        const TriangleMesh mesh = joined(large, tiny);
        const Topology topology = build_topology(mesh).value();
        const MeshIndex listed = with_lists(build_mesh_index(mesh).value()).value();
        int faces = 0;
        for (const Vec3& p : proximity_points(tiny, 200, 21)) {
            const ClosestFeature truth = closest_feature_by_brute_force(mesh, topology, p);
            faces += truth.feature.kind == FeatureKind::face ? 1 : 0;
            expect_same(closest_feature(listed, p), truth);
        }
        EXPECT_GT(faces, 20);
    }
}

// A triangle without an area counts as its sides, however roundings make it look.
TEST(ClosestInIndex, NamesNoFaceOfTrianglesWithoutAnArea)
{
    std::mt19937 random(22);
    std::uniform_real_distribution<float> uniform(-1, 1);
    std::vector<Vec3> corners;
    std::vector<TriangleCorners> triangles;
    // Every other line is slanted, so that differences of its points are rounded off it.
    const auto on_line = [&](std::uint32_t line) {
        const float part = std::ldexp(uniform(random), -static_cast<int>(random() % 120));
        const double along = part;
        return Vec3(3 + line, line % 2 * 3 * along, along);
    };
    for (std::uint32_t i = 0; i < 40; ++i) {
        for (int k = 0; k < 3; ++k) corners.push_back(on_line(i));
        triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
    }
    const TriangleMesh mesh =
        joined(sphere_mesh(Vec3::Zero(), 1.0, 8, 8), mesh_of(corners, triangles));
    const Topology topology = build_topology(mesh).value();
    const MeshIndex index = build_mesh_index(mesh).value();
    const MeshIndex listed = with_lists(index).value();
    for (std::uint32_t i = 0; i < 20'000; ++i) {
        const Vec3 p = on_line(i % 40);
        const ClosestFeature truth = closest_feature_by_brute_force(mesh, topology, p);
        EXPECT_NE(truth.feature.kind, FeatureKind::face);
        expect_same(closest_feature(index, p), truth);
        expect_same(closest_feature(listed, p), truth);
    }
}

// Quarters, so that differences are exact: only answers that are rounded to coordinates can change.
TEST(ClosestInIndex, MeasuresSliversFarFromTheOriginAsNearIt)
{
    std::mt19937 random(23);
    std::uniform_int_distribution<int> number(-40, 40);
    const auto place = [&] {
        return Vec3(0.25 * number(random), 0.25 * number(random), 0.25 * number(random));
    };
    int faces = 0;
    for (int i = 0; i < 200; ++i) {
        SCOPED_TRACE(i);
        std::vector<Vec3> corners;
        std::vector<TriangleCorners> triangles;
        for (std::uint32_t k = 0; k < 12; ++k) {
            const Vec3 a = place();
            const Vec3 side = place();
            for (const Vec3& corner : {a, Vec3(a + 8 * side), Vec3(a + 3 * side + 0.05 * place())})
                corners.push_back((4 * corner).array().round() / 4);
            triangles.push_back({3 * k, 3 * k + 1, 3 * k + 2});
        }
        const Vec3 offset(0x1p50, -0x1p49, 0x1p44);
        std::vector<Vec3> moved;
        for (const Vec3& corner : corners) moved.push_back(corner + offset);
        const MeshIndex here = build_mesh_index(mesh_of(corners, triangles)).value();
        const MeshIndex there = build_mesh_index(mesh_of(moved, triangles)).value();
        for (int k = 0; k < 50; ++k) {
            const std::size_t at = 3 * static_cast<std::size_t>(k % 12);
            const Vec3 p = 0.75 * corners[at] + 0.25 * corners[at + 1] + 0.05 * place();
            const Vec3 q = (4 * p).array().round() / 4;
            const ClosestFeature near = closest_feature(here, q).value();
            const ClosestFeature far = closest_feature(there, q + offset).value();
            EXPECT_EQ(far.feature, near.feature);
            EXPECT_EQ(far.squared_distance, near.squared_distance);
            faces += near.feature.kind == FeatureKind::face ? 1 : 0;
        }
    }
    EXPECT_GT(faces, 500);
}

TEST(ClosestInIndex, AnswersLikeLists)
{
    for (const char* const name : {"spaceship:20000", "sphere:40x40"}) {
        SCOPED_TRACE(name);
        const TriangleMesh mesh = sample_mesh(name).value();
        const MeshIndex index = build_mesh_index(mesh).value();
        const MeshIndex listed = with_lists(index).value();
        for (const Vec3& p : proximity_points(mesh, 2000, 17))
            expect_same(closest_feature(index, p), closest_feature(listed, p).value());
    }
}

// The inside of a sliver is nearer than its sides and than another triangle: only its sides are
// measured in floats.
TEST(ClosestInIndex, FindsTheInsideOfSlivers)
{
    const TriangleMesh mesh = mesh_of({Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0.5, 0.019, 0),
                                       Vec3(0, -1, 0.003), Vec3(1, -1, 0.003), Vec3(0.5, 1, 0.003)},
                                      {{0, 1, 2}, {3, 4, 5}});
    std::vector<Vec3> points;
    for (int i = 0; i < 40; ++i) points.emplace_back(0.4 + 0.005 * i, 0.0085, 0.0005);
    expect_answers_of_brute_force(mesh, points);
    const auto found = closest_feature(build_mesh_index(mesh).value(), Vec3(0.5, 0.0085, 0.0005));
    EXPECT_EQ(found->feature, (Feature{FeatureKind::face, 0}));
}

// Points that are over a triangle by the least that doubles tell, seen from its side.
TEST(ClosestInIndex, AnswersLikeBruteForceForTheSmallestCoordinates)
{
    constexpr double least = std::numeric_limits<double>::denorm_min();
    const TriangleMesh mesh = mesh_of({Vec3(1, 1, 1), Vec3(1, 1, 0), Vec3(0, 0, 0)}, {{0, 1, 2}});
    std::vector<Vec3> points;
    for (int i = 0; i < 20; ++i) {
        for (const double z : {least, 2 * least, 3 * least, -least})
            points.emplace_back(0.01 * i, 0.05 - 0.02 * i, z);
    }
    expect_answers_of_brute_force(mesh, points);
}

// All triangles are as near, but for rounding: more candidates than are kept.
TEST(ClosestInIndex, AnswersAtTheCentreOfASphere)
{
    const Vec3 centre(0.1, 0.2, 0.3);
    const TriangleMesh mesh = sphere_mesh(centre, 1.0, 40, 40);
    std::vector<Vec3> points = {centre};
    for (const double off : {1e-16, 1e-12, 1e-9, 1e-7, 1e-6, 1e-5})
        for (int axis = 0; axis < 3; ++axis) points.emplace_back(centre + off * Vec3::Unit(axis));
    expect_answers_of_brute_force(mesh, points);
}

TEST(ClosestInIndex, RespectsARadius)
{
    const TriangleMesh mesh = sample_mesh("spaceship:1300").value();
    const Topology topology = build_topology(mesh).value();
    const MeshIndex plain = build_mesh_index(mesh).value();
    constexpr double infinity = std::numeric_limits<double>::infinity();
    for (const MeshIndex& index : {plain, with_lists(plain).value()}) {
        for (const Vec3& p : proximity_points(mesh, 200, 10)) {
            const ClosestFeature truth = closest_feature_by_brute_force(mesh, topology, p);
            const double distance = std::sqrt(truth.squared_distance);
            for (const double radius :
                 {0.0, 0.5 * distance, std::nextafter(distance, 0.0), distance,
                  std::nextafter(distance, 1e9), 2 * distance, infinity}) {
                const auto found = closest_feature(index, p, {.radius = radius});
                ASSERT_EQ(found.has_value(), truth.squared_distance <= radius * radius);
                if (found) expect_same(*found, truth);
            }
            for (const double radius :
                 {-1.0, -2 * distance - 1, -infinity, std::numeric_limits<double>::quiet_NaN()})
                EXPECT_FALSE(closest_feature(index, p, {.radius = radius})) << radius;
        }
    }
}

TEST(ClosestInIndex, FindsNothingForPointsThatAreNotFinite)
{
    const MeshIndex index = build_mesh_index(sample_mesh("cube").value()).value();
    for (const double value :
         {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
        for (int axis = 0; axis < 3; ++axis) {
            Vec3 p = Vec3::Zero();
            p[axis] = value;
            EXPECT_FALSE(closest_feature(index, p));
        }
    }
}

TEST(ClosestInIndex, AcceptsAnyAnswerAsAStart)
{
    const TriangleMesh mesh = sample_mesh("spaceship:1300").value();
    const TriangleMesh other =
        moved(mesh, [](const Vec3& p) { return Vec3(0.01 * p + Vec3(3, 1, 2)); });
    const MeshIndex index = build_mesh_index(mesh).value();
    const MeshIndex other_index = build_mesh_index(other).value();
    std::vector<ClosestFeature> earlier = {no_closest_feature(), {}};
    const std::vector<Vec3> points = proximity_points(mesh, 120, 11);
    for (const Vec3& p : points) {
        const ClosestFeature truth = closest_feature(index, p).value();
        earlier.push_back(truth);
        earlier.push_back(closest_feature(other_index, p).value());
        // A point that is nearer than the mesh is.
        ClosestFeature wrong = truth;
        wrong.point = p;
        earlier.push_back(wrong);
        for (const ClosestFeature& start : earlier)
            expect_same(closest_feature(index, p, {.start_from = &start}), truth);
        const double radius = std::sqrt(truth.squared_distance) * 0.75;
        const auto within = closest_feature(index, p, {.radius = radius, .start_from = &wrong});
        EXPECT_EQ(within.has_value(), truth.squared_distance <= radius * radius);
    }
}

TEST(ClosestInIndex, HasTheSameAnswersOnEveryInstructionSetWithoutAllocating)
{
    const TriangleMesh mesh = sample_mesh("spaceship:20000").value();
    const MeshIndex index = build_mesh_index(mesh).value();
    const std::vector<Vec3> points = proximity_points(mesh, 300, 12);
    std::vector<ClosestFeature> first;
    for (const Vec3& p : points) first.push_back(closest_feature(index, p).value());
    for (const SimdTarget& target : simd_targets()) {
        SCOPED_TRACE(target.name);
        force_simd_target(target);
        std::uint64_t allocations = 0;
        for (std::size_t i = 0; i < points.size(); ++i) {
            const std::size_t before = allocation_count();
            const auto found = closest_feature(index, points[i], {.start_from = &first[i / 2]});
            const auto cold = closest_feature(index, points[i]);
            allocations += allocation_count() - before;
            expect_same(found, first[i]);
            expect_same(cold, first[i]);
        }
        EXPECT_EQ(allocations, 0U);
    }
    restore_simd_targets();
}

/// A batch's answers by columns.
struct Columns {
    explicit Columns(std::size_t size)
        : squared(size), distances(size), points(size), kinds(size), ids(size), barycentrics(size),
          triangles(size)
    {}

    [[nodiscard]] ClosestOutputs outputs()
    {
        return {.squared_distances = squared,
                .triangles = triangles,
                .distances = distances,
                .points = points,
                .feature_kinds = kinds,
                .feature_ids = ids,
                .barycentrics = barycentrics};
    }

    void expect_same(std::size_t i, const ClosestFeature& truth) const
    {
        EXPECT_EQ(squared[i], truth.squared_distance);
        EXPECT_EQ(distances[i], std::sqrt(truth.squared_distance));
        EXPECT_EQ(points[i], truth.point);
        EXPECT_EQ(kinds[i], truth.feature.kind);
        EXPECT_EQ(ids[i], truth.feature.id);
        EXPECT_EQ(barycentrics[i], truth.barycentric);
        EXPECT_EQ(triangles[i], truth.triangle);
    }

    std::vector<double> squared;
    std::vector<double> distances;
    std::vector<Vec3> points;
    std::vector<FeatureKind> kinds;
    std::vector<std::uint32_t> ids;
    std::vector<std::array<double, 3>> barycentrics;
    std::vector<TriangleId> triangles;
};

TEST(ClosestInIndex, BatchesAnswerLikeSingleQueries)
{
    for (const NamedMesh& named : proximity_meshes()) {
        SCOPED_TRACE(named.name);
        const MeshIndex index = build_mesh_index(named.mesh).value();
        std::vector<Vec3> points = proximity_points(named.mesh, 500, 14);
        points.insert(points.end(), 20, points[4]);
        for (const double far : {1e3, 1e20, 1e155}) points.emplace_back(far * Vec3(1, -1, 0.5));
        std::vector<ClosestFeature> answers(points.size());
        Columns columns(points.size());
        for (const SimdTarget& target : simd_targets()) {
            SCOPED_TRACE(target.name);
            force_simd_target(target);
            for (const BatchOrder order : {BatchOrder::as_given, BatchOrder::sorted}) {
                ASSERT_TRUE(
                    closest_features(index, points, {.answers = answers}, {.order = order}));
                ASSERT_TRUE(closest_features(index, points, columns.outputs(), {.order = order}));
                for (std::size_t i = 0; i < points.size(); ++i) {
                    const ClosestFeature truth = closest_feature(index, points[i]).value();
                    expect_same(answers[i], truth);
                    columns.expect_same(i, truth);
                }
            }
        }
        restore_simd_targets();
    }
}

// Squares of these distances are zero, or beyond all doubles.
TEST(ClosestInIndex, BatchesAnswerLikeSingleQueriesAtEveryScale)
{
    const TriangleMesh model = sample_mesh("spaceship:1300").value();
    for (const double scale : {1e-300, 1e-170, 1e-160, 1e150, 1e160}) {
        SCOPED_TRACE(scale);
        const TriangleMesh mesh = moved(model, [&](const Vec3& p) { return Vec3(scale * p); });
        const MeshIndex index = build_mesh_index(mesh).value();
        std::vector<Vec3> points;
        for (const Vec3& p : proximity_points(model, 300, 14)) points.emplace_back(scale * p);
        std::vector<ClosestFeature> answers(points.size());
        for (const BatchOrder order : {BatchOrder::as_given, BatchOrder::sorted}) {
            ASSERT_TRUE(closest_features(index, points, {.answers = answers}, {.order = order}));
            for (std::size_t i = 0; i < points.size(); ++i)
                expect_same(answers[i], closest_feature(index, points[i]).value());
        }
    }
}

TEST(ClosestInIndex, BatchesHaveTheSameAnswersForEveryNumberOfThreads)
{
    const TriangleMesh mesh = sample_mesh("spaceship:20000").value();
    const MeshIndex index = build_mesh_index(mesh).value();
    const std::vector<Vec3> points = proximity_points(mesh, 30000, 15);
    std::vector<ClosestFeature> first(points.size());
    ASSERT_TRUE(
        closest_features(index, points, {.answers = first}, {.execution = {.threads = {1}}}));
    for (const int threads : {1, 2, 3, 7}) {
        // More than what a thread takes at a time, of each column.
        Columns columns(points.size());
        std::vector<ClosestFeature> answers(points.size());
        ClosestOutputs outputs = columns.outputs();
        outputs.answers = answers;
        for (const BatchOrder order : {BatchOrder::as_given, BatchOrder::sorted}) {
            ASSERT_TRUE(closest_features(index, points, outputs,
                                         {.order = order, .execution = {.threads = {threads}}}));
            for (std::size_t i = 0; i < points.size(); ++i) {
                expect_same(answers[i], first[i]);
                columns.expect_same(i, first[i]);
            }
        }
    }
}

TEST(ClosestInIndex, BatchesReportErrors)
{
    const MeshIndex index = build_mesh_index(sample_mesh("cube").value()).value();
    std::vector<Vec3> points(5000, Vec3(1, 2, 3));
    std::vector<double> distances(points.size());
    std::vector<ClosestFeature> few_answers(7);
    Columns few(7);
    for (const ClosestOutputs& outputs :
         {ClosestOutputs{.answers = few_answers}, ClosestOutputs{.squared_distances = few.squared},
          ClosestOutputs{.triangles = few.triangles}, ClosestOutputs{.distances = few.distances},
          ClosestOutputs{.points = few.points}, ClosestOutputs{.feature_kinds = few.kinds},
          ClosestOutputs{.feature_ids = few.ids},
          ClosestOutputs{.barycentrics = few.barycentrics}}) {
        const Status status = closest_features(index, points, outputs);
        ASSERT_FALSE(status);
        EXPECT_EQ(code_of(status), ErrorCode::invalid_argument);
    }
    EXPECT_TRUE(closest_features(index, points, {}));
    EXPECT_TRUE(closest_features(index, {}, {}));
    points[4500][1] = std::numeric_limits<double>::quiet_NaN();
    points[4900][2] = std::numeric_limits<double>::infinity();
    for (const BatchOrder order : {BatchOrder::as_given, BatchOrder::sorted}) {
        const auto status =
            closest_features(index, points, {.squared_distances = distances}, {.order = order});
        ASSERT_FALSE(status);
        EXPECT_NE(status.error().message.find("point 4500"), std::string::npos);
    }
    // Also among those that are looked at to choose an order.
    points[0][0] = std::numeric_limits<double>::quiet_NaN();
    EXPECT_NE(
        closest_features(index, points, {.distances = distances}).error().message.find("point 0"),
        std::string::npos);
    Progress progress;
    progress.cancel();
    EXPECT_EQ(code_of(closest_features(index, points, {.squared_distances = distances},
                                       {.execution = {.progress = &progress}})),
              ErrorCode::cancelled);
}

TEST(ClosestInIndex, RadiusHoldsForMeshesWhoseSquaresOverflow)
{
    constexpr double tiny = std::numeric_limits<double>::denorm_min();
    const MeshIndex index =
        build_mesh_index(
            make_triangle_mesh({{0, 0, 0}, {tiny, 0, 0}, {0, tiny, 0}}, {{0, 1, 2}}).value())
            .value();
    const Vec3 p(3, 4, 12); // 13 away
    EXPECT_TRUE(closest_feature(index, p));
    EXPECT_TRUE(closest_feature(index, p, {.radius = 13}));
    EXPECT_FALSE(closest_feature(index, p, {.radius = 12.5}));
}

TEST(ClosestInIndex, BatchesStopSoonWithinWhatAThreadSorts)
{
    const MeshIndex plain = build_mesh_index(sample_mesh("icosphere:3").value()).value();
    std::mt19937 random(7); // fixed: what is looked at is where the search ends
    std::uniform_real_distribution<double> coordinate(-2, 2);
    std::vector<Vec3> points(60'000);
    for (Vec3& p : points) p = Vec3{coordinate(random), coordinate(random), coordinate(random)};
    for (const MeshIndex& index : {plain, with_lists(plain).value()}) {
        for (const BatchOrder order : {BatchOrder::as_given, BatchOrder::sorted}) {
            std::vector<double> distances(points.size(), -1);
            const ClosestOutputs outputs = {.distances = distances};
            const auto ask = [&](Progress& progress) {
                return closest_features(
                    index, points, outputs,
                    {.order = order, .execution = {.threads = {1}, .progress = &progress}});
            };
            Progress stopped;
            stopped.cancel_after(10);
            const Status status = ask(stopped);
            ASSERT_FALSE(status);
            EXPECT_EQ(code_of(status), ErrorCode::cancelled);
            EXPECT_GT(stopped.fraction(), 0.0);
            EXPECT_GT(std::ranges::count(distances, -1.0), 45'000);
            Progress whole;
            ASSERT_TRUE(ask(whole));
            EXPECT_EQ(whole.fraction(), 1.0);
            EXPECT_EQ(std::ranges::count(distances, -1.0), 0);
        }
    }
}

} // namespace
} // namespace proxima::closest_in_index_test
