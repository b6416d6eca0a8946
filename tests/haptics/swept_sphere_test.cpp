#include "haptics/surface/swept_sphere.h"

#include "geometry/closest_point.h"
#include "geometry/exact_predicates.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <random>

namespace proxima::swept_sphere_test {
namespace {

constexpr double tolerance = 0x1p-42;

double distance(const Triangle& triangle, const Vec3& p)
{
    return (closest_point(triangle, p).point - p).norm();
}

/// By steps that are never longer than what is free: the distance is known to be right.
std::optional<double> time_by_steps(const Triangle& triangle, double radius, const Vec3& p,
                                    const Vec3& motion)
{
    double t = 0;
    while (t <= 1) {
        const double left = distance(triangle, p + t * motion) - radius;
        if (left < 1e-9) return t;
        t += left / motion.norm();
    }
    return std::nullopt;
}

TEST(SweptSphere, AgreesWithSmallSteps)
{
    int hits = 0;
    int misses = 0;
    for (std::uint32_t seed = 0; seed < 20000; ++seed) {
        std::mt19937 random(seed);
        std::uniform_real_distribution<double> place(-1, 1);
        const auto anywhere = [&] { return Vec3{place(random), place(random), place(random)}; };
        Triangle triangle{{anywhere(), anywhere(), anywhere()}};
        if (seed % 10 == 0) triangle.vertices[2] = triangle[0] + 0.3 * (triangle[1] - triangle[0]);
        if (seed % 30 == 0) triangle.vertices[1] = triangle.vertices[2] = triangle[0];
        const double radius = seed % 2 == 0 ? 0.3 : 0.01;
        const Vec3 p = 1.5 * anywhere();
        // Half of them about towards it.
        const Vec3 motion =
            seed % 4 < 2 ? Vec3(2 * anywhere()) : Vec3(triangle[0] - p + 0.4 * anywhere());
        if (distance(triangle, p) <= radius + 1e-6) continue;
        const auto t = touch_time(triangle, radius, p, motion, tolerance);
        const auto expected = time_by_steps(triangle, radius, p, motion);
        if (t) {
            EXPECT_NEAR(distance(triangle, p + *t * motion), radius, 1e-9) << "seed " << seed;
            // Steps stop a little early where the sphere all but grazes.
            ASSERT_TRUE(expected) << "seed " << seed;
            EXPECT_NEAR(*t, *expected, 2e-3) << "seed " << seed;
            EXPECT_GE(*t, *expected - 1e-9) << "seed " << seed;
            ++hits;
        } else {
            if (expected) {
                const double grazed = distance(triangle, p + *expected * motion);
                EXPECT_GT(grazed, radius - 1e-9) << "seed " << seed;
                for (int i = 0; i <= 1000; ++i)
                    EXPECT_GT(distance(triangle, p + i * 1e-3 * motion), radius - 1e-9) << seed;
            }
            ++misses;
        }
    }
    EXPECT_GT(hits, 2000);
    EXPECT_GT(misses, 2000);
}

TEST(SweptSphere, RejectsMotionsBeyondThePlaneOfTheTriangle)
{
    int beyond = 0;
    for (std::uint32_t seed = 0; seed < 20000; ++seed) {
        std::mt19937 random(seed);
        std::uniform_real_distribution<double> place(-1, 1);
        const auto anywhere = [&] { return Vec3{place(random), place(random), place(random)}; };
        Triangle triangle{{anywhere(), anywhere(), anywhere()}};
        if (seed % 5 == 0) { // a sliver
            triangle.vertices[2] = triangle[0] + 0.3 * (triangle[1] - triangle[0]) +
                                   std::pow(10.0, -16 * std::abs(place(random))) * anywhere();
        }
        const Vec3 normal = unit_normal(triangle);
        const double radius = seed % 2 == 0 ? 0.3 : 1e-9;
        // Along the plane, about as near as the radius; or anywhere.
        const Vec3 on = (triangle[0] + triangle[1] + triangle[2]) / 3;
        const double off = seed % 3 == 0 ? 1e-3 * place(random) : 0.0;
        const Vec3 p =
            seed % 4 == 0 ? Vec3(1.5 * anywhere()) : Vec3(on + (1 + off) * radius * normal);
        const Vec3 aside = anywhere();
        const Vec3 motion = seed % 4 == 0 ? aside : Vec3(aside - normal * normal.dot(aside));
        const TrianglePlane plane(triangle);
        if (plane.is_beyond(p, motion, radius)) {
            ++beyond;
            for (int i = 0; i <= 50; ++i)
                EXPECT_GT(distance(triangle, p + i * 0.02 * motion), radius - 1e-15) << seed;
            EXPECT_FALSE(touch_time(triangle, radius, p, motion, tolerance)) << seed;
        }
        // Gone along: no need to look closer.
        const bool plump = seed % 5 != 0 && scaled_normal(triangle).norm() > 0.1;
        if (seed % 4 == 1 && plump) {
            EXPECT_TRUE(plane.is_beyond(on + radius * normal, motion, 0.9 * radius)) << seed;
        }
    }
    EXPECT_GT(beyond, 2000);
}

// Spheres of many sizes that come upon triangles of many sizes, near and far from the origin.
TEST(SweptSphere, IsNotTouchedBeforeItsLowerBound)
{
    int told = 0;
    int close = 0;
    for (std::uint32_t seed = 0; seed < 40000; ++seed) {
        std::mt19937 random(seed);
        std::uniform_real_distribution<double> place(-1, 1);
        const auto anywhere = [&] { return Vec3{place(random), place(random), place(random)}; };
        const double size = std::pow(10.0, 3 * place(random));
        const double radius = size * std::pow(10.0, 2 + 3 * place(random));
        const Vec3 origin = seed % 3 == 0 ? Vec3(1e4 * size * anywhere()) : Vec3(Vec3::Zero());
        const Triangle triangle{
            {origin + size * anywhere(), origin + size * anywhere(), origin + size * anywhere()}};
        const Vec3 away = anywhere().normalized();
        const Vec3 p = triangle[0] + (radius + size * (0.2 + std::abs(place(random)))) * away;
        const Vec3 motion = 2 * size * anywhere() - (seed % 2 == 0 ? size : 0) * away;
        if (distance(triangle, p) <= radius) continue;
        const double least = least_touch_time(triangle, radius, p, motion);
        EXPECT_GE(least, 0) << "seed " << seed;
        const auto t = touch_time(triangle, radius, p, motion, tolerance);
        if (t) {
            ASSERT_LE(least, *t) << "seed " << seed;
            close += *t - least < 0.2 ? 1 : 0;
        } else if (least > 1) {
            ++told;
        }
        const double until = std::min(least, 1.0) * (1 - 1e-9);
        ASSERT_GE(distance(triangle, p + until * motion), radius * (1 - 1e-12)) << "seed " << seed;
    }
    EXPECT_GT(told, 5000);
    EXPECT_GT(close, 3000);
}

TEST(SweptSphere, IsExactForARadiusOfABillionth)
{
    int hits = 0;
    for (std::uint32_t seed = 0; seed < 5000; ++seed) {
        std::mt19937 random(seed);
        std::uniform_real_distribution<double> unit(0, 1);
        const auto anywhere = [&] {
            return Vec3(unit(random) - 0.5, unit(random) - 0.5, unit(random) - 0.5);
        };
        const Triangle triangle{{anywhere(), anywhere(), anywhere()}};
        // Towards corners, sides and the inside.
        double u = unit(random);
        double v = (1 - u) * unit(random);
        if (seed % 3 == 1) v = 0;
        if (seed % 3 == 2) u = v = 0;
        const Vec3 on =
            triangle[0] + u * (triangle[1] - triangle[0]) + v * (triangle[2] - triangle[0]);
        const Vec3 p = on + anywhere();
        const double radius = 0x1p-30;
        if (distance(triangle, p) < 1e-3) continue;
        const Vec3 motion = 1.5 * (on - p);
        const auto t = touch_time(triangle, radius, p, motion, tolerance);
        ASSERT_TRUE(t) << "seed " << seed;
        EXPECT_NEAR(distance(triangle, p + *t * motion), radius, 1e-14) << "seed " << seed;
        ++hits;
    }
    EXPECT_GT(hits, 4000);
}

TEST(SweptSphere, NormalsOfSliversAreExact)
{
    for (double width = 1; width > 1e-13; width /= 7) {
        const Triangle sliver{{Vec3(1, 1, 1), Vec3(2, 2, 1), Vec3(1.5 + width, 1.5 - width, 1)}};
        const Vec3 normal = unit_normal(sliver);
        EXPECT_NEAR(std::abs(normal.z()), 1, 1e-15) << width;
        EXPECT_LT(normal.head<2>().norm(), 1e-15) << width;
    }
    EXPECT_EQ(unit_normal({{Vec3(0, 0, 0), Vec3(1, 2, 3), Vec3(2, 4, 6)}}), Vec3::Zero());
    EXPECT_NEAR(unit_normal({{Vec3(0, 0, 0), Vec3(1e-100, 0, 0), Vec3(0, 1e-100, 0)}}).z(), 1,
                1e-15);
}

} // namespace
} // namespace proxima::swept_sphere_test
