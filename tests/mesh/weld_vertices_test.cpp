#include "mesh/weld_vertices.h"

#include <bit>
#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <random>

namespace proxima::weld_vertices_test {
namespace {

bool same(const Vec3& a, const Vec3& b)
{
    for (int axis = 0; axis < 3; ++axis) {
        const bool equal = a[axis] == b[axis] || std::bit_cast<std::uint64_t>(a[axis]) ==
                                                     std::bit_cast<std::uint64_t>(b[axis]);
        if (!equal) return false;
    }
    return true;
}

TEST(WeldVertices, AgreesWithComparingAllPairs)
{
    const double values[] = {0.0,
                             -0.0,
                             1.0,
                             5e-324,
                             std::nextafter(1.0, 2.0),
                             std::nan(""),
                             std::numeric_limits<double>::infinity()};
    for (std::uint64_t seed = 0; seed < 200; ++seed) {
        SCOPED_TRACE(seed);
        std::mt19937_64 random(seed);
        const auto any = [&] { return values[random() % std::size(values)]; };
        std::vector<Vec3> positions;
        std::vector<TriangleCorners> triangles;
        const std::size_t count = 1 + random() % 60;
        for (std::size_t i = 0; i < count; ++i) positions.emplace_back(any(), any(), any());
        const auto vertex = [&] { return static_cast<std::uint32_t>(random() % count); };
        triangles.reserve(40);
        for (int i = 0; i < 40; ++i) triangles.push_back({vertex(), vertex(), vertex()});

        std::vector<Vec3> expected;
        std::vector<std::uint32_t> new_ids;
        for (const Vec3& position : positions) {
            std::uint32_t id = 0;
            while (id < expected.size() && !same(expected[id], position)) ++id;
            if (id == expected.size()) expected.push_back(position);
            new_ids.push_back(id);
        }
        auto expected_triangles = triangles;
        for (auto& corners : expected_triangles) {
            for (auto& corner : corners) corner = new_ids[corner];
        }

        ASSERT_TRUE(weld_vertices(positions, triangles));
        EXPECT_EQ(triangles, expected_triangles);
        ASSERT_EQ(positions.size(), expected.size());
        for (std::size_t i = 0; i < expected.size(); ++i) {
            for (int axis = 0; axis < 3; ++axis) { // the first one's own bits
                EXPECT_EQ(std::bit_cast<std::uint64_t>(positions[i][axis]),
                          std::bit_cast<std::uint64_t>(expected[i][axis]));
            }
        }
    }
}

TEST(WeldVertices, AcceptsAnEmptyMesh)
{
    std::vector<Vec3> positions;
    std::vector<TriangleCorners> triangles;
    EXPECT_TRUE(weld_vertices(positions, triangles));
    EXPECT_TRUE(positions.empty());
    EXPECT_GT(weld_scratch_bytes(1'000'000), 4'000'000U);
}

} // namespace
} // namespace proxima::weld_vertices_test
