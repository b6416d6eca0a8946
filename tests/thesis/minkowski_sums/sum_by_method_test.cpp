// The thesis's methods give the sum that the overlay of Gaussian maps gives.
#include "proxima/thesis.h"

#include "code_of.h"
#include "minkowski/polytopes.h"
#include "minkowski/whole_sum.h"
#include "thesis/minkowski_sums/count_sum_by_method.h"

#include <gtest/gtest.h>

#include <cmath>

namespace proxima::sum_by_method_test {
namespace {

using test::described;
using test::expect_euler;
using test::Points;

TEST(SumByMethod, TheThreeMethodsAgree)
{
    int compared = 0;
    for (unsigned seed = 0; seed < 300; ++seed) {
        SCOPED_TRACE(seed);
        std::mt19937 random(seed);
        const auto a = test::hull_of(test::nasty_points(random));
        const auto b = test::hull_of(test::nasty_points(random));
        const auto arcs = minkowski_sum(a, b);
        ASSERT_TRUE(arcs);
        for (const auto method : {MinkowskiMethod::geometric, MinkowskiMethod::hull}) {
            const auto sum = minkowski_sum_by(method, a, b);
            EXPECT_EQ(sum.has_value(), arcs->dimension() == 3);
            if (!sum) continue;
            EXPECT_EQ(described(*sum), described(*arcs));
            expect_euler(*sum);
            ++compared;
        }
        if (HasFailure()) break;
    }
    EXPECT_GT(compared, 300);
}

TEST(SumByMethod, ArcsTakeDotProductsLinearInTheEdges)
{
    // Two coaxial prisms: one pair of caps with thousands of corners each.
    const auto prism = [](int sides, double turn) {
        Points points;
        for (int i = 0; i < sides; ++i) {
            const double angle = 2 * 3.14159265358979 * (i + turn) / sides;
            for (const double z : {-1.0, 1.0})
                points.emplace_back(std::cos(angle), std::sin(angle), z);
        }
        return test::hull_of(points);
    };
    const int sides = 3000;
    const auto counted =
        count_minkowski_sum(MinkowskiMethod::arcs, prism(sides, 0), prism(sides, 0.3));
    ASSERT_TRUE(counted);
    EXPECT_LT(counted->counts.dot_products, 200 * sides);
}

TEST(SumByMethod, CountingChangesNothing)
{
    for (unsigned seed = 0; seed < 60; ++seed) {
        SCOPED_TRACE(seed);
        std::mt19937 random(seed);
        const auto a = test::hull_of(test::nasty_points(random));
        const auto b = test::hull_of(test::nasty_points(random));
        for (const auto method :
             {MinkowskiMethod::arcs, MinkowskiMethod::geometric, MinkowskiMethod::hull}) {
            const auto plain = minkowski_sum_by(method, a, b);
            const auto counted = count_minkowski_sum(method, a, b);
            ASSERT_EQ(plain.has_value(), counted.has_value());
            if (!plain) continue;
            EXPECT_EQ(described(*plain), described(counted->sum));
            if (method != MinkowskiMethod::arcs) {
                EXPECT_GT(counted->counts.dot_products, 0);
            }
        }
    }
}

TEST(SumByMethod, StopsOnRequest)
{
    std::mt19937 random(1);
    const auto a = test::hull_of(test::round_points(random, 40, 1e5));
    for (const auto method :
         {MinkowskiMethod::arcs, MinkowskiMethod::geometric, MinkowskiMethod::hull}) {
        Progress progress;
        progress.cancel();
        const auto sum = minkowski_sum_by(method, a, a, {.execution = {.progress = &progress}});
        ASSERT_FALSE(sum);
        EXPECT_EQ(code_of(sum), ErrorCode::cancelled);
    }
}

} // namespace
} // namespace proxima::sum_by_method_test
