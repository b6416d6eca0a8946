#include "code_of.h"
#include "index/test_meshes.h"
#include "proxima/mesh_index.h"
#include "proxima/signed_distance.h"
#include "query/closest/signed_mesh.h"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <gtest/gtest.h>
#include <limits>
#include <random>
#include <string>
#include <vector>

namespace proxima::signed_batch_test {
namespace {

using namespace proxima::testing;

/// With open edges and parts that are in doubt, so that every method has its turn.
TriangleMesh ship_and_balls()
{
    const TriangleMesh balls = joined(ball(Vec3(9, 9, 9), 1.0), ball(Vec3(9.5, 9, 9), 1.0));
    return joined(sample_mesh("spaceship:1300").value(), balls);
}

bool same_bits(double a, double b)
{
    return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b);
}

TEST(SignedDistances, HaveTheBitsOfSingleQueriesForAnyNumberOfThreads)
{
    const TriangleMesh mesh = ship_and_balls();
    const MeshIndex index = with_signs(build_mesh_index(mesh).value()).value();
    std::vector<Vec3> points = proximity_points(mesh, 12'000, 77);
    for (const Vec3& position : mesh.positions()) points.push_back(position);
    std::vector<SignedDistance> truth;
    for (const Vec3& p : points) truth.push_back(signed_distance(index, p).value());
    for (const int threads : {1, 2, 5}) {
        for (const BatchOrder order : {BatchOrder::as_given, BatchOrder::sorted}) {
            std::vector<double> distances(points.size());
            std::vector<SignedDistance> answers(points.size());
            std::vector<SignMethod> methods(points.size());
            const BatchOptions options{.order = order, .execution = {.threads = {threads}}};
            ASSERT_TRUE(signed_distances(
                index, points, {.distances = distances, .methods = methods, .answers = answers},
                options));
            std::vector<double> alone(points.size());
            ASSERT_TRUE(signed_distances(index, points, {.distances = alone}, options));
            for (std::size_t i = 0; i < points.size(); ++i) {
                ASSERT_TRUE(same_bits(distances[i], truth[i].distance)) << "point " << i;
                ASSERT_TRUE(same_bits(alone[i], truth[i].distance)) << "point " << i;
                ASSERT_TRUE(same_bits(answers[i].distance, truth[i].distance)) << "point " << i;
                ASSERT_EQ(answers[i].method, truth[i].method) << "point " << i;
                ASSERT_EQ(methods[i], truth[i].method) << "point " << i;
                ASSERT_EQ(answers[i].closest.feature, truth[i].closest.feature) << "point " << i;
            }
        }
    }
}

TEST(SignedDistances, ReportErrors)
{
    const MeshIndex plain = build_mesh_index(cube_mesh(Vec3::Zero(), 1.0)).value();
    const MeshIndex index = with_signs(plain).value();
    std::vector<Vec3> points(10, Vec3(3, 0, 0));
    std::vector<double> distances(9);
    const Status without = signed_distances(plain, points, {});
    ASSERT_FALSE(without);
    EXPECT_EQ(code_of(without), ErrorCode::invalid_argument);
    EXPECT_NE(without.error().message.find("with_signs"), std::string::npos);
    EXPECT_EQ(code_of(signed_distances(index, points, {.distances = distances})),
              ErrorCode::invalid_argument);
    std::vector<SignMethod> methods(11);
    EXPECT_EQ(code_of(signed_distances(index, points, {.methods = methods})),
              ErrorCode::invalid_argument);
    std::vector<SignedDistance> answers(9);
    EXPECT_EQ(code_of(signed_distances(index, points, {.answers = answers})),
              ErrorCode::invalid_argument);
    distances.resize(10);
    EXPECT_TRUE(signed_distances(index, points, {.distances = distances}));
    EXPECT_EQ(distances[7], 2.0);
    EXPECT_TRUE(signed_distances(index, {}, {}));
    Progress progress;
    progress.cancel();
    EXPECT_EQ(code_of(signed_distances(index, points, {.distances = distances},
                                       {.execution = {.progress = &progress}})),
              ErrorCode::cancelled);
    points[4].y() = std::numeric_limits<double>::infinity();
    const Status refused = signed_distances(index, points, {.distances = distances});
    ASSERT_FALSE(refused);
    EXPECT_NE(refused.error().message.find("point 4"), std::string::npos);
}

TEST(SignedDistances, StopSoonWithinWhatAThreadTakes)
{
    const MeshIndex index = build_mesh_index(sample_mesh("icosphere:3").value())
                                .and_then([](const MeshIndex& plain) { return with_signs(plain); })
                                .value();
    std::mt19937 random(8); // fixed: what is looked at is where the work ends
    std::uniform_real_distribution<double> coordinate(-2, 2);
    std::vector<Vec3> points(40'000);
    for (Vec3& p : points) p = Vec3{coordinate(random), coordinate(random), coordinate(random)};
    constexpr double nothing = 77;
    std::vector<double> distances(points.size(), nothing);
    const auto ask = [&](Progress& progress) {
        return signed_distances(index, points, {.distances = distances},
                                {.execution = {.threads = {1}, .progress = &progress}});
    };
    // While it searches, which are the first 625 reports or so, and while it finds signs.
    for (const std::uint64_t reports : {10U, 650U}) {
        std::ranges::fill(distances, nothing);
        Progress stopped;
        stopped.cancel_after(reports);
        const Status status = ask(stopped);
        ASSERT_FALSE(status);
        EXPECT_EQ(code_of(status), ErrorCode::cancelled);
        EXPECT_GT(stopped.fraction(), 0.0);
        const auto left = std::ranges::count(distances, nothing);
        EXPECT_GT(left, 10'000);
        EXPECT_EQ(left == 40'000, reports == 10U);
    }
    Progress whole;
    ASSERT_TRUE(ask(whole));
    EXPECT_EQ(whole.fraction(), 1.0);
    EXPECT_EQ(std::ranges::count(distances, nothing), 0);
}

} // namespace
} // namespace proxima::signed_batch_test
