#include "haptics/tool/closest_directions.h"

#include "base/simd.h"
#include "geometry/triangle_distance.h"
#include "haptics/tool/tool_bench.h"

#include <algorithm>
#include <cstring>
#include <gtest/gtest.h>
#include <optional>
#include <random>
#include <string>

namespace proxima::testing::closest_directions_test {
namespace {

/// Pairs of all shapes and sizes: slivers, needles, parallel sides, triangles without an area.
EightTrianglePairs random_pairs(std::uint32_t seed)
{
    std::mt19937 random(seed);
    const auto unit = [&] { return std::uniform_real_distribution<double>(-1, 1)(random); };
    const double size = std::pow(10.0, 3 * unit());
    EightTrianglePairs pairs;
    for (auto* const side : {&pairs.scene, &pairs.tool}) {
        for (std::size_t lane = 0; lane < 8; ++lane) {
            const double thin = random() % 4 == 0 ? 1e-4 : 1;
            const double away = side == &pairs.scene ? 0 : 2.5;
            for (std::size_t axis = 0; axis < 3; ++axis) {
                auto& corners = *side;
                corners[0][axis][lane] = size * (unit() + (axis == 2 ? away : 0));
                corners[1][axis][lane] = corners[0][axis][lane] + size * unit();
                corners[2][axis][lane] = corners[1][axis][lane] + thin * size * unit();
                if (lane == 7 && seed % 3 == 0) corners[2][axis][lane] = corners[1][axis][lane];
            }
        }
    }
    return pairs;
}

Triangle triangle_of(const double (&corners)[3][3][8], std::size_t lane)
{
    Triangle triangle;
    for (std::size_t i = 0; i < 3; ++i) {
        triangle.vertices[i] = Vec3(corners[i][0][lane], corners[i][1][lane], corners[i][2][lane]);
    }
    return triangle;
}

/// Against the scalar closest points: the plane across a direction separates by the distance.
TEST(ClosestDirections, TheirGapIsTheDistance)
{
    int apart = 0;
    for (std::uint32_t seed = 1; seed <= 400; ++seed) {
        const EightTrianglePairs pairs = random_pairs(seed);
        const RigidTransform pose = pose_at({0, 0, 0}, {0.1, 0.05 * (seed % 5), 0});
        EightDirections directions;
        find_closest_directions(pairs, pose, directions);
        for (std::size_t lane = 0; lane < 8; ++lane) {
            SCOPED_TRACE("seed " + std::to_string(seed) + ", lane " + std::to_string(lane));
            const Triangle scene = triangle_of(pairs.scene, lane);
            const Triangle tool = pose(triangle_of(pairs.tool, lane));
            const double distance = std::sqrt(closest_points(scene, tool).squared_distance);
            const Vec3 across(directions.across[0][lane], directions.across[1][lane],
                              directions.across[2][lane]);
            if (!(distance > 0)) continue;
            const Vec3 normal = across.normalized();
            double gap = std::numeric_limits<double>::infinity();
            for (const Vec3& p : scene.vertices)
                for (const Vec3& q : tool.vertices) gap = std::min(gap, normal.dot(q - p));
            EXPECT_NEAR(gap, distance, 1e-7 * distance);
            ++apart;
        }
    }
    EXPECT_GT(apart, 2000);
}

TEST(ClosestDirections, AreTheSameOnEveryInstructionSet)
{
    for (std::uint32_t seed = 1; seed <= 50; ++seed) {
        const EightTrianglePairs pairs = random_pairs(seed);
        const RigidTransform pose = pose_at({0.1, 0, 0.2}, {0.4, 0.3, -0.2});
        std::optional<EightDirections> first;
        for (const SimdTarget& target : simd_targets()) {
            SCOPED_TRACE(target.name);
            force_simd_target(target);
            EightDirections directions;
            find_closest_directions(pairs, pose, directions);
            if (!first) first = directions;
            EXPECT_EQ(std::memcmp(&directions, &*first, sizeof directions), 0);
        }
    }
    restore_simd_targets();
}

} // namespace
} // namespace proxima::testing::closest_directions_test
