#include "query/contacts/hull_depth.h"

#include "proxima/minkowski_sum.h"
#include "proxima/sample_meshes.h"
#include "query/contacts/random_motions.h"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <random>
#include <utility>
#include <vector>

namespace proxima::hull_depth_test {
namespace {

using namespace testing;

using Points = std::vector<Vec3>;

ConvexPolyhedron hull_of(const Points& points)
{
    auto made = convex_hull(points);
    EXPECT_TRUE(made);
    return std::move(made).value();
}

Points moved(const ConvexPolyhedron& hull, const RigidTransform& pose)
{
    Points points;
    for (const Vec3& p : hull.points()) points.push_back(pose(p));
    return points;
}

double largest(std::span<const Vec3> points)
{
    double most = 0;
    for (const Vec3& p : points) most = std::max(most, p.cwiseAbs().maxCoeff());
    return most;
}

double rounding_of(const ConvexPolyhedron& a, const Points& moved_b)
{
    return 0x1p-48 * std::sqrt(3.0) * (largest(a.points()) + largest(moved_b));
}

/// By how much the point is beyond one of the planes.
double beyond(const ConvexPolyhedron& hull, const Vec3& point)
{
    double most = -HUGE_VAL;
    for (std::uint32_t facet = 0; facet < hull.facet_count(); ++facet) {
        const HalfSpace plane = hull.half_space(facet);
        most = std::max(most, plane.normal.dot(point) - plane.offset);
    }
    return most;
}

/// What an answer promises, by the planes of both hulls and by all facets of their Minkowski sum.
void expect_right(const HullDepth& found, const ConvexPolyhedron& a, const Points& moved_b)
{
    const double rounding = rounding_of(a, moved_b);
    const ConvexPolyhedron b = hull_of(moved_b);
    const auto truth = separation(a, b);
    ASSERT_TRUE(truth);
    EXPECT_LE(found.lower, -truth->distance + 2 * rounding);
    EXPECT_GE(found.lower, -truth->distance - 4 * rounding);
    EXPECT_NEAR(found.direction.norm(), 1, 1e-15);
    double top = -HUGE_VAL;
    for (const Vec3& p : a.points()) top = std::max(top, found.direction.dot(p));
    double least = HUGE_VAL;
    for (const Vec3& p : moved_b) least = std::min(least, found.direction.dot(p));
    EXPECT_LE(top - least, found.lower + 3 * rounding) << "moving B does not part them";
    EXPECT_LE(beyond(a, found.common), 4 * rounding);
    EXPECT_LE(beyond(b, found.common), 4 * rounding);
}

Points box_corners(const Vec3& extent)
{
    Points corners;
    for (int i = 0; i < 8; ++i) {
        corners.push_back(
            extent.cwiseProduct(Vec3((i & 1) - 0.5, (i >> 1 & 1) - 0.5, (i >> 2) - 0.5)));
    }
    return corners;
}

/// Corners of a body: on an ellipsoid, of a box, or of a small lattice, where many are in one plane.
Points random_corners(std::mt19937_64& random)
{
    std::uniform_real_distribution<double> radius(0.1, 2);
    const Vec3 radii(radius(random), radius(random), radius(random));
    Points corners;
    switch (std::uniform_int_distribution(0, 2)(random)) {
    case 0: {
        const int count = std::uniform_int_distribution(4, 60)(random);
        for (int i = 0; i < count; ++i)
            corners.push_back(random_direction(random).cwiseProduct(radii));
        break;
    }
    case 1:
        return box_corners(radii);
    default: {
        std::uniform_int_distribution coordinate(-2, 2);
        for (int i = 0; i < 12; ++i) {
            const double x = coordinate(random);
            const double y = coordinate(random);
            corners.emplace_back(x, y, coordinate(random));
        }
    }
    }
    return corners;
}

TEST(HullDepth, IsThatOfTheMinkowskiSum)
{
    int overlapping = 0;
    int answered = 0;
    for (std::uint64_t seed = 0; seed < 1500; ++seed) {
        SCOPED_TRACE(seed);
        std::mt19937_64 random(seed);
        const ConvexPolyhedron a = hull_of(random_corners(random));
        const ConvexPolyhedron b = hull_of(random_corners(random));
        const Vec3 away = std::exponential_distribution(1.5)(random) * random_direction(random);
        const bool is_turned = seed % 3 != 0;
        RigidTransform pose = is_turned ? random_pose(random, away) : RigidTransform{};
        pose.translation = away;
        const Points moved_b = moved(b, pose);
        const auto found = find_hull_depth(a, b, moved_b, rounding_of(a, moved_b));
        const auto truth = separation(a, hull_of(moved_b));
        ASSERT_TRUE(truth);
        if (truth->distance > -1e-9) {
            EXPECT_FALSE(found && truth->distance > 0);
            continue;
        }
        ++overlapping;
        if (!found) continue;
        ++answered;
        expect_right(*found, a, moved_b);
    }
    EXPECT_GT(overlapping, 1000);
    EXPECT_GE(answered, overlapping - 3) << "others have to build the whole sum";
}

TEST(HullDepth, IsThatOfThinBodiesOrNothing)
{
    int answered = 0;
    for (std::uint64_t seed = 0; seed < 1500; ++seed) {
        SCOPED_TRACE(seed);
        std::mt19937_64 random(seed);
        std::uniform_real_distribution<double> exponent(-12, 0);
        Points bodies[] = {random_corners(random), random_corners(random)};
        for (Points& body : bodies) {
            const Vec3 scale(1, std::pow(10, exponent(random)), std::pow(10, exponent(random)));
            for (Vec3& p : body) p = scale.cwiseProduct(p);
        }
        const ConvexPolyhedron a = hull_of(bodies[0]);
        const ConvexPolyhedron b = hull_of(bodies[1]);
        const Points moved_b = moved(
            b, random_pose(random, std::pow(10, exponent(random)) * random_direction(random)));
        const auto found = find_hull_depth(a, b, moved_b, rounding_of(a, moved_b));
        if (!found) continue;
        ++answered;
        expect_right(*found, a, moved_b);
    }
    EXPECT_GT(answered, 100);
}

TEST(HullDepth, IsThatOfBodiesWithManyCornersAndOfOneFarWithinTheOther)
{
    std::mt19937_64 random(1);
    Points ball;
    for (int i = 0; i < 2000; ++i) ball.push_back(random_direction(random));
    const ConvexPolyhedron large = hull_of(ball);
    for (const double size : {1.0, 1e-3}) {
        Points small = ball;
        for (Vec3& p : small) p = size * p + Vec3(0.1, 0.2, -0.3);
        const ConvexPolyhedron b = hull_of(small);
        const Points moved_b(b.points().begin(), b.points().end());
        const auto found = find_hull_depth(large, b, moved_b, rounding_of(large, moved_b));
        ASSERT_TRUE(found) << size;
        expect_right(*found, large, moved_b);
    }
}

TEST(HullDepth, GivesUpWhereThousandsOfFacetsAreAboutAsFar)
{
    const TriangleMesh sphere = make_icosphere(5);
    const ConvexPolyhedron ball = hull_of({sphere.positions().begin(), sphere.positions().end()});
    const Points same(ball.points().begin(), ball.points().end());
    EXPECT_FALSE(find_hull_depth(ball, ball, same, rounding_of(ball, same)));
}

TEST(HullDepth, IsNothingForHullsThatTouchOrAreApartOrFlat)
{
    const ConvexPolyhedron box = hull_of(box_corners(Vec3(1, 1, 1)));
    const ConvexPolyhedron square = hull_of(box_corners(Vec3(1, 1, 0)));
    for (const Vec3& shift : {Vec3(1, 0.25, 0.25), Vec3(1, 1, 1), Vec3(1.5, 0, 0), Vec3(9, 9, 9)}) {
        RigidTransform pose;
        pose.translation = shift;
        EXPECT_FALSE(find_hull_depth(box, box, moved(box, pose), 1e-14)) << shift.transpose();
        EXPECT_FALSE(find_hull_depth(square, square, moved(square, pose), 1e-14));
    }
    EXPECT_FALSE(find_hull_depth(square, square, moved(square, {}), 1e-14));
}

} // namespace
} // namespace proxima::hull_depth_test
