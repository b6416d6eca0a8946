// Depths and distances of triangles and boxes against 113-bit numbers over all axes and features,
// and against the exact overlap test: the motion returned frees, a shorter one does not.
#include "minkowski/triangle_cube_proximity.h"

#include "geometry/triangle_box.h"
#include "oracles/integer_overlap.h"
#include "oracles/quad_distance.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace proxima {
namespace {

using oracle::Quad;
using oracle::QuadPoint;
using oracle::root;

struct Pair {
    Triangle triangle;
    Box box;
};

Vec3 to_vec(const oracle::Point& point)
{
    return {static_cast<double>(point[0]), static_cast<double>(point[1]),
            static_cast<double>(point[2])};
}

/// Whole pairs that touch, nearly touch and degenerate; general ones; boxes flat in places.
Pair make_pair(unsigned seed)
{
    if (seed % 2 == 0) {
        oracle::PairGenerator generate(seed, seed % 4 == 0 ? 8 : 1000);
        const oracle::IntegerPair whole = generate();
        Pair pair;
        for (std::size_t i = 0; i < 3; ++i)
            pair.triangle.vertices[i] = to_vec(whole.triangle.vertices[i]);
        pair.box = {to_vec(whole.box.lower), to_vec(whole.box.upper)};
        return pair;
    }
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> coordinate(-1, 1);
    const auto point = [&] {
        return Vec3{coordinate(random), coordinate(random), coordinate(random)};
    };
    Pair pair;
    // Small triangles in large boxes, the other way round, and in between.
    const double size = std::pow(10.0, std::uniform_real_distribution<double>(-3, 2)(random));
    const Vec3 middle = 1.5 * point();
    for (Vec3& vertex : pair.triangle.vertices) vertex = middle + size * point();
    pair.box.extend(point());
    pair.box.extend(point());
    return pair;
}

double size_of(const Pair& pair)
{
    Box both = pair.box;
    for (const Vec3& vertex : pair.triangle.vertices) both.extend(vertex);
    return both.extent().maxCoeff();
}

/// Width over length: how far from a segment the triangle is.
double slenderness(const Triangle& triangle)
{
    double longest = 0;
    for (int i = 0; i < 3; ++i)
        longest = std::max(longest, (triangle[(i + 1) % 3] - triangle[i]).norm());
    return longest > 0 ? scaled_normal(triangle).norm() / (longest * longest) : 0;
}

Triangle moved(const Triangle& triangle, const Vec3& by)
{
    Triangle result = triangle;
    for (Vec3& vertex : result.vertices) vertex += by;
    return result;
}

constexpr double tolerance = 1e-14; // of the size

TEST(TriangleCubePenetration, IsTheLeastOverAllAxes)
{
    int overlapping = 0;
    for (unsigned seed = 0; seed < 40000; ++seed) {
        SCOPED_TRACE(seed);
        const Pair pair = make_pair(seed);
        const auto found = penetration(pair.triangle, pair.box);
        ASSERT_EQ(found.has_value(), triangle_overlaps_box(pair.triangle, pair.box));
        if (!found) continue;
        ++overlapping;
        long double least = std::numeric_limits<long double>::infinity();
        for (const oracle::QuadMotion& motion : oracle::motions(pair.triangle, pair.box)) {
            const long double length = root(oracle::dot(motion.direction, motion.direction));
            least = std::min(least, static_cast<long double>(motion.motion) / length);
        }
        EXPECT_NEAR(found->depth, static_cast<double>(least), tolerance * size_of(pair));
        EXPECT_NEAR(found->direction.norm(), 1, 1e-15);
    }
    EXPECT_GT(overlapping, 10000);
}

TEST(TriangleCubePenetration, FreesTheTriangleAndNoShorterMotionDoes)
{
    for (unsigned seed = 0; seed < 20000; ++seed) {
        SCOPED_TRACE(seed);
        const Pair pair = make_pair(seed);
        const auto found = penetration(pair.triangle, pair.box);
        if (!found) continue;
        const double slack = 2 * tolerance * (size_of(pair) + 3);
        const Vec3 beyond = (found->depth + slack) * found->direction;
        EXPECT_FALSE(triangle_overlaps_box(moved(pair.triangle, beyond), pair.box));
        if (found->depth < slack) continue;
        const double shorter = found->depth - slack;
        EXPECT_TRUE(
            triangle_overlaps_box(moved(pair.triangle, shorter * found->direction), pair.box));
        std::mt19937 random(seed);
        std::normal_distribution<double> normal;
        for (int i = 0; i < 10; ++i) { // nor along any other direction
            const Vec3 direction =
                Vec3{normal(random), normal(random), normal(random)}.normalized();
            EXPECT_TRUE(triangle_overlaps_box(moved(pair.triangle, shorter * direction), pair.box));
        }
    }
}

TEST(TriangleCubePenetration, AlongADirectionEndsWhereTheExactTestSays)
{
    int checked = 0;
    for (unsigned seed = 0; seed < 20000; ++seed) {
        SCOPED_TRACE(seed);
        const Pair pair = make_pair(seed);
        std::mt19937 random(seed);
        std::normal_distribution<double> normal;
        Vec3 direction = Vec3{normal(random), normal(random), normal(random)};
        if (seed % 5 == 0)
            direction = Vec3::Unit(static_cast<int>(seed % 3)) * (seed % 2 == 0 ? 3 : -3);
        const auto depth = penetration_along(pair.triangle, pair.box, direction);
        ASSERT_EQ(depth.has_value(), triangle_overlaps_box(pair.triangle, pair.box));
        if (!depth) continue;

        const double size = size_of(pair);
        const Vec3 along = direction.normalized();
        long double least = std::numeric_limits<long double>::infinity();
        long double condition = 1;
        for (const oracle::QuadMotion& motion : oracle::motions(pair.triangle, pair.box)) {
            const auto length = root(oracle::dot(motion.direction, motion.direction));
            const auto progress =
                static_cast<long double>(oracle::dot(motion.direction, along)) / length;
            if (progress < 1e-9L) continue; // hardly leaves there: the answer is not well posed
            const auto value = static_cast<long double>(motion.motion) / length / progress;
            if (value < least) {
                least = value;
                condition = 1 / progress;
            }
        }
        const auto slack = 4 * tolerance * (size + 3 + *depth) * static_cast<double>(condition);
        if (slack > 1e-6 * size) continue;
        ++checked;
        EXPECT_NEAR(*depth, static_cast<double>(least), slack);
        EXPECT_FALSE(
            triangle_overlaps_box(moved(pair.triangle, (*depth + slack) * along), pair.box));
        if (*depth > slack) {
            const Triangle less = moved(pair.triangle, (*depth - slack) * along);
            EXPECT_TRUE(triangle_overlaps_box(less, pair.box));
        }
    }
    EXPECT_GT(checked, 5000);
}

TEST(TriangleCubePenetration, NeedlesAreFreedNearlyAsCheaplyAsSegments)
{
    for (unsigned seed = 0; seed < 20000; ++seed) {
        SCOPED_TRACE(seed);
        Pair pair = make_pair(2 * seed + 1);
        std::mt19937 random(seed);
        const double width =
            std::pow(10.0, std::uniform_real_distribution<double>(-17, -3)(random));
        auto& v = pair.triangle.vertices;
        const double t = std::uniform_real_distribution<double>(0, 1)(random);
        v[2] = v[0] + t * (v[1] - v[0]) + width * (v[2] - v[0]);
        const auto found = penetration(pair.triangle, pair.box);
        if (!found) continue;
        long double least = std::numeric_limits<long double>::infinity();
        for (const oracle::QuadMotion& motion : oracle::motions(pair.triangle, pair.box)) {
            const auto length = root(oracle::dot(motion.direction, motion.direction));
            least = std::min(least, static_cast<long double>(motion.motion) / length);
        }
        const double size = size_of(pair);
        const double slender = slenderness(pair.triangle);
        const double w = slender * size;
        const double bound =
            tolerance * size + std::min(w, slender > 0 ? 2e-15 / slender * size : 0.0);
        EXPECT_GE(found->depth, static_cast<double>(least) - tolerance * size);
        EXPECT_LE(found->depth, static_cast<double>(least) + bound);
        const Vec3 beyond = (found->depth + 2 * tolerance * (size + 3)) * found->direction;
        EXPECT_FALSE(triangle_overlaps_box(moved(pair.triangle, beyond), pair.box));
    }
}

TEST(TriangleCubeSeparation, IsTheDistanceOfTheClosestFeatures)
{
    int apart = 0;
    for (unsigned seed = 0; seed < 8000; ++seed) {
        SCOPED_TRACE(seed);
        const Pair pair = make_pair(seed);
        const TriangleBoxSeparation found = separation(pair.triangle, pair.box);
        const double size = size_of(pair);
        EXPECT_TRUE(pair.box.contains(found.on_box));
        EXPECT_LE(root(oracle::squared_distance(found.on_triangle, pair.triangle)),
                  tolerance * (size + 3));
        if (triangle_overlaps_box(pair.triangle, pair.box)) {
            EXPECT_EQ(found.distance, 0);
            EXPECT_EQ(found.on_triangle, found.on_box);
            continue;
        }
        ++apart;
        const auto expected =
            static_cast<double>(root(oracle::squared_distance(pair.triangle, pair.box)));
        EXPECT_NEAR(found.distance, expected, tolerance * size);
        EXPECT_NEAR((found.on_triangle - found.on_box).norm(), expected, tolerance * (size + 3));

        // A plane across the gap proves that nothing is closer.
        if (expected < 1e-3 * size) continue;
        const Vec3 across = (found.on_triangle - found.on_box) / found.distance;
        for (const Vec3& vertex : pair.triangle.vertices)
            EXPECT_GE(across.dot(vertex - found.on_triangle), -1e-11 * size);
        for (int corner = 0; corner < 8; ++corner)
            EXPECT_LE(across.dot(oracle::box_corner(pair.box, corner) - found.on_box),
                      1e-11 * size);
    }
    EXPECT_GT(apart, 4000);
}

TEST(TriangleCubeProximity, SizesAndPlacesDoNotMatter)
{
    for (unsigned seed = 0; seed < 4000; ++seed) {
        SCOPED_TRACE(seed);
        const Pair pair = make_pair(seed);
        const auto plain = penetration(pair.triangle, pair.box);
        const TriangleBoxSeparation plain_gap = separation(pair.triangle, pair.box);
        for (const int exponent : {-960, -600, 200, 1000}) {
            const double factor = std::ldexp(1.0, exponent);
            Pair scaled = pair;
            for (Vec3& vertex : scaled.triangle.vertices) vertex *= factor;
            scaled.box = {factor * pair.box.lower, factor * pair.box.upper};
            const auto found = penetration(scaled.triangle, scaled.box);
            ASSERT_EQ(found.has_value(), plain.has_value());
            if (found) {
                EXPECT_EQ(found->depth, factor * plain->depth);
                EXPECT_EQ(found->direction, plain->direction);
            }
            const TriangleBoxSeparation gap = separation(scaled.triangle, scaled.box);
            EXPECT_EQ(gap.distance, factor * plain_gap.distance);
            EXPECT_EQ(gap.on_triangle, factor * plain_gap.on_triangle);
        }
    }
    // All in a plane that is far out: only that coordinate is large.
    const double far = 1e300;
    const Box box = {{0, 0, far}, {1, 1, far}};
    const Triangle triangle = {{Vec3(0.25, 0.5, far), Vec3(9, 0, far), Vec3(9, 1, far)}};
    EXPECT_EQ(penetration(triangle, box)->depth, 0);
    EXPECT_EQ(penetration_along(triangle, box, Vec3(2, 0, 0)), 0.75);
    const Triangle beside = moved(triangle, {2, 0, 0});
    EXPECT_EQ(separation(beside, box).distance, 1.25);
}

TEST(TriangleCubeProximity, KnowsSimpleCases)
{
    const Box box = {{0, 0, 0}, {4, 2, 6}};
    const auto point = [](double x, double y, double z) {
        return Triangle{{Vec3(x, y, z), Vec3(x, y, z), Vec3(x, y, z)}};
    };
    const auto inside = penetration(point(1, 1.5, 3), box);
    EXPECT_EQ(inside->depth, 0.5);
    EXPECT_EQ(inside->direction, Vec3(0, 1, 0));
    EXPECT_EQ(penetration_along(point(1, 1.5, 3), box, {-2, 0, 0}), 1);
    EXPECT_EQ(penetration(point(0, 1, 3), box)->depth, 0);
    EXPECT_FALSE(penetration(point(-1, 1, 3), box).has_value());
    EXPECT_FALSE(penetration_along(point(-1, 1, 3), box, {1, 0, 0}).has_value());
    const TriangleBoxSeparation gap = separation(point(-3, 6, 3), box);
    EXPECT_EQ(gap.distance, 5);
    EXPECT_EQ(gap.on_box, Vec3(0, 2, 3));
    EXPECT_EQ(gap.on_triangle, Vec3(-3, 6, 3));
    // A large triangle through which the box sticks is pushed along its own normal.
    const Triangle slice = {{Vec3(-50, -50, 5), Vec3(50, -50, 5), Vec3(0, 90, 5)}};
    EXPECT_EQ(penetration(slice, box)->depth, 1);
    EXPECT_EQ(penetration(slice, box)->direction, Vec3(0, 0, 1));
    EXPECT_EQ(separation(slice, box).on_box.z(), 5);
}

} // namespace
} // namespace proxima
