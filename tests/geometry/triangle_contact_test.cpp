#include "proxima/geometry/triangle_contact.h"

#include "proxima/geometry/exact_predicates.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <gtest/gtest.h>
#include <random>

namespace proxima {
namespace {

using Whole = Eigen::Matrix<std::int64_t, 3, 1>;
using WholeTriangle = std::array<Whole, 3>;

/// Two convex sets of whole points are apart if and only if an axis separates them: the normals,
/// the cross products of sides, and for one plane the normals of sides in it. In whole numbers.
bool separating_axis_exists(const WholeTriangle& a, const WholeTriangle& b)
{
    const auto separates = [&](const Whole& axis) {
        std::array<std::int64_t, 3> on_a{};
        std::array<std::int64_t, 3> on_b{};
        for (std::size_t i = 0; i < 3; ++i) {
            on_a[i] = axis.dot(a[i]);
            on_b[i] = axis.dot(b[i]);
        }
        return *std::ranges::max_element(on_a) < *std::ranges::min_element(on_b) ||
               *std::ranges::max_element(on_b) < *std::ranges::min_element(on_a);
    };
    const auto side = [](const WholeTriangle& t, std::size_t i) -> Whole {
        return t[(i + 1) % 3] - t[i];
    };
    const Whole normal_a = side(a, 0).cross(side(a, 1));
    const Whole normal_b = side(b, 0).cross(side(b, 1));
    if (separates(normal_a) || separates(normal_b)) return true;
    for (std::size_t i = 0; i < 3; ++i) {
        if (separates(normal_a.cross(side(a, i))) || separates(normal_b.cross(side(b, i))))
            return true;
        for (std::size_t k = 0; k < 3; ++k) {
            if (separates(side(a, i).cross(side(b, k)))) return true;
        }
    }
    return false;
}

Triangle as_doubles(const WholeTriangle& t, double scale)
{
    return {
        {scale * t[0].cast<double>(), scale * t[1].cast<double>(), scale * t[2].cast<double>()}};
}

TEST(TriangleContact, AgreesWithSeparatingAxesInWholeNumbers)
{
    std::mt19937 random(1);
    int meeting = 0;
    int apart = 0;
    for (int n = 0; n < 60000; ++n) {
        const std::int64_t size = n % 3 == 0 ? 3 : n % 3 == 1 ? 6 : 1000;
        const bool flat = n % 5 == 0; // both in one plane
        const auto coordinate = [&] {
            return static_cast<std::int64_t>(random() % static_cast<unsigned>(size));
        };
        std::array<WholeTriangle, 2> t;
        for (WholeTriangle& triangle : t) {
            for (Whole& corner : triangle) {
                corner = {coordinate(), coordinate(), flat ? 0 : coordinate()};
                if (flat) corner[2] = corner[0] + 2 * corner[1];
            }
        }
        if (n % 7 == 0) t[1][0] = t[0][1]; // a corner in common
        const auto has_area = [](const WholeTriangle& x) {
            return !Whole((x[1] - x[0]).cross(x[2] - x[0])).isZero();
        };
        if (!has_area(t[0]) || !has_area(t[1])) continue;
        const bool meet = !separating_axis_exists(t[0], t[1]);
        const Triangle a = as_doubles(t[0], 0.25);
        const Triangle b = as_doubles(t[1], 0.25);
        ASSERT_EQ(triangles_meet(a, b), meet) << "case " << n;
        ASSERT_EQ(triangles_meet(b, a), meet) << "case " << n;
        ++(meet ? meeting : apart);
    }
    EXPECT_GT(meeting, 5000);
    EXPECT_GT(apart, 5000);
}

TEST(TriangleContact, SeesOneBitOfAGap)
{
    const Triangle floor = {{Vec3(-1, -1, 0.1), Vec3(3, -1, 0.1), Vec3(-1, 3, 0.1)}};
    const auto standing = [](double z) {
        return Triangle{{Vec3(0, 0, z), Vec3(0.3, 0.7, 5), Vec3(0.9, 0.1, 7)}};
    };
    EXPECT_TRUE(triangles_meet(floor, standing(0.1)));
    EXPECT_FALSE(triangles_meet(floor, standing(std::nextafter(0.1, 1.0))));
    EXPECT_TRUE(segment_meets_triangle(Vec3(0, 0, 0), Vec3(0, 0, 0.1), floor));
    EXPECT_FALSE(
        segment_meets_triangle(Vec3(0, 0, 0), Vec3(0, 0, std::nextafter(0.1, 0.0)), floor));
}

} // namespace
} // namespace proxima
