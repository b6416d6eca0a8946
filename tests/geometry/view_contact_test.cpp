#include "geometry/view_contact.h"

#include "geometry/test_volumes.h"
#include "oracles/half_space_system.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace proxima::view_contact_test {
namespace {

using namespace testing;

/// The same by other numbers: planes times one power of two, space times another.
std::vector<ViewPlane> scaled(std::span<const ViewPlane> planes, int own, int space)
{
    std::vector<ViewPlane> result(planes.begin(), planes.end());
    for (ViewPlane& plane : result) {
        plane.normal = plane.normal.unaryExpr([&](double v) { return std::ldexp(v, own); });
        plane.offset = std::ldexp(plane.offset, own + space);
    }
    return result;
}

Vec3 scaled(const Vec3& point, int space)
{
    return point.unaryExpr([&](double v) { return std::ldexp(v, space); });
}

struct Counts {
    int meets = 0;
    int passes_only = 0; ///< outside, though of no single plane
    int apart = 0;

    void add(bool meet, bool pass) { ++(meet ? meets : pass ? passes_only : apart); }
    void expect_each(int least) const
    {
        EXPECT_GT(meets, least);
        EXPECT_GT(passes_only, least);
        EXPECT_GT(apart, least);
    }
};

class WholeShapes : public ::testing::Test {
protected:
    double number(int reach)
    {
        return static_cast<double>(random() % static_cast<unsigned>(reach));
    }
    Vec3 point(int reach)
    {
        const double x = number(reach);
        const double y = number(reach);
        return {x, y, number(reach)};
    }
    std::mt19937_64 random{7}; ///< the seed
};

TEST_F(WholeShapes, MeetTrianglesAsExactEliminationDoes)
{
    Counts counts;
    for (int trial = 0; trial < 60000; ++trial) {
        const auto planes = whole_planes(random, 1 + random() % 8, 12);
        const ViewVolume volume = make_view_volume(planes).value();
        Triangle triangle{{point(6), point(6), point(6)}};
        if (trial % 7 == 0) triangle.vertices[2] = triangle.vertices[0];
        if (trial % 49 == 0) triangle.vertices[1] = triangle.vertices[0];
        if (trial % 11 == 0) triangle.vertices[2] = 2 * triangle.vertices[1] - triangle.vertices[0];
        const bool truth = oracle_meets<__int128>(planes, triangle);
        const bool passes =
            !volume.empty() && std::ranges::all_of(planes, [&](const ViewPlane& plane) {
                return std::ranges::any_of(triangle.vertices, [&](const Vec3& v) {
                    return plane.normal.dot(v) + plane.offset >= 0; // whole numbers: exact
                });
            });
        ASSERT_EQ(meets_volume(volume, triangle), truth) << "trial " << trial;
        ASSERT_EQ(passes_planes(volume, triangle), passes) << "trial " << trial;
        counts.add(truth, passes);
        if (trial % 50 != 0) continue;
        // At both ends of the range of doubles.
        for (const auto& [own, space] : {std::pair(0, 300), std::pair(-500, -500),
                                         std::pair(900, -900), std::pair(-1060, 1000)}) {
            const ViewVolume other = make_view_volume(scaled(planes, own, space)).value();
            Triangle moved = triangle;
            for (Vec3& v : moved.vertices) v = scaled(v, space);
            ASSERT_EQ(meets_volume(other, moved), truth) << "trial " << trial << ", " << own;
            ASSERT_EQ(passes_planes(other, moved), passes) << "trial " << trial << ", " << own;
        }
    }
    counts.expect_each(500);
}

TEST_F(WholeShapes, MeetBoxesAsExactEliminationDoes)
{
    Counts counts;
    int within = 0;
    for (int trial = 0; trial < 20000; ++trial) {
        const auto planes = whole_planes(random, 1 + random() % 8, 12);
        const ViewVolume volume = make_view_volume(planes).value();
        const Vec3 lower = point(6) - Vec3::Constant(3);
        const Box box{lower, lower + point(trial % 2 == 0 ? 2 : 8)};
        const bool truth = oracle_meets<__int128>(planes, box);
        ASSERT_EQ(meets_volume(volume, box), truth) << "trial " << trial;
        const bool passes =
            !volume.empty() && std::ranges::all_of(planes, [&](const ViewPlane& plane) {
                const Vec3 farthest = (plane.normal.array() >= 0).select(box.upper, box.lower);
                return plane.normal.dot(farthest) + plane.offset >= 0; // whole numbers: exact
            });
        ASSERT_EQ(passes_planes(volume, box), passes) << "trial " << trial;
        counts.add(truth, passes);
        // A volume that lies deep inside, or reaches out.
        const Box around{Vec3::Constant(-1000), Vec3::Constant(1000)};
        ASSERT_EQ(meets_volume(volume, around), !volume.empty());
        within += volume.empty() ? 0 : 1;
    }
    counts.expect_each(100);
    EXPECT_GT(within, 1000);
}

TEST(ViewContact, CountsTouching)
{
    // The edge of a wedge, and what touches it in a point, or stays an ulp away.
    const ViewVolume wedge =
        make_view_volume(std::vector<ViewPlane>{{Vec3(1, 1, 0), 0}, {Vec3(-1, 1, 0), 0}}).value();
    const double below_zero = -std::numeric_limits<double>::denorm_min();
    const auto triangle = [](double y) {
        return Triangle{{Vec3(-1, y, 0), Vec3(1, y, 0), Vec3(0, -1, 5)}};
    };
    EXPECT_TRUE(meets_volume(wedge, triangle(0)));
    EXPECT_TRUE(passes_planes(wedge, triangle(below_zero)));
    EXPECT_FALSE(meets_volume(wedge, triangle(below_zero)));
    const auto box = [](double y) {
        Box made;
        made.extend(Vec3(-1, -1, -1));
        made.extend(Vec3(1, y, 1));
        return made;
    };
    EXPECT_TRUE(meets_volume(wedge, box(0)));
    EXPECT_TRUE(passes_planes(wedge, box(below_zero)));
    EXPECT_FALSE(meets_volume(wedge, box(below_zero)));
}

TEST(ViewContact, DoesNotDependOnTheSizesOfPlanes)
{
    constexpr std::uint64_t seed = 8;
    SCOPED_TRACE(::testing::Message() << "seed " << seed);
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> number(-1, 1);
    const Triangle triangle{{Vec3::UnitX(), Vec3::UnitY(), Vec3::UnitZ()}};
    using Shifts = std::array<int, 3>;
    int meets = 0;
    int apart = 0;
    for (int trial = 0; trial < 20000; ++trial) {
        // Through zero, all but contradictory.
        std::array<ViewPlane, 3> planes;
        for (std::size_t i = 0; i < 2; ++i)
            for (double& component : planes[i].normal) component = number(random);
        const double gap = std::pow(10.0, 3 * number(random) - 4);
        planes[2].normal =
            -planes[0].normal - planes[1].normal + Vec3::Constant(trial % 2 == 0 ? gap : -gap);
        const bool truth = meets_volume(make_view_volume(planes).value(), triangle);
        ++(truth ? meets : apart);
        // Products of two over- or underflow, those of three do not.
        for (const Shifts& shifts :
             {Shifts{-535, -535, 500}, Shifts{512, 512, -10}, Shifts{512, 512, 0}}) {
            std::array<ViewPlane, 3> same;
            for (std::size_t i = 0; i < 3; ++i)
                same[i].normal = std::ldexp(1.0, shifts[i]) * planes[i].normal;
            ASSERT_EQ(meets_volume(make_view_volume(same).value(), triangle), truth)
                << "trial " << trial << ", " << ::testing::PrintToString(shifts);
        }
    }
    EXPECT_GT(meets, 1000);
    EXPECT_GT(apart, 1000);
}

TEST(ViewContact, AcceptsTheGreatestNumberOfPlanes)
{
    // A ball of 1,024 planes.
    std::vector<ViewPlane> planes(max_view_planes);
    for (std::size_t i = 0; i < planes.size(); ++i) {
        const double z =
            1 - (2.0 * static_cast<double>(i) + 1) / static_cast<double>(planes.size());
        const double angle = 2.4 * static_cast<double>(i);
        const double r = std::sqrt(1 - z * z);
        planes[i] = {Vec3(-r * std::cos(angle), -r * std::sin(angle), -z), 1};
    }
    const ViewVolume ball = make_view_volume(planes).value();
    EXPECT_FALSE(ball.empty());
    const auto across = [](double height) {
        return Triangle{{Vec3(-50, -50, height), Vec3(50, -50, height), Vec3(0, 90, height)}};
    };
    EXPECT_TRUE(meets_volume(ball, across(0.99)));
    EXPECT_TRUE(meets_volume(ball, across(-0.5)));
    EXPECT_FALSE(meets_volume(ball, across(1.05)));
    const auto beside = [](double distance) {
        const Vec3 at = distance * Vec3(1, 1, 1).normalized();
        return Triangle{{at + Vec3(9, -9, 0), at + Vec3(-9, 9, 0), at + Vec3(0, -9, 9)}};
    };
    EXPECT_TRUE(meets_volume(ball, beside(0.98)));
    EXPECT_FALSE(meets_volume(ball, beside(1.05)));
}

} // namespace
} // namespace proxima::view_contact_test
