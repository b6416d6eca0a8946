#include "geometry/triangle_contact.h"

#include "geometry/closest_point.h"
#include "geometry/exact_predicates.h"
#include "geometry/triangle_intersection.h"
#include "oracles/integer_contact.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <gtest/gtest.h>
#include <random>
#include <vector>

namespace proxima::triangle_contact_test {
namespace {

using oracle::Whole;
using oracle::WholeTriangle;

Triangle as_doubles(const WholeTriangle& t, double scale)
{
    return {
        {scale * t[0].cast<double>(), scale * t[1].cast<double>(), scale * t[2].cast<double>()}};
}

Triangle turned(const Triangle& t, int first, bool mirrored)
{
    return mirrored ? Triangle{{t[first], t[(first + 2) % 3], t[(first + 1) % 3]}}
                    : Triangle{{t[first], t[(first + 1) % 3], t[(first + 2) % 3]}};
}

struct Answers {
    int meeting = 0;
    int apart = 0;
    void count(bool meet) { ++(meet ? meeting : apart); }
};

void compare(const WholeTriangle& s, const WholeTriangle& t, double scale, Answers& answers)
{
    const bool meet = oracle::triangles_meet(s, t);
    const Triangle a = as_doubles(s, scale);
    const Triangle b = as_doubles(t, scale);
    ASSERT_EQ(triangles_meet(a, b), meet);
    ASSERT_EQ(triangles_meet(b, a), meet);
    ASSERT_EQ(!intersect(a, b).empty(), meet);
    if (t[1] == t[2]) {
        ASSERT_EQ(segment_meets_triangle(b[0], b[1], a), meet);
    }
    answers.count(meet);
}

TEST(TriangleContact, AgreesOnEveryPairInTheUnitCube)
{
    Answers answers;
    for (unsigned bits = 0; bits < 1U << 18U; ++bits) {
        std::array<WholeTriangle, 2> t;
        for (unsigned i = 0; i < 6; ++i) {
            const unsigned corner = bits >> 3U * i & 7U;
            t[i / 3][i % 3] = Whole(corner & 1U, corner >> 1U & 1U, corner >> 2U);
        }
        SCOPED_TRACE(bits);
        compare(t[0], t[1], 1, answers);
        if (HasFatalFailure()) return;
    }
    EXPECT_GT(answers.meeting, 50000);
    EXPECT_GT(answers.apart, 50000);
}

TEST(TriangleContact, AgreesWithTheHullOfDifferencesInIntegers)
{
    constexpr unsigned seed = 1;
    std::mt19937 random(seed);
    Answers answers;
    for (int n = 0; n < 150000; ++n) {
        const std::int64_t size = n % 4 == 0 ? 3 : n % 4 == 1 ? 5 : n % 4 == 2 ? 7 : 1000;
        const bool flat = n % 5 == 0;
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
        if (n % 7 == 0) t[1][0] = t[0][1];                      // a corner in common
        if (n % 11 == 0) t[1][2] = t[1][1];                     // a segment
        if (n % 13 == 0) t[0][2] = 2 * t[0][1] - t[0][0];       // another one
        if (n % 17 == 0) t[1][0] = t[1][1] = t[1][2];           // a point
        if (n % 19 == 0) t[1][1] = t[0][0] + t[0][1] - t[1][0]; // edges that halve each other
        SCOPED_TRACE(::testing::Message() << "seed " << seed << " case " << n);
        compare(t[0], t[1], 0.25, answers);
        if (HasFatalFailure()) return;
    }
    EXPECT_GT(answers.meeting, 20000);
    EXPECT_GT(answers.apart, 20000);
}

TEST(TriangleContact, DetectsAGapOfOneBit)
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

TEST(TriangleIntersection, IdentifiesTheFeaturesOfItsEnds)
{
    using enum TrianglePart;
    const Triangle floor = {{Vec3(0, 0, 0), Vec3(4, 0, 0), Vec3(0, 4, 0)}};
    const auto ends = [&](const Triangle& other) {
        const TriangleIntersection found = intersect(floor, other);
        std::vector<MeetingParts> list(found.ends().begin(), found.ends().end());
        std::ranges::sort(list);
        return list;
    };
    using Ends = std::vector<MeetingParts>;
    // A wedge through the face; a corner on an edge; a fin along an edge; a segment; a point.
    EXPECT_EQ(ends({{Vec3(1, 1, -1), Vec3(1, 1, 1), Vec3(1, 9, 0)}}),
              (Ends{{side_1, inside}, {inside, side_0}}));
    EXPECT_EQ(ends({{Vec3(1, 0, 0), Vec3(1, 0, 1), Vec3(2, 0, 3)}}), (Ends{{side_0, corner_0}}));
    EXPECT_EQ(ends({{Vec3(-1, 0, 0), Vec3(1, 0, 0), Vec3(0, 0, 3)}}),
              (Ends{{corner_0, side_0}, {side_0, corner_1}}));
    EXPECT_EQ(ends({{Vec3(1, 1, -1), Vec3(1, 1, 0), Vec3(1, 1, 1)}}), (Ends{{inside, side_2}}));
    EXPECT_EQ(ends({{Vec3(1, 1, 0), Vec3(1, 1, 0), Vec3(1, 1, 0)}}), (Ends{{inside, corner_0}}));
    EXPECT_EQ(ends({{Vec3(1, 1, 1), Vec3(5, 1, 1), Vec3(1, 5, 1)}}), Ends{});
}

TEST(TriangleIntersection, OfTrianglesInOnePlaneIsAPolygonInOrder)
{
    using enum TrianglePart;
    const Triangle a = {{Vec3(0, 0, 0), Vec3(6, 0, 0), Vec3(3, 6, 0)}};
    const Triangle b = {{Vec3(0, 4, 0), Vec3(3, -2, 0), Vec3(6, 4, 0)}};
    const TriangleIntersection star = intersect(a, b);
    ASSERT_EQ(star.size(), 6U);
    double doubled_area = 0;
    for (std::size_t i = 0; i < 6; ++i) {
        const Vec3 p = meeting_point(a, b, star.ends()[i]);
        const Vec3 q = meeting_point(a, b, star.ends()[(i + 1) % 6]);
        EXPECT_TRUE(is_side(star.ends()[i].of_a) && is_side(star.ends()[i].of_b));
        doubled_area += p.cross(q).z();
    }
    EXPECT_NEAR(std::abs(doubled_area), 24, 1e-12);
    EXPECT_EQ(intersect(a, a).size(), 3U);
}

/// As many ends whichever corner comes first; at the same bits whichever triangle does.
TEST(TriangleIntersection, DoesNotDependOnTheOrderOfCorners)
{
    constexpr unsigned seed = 5;
    SCOPED_TRACE(::testing::Message() << "seed " << seed);
    std::mt19937 random(seed);
    const auto number = [&] { return std::uniform_real_distribution<double>(-1, 1)(random); };
    int met = 0;
    for (int n = 0; n < 6000; ++n) {
        const bool whole = n % 2 == 0;
        Triangle a;
        Triangle b;
        for (Triangle* t : {&a, &b}) {
            for (Vec3& corner : t->vertices) {
                for (double& x : corner) x = whole ? std::round(2 * number()) : number();
            }
        }
        if (n % 3 == 0) b.vertices[1] = a[2];
        if (is_degenerate(a) || is_degenerate(b)) continue;
        const auto places = [](const Triangle& s, const Triangle& t) {
            std::vector<std::array<double, 3>> list;
            const TriangleIntersection meeting = intersect(s, t);
            for (const MeetingParts& parts : meeting.ends()) {
                const Vec3 place = meeting_point(s, t, parts);
                list.push_back({place.x(), place.y(), place.z()});
            }
            std::ranges::sort(list);
            return list;
        };
        const auto list = places(a, b);
        for (const auto& at : list) {
            const Vec3 place(at[0], at[1], at[2]);
            ASSERT_LT((closest_point(a, place).point - place).norm(), 4e-15) << "case " << n;
            ASSERT_LT((closest_point(b, place).point - place).norm(), 4e-15) << "case " << n;
            ++met;
        }
        for (int turn = 1; turn < 18; ++turn) {
            const Triangle s = turned(a, turn % 3, turn >= 9);
            const Triangle t = turned(b, turn / 3 % 3, turn % 2 != 0);
            ASSERT_EQ(places(s, t).size(), list.size()) << "case " << n;
            ASSERT_EQ(places(t, s).size(), list.size()) << "case " << n;
        }
        ASSERT_EQ(places(b, a), list) << "case " << n;
    }
    EXPECT_GT(met, 2000);
}

/// Coordinates of one axis far too small for products with those of another.
TEST(TriangleIntersection, StaysWhereItIsWhateverTheUnitsOfAxesAre)
{
    constexpr unsigned seed = 6;
    SCOPED_TRACE(::testing::Message() << "seed " << seed);
    std::mt19937 random(seed);
    std::uniform_int_distribution<int> whole(-4, 4);
    int met = 0;
    for (int n = 0; n < 2000; ++n) {
        Triangle a;
        Triangle b;
        for (Triangle* t : {&a, &b}) {
            for (Vec3& corner : t->vertices) {
                for (double& x : corner) x = whole(random);
            }
        }
        const TriangleIntersection meeting = intersect(a, b);
        for (const Vec3& units :
             {Vec3(1, 0x1p-1000, 0x1p300), Vec3(0x1p-1060, 1, 0x1p-30), Vec3(0x1p-300, 1, 1)}) {
            const auto scaled = [&](const Triangle& t) {
                return Triangle{
                    {units.cwiseProduct(t[0]), units.cwiseProduct(t[1]), units.cwiseProduct(t[2])}};
            };
            for (const MeetingParts& parts : meeting.ends()) {
                const Vec3 place = meeting_point(a, b, parts);
                const Vec3 other = meeting_point(scaled(a), scaled(b), parts);
                for (int axis = 0; axis < 3; ++axis) {
                    ASSERT_NEAR(other[axis], units[axis] * place[axis],
                                1e-14 * units[axis] + 0x1p-1073)
                        << "case " << n;
                }
                ++met;
            }
        }
    }
    EXPECT_GT(met, 3000);
}

} // namespace
} // namespace proxima::triangle_contact_test
