// Spheres and triangles whose corners move: times and planes against positions close together.
#include "geometry/closest_point.h"
#include "haptics/surface/moving_triangle.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <string>

namespace proxima::moving_triangle_test {
namespace {

constexpr int instants = 400;

double distance(const Triangle& triangle, const Vec3& p)
{
    return (closest_point(triangle, p).point - p).norm();
}

/// A case, of one of several kinds, with a sphere that does not touch at first.
struct Case {
    MovingTriangle triangle;
    Vec3 p = Vec3::Zero();
    Vec3 motion = Vec3::Zero();
    double radius = 1e-9;
};

class Cases {
public:
    explicit Cases(std::uint32_t seed) : random_(seed) {}

    Case next()
    {
        const auto kind = random_() % 5;
        for (;;) {
            Case c;
            for (std::size_t k = 0; k < 3; ++k) {
                c.triangle.before.vertices[k] = vector(1);
                c.triangle.now.vertices[k] =
                    c.triangle.before.vertices[k] + vector(motion_of(kind));
            }
            if (kind == 3) c.triangle.before.vertices[2] = c.triangle.before[0]; // no area at first
            if (kind == 4) {                                                     // a sliver
                c.triangle.before.vertices[2] =
                    0.5 * (c.triangle.before[0] + c.triangle.before[1]) + vector(1e-7);
                c.triangle.now.vertices[2] = c.triangle.before[2] + vector(0.1);
            }
            c.p = vector(1);
            c.motion = vector(kind == 0 ? 0.01 : 1);
            c.radius = random_() % 2 == 0 ? 1e-9 : 0.05;
            if (random_() % 2 == 0) { // it touches
                const TrianglePoint at = closest_point(c.triangle.before, c.p);
                const Vec3 away = c.p - at.point;
                if (!(away.norm() > 0)) continue;
                c.p = at.point + away.normalized() * (c.radius * (1 + 1e-6));
            }
            if (distance(c.triangle.before, c.p) > c.radius) return c;
        }
    }

private:
    [[nodiscard]] static double motion_of(unsigned long kind)
    {
        return kind == 0 ? 0.01 : kind == 1 ? 0.3 : 2;
    }
    Vec3 vector(double size)
    {
        std::uniform_real_distribution<double> number(-size, size);
        return {number(random_), number(random_), number(random_)};
    }
    std::mt19937 random_;
};

TEST(MovingTriangle, IsEnteredNoEarlierThanTheTimeSays)
{
    constexpr double tolerance = 1e-12;
    int touched = 0;
    int at_contact = 0;
    for (const std::uint32_t seed : {1U, 2U, 3U}) {
        Cases cases(seed);
        for (int i = 0; i < 3000; ++i) {
            const Case c = cases.next();
            const std::string where =
                "seed " + std::to_string(seed) + ", case " + std::to_string(i);
            const auto t = touch_time(c.triangle, c.radius, c.p, c.motion, tolerance);
            const double end = t.value_or(1);
            for (int k = 0; k <= instants; ++k) {
                const double time = end * k / instants;
                ASSERT_GT(distance(c.triangle.at(time), c.p + time * c.motion),
                          c.radius - 1.01 * tolerance - 1e-6 * c.radius)
                    << where << ", time " << time;
            }
            if (!t) continue;
            ++touched;
            const double gap = distance(c.triangle.at(*t), c.p + *t * c.motion) - c.radius;
            at_contact += gap < 1e-6 ? 1 : 0;
        }
    }
    EXPECT_GT(touched, 2000);
    // The steps may end before: an earlier time is no less right.
    EXPECT_GT(at_contact, touched * 19 / 20);
}

TEST(MovingTriangle, PlanesSeparateForTheWholeMotion)
{
    int planes = 0;
    int cases_of_contact = 0;
    for (const std::uint32_t seed : {4U, 5U, 6U}) {
        Cases cases(seed);
        std::mt19937 random(seed);
        std::uniform_real_distribution<double> number(-1, 1);
        for (int i = 0; i < 3000; ++i) {
            const Case c = cases.next();
            const std::string where =
                "seed " + std::to_string(seed) + ", case " + std::to_string(i);
            const auto t = touch_time(c.triangle, c.radius, c.p, c.motion, 1e-12);
            if (!t) continue;
            ++cases_of_contact;
            const auto plane = separating_plane(c.triangle, c.radius, c.p, c.motion, *t);
            if (!plane) continue;
            ++planes;
            ASSERT_NEAR(plane->normal.norm(), 1, 1e-12) << where;
            // Any end on the plane's side, and the nearest one to where it would have gone.
            Vec3 ends[2] = {c.p + c.motion,
                            c.p + Vec3(number(random), number(random), number(random))};
            for (Vec3& end : ends) {
                const double short_by = c.radius - plane->normal.dot(end - plane->point);
                if (short_by > 0) end += short_by * plane->normal;
                for (int k = 0; k <= instants; ++k) {
                    const double time = static_cast<double>(k) / instants;
                    ASSERT_GT(distance(c.triangle.at(time), c.p + time * (end - c.p)),
                              0.5 * c.radius - 1e-13)
                        << where << ", time " << time;
                }
            }
        }
    }
    EXPECT_GT(cases_of_contact, 1500);
    EXPECT_GT(planes, cases_of_contact * 999 / 1000);
}

} // namespace
} // namespace proxima::moving_triangle_test
