#include "mesh/triangulate_polygon.h"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <numeric>
#include <random>
#include <set>

namespace proxima::triangulate_polygon_test {
namespace {

std::vector<std::uint32_t> all_corners(std::size_t count)
{
    std::vector<std::uint32_t> corners(count);
    std::iota(corners.begin(), corners.end(), 0U);
    return corners;
}

std::vector<TriangleCorners> triangulate(const std::vector<Vec3>& positions)
{
    std::vector<TriangleCorners> triangles(positions.size() - 2);
    PolygonTriangulator triangulator;
    EXPECT_TRUE(triangulator.triangulate(all_corners(positions.size()), positions, triangles));
    return triangles;
}

Vec3 doubled_area(const std::vector<Vec3>& p)
{
    Vec3 area = Vec3::Zero();
    for (std::size_t i = 0; i < p.size(); ++i) area += p[i].cross(p[(i + 1) % p.size()]);
    return area;
}

// Triangles of one orientation whose borders add up to the polygon's cover each point as often as
// the polygon winds around it: exactly once inside a simple polygon, and never outside.
void expect_cover(const std::vector<Vec3>& positions, const std::vector<TriangleCorners>& triangles)
{
    const Vec3 area = doubled_area(positions);
    std::multiset<std::pair<std::uint32_t, std::uint32_t>> edges;
    for (const TriangleCorners& t : triangles) {
        const Vec3 normal = scaled_normal({{positions[t[0]], positions[t[1]], positions[t[2]]}});
        EXPECT_GT(normal.dot(area), -1e-12 * area.squaredNorm())
            << t[0] << " " << t[1] << " " << t[2];
        for (std::size_t i = 0; i < 3; ++i) {
            const auto opposite = edges.find({t[(i + 1) % 3], t[i]});
            if (opposite != edges.end()) {
                edges.erase(opposite);
            } else {
                edges.insert({t[i], t[(i + 1) % 3]});
            }
        }
    }
    const auto count = static_cast<std::uint32_t>(positions.size());
    ASSERT_EQ(edges.size(), count);
    for (std::uint32_t i = 0; i < count; ++i) EXPECT_TRUE(edges.count({i, (i + 1) % count}));
}

TEST(TriangulatePolygon, FansConvexPolygons)
{
    std::vector<Vec3> positions;
    positions.reserve(9);
    for (int i = 0; i < 9; ++i) positions.emplace_back(std::cos(0.7 * i), std::sin(0.7 * i), 3);
    const auto triangles = triangulate(positions);
    for (std::uint32_t i = 0; i < 7; ++i) {
        EXPECT_EQ(triangles[i], (TriangleCorners{0, i + 1, i + 2}));
    }
}

TEST(TriangulatePolygon, CutsAnArrowAlongItsInnerDiagonalFromEveryStart)
{
    const std::vector<Vec3> arrow{{0, 0, 0}, {2, 1, 0}, {0, 2, 0}, {0.5, 1, 0}};
    for (std::size_t start = 0; start < 4; ++start) {
        std::vector<Vec3> turned = arrow;
        std::rotate(turned.begin(), turned.begin() + static_cast<std::ptrdiff_t>(start),
                    turned.end());
        expect_cover(turned, triangulate(turned));
        std::ranges::reverse(turned);
        expect_cover(turned, triangulate(turned));
    }
}

TEST(TriangulatePolygon, CutsAnArrowOfAnySize)
{
    for (std::size_t start = 0; start < 4; ++start) {
        std::vector<Vec3> arrow{{0, 0, 0}, {2, 1, 0}, {0, 2, 0}, {0.5, 1, 0}};
        std::rotate(arrow.begin(), arrow.begin() + static_cast<std::ptrdiff_t>(start), arrow.end());
        const auto usual = triangulate(arrow);
        for (const int exponent : {-1040, -700, -560, -210, 210, 560, 660, 1020}) {
            std::vector<Vec3> scaled;
            for (const Vec3& p : arrow) {
                scaled.emplace_back(std::ldexp(p.x(), exponent), std::ldexp(p.y(), exponent),
                                    std::ldexp(1.0, exponent));
            }
            EXPECT_EQ(triangulate(scaled), usual) << exponent;
        }
    }
}

// Star-shaped around the origin, so simple, with spikes; in a random plane far from the origin.
TEST(TriangulatePolygon, CoversRandomConcavePolygonsOnce)
{
    for (std::uint64_t seed = 0; seed < 500; ++seed) {
        SCOPED_TRACE(seed);
        std::mt19937_64 random(seed);
        std::uniform_real_distribution<double> unit(0.05, 1);
        const auto count = static_cast<int>(4 + random() % 40);
        const Eigen::Quaterniond rotation{unit(random), unit(random), unit(random), unit(random)};
        const Eigen::Matrix3d axes = rotation.normalized().toRotationMatrix();
        std::vector<Vec3> positions;
        for (int i = 0; i < count; ++i) {
            const double angle = (i + 0.8 * unit(random)) * 2 * M_PI / count;
            const double radius = unit(random);
            const Vec3 flat(radius * std::cos(angle), radius * std::sin(angle), 0);
            positions.emplace_back(axes * flat + Vec3(10, -20, 30));
        }
        expect_cover(positions, triangulate(positions));
    }
}

// A comb and a spiral are not star-shaped.
TEST(TriangulatePolygon, CoversCombsAndSpirals)
{
    std::vector<Vec3> comb{{0, -1, 0}};
    for (int i = 0; i < 50; ++i) {
        comb.emplace_back(2 * i + 0.5, i % 3 + 1.0, 0);
        comb.emplace_back(2 * i + 1.5, -0.5, 0);
    }
    comb.emplace_back(101, -1, 0);
    expect_cover(comb, triangulate(comb));
    std::ranges::reverse(comb);
    expect_cover(comb, triangulate(comb));

    std::vector<Vec3> spiral;
    for (int i = 0; i <= 120; ++i) {
        spiral.emplace_back((i + 10) * std::cos(0.2 * i), (i + 10) * std::sin(0.2 * i), 0);
    }
    for (int i = 120; i >= 0; --i) {
        spiral.emplace_back((i + 5) * std::cos(0.2 * i), (i + 5) * std::sin(0.2 * i), 0);
    }
    expect_cover(spiral, triangulate(spiral));
}

// A square with a square hole, both joined by a bridge that is walked twice.
TEST(TriangulatePolygon, CoversAPolygonWithABridgeToItsHole)
{
    const std::vector<Vec3> ring{{0, 0, 0}, {4, 0, 0}, {4, 4, 0}, {0, 4, 0}, {0, 0, 0},
                                 {1, 1, 0}, {1, 3, 0}, {3, 3, 0}, {3, 1, 0}, {1, 1, 0}};
    const auto triangles = triangulate(ring);
    double area = 0;
    for (const TriangleCorners& t : triangles) {
        const double part = scaled_normal({{ring[t[0]], ring[t[1]], ring[t[2]]}}).z();
        EXPECT_GE(part, 0);
        area += part;
    }
    EXPECT_EQ(area, 2 * (16 - 4));
}

TEST(TriangulatePolygon, GivesAllTrianglesOfInvalidPolygons)
{
    const double nan = std::nan("");
    const std::vector<std::vector<Vec3>> polygons{
        {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}, {4, 0, 0}},    // a line
        {{1, 1, 1}, {1, 1, 1}, {1, 1, 1}, {1, 1, 1}},               // a point
        {{0, 0, 0}, {1, 1, 0}, {1, 0, 0}, {0, 1, 0}},               // a bow tie without area
        {{0, 0, 0}, {3, 3, 0}, {3, 0, 0}, {0, 2, 0}, {-1, 7, 0}},   // crossing itself
        {{0, 0, 0}, {1, 0, nan}, {1, 1, 0}, {0, 1, 0}},             // not a number
        {{0, 0, 0}, {1e300, 0, 0}, {1e300, 1e300, 0}, {0, 1e9, 0}}, // overflows
        {{0, 0, 0}, {2, 0, 0}, {2, 0, 0}, {2, 2, 0}, {1, 0.5, 0}},  // a repeated corner
    };
    for (const std::vector<Vec3>& polygon : polygons) {
        const auto triangles = triangulate(polygon);
        std::set<std::uint32_t> used;
        for (const TriangleCorners& t : triangles) {
            EXPECT_EQ((std::set<std::uint32_t>{t[0], t[1], t[2]}.size()), 3U);
            used.insert(t.begin(), t.end());
        }
        EXPECT_EQ(used.size(), polygon.size());
    }
}

TEST(TriangulatePolygon, RefusesLargeConcavePolygonsOnly)
{
    constexpr std::size_t count = max_concave_corners + 2;
    std::vector<Vec3> positions;
    for (std::size_t i = 0; i < count; ++i) {
        const double angle = 2 * M_PI * static_cast<double>(i) / count;
        positions.emplace_back(std::cos(angle), std::sin(angle), 0);
    }
    std::vector<TriangleCorners> triangles(count - 2);
    PolygonTriangulator triangulator;
    EXPECT_TRUE(triangulator.triangulate(all_corners(count), positions, triangles));
    positions[count / 2] *= 0.5;
    EXPECT_TRUE(triangulator.triangulate(all_corners(count), positions, triangles)); // still a fan
    positions[1] *= 0.5;
    EXPECT_FALSE(triangulator.triangulate(all_corners(count), positions, triangles));
}

} // namespace
} // namespace proxima::triangulate_polygon_test
