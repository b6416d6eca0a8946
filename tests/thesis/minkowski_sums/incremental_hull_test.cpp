#include "thesis/minkowski_sums/incremental_hull.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <random>

namespace proxima::incremental_hull_test {
namespace {

using Points = std::vector<Vec3>;

/// A closed surface of Euler characteristic 2 that holds all points and has only them as corners.
void expect_convex_hull(const std::vector<HullFace<double>>& faces, const Points& points,
                        double tolerance)
{
    std::map<std::pair<int, int>, int> sides;
    std::vector<int> corners;
    for (const auto& face : faces) {
        for (std::size_t i = 0; i < 3; ++i) {
            ++sides[{face.vertices[i], face.vertices[(i + 1) % 3]}];
            corners.push_back(face.vertices[i]);
        }
        for (const Vec3& point : points) {
            EXPECT_LE(face.normal.dot(point) - face.offset, tolerance * face.normal.norm());
        }
    }
    for (const auto& [side, count] : sides) {
        EXPECT_EQ(count, 1);
        EXPECT_EQ(sides.count({side.second, side.first}), 1U);
    }
    std::ranges::sort(corners);
    corners.erase(std::unique(corners.begin(), corners.end()), corners.end());
    const auto edges = static_cast<int>(sides.size()) / 2;
    EXPECT_EQ(static_cast<int>(corners.size()) - edges + static_cast<int>(faces.size()), 2);
}

TEST(IncrementalHull, IsExactForIntegerPoints)
{
    for (unsigned seed = 0; seed < 2000; ++seed) {
        SCOPED_TRACE(seed);
        std::mt19937 random(seed);
        // Few values each: many duplicate, collinear and coplanar points.
        std::uniform_int_distribution<int> coordinate(0, seed % 2 == 0 ? 2 : 9);
        Points points(4 + seed % 28);
        for (Vec3& point : points) {
            point = Eigen::Vector3i{coordinate(random), coordinate(random), coordinate(random)}
                        .cast<double>();
        }
        const auto faces = incremental_hull<double>(points);
        if (faces) {
            expect_convex_hull(*faces, points, 0);
        } else {
            // All points coplanar: every quadruple has no volume.
            for (const Vec3& a : points) {
                for (const Vec3& b : points) {
                    for (const Vec3& c : points) {
                        EXPECT_EQ((a - points[0]).cross(b - points[0]).dot(c - points[0]), 0);
                    }
                }
            }
        }
    }
}

TEST(IncrementalHull, ContainsRandomPoints)
{
    for (unsigned seed = 0; seed < 500; ++seed) {
        SCOPED_TRACE(seed);
        std::mt19937 random(seed);
        std::uniform_real_distribution<double> coordinate(-1, 1);
        Points points(5 + seed % 60);
        for (Vec3& point : points) {
            point = Vec3{coordinate(random), coordinate(random), coordinate(random)};
        }
        const auto faces = incremental_hull<double>(points);
        ASSERT_TRUE(faces);
        expect_convex_hull(*faces, points, 1e-13);
    }
}

TEST(IncrementalHull, RefusesFlatSets)
{
    EXPECT_FALSE(incremental_hull<double>(Points{}));
    EXPECT_FALSE(incremental_hull<double>(Points(7, Vec3(1, 2, 3))));
    EXPECT_FALSE(incremental_hull<double>(Points{{0, 0, 0}, {1, 1, 1}, {2, 2, 2}, {5, 5, 5}}));
    EXPECT_FALSE(incremental_hull<double>(
        Points{{0.1, 0, 0.3}, {1.7, 0, 0.2}, {0.9, 0, 2.5}, {5, 0, 5}, {-2, 0, 7}}));
}

} // namespace
} // namespace proxima::incremental_hull_test
