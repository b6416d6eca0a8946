#include "geometry/triangle_distance.h"

#include "geometry/triangle_contact.h"
#include "oracles/quad_distance.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace proxima::triangle_distance_test {
namespace {

using oracle::Quad;
using oracle::QuadPoint;
using oracle::root;

constexpr double tolerance = 2e-14; // of coordinates up to about 6

/// Of triangles that are apart: all pairs of sides, all corners.
Quad quad_squared_distance(const Triangle& a, const Triangle& b)
{
    Quad best = oracle::squared_distance(QuadPoint(a[0]), b);
    for (int i = 0; i < 3; ++i) {
        best = std::min({best, oracle::squared_distance(QuadPoint(a[i]), b),
                         oracle::squared_distance(QuadPoint(b[i]), a)});
        for (int k = 0; k < 3; ++k) {
            best = std::min(best, oracle::squared_distance(Segment{a[i], a[(i + 1) % 3]},
                                                           Segment{b[k], b[(k + 1) % 3]}));
        }
    }
    return best;
}

/// Pairs of all kinds: whole corners (touching, sharing, coplanar, degenerate), general ones,
/// slivers, one all but parallel to the other, one that only just passes through the other.
class Pairs {
public:
    explicit Pairs(unsigned seed) : random_(seed) {}

    struct Pair {
        Triangle a;
        Triangle b;
    };
    Pair operator()()
    {
        Pair pair = {triangle(), triangle()};
        switch (below(5)) {
        case 0: // beside it, turned by next to nothing
            for (int i = 0; i < 3; ++i) {
                pair.b.vertices[static_cast<std::size_t>(i)] =
                    pair.a[(i + below(2)) % 3] + nudge() + nudge();
            }
            break;
        case 1: // a corner or a side in common, or nearly
            pair.b.vertices[0] = pair.a[below(3)] + nudge();
            if (below(2) == 0) pair.b.vertices[1] = pair.a[below(3)] + nudge();
            break;
        case 2: { // a corner on the inside, or nearly
            const double s = below(5) / 8.0;
            const double t = below(5) / 8.0;
            pair.b.vertices[0] =
                pair.a[0] + s * (pair.a[1] - pair.a[0]) + t * (pair.a[2] - pair.a[0]) + nudge();
            break;
        }
        default:
            break;
        }
        return pair;
    }
    int below(int n) { return std::uniform_int_distribution<int>(0, n - 1)(random_); }

private:
    Vec3 point()
    {
        if (below(2) == 0) return {below(7) - 3.0, below(7) - 3.0, below(7) - 3.0};
        std::uniform_real_distribution<double> coordinate(-3, 3);
        const double x = coordinate(random_);
        const double y = coordinate(random_);
        return {x, y, coordinate(random_)};
    }
    Triangle triangle()
    {
        Triangle triangle = {{point(), point(), point()}};
        switch (below(6)) {
        case 0: // a sliver or needle, down to a segment
            triangle.vertices[2] =
                triangle[0] + below(5) / 4.0 * (triangle[1] - triangle[0]) + nudge();
            break;
        case 1: // tiny, down to a point
            triangle.vertices[1] = triangle[0] + nudge();
            triangle.vertices[2] = triangle[0] + nudge();
            break;
        default:
            break;
        }
        return triangle;
    }
    Vec3 nudge()
    {
        const double size = std::pow(10.0, -below(18));
        if (below(3) == 0) return Vec3::Zero();
        return size * point();
    }

    std::mt19937 random_;
};

/// The point is the corners' sum by the weights, which say which part it is on.
void expect_on(const TrianglePoint& point, const Triangle& triangle)
{
    EXPECT_LE(root(oracle::squared_distance(QuadPoint(point.point), triangle)), tolerance);
    Vec3 weighted = Vec3::Zero();
    const auto part = static_cast<std::size_t>(point.part);
    for (std::size_t i = 0; i < 3; ++i) {
        EXPECT_GE(point.weights[i], 0);
        weighted += point.weights[i] * triangle.vertices[i];
        const bool is_zero = part == 6 ? false : part < 3 ? i != part : i == (part - 3 + 2) % 3;
        EXPECT_EQ(point.weights[i] == 0, is_zero);
    }
    EXPECT_LE((weighted - point.point).norm(), tolerance);
}

TEST(TriangleDistance, AgreesWithAllPairsOfFeaturesInQuadPrecision)
{
    std::array<std::array<int, 7>, 7> parts = {};
    int meeting = 0;
    for (unsigned seed = 0; seed < 12000; ++seed) {
        SCOPED_TRACE(seed);
        Pairs pairs(seed);
        const auto [a, b] = pairs();
        const ClosestTrianglePoints closest = closest_points(a, b);
        expect_on(closest.first, a);
        expect_on(closest.second, b);
        const bool meet = triangles_meet(a, b);
        meeting += meet ? 1 : 0;
        EXPECT_EQ(closest.squared_distance == 0, meet);
        if (meet) {
            EXPECT_EQ(closest.first.point, closest.second.point);
            continue;
        }
        const long double expected = root(quad_squared_distance(a, b));
        EXPECT_NEAR(static_cast<double>(std::sqrt(closest.squared_distance) - expected), 0,
                    tolerance);
        EXPECT_NEAR((closest.first.point - closest.second.point).norm(),
                    std::sqrt(closest.squared_distance), tolerance);
        ++parts[static_cast<std::size_t>(closest.first.part)]
               [static_cast<std::size_t>(closest.second.part)];
    }
    EXPECT_GT(meeting, 1500);
    // Corners with all parts, sides with sides, insides with corners.
    for (std::size_t i = 0; i < 6; ++i) {
        for (std::size_t k = 0; k < 6; ++k) EXPECT_GT(parts[i][k], 15) << i << ' ' << k;
        if (i < 3) {
            EXPECT_GT(parts[i][6], 15);
            EXPECT_GT(parts[6][i], 15);
        }
    }
}

TEST(TriangleDistance, IsSymmetric)
{
    for (unsigned seed = 0; seed < 5000; ++seed) {
        SCOPED_TRACE(seed);
        Pairs pairs(seed);
        const auto [a, b] = pairs();
        const double one = std::sqrt(closest_points(a, b).squared_distance);
        const double other = std::sqrt(closest_points(b, a).squared_distance);
        EXPECT_NEAR(one, other, tolerance);
    }
}

TEST(TriangleDistance, IsNeverAboveTheDistanceOfSampledPoints)
{
    std::mt19937 random(7);
    std::uniform_real_distribution<double> unit(0, 1);
    const auto some_point = [&](const Triangle& t) {
        double u = unit(random);
        double v = unit(random);
        if (u + v > 1) u = 1 - u, v = 1 - v;
        return Vec3(t[0] + u * (t[1] - t[0]) + v * (t[2] - t[0]));
    };
    for (unsigned seed = 0; seed < 400; ++seed) {
        SCOPED_TRACE(seed);
        Pairs pairs(seed);
        const auto [a, b] = pairs();
        const double distance = std::sqrt(closest_points(a, b).squared_distance);
        for (int i = 0; i < 200; ++i)
            EXPECT_LE(distance, (some_point(a) - some_point(b)).norm() + tolerance);
    }
}

TEST(TriangleDistance, ScalesByPowersOfTwo)
{
    for (unsigned seed = 0; seed < 2000; ++seed) {
        SCOPED_TRACE(seed);
        Pairs pairs(seed);
        const auto [a, b] = pairs();
        const ClosestTrianglePoints closest = closest_points(a, b);
        for (const int power : {-80, 80}) {
            const auto scaled = [&](Triangle t) {
                for (Vec3& v : t.vertices) v *= std::ldexp(1.0, power);
                return t;
            };
            const ClosestTrianglePoints other = closest_points(scaled(a), scaled(b));
            if (closest.squared_distance > 1e-300) {
                EXPECT_EQ(other.squared_distance, std::ldexp(closest.squared_distance, 2 * power));
            }
            EXPECT_EQ(other.first.point, closest.first.point * std::ldexp(1.0, power));
        }
    }
}

TEST(TriangleDistance, DistinguishesADistanceOfOneBitFromZero)
{
    const Triangle floor = {{Vec3(-1, -1, 0.1), Vec3(3, -1, 0.1), Vec3(-1, 3, 0.1)}};
    const auto standing = [](double z) {
        return Triangle{{Vec3(0, 0, z), Vec3(0.3, 0.7, 5), Vec3(0.9, 0.1, 7)}};
    };
    EXPECT_EQ(closest_points(floor, standing(0.1)).squared_distance, 0);
    const double above = std::nextafter(0.1, 1.0);
    EXPECT_EQ(closest_points(floor, standing(above)).squared_distance,
              (above - 0.1) * (above - 0.1));
    EXPECT_EQ(closest_points(floor, standing(0.1 - 0.05)).squared_distance, 0);
}

} // namespace
} // namespace proxima::triangle_distance_test
