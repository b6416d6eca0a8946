#include "mesh/near_vertices.h"

#include "mesh/random_soups.h"

#include <cmath>
#include <gtest/gtest.h>
#include <random>

namespace proxima::near_vertices_test {
namespace {

/// Joins each to the nearest of those kept before it.
std::vector<std::uint32_t> slowly_near(std::span<const Vec3> positions, double distance)
{
    std::vector<std::uint32_t> becomes;
    for (std::uint32_t vertex = 0; vertex < positions.size(); ++vertex) {
        double nearest = distance;
        std::uint32_t one = vertex;
        for (std::uint32_t kept = 0; kept < vertex; ++kept) {
            if (becomes[kept] != kept) continue;
            const Vec3 between = positions[kept] - positions[vertex];
            const double apart = std::hypot(between.x(), between.y(), between.z());
            if (apart > nearest || (apart == nearest && one != vertex)) continue;
            nearest = apart;
            one = kept;
        }
        becomes.push_back(one);
    }
    return becomes;
}

TEST(NearVertices, AgreesWithComparingAllPairs)
{
    std::size_t joined = 0;
    for (std::uint32_t seed = 0; seed < 400; ++seed) {
        SCOPED_TRACE(seed);
        std::mt19937 random(seed);
        const double scale = std::ldexp(1.0, static_cast<int>(below(random, 2000)) - 1000);
        const double offset =
            below(random, 2) == 0 ? 0 : scale * std::ldexp(1.0, 1 + below(random, 54));
        const bool on_grid = below(random, 2) == 0;
        std::uniform_real_distribution<double> any(-4, 4);
        std::vector<Vec3> positions;
        for (int i = 0; i < 120; ++i) {
            Vec3 position(any(random), any(random), any(random));
            if (on_grid) position = position.array().round(); // many at exactly the distance
            positions.push_back(scale * position + Vec3(offset, 0, -offset));
        }
        const double distance = scale * (on_grid ? 1.0 : 0.9);
        const std::vector<std::uint8_t> all(positions.size(), 1);
        const auto becomes = near_vertices(positions, all, distance, nullptr);
        ASSERT_TRUE(becomes);
        EXPECT_EQ(*becomes, slowly_near(positions, distance));
        for (std::uint32_t i = 0; i < becomes->size(); ++i) joined += (*becomes)[i] != i ? 1 : 0;
    }
    EXPECT_GT(joined, 2000U);
}

} // namespace
} // namespace proxima::near_vertices_test
