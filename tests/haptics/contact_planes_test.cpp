#include "haptics/proxy/contact_planes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <span>
#include <vector>

namespace proxima::contact_planes_test {
namespace {

Vec3 random_direction(std::mt19937& random)
{
    std::normal_distribution<double> normal;
    return Vec3{normal(random), normal(random), normal(random)}.normalized();
}

double worst_violation(const std::vector<ContactPlane>& planes, const Vec3& shift)
{
    double worst = 0;
    for (const ContactPlane& plane : planes)
        worst = std::max(worst, -(plane.gap + plane.normal.dot(shift)));
    return worst;
}

/// The least shift by projecting onto every half-space in turn, corrected: [dykstra-1983]. Slow,
/// and knows nothing of subsets.
Vec3 shift_by_projections(const std::vector<ContactPlane>& planes, int rounds)
{
    Vec3 x = Vec3::Zero();
    std::vector<Vec3> corrections(planes.size(), Vec3::Zero());
    for (int round = 0; round < rounds; ++round) {
        for (std::size_t i = 0; i < planes.size(); ++i) {
            const Vec3 y = x + corrections[i];
            const double by = std::max(0.0, -(planes[i].gap + planes[i].normal.dot(y)));
            x = y + by * planes[i].normal;
            corrections[i] = y - x;
        }
    }
    return x;
}

TEST(ContactPlanes, LeaveAllowedPointsWhereTheyAre)
{
    const std::vector<ContactPlane> planes = {{Vec3::UnitZ(), 0.5}, {Vec3::UnitX(), 0}};
    const PlaneSolution solution = nearest_allowed(planes, 1e-12);
    EXPECT_EQ(solution.count, 0U);
    EXPECT_EQ(solution.shift, Vec3::Zero());
    EXPECT_TRUE(solution.feasible);
    EXPECT_EQ(nearest_allowed({}, 1e-12).count, 0U);
}

TEST(ContactPlanes, AllowGapsOfTheToleranceItself)
{
    const std::vector<ContactPlane> planes = {{Vec3::UnitZ(), -0.25}, {Vec3::UnitX(), -0.25}};
    for (const std::size_t count : {1U, 2U}) {
        const auto some = std::span(planes).first(count);
        EXPECT_EQ(nearest_allowed(some, 0.25).count, 0U) << count;
        const PlaneSolution moved = nearest_allowed(some, std::nextafter(0.25, 0.0));
        EXPECT_EQ(moved.count, count);
        EXPECT_TRUE(moved.feasible) << count;
    }
}

TEST(ContactPlanes, NoPlaneBesideThemCounts)
{
    // In memory a plane follows that is farther away than all of them.
    const std::vector<ContactPlane> planes = {
        {Vec3::UnitX(), -1}, {Vec3::UnitY(), -2}, {Vec3::UnitZ(), -3}};
    EXPECT_EQ(nearest_allowed(std::span(planes).first(2), 1e-12).shift, Vec3(1, 2, 0));
    EXPECT_EQ(nearest_allowed(std::span(planes).first(1), 1e-12).shift, Vec3(1, 0, 0));
    EXPECT_EQ(nearest_allowed(std::span(planes).subspan(1, 1), 1e-12).shift, Vec3(0, 2, 0));
}

TEST(ContactPlanes, SolveACornerOfThreePlanesInOneCall)
{
    const std::vector<ContactPlane> planes = {
        {Vec3::UnitX(), -1}, {Vec3::UnitY(), -2}, {Vec3::UnitZ(), -3}};
    const PlaneSolution solution = nearest_allowed(planes, 1e-12);
    EXPECT_EQ(solution.count, 3U);
    EXPECT_LT((solution.shift - Vec3(1, 2, 3)).norm(), 1e-14);
    for (std::size_t i = 0; i < 3; ++i)
        EXPECT_NEAR(solution.pressure[i], solution.active[i] + 1.0, 1e-14);
}

TEST(ContactPlanes, AgreeWithProjectionsOntoRandomCones)
{
    int sizes[4] = {};
    for (std::uint32_t seed = 0; seed < 3000; ++seed) {
        std::mt19937 random(seed);
        std::uniform_real_distribution<double> unit(0, 1);
        // A cone round a direction, so that there is always an allowed place.
        const Vec3 axis = random_direction(random);
        std::vector<ContactPlane> planes(1 + random() % 9);
        for (ContactPlane& plane : planes) {
            do {
                plane.normal = random_direction(random);
            } while (plane.normal.dot(axis) < 0.2);
            plane.gap = 0.3 - unit(random);
        }
        const PlaneSolution solution = nearest_allowed(planes, 1e-12);
        ASSERT_TRUE(solution.feasible) << "seed " << seed;
        EXPECT_LE(worst_violation(planes, solution.shift), 1e-12) << "seed " << seed;
        const Vec3 expected = shift_by_projections(planes, 4000);
        EXPECT_LT((solution.shift - expected).norm(), 1e-5) << "seed " << seed;
        EXPECT_LE(solution.shift.norm(), expected.norm() + 1e-9) << "seed " << seed;
        // The multipliers push outward and make up the shift.
        Vec3 sum = Vec3::Zero();
        for (std::size_t i = 0; i < solution.count; ++i) {
            EXPECT_GE(solution.pressure[i], -1e-10) << "seed " << seed;
            sum += solution.pressure[i] * planes[solution.active[i]].normal;
        }
        EXPECT_LT((sum - solution.shift).norm(), 1e-9) << "seed " << seed;
        ++sizes[solution.count];
    }
    for (const int size : sizes) EXPECT_GT(size, 50);
}

TEST(ContactPlanes, SolveNearlyParallelPlanes)
{
    for (double angle = 1e-15; angle < 1e-2; angle *= 3) {
        const std::vector<ContactPlane> planes = {
            {Vec3::UnitZ(), -1e-3}, {Vec3(std::sin(angle), 0, std::cos(angle)), -1e-3}};
        const PlaneSolution solution = nearest_allowed(planes, 1e-13);
        EXPECT_NEAR(solution.shift.norm(), 1e-3, 1e-3 * angle + 1e-13) << angle;
        EXPECT_LE(worst_violation(planes, solution.shift), 1e-3 * angle + 1e-13) << angle;
    }
}

TEST(ContactPlanes, ReportOppositePlanesAsInfeasible)
{
    const std::vector<ContactPlane> planes = {{Vec3::UnitZ(), -1}, {-Vec3::UnitZ(), -1}};
    EXPECT_FALSE(nearest_allowed(planes, 1e-12).feasible);
}

} // namespace
} // namespace proxima::contact_planes_test
