// Distances and slabs of one triangle against closest_point(), and means of linear bounds against sums.
#include "query/deviation/row_triangle.h"

#include "geometry/closest_point.h"
#include "query/deviation/mean_search.h"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <random>
#include <string>

namespace proxima::row_triangle_test {
namespace {

class RandomTriangles {
public:
    explicit RandomTriangles(std::uint64_t seed) : random_(seed) {}

    Vec3 point(double size)
    {
        std::uniform_real_distribution<double> unit(-size, size);
        return {unit(random_), unit(random_), unit(random_)};
    }
    /// Of any shape: also slivers, needles, segments and points.
    Triangle triangle()
    {
        Triangle triangle{{point(1), point(1), point(1)}};
        const double thin = std::pow(10.0, -static_cast<double>(random_() % 12));
        switch (random_() % 5) {
        case 0:
            triangle.vertices[2] = triangle[0] + thin * (triangle[2] - triangle[0]);
            break;
        case 1:
            triangle.vertices[2] =
                triangle[0] + 0.3 * (triangle[1] - triangle[0]) + thin * point(1);
            break;
        case 2:
            if (random_() % 4 == 0) triangle.vertices[2] = triangle.vertices[random_() % 2];
            break;
        case 3:
            for (Vec3& corner : triangle.vertices) corner = thin * corner;
            break;
        default:
            break;
        }
        return triangle;
    }

private:
    std::mt19937_64 random_;
};

TEST(RowTriangle, BoundsDistancesFromBothSides)
{
    for (std::uint64_t seed = 1; seed <= 4000; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        RandomTriangles random(seed);
        const Triangle triangle = random.triangle();
        const Vec3 origin = random.point(0.5);
        const RowTriangle row(triangle, origin, 7, {1, 2, 3});
        constexpr double slack = 1e-14;
        for (int i = 0; i < 8; ++i) {
            const Vec3 world = i == 0   ? triangle.vertices[seed % 3]
                               : i == 1 ? Vec3(0.5 * (triangle[0] + triangle[1]))
                                        : random.point(i < 5 ? 1.0 : 2.0);
            const Vec3 p = world - origin;
            const double truth = (closest_point(triangle, world).point - world).norm();
            const TriangleFoot foot = row.foot(p);
            // The distance of some point of the triangle, and here of the closest.
            EXPECT_GE(foot.distance, truth - slack);
            EXPECT_NEAR(foot.distance, truth, 1e-7);
            EXPECT_EQ(foot.distance, row.distance(p));
            for (int j = 0; j < 4; ++j) {
                const Vec3 other = random.point(2.0);
                const double there = (closest_point(triangle, other).point - other).norm();
                EXPECT_LE(foot.below(other - origin), there + slack);
                EXPECT_LE(row.slab(random.point(1)).below(other - origin), there + slack);
            }
            EXPECT_LE(foot.below(p), truth + slack);
        }
    }
}

TEST(RowTriangle, TouchesWhatItBoundsWhereTheFootIs)
{
    const Triangle triangle{{Vec3(0, 0, 0), Vec3(4, 0, 0), Vec3(0, 4, 0)}};
    const RowTriangle row(triangle, Vec3::Zero(), 0, {0, 1, 2});
    for (const Vec3& p : {Vec3(1, 1, 2), Vec3(1, 1, -2), Vec3(-1, -1, 1), Vec3(2, -3, 1),
                          Vec3(3, 3, 0.5), Vec3(9, -1, 0)}) {
        const TriangleFoot foot = row.foot(p);
        EXPECT_NEAR(foot.below(p), foot.distance, 1e-14);
        EXPECT_NEAR(foot.height, p.z(), 1e-15);
    }
    // Inward vectors point from each side to the third corner.
    for (std::size_t side = 0; side < 3; ++side) {
        EXPECT_GT(row.inward(side).dot(triangle.vertices[(side + 2) % 3] - triangle.vertices[side]),
                  0);
        EXPECT_NEAR(
            row.inward(side).dot(triangle.vertices[(side + 1) % 3] - triangle.vertices[side]), 0,
            1e-14);
    }
}

TEST(MeanBounds, AreThoseOfLinearBounds)
{
    std::mt19937_64 random(5);
    std::uniform_real_distribution<double> unit(-1, 1);
    for (int round = 0; round < 200; ++round) {
        CornerValues below{unit(random), unit(random), unit(random)};
        if (round % 5 == 0) below[static_cast<std::size_t>(round % 3)] = 0;
        CornerValues above{};
        for (std::size_t k = 0; k < 3; ++k)
            above[k] = std::max(below[k], 0.0) + std::abs(unit(random));
        const MeanBounds mean = mean_bounds(above, below);
        // Midpoints of a grid of triangles; the linear function is 0 where it is negative.
        constexpr int n = 400;
        double sum = 0;
        double squares = 0;
        double upper = 0;
        double upper_squares = 0;
        const auto add = [&](double s, double t) {
            const auto at = [&](const CornerValues& values) {
                return values[0] + s * (values[1] - values[0]) + t * (values[2] - values[0]);
            };
            const double low = std::max(at(below), 0.0);
            sum += low;
            squares += low * low;
            upper += at(above);
            upper_squares += at(above) * at(above);
        };
        for (int i = 0; i < n; ++i) {
            for (int j = 0; i + j < n; ++j) {
                add((i + 1.0 / 3) / n, (j + 1.0 / 3) / n);
                if (i + j + 1 < n) add((i + 2.0 / 3) / n, (j + 2.0 / 3) / n);
            }
        }
        constexpr double count = n * n;
        EXPECT_NEAR(mean.lower, sum / count, 1e-5);
        EXPECT_NEAR(mean.squares_lower, squares / count, 1e-5);
        EXPECT_NEAR(mean.upper, upper / count, 1e-9);
        EXPECT_NEAR(mean.squares_upper, upper_squares / count, 1e-5);
    }
}

} // namespace
} // namespace proxima::row_triangle_test
