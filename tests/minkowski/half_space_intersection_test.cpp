#include "proxima/convex_polyhedron.h"

#include "code_of.h"
#include "polytopes.h"

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

namespace proxima::half_space_intersection_test {
namespace {

using test::Points;
using Planes = std::vector<HalfSpace>;

Vec3 random_direction(std::mt19937& random)
{
    std::normal_distribution<double> normal;
    return Vec3{normal(random), normal(random), normal(random)}.normalized();
}

/// Columns at right angles, of any direction.
Eigen::Matrix3d random_frame(std::mt19937& random)
{
    const Vec3 a = random_direction(random);
    const Vec3 b = a.cross(random_direction(random)).normalized();
    Eigen::Matrix3d frame;
    frame << a, b, a.cross(b);
    return frame;
}

/// How far the worst corner is outside a plane, measured apart from the code under test.
double worst_outside(const ConvexPolyhedron& polyhedron, const Planes& planes)
{
    long double worst = -std::numeric_limits<long double>::infinity();
    for (const HalfSpace& plane : planes) {
        const Eigen::Matrix<long double, 3, 1> n = plane.normal.cast<long double>();
        for (const Vec3& p : polyhedron.points())
            worst = std::max(worst, (n.dot(p.cast<long double>()) - plane.offset) / n.norm());
    }
    return static_cast<double>(worst);
}

double farthest_ray(const ConvexPolyhedron& polyhedron, const Planes& planes)
{
    double worst = -1;
    for (const HalfSpace& plane : planes) {
        for (const Vec3& r : polyhedron.rays())
            worst = std::max(worst, plane.normal.normalized().dot(r.normalized()));
    }
    return worst;
}

double nearest(const Vec3& p, std::span<const Vec3> points)
{
    double distance = std::numeric_limits<double>::infinity();
    for (const Vec3& q : points) distance = std::min(distance, (p - q).norm());
    return distance;
}

std::string refusal(const Planes& planes)
{
    const auto result = polyhedron_of_half_spaces(planes);
    return result ? "accepted" : describe(result.error());
}

/// 0.3 <= a . x <= 0.3 + width, and +-1 in the two directions across.
Planes slab(const Eigen::Matrix3d& frame, double width)
{
    const Vec3 a = frame.col(0);
    const Vec3 b = frame.col(1);
    const Vec3 c = frame.col(2);
    return {{a, 0.3 + width}, {-a, -0.3}, {b, 1}, {-b, 1}, {c, 1}, {-c, 1}};
}

TEST(HalfSpaceIntersection, ThinSlabsHaveTheirEightCorners)
{
    for (const double width : {1e-2, 1e-4, 1e-6, 1e-8, 1e-9, 1e-10, 1e-11}) {
        for (unsigned seed = 0; seed < 40; ++seed) {
            SCOPED_TRACE(::testing::Message() << "seed " << seed << ", width " << width);
            std::mt19937 random(seed);
            const Eigen::Matrix3d frame = random_frame(random);
            const Planes planes = slab(frame, width);
            const auto found = polyhedron_of_half_spaces(planes);
            ASSERT_TRUE(found) << describe(found.error());
            EXPECT_EQ(found->points().size(), 8U);
            EXPECT_TRUE(found->is_bounded());
            EXPECT_LT(worst_outside(*found, planes), 1e-15);
            for (const double x : {0.3, 0.3 + width}) {
                for (const double y : {-1, 1}) {
                    for (const double z : {-1, 1})
                        EXPECT_LT(nearest(frame * Vec3(x, y, z), found->points()), 4e-15);
                }
            }
        }
    }
}

TEST(HalfSpaceIntersection, RefusesSlabsThinnerThanItCanResolve)
{
    for (const double width : {1e-13, 1e-14, 1e-15, 0.0}) {
        for (unsigned seed = 0; seed < 20; ++seed) {
            SCOPED_TRACE(::testing::Message() << "seed " << seed << ", width " << width);
            std::mt19937 random(seed);
            EXPECT_NE(refusal(slab(random_frame(random), width)).find("no volume"),
                      std::string::npos);
        }
    }
}

TEST(HalfSpaceIntersection, RefusesFlatAndEmptySets)
{
    std::normal_distribution<double> normal;
    for (const double gap : {0.0, 1e-12, 1e-9, 1e-7, 1e-5, 1e-3}) {
        for (unsigned seed = 0; seed < 300; ++seed) {
            std::mt19937 random(seed);
            const Vec3 a = random_direction(random);
            const double d = normal(random);
            Planes planes = {{a, d}, {-a, -d - gap}};
            for (int i = 0; i < 6; ++i)
                planes.push_back({random_direction(random), 1 + std::abs(normal(random))});
            EXPECT_NE(refusal(planes).find("no volume"), std::string::npos)
                << "seed " << seed << ", gap " << gap << ": " << refusal(planes);
        }
    }
    // An empty slab in a thin box.
    for (const double width : {1e-8, 1e-6, 1e-5, 5e-5}) {
        for (unsigned seed = 0; seed < 40; ++seed) {
            std::mt19937 random(seed);
            const Eigen::Matrix3d frame = random_frame(random);
            const Planes planes = {{frame.col(0), 0.3},   {-frame.col(0), -0.3 - 1e-7},
                                   {frame.col(1), width}, {-frame.col(1), width},
                                   {frame.col(2), 1},     {-frame.col(2), 1}};
            EXPECT_NE(refusal(planes).find("no volume"), std::string::npos)
                << "seed " << seed << ", width " << width;
        }
    }
}

/// Sets of any planes, most of them unbounded: what is accepted is inside all planes, and holds
/// every random point that is in all of them.
TEST(HalfSpaceIntersection, AgreesWithSampledPointsOfRandomPlanes)
{
    int accepted = 0;
    int unbounded = 0;
    for (unsigned seed = 0; seed < 400; ++seed) {
        SCOPED_TRACE(::testing::Message() << "seed " << seed);
        std::mt19937 random(seed);
        std::normal_distribution<double> normal;
        Planes planes;
        for (unsigned i = 0; i < 3 + seed % 12; ++i) {
            const double length = std::exp(3 * normal(random));
            planes.push_back({length * random_direction(random), length * normal(random)});
        }
        const auto found = polyhedron_of_half_spaces(planes);
        std::vector<Vec3> common;
        for (int i = 0; i < 300; ++i) {
            const Vec3 x = 3 * Vec3{normal(random), normal(random), normal(random)};
            if (std::ranges::all_of(planes, [&](const HalfSpace& plane) {
                    return plane.normal.dot(x) < plane.offset;
                }))
                common.push_back(x);
        }
        if (!found) {
            EXPECT_TRUE(common.empty()) << describe(found.error());
            continue;
        }
        ++accepted;
        if (!found->is_bounded()) ++unbounded;
        double size = 1;
        for (const Vec3& p : found->points()) size = std::max(size, p.norm());
        EXPECT_LT(worst_outside(*found, planes), 1e-15 * size);
        EXPECT_LT(farthest_ray(*found, planes), 1e-12);
        for (std::uint32_t f = 0; f < found->facet_count(); ++f) {
            const HalfSpace side = found->half_space(f);
            for (const Vec3& x : common)
                EXPECT_LE(side.normal.dot(x), side.offset + 1e-9 * size) << "facet " << f;
        }
    }
    EXPECT_GT(accepted, 150);
    EXPECT_GT(unbounded, 50);
}

TEST(HalfSpaceIntersection, RecoversTheCornersOfObliqueHulls)
{
    for (unsigned seed = 0; seed < 150; ++seed) {
        SCOPED_TRACE(::testing::Message() << "seed " << seed);
        std::mt19937 random(seed);
        const Eigen::Matrix3d frame = random_frame(random);
        const Vec3 shift = 100.0 * random_direction(random);
        Points points;
        for (int i = 0; i < 12; ++i) points.emplace_back(shift + 10 * random_direction(random));
        Points rays;
        if (seed % 2 == 1) rays = {frame * Vec3(4, 1, 0), frame * Vec3(4, 0, 1), frame.col(0)};
        const ConvexPolyhedron hull = test::hull_of(points, rays);
        Planes planes;
        for (std::uint32_t f = 0; f < hull.facet_count(); ++f) planes.push_back(hull.half_space(f));
        std::ranges::shuffle(planes, random);
        const auto found = polyhedron_of_half_spaces(planes);
        ASSERT_TRUE(found) << describe(found.error());
        // The planes are rounded, so a corner of more than three may come apart, and by more where
        // two of them hardly differ.
        for (const Vec3& p : hull.points()) EXPECT_LT(nearest(p, found->points()), 1e-9);
        for (const Vec3& p : found->points()) EXPECT_LT(nearest(p, hull.points()), 1e-6);
        EXPECT_EQ(found->rays().size(), hull.rays().size());
        // half_space_tolerance of |p| + |c|, which are below 120 and 600.
        EXPECT_LT(worst_outside(*found, planes), 7e-12);
    }
}

TEST(HalfSpaceIntersection, IsTheSameAtEveryScale)
{
    std::mt19937 random(5);
    const Eigen::Matrix3d frame = random_frame(random);
    for (const double scale : {0x1p-700, 0x1p-300, 0x1p-40, 0x1p+40, 0x1p+290}) {
        Planes planes = slab(frame, 0.01);
        const auto unit = polyhedron_of_half_spaces(planes);
        for (HalfSpace& plane : planes) plane.offset *= scale;
        const auto found = polyhedron_of_half_spaces(planes);
        ASSERT_TRUE(found) << scale << ": " << describe(found.error());
        ASSERT_EQ(found->points().size(), 8U);
        for (std::size_t i = 0; i < 8; ++i)
            EXPECT_EQ(found->points()[i], Vec3(scale * unit->points()[i])) << scale;
    }
}

TEST(HalfSpaceIntersection, AcceptsNormalsOfAnyLength)
{
    const Vec3 x = Vec3::UnitX();
    const Vec3 y = Vec3::UnitY();
    const Vec3 z = Vec3::UnitZ();
    const Planes rest = {{-x, 1}, {-y, 1}, {z, 1}, {-z, 1}};
    Planes planes = rest;
    planes.push_back({{1.7e308, 1.7e308, 0}, 1.7e308});
    const auto prism = polyhedron_of_half_spaces(planes);
    ASSERT_TRUE(prism) << describe(prism.error());
    EXPECT_EQ(prism->points().size(), 6U);
    EXPECT_LT(nearest({2, -1, 1}, prism->points()), 1e-14);

    planes = rest;
    planes.push_back({1e-300 * x, 1e300});
    const auto result = polyhedron_of_half_spaces(planes);
    ASSERT_FALSE(result);
    EXPECT_EQ(code_of(result), ErrorCode::limit_exceeded);
    EXPECT_EQ(result.error().where, "half-space 4");
}

TEST(HalfSpaceIntersection, StopsOnRequest)
{
    std::mt19937 random(1);
    const Planes planes = slab(random_frame(random), 1);
    Progress progress;
    progress.cancel();
    const auto result = polyhedron_of_half_spaces(planes, {.progress = &progress});
    ASSERT_FALSE(result);
    EXPECT_EQ(code_of(result), ErrorCode::cancelled);
}

} // namespace
} // namespace proxima::half_space_intersection_test
