// The four overlap tests where doubles are exact: whole coordinates, touching and degenerate pairs.
#include "oracles/integer_overlap.h"
#include "thesis/octree_generation/all_overlap_tests.h"

#include <gtest/gtest.h>

#include <cmath>
#include <iostream>
#include <type_traits>

namespace proxima::overlap_tests_test {
namespace {

Vec3 to_vec3(const oracle::Point& point)
{
    return {static_cast<double>(point[0]), static_cast<double>(point[1]),
            static_cast<double>(point[2])};
}

Triangle to_triangle(const oracle::IntegerTriangle& triangle)
{
    return {{to_vec3(triangle.vertices[0]), to_vec3(triangle.vertices[1]),
             to_vec3(triangle.vertices[2])}};
}

bool is_solid(const oracle::IntegerBox& box)
{
    return box.lower[0] < box.upper[0] && box.lower[1] < box.upper[1] &&
           box.lower[2] < box.upper[2];
}

struct Tally {
    int pairs = 0;
    int overlapping = 0;
    int uncertain = 0;
    int wrong = 0;
};

std::ostream& operator<<(std::ostream& out, const Tally& tally)
{
    return out << tally.pairs << " pairs, " << tally.overlapping << " overlapping, "
               << tally.uncertain << " uncertain, " << tally.wrong << " wrong and uncertain";
}

template <class Test>
class OverlapTests : public ::testing::Test {};

TYPED_TEST_SUITE(OverlapTests, testing::AllOverlapTests, testing::OverlapTestNames);

/// Only the pairwise test divides, and so rounds on whole numbers: its touching answers may be
/// wrong where they are not certain. The others must be right.
template <class Test>
constexpr bool is_exact_on_whole_numbers = !std::is_same_v<Test, PairwiseTest>;

template <class Test>
void check(const Test& test, const oracle::IntegerTriangle& triangle, const oracle::IntegerBox& box,
           Tally& tally)
{
    const bool expected = oracle::overlaps(triangle, box);
    const Vec3 centre = 0.5 * (to_vec3(box.lower) + to_vec3(box.upper));
    const Overlap answer = test.overlap(centre);
    ++tally.pairs;
    tally.overlapping += expected ? 1 : 0;
    tally.uncertain += answer.certain ? 0 : 1;
    tally.wrong += answer.overlaps != expected ? 1 : 0;
    if (answer.certain || is_exact_on_whole_numbers<Test>) {
        ASSERT_EQ(answer.overlaps, expected)
            << "box " << to_vec3(box.lower).transpose() << " to " << to_vec3(box.upper).transpose()
            << ", triangle " << to_vec3(triangle.vertices[0]).transpose() << ", "
            << to_vec3(triangle.vertices[1]).transpose() << ", "
            << to_vec3(triangle.vertices[2]).transpose();
    }
}

template <class Test>
Tally check_random_pairs(std::uint64_t seed, std::int64_t size, int count)
{
    oracle::PairGenerator generate(seed, size);
    Tally tally;
    for (int i = 0; i < count; ++i) {
        const oracle::IntegerPair pair = generate();
        if (!is_solid(pair.box)) continue;
        Test test(to_triangle(pair.triangle));
        test.set_half_size(0.5 * (to_vec3(pair.box.upper) - to_vec3(pair.box.lower)));
        check(test, pair.triangle, pair.box, tally);
        if (::testing::Test::HasFatalFailure()) break;
    }
    return tally;
}

TYPED_TEST(OverlapTests, AgreeWithIntegersOnTouchingAndDegeneratePairs)
{
    for (const std::int64_t size : {4, 8, 100, 4000}) {
        SCOPED_TRACE(size);
        const Tally tally = check_random_pairs<TypeParam>(1, size, 100'000);
        std::cout << "coordinates 0 to " << size << ": " << tally << "\n";
        EXPECT_GT(tally.overlapping, 10'000);
        EXPECT_GT(tally.pairs - tally.overlapping, 10'000);
        EXPECT_LE(tally.wrong, tally.uncertain);
    }
}

/// All cells of all depths of the root [0, 8]^3 against one triangle, as the builder would ask.
TYPED_TEST(OverlapTests, AgreeWithIntegersDownAnOctree)
{
    oracle::PairGenerator generate(2, 8);
    Tally tally;
    for (int i = 0; i < 150; ++i) {
        oracle::IntegerTriangle triangle = generate().triangle;
        TypeParam test(to_triangle(triangle));
        for (std::int64_t edge = 8; edge >= 1; edge /= 2) {
            test.set_half_size(Vec3::Constant(static_cast<double>(edge) / 2));
            for (std::int64_t x = 0; x < 8; x += edge) {
                for (std::int64_t y = 0; y < 8; y += edge) {
                    for (std::int64_t z = 0; z < 8; z += edge) {
                        check(test, triangle, {{x, y, z}, {x + edge, y + edge, z + edge}}, tally);
                        ASSERT_FALSE(this->HasFatalFailure());
                    }
                }
            }
        }
    }
    std::cout << tally << "\n";
}

TYPED_TEST(OverlapTests, AnswerKnownPairs)
{
    struct Case {
        const char* what;
        Triangle triangle;
        bool overlaps;
    };
    const Case cases[] = {
        {"wholly inside", {{Vec3(.1, .2, .3), Vec3(.5, .2, .1), Vec3(.3, .6, .2)}}, true},
        {"around the cell", {{Vec3(-9, -9, 0), Vec3(9, -9, 0.125), Vec3(0, 18, 0)}}, true},
        {"cutting one edge", {{Vec3(0.5, 2, 0), Vec3(2, 0.5, 0), Vec3(2, 2, 0)}}, false},
        {"in the plane of a face", {{Vec3(-9, -9, 1), Vec3(9, -9, 1), Vec3(0, 18, 1)}}, true},
        {"in that plane, beside", {{Vec3(2, 2, 1), Vec3(9, 2, 1), Vec3(2, 18, 1)}}, false},
        {"edge on edge", {{Vec3(1, 1, -9), Vec3(1, 1, 9), Vec3(5, 5, 0)}}, true},
        {"edge on part of an edge", {{Vec3(1, 1, 0), Vec3(1, 1, 0.5), Vec3(5, 5, 0)}}, true},
        {"vertex on a corner", {{Vec3(1, 1, 1), Vec3(5, 4, 3), Vec3(3, 5, 4)}}, true},
        {"corner in the face", {{Vec3(3, 0, 0), Vec3(0, 3, 0), Vec3(0, 0, 3)}}, true},
        {"just past the corner",
         {{Vec3(3.0625, 0, 0), Vec3(0, 3.0625, 0), Vec3(0, 0, 3.0625)}},
         false},
        {"edge through a corner", {{Vec3(1, -1, 3), Vec3(1, 3, -1), Vec3(9, 9, 9)}}, true},
        {"segment through", {{Vec3(-2, -2, -2), Vec3(2, 2, 2), Vec3(0, 0, 0)}}, true},
        {"segment, two vertices equal", {{Vec3(-2, 0, 0), Vec3(-2, 0, 0), Vec3(2, 0, 0)}}, true},
        {"segment touching an edge", {{Vec3(2, 0, 0), Vec3(0, 2, 0), Vec3(1, 1, 0)}}, true},
        {"segment passing an edge",
         {{Vec3(2.25, 0, 0), Vec3(0, 2.25, 0), Vec3(2.25, 0, 0)}},
         false},
        {"point inside", {{Vec3(0.5, 0, 0), Vec3(0.5, 0, 0), Vec3(0.5, 0, 0)}}, true},
        {"point on a face", {{Vec3(1, 0, 0), Vec3(1, 0, 0), Vec3(1, 0, 0)}}, true},
        {"point outside", {{Vec3(1.5, 0, 0), Vec3(1.5, 0, 0), Vec3(1.5, 0, 0)}}, false},
        {"far away", {{Vec3(90, 0, 0), Vec3(90, 1, 0), Vec3(90, 0, 1)}}, false}};
    for (const Case& pair : cases) {
        TypeParam test(pair.triangle);
        test.set_half_size(Vec3::Ones());
        EXPECT_EQ(test.overlap(Vec3::Zero()).overlaps, pair.overlaps) << pair.what;
    }
}

TYPED_TEST(OverlapTests, AreCertainOfClearPairs)
{
    TypeParam through(Triangle{{Vec3(-1.5, .2, .3), Vec3(5, .2, .1), Vec3(.3, 6, .2)}});
    through.set_half_size(Vec3::Ones());
    EXPECT_TRUE(through.overlap(Vec3::Zero()).overlaps);
    EXPECT_TRUE(through.overlap(Vec3::Zero()).certain);
    for (const Vec3& beside : {Vec3(0, 0, 4), Vec3(4, 4, 0), Vec3(90, 0, 0), Vec3(0, 0, 1.5)}) {
        EXPECT_FALSE(through.overlap(beside).overlaps);
        EXPECT_TRUE(through.overlap(beside).certain) << beside.transpose();
    }
    TypeParam corner(Triangle{{Vec3(3, 0, 0), Vec3(0, 3, 0), Vec3(0, 0, 3)}});
    corner.set_half_size(Vec3::Ones());
    EXPECT_FALSE(corner.overlap(Vec3::Zero()).certain) << "the corner touches the triangle";
}

/// Coordinates that doubles cannot work with give no certain answer, and no trap.
TYPED_TEST(OverlapTests, AreNeverCertainOutsideTheirRange)
{
    const double infinity = std::numeric_limits<double>::infinity();
    const double nan = std::numeric_limits<double>::quiet_NaN();
    for (const double scale : {1e-300, 1e-100, 1e100, 1e300, infinity, nan}) {
        TypeParam test(
            Triangle{{scale * Vec3(.1, .2, .3), scale * Vec3(5, .2, .1), scale * Vec3(1, 6, 7)}});
        test.set_half_size(Vec3::Constant(scale));
        EXPECT_FALSE(test.overlap(Vec3::Zero()).certain) << scale;
    }
    // Cells too small for the spacing of doubles at their place.
    TypeParam far(Triangle{{Vec3(1e9, 0, 0), Vec3(1e9, 1, 0), Vec3(1e9, 0, 1)}});
    far.set_half_size(Vec3::Constant(1));
    EXPECT_TRUE(far.overlap(Vec3(1e9 + 0.5, 0.25, 0.25)).certain);
    far.set_half_size(Vec3::Constant(1e-7));
    EXPECT_FALSE(far.overlap(Vec3(1e9, 0, 0)).certain);
    EXPECT_FALSE(far.overlap(Vec3(1e9, 0, 5)).certain);
}

} // namespace
} // namespace proxima::overlap_tests_test
