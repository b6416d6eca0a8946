#include "thesis/octree_generation/triangle_cube_sum.h"

#include "geometry/triangle_box.h"
#include "minkowski/counting_number.h"
#include "oracles/integer_overlap.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numeric>
#include <random>
#include <set>
#include <utility>

namespace proxima::triangle_cube_sum_test {
namespace {

using Integer = std::int64_t;
using oracle::IntegerPair;
using oracle::PairGenerator;

/// A half-space normal . x <= offset with coprime components, so that equal ones compare equal.
using HalfSpace = std::pair<Triple<Integer>, Integer>;

HalfSpace reduced(const Triple<Integer>& normal, Integer offset)
{
    const Integer divisor = std::gcd(std::gcd(normal[0], normal[1]), normal[2]);
    return {{normal[0] / divisor, normal[1] / divisor, normal[2] / divisor}, offset / divisor};
}

Integer dot(const Triple<Integer>& a, const Triple<Integer>& b)
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

Triple<Integer> sum_vertex(const CornerCoordinates<Integer>& vertices, int index, Integer half_size)
{
    Triple<Integer> point = vertices[static_cast<std::size_t>(index / 8)];
    for (std::size_t k = 0; k < 3; ++k) {
        const bool upper = (static_cast<std::size_t>(index % 8) >> k & 1U) != 0;
        point[k] += upper ? half_size : -half_size;
    }
    return point;
}

// Facets of the hull of the 24 sums by trying all planes through three of them.
std::set<HalfSpace> facets_by_brute_force(const CornerCoordinates<Integer>& vertices,
                                          Integer half_size)
{
    std::array<Triple<Integer>, 24> points;
    for (int k = 0; k < 24; ++k)
        points[static_cast<std::size_t>(k)] = sum_vertex(vertices, k, half_size);
    std::set<HalfSpace> facets;
    for (std::size_t a = 0; a < 24; ++a) {
        for (std::size_t b = a + 1; b < 24; ++b) {
            for (std::size_t c = b + 1; c < 24; ++c) {
                const Triple<Integer> normal = oracle::cross(
                    oracle::subtract(points[b], points[a]), oracle::subtract(points[c], points[a]));
                if (normal == Triple<Integer>{0, 0, 0}) continue;
                const Integer offset = dot(normal, points[a]);
                bool above = false;
                bool below = false;
                for (const auto& point : points) {
                    const Integer value = dot(normal, point);
                    above = above || value > offset;
                    below = below || value < offset;
                    if (above && below) break;
                }
                if (!above) facets.insert(reduced(normal, offset));
                if (!below) facets.insert(reduced({-normal[0], -normal[1], -normal[2]}, -offset));
            }
        }
    }
    return facets;
}

// The 17 half-spaces, their offsets found through the support's index; equal ones merge.
std::set<HalfSpace> facets_in_closed_form(const CornerCoordinates<Integer>& vertices,
                                          Integer half_size)
{
    const TriangleCubeSum<Integer> sum(vertices);
    std::set<HalfSpace> facets;
    for (int i = 0; i < triangle_cube_half_spaces; ++i) {
        const Triple<Integer> normal = sum.normal(i);
        if (normal == Triple<Integer>{0, 0, 0}) continue;
        facets.insert(
            reduced(normal, dot(normal, sum_vertex(vertices, sum.support(i).index(), half_size))));
    }
    return facets;
}

TEST(TriangleCubeSum, HasExactlyTheFacetsOfTheHull)
{
    constexpr std::uint64_t seed = 101;
    SCOPED_TRACE(::testing::Message() << "seed " << seed);
    std::size_t most = 0;
    for (const Integer size : {3, 12, 1000}) {
        PairGenerator generate(seed, size);
        int with_17 = 0;
        for (int i = 0; i < 1'500; ++i) {
            CornerCoordinates<Integer> vertices = generate().triangle.vertices;
            if (i % 2 == 0) // plainly random ones too
                for (auto& vertex : vertices) vertex = generate.random_point();
            const Integer half_size = 1 + generate.below(size);
            const auto expected = facets_by_brute_force(vertices, half_size);
            ASSERT_EQ(facets_in_closed_form(vertices, half_size), expected)
                << "grid " << size << " triangle " << i;
            most = std::max(most, expected.size());
            with_17 += expected.size() == 17 ? 1 : 0;
        }
        EXPECT_GT(with_17, size == 1000 ? 700 : 0);
    }
    EXPECT_EQ(most, 17U);
}

TEST(TriangleCubeSum, KeepsItsSupportsAtEverySize)
{
    constexpr std::uint64_t seed = 102;
    PairGenerator generate(seed, 1000);
    for (int i = 0; i < 2'000; ++i) {
        const CornerCoordinates<Integer> vertices = generate().triangle.vertices;
        const TriangleCubeSum<Integer> sum(vertices);
        for (int side = 0; side < triangle_cube_half_spaces; ++side) {
            const Triple<Integer> normal = sum.normal(side);
            const SumSupport support = sum.support(side);
            EXPECT_EQ(support.index() % 8, support.cube_corner);
            EXPECT_EQ(support.index() / 8, support.triangle_vertex);
            for (const Integer half_size : {0, 1, 17, 4096}) {
                const Integer at_support =
                    dot(normal, sum_vertex(vertices, support.index(), half_size));
                for (int k = 0; k < 24; ++k) {
                    ASSERT_LE(dot(normal, sum_vertex(vertices, k, half_size)), at_support)
                        << "seed " << seed << " triangle " << i << " half-space " << side;
                }
            }
        }
    }
}

// A cube or box with whole centre and half edges around a random place of the pair's box.
IntegerPair with_even_box(IntegerPair pair, bool cube)
{
    for (std::size_t k = 0; k < 3; ++k) {
        const std::size_t like = cube ? 0 : k;
        const Integer edge = (pair.box.upper[like] - pair.box.lower[like]) / 2 * 2;
        pair.box.upper[k] = pair.box.lower[k] + edge;
    }
    return pair;
}

template <class T>
bool contains_center(const IntegerPair& pair, bool cube)
{
    CornerCoordinates<T> vertices;
    Triple<T> center;
    Triple<T> half;
    for (std::size_t k = 0; k < 3; ++k) {
        for (std::size_t j = 0; j < 3; ++j)
            vertices[j][k] = static_cast<T>(pair.triangle.vertices[j][k]);
        const Integer whole_half = (pair.box.upper[k] - pair.box.lower[k]) / 2;
        center[k] = static_cast<T>(pair.box.lower[k] + whole_half);
        half[k] = static_cast<T>(whole_half);
    }
    TriangleCubeSum<T> sum(vertices);
    if (cube) {
        sum.set_half_size(half[0]);
    } else {
        sum.set_half_sizes(half);
    }
    return sum.contains(center);
}

TEST(TriangleCubeSum, ContainsCentersOfTouchingBoxesAndCubes)
{
    constexpr std::uint64_t seed = 103;
    for (const Integer size : {2, 8, 1000, 1 << 16}) {
        PairGenerator generate(seed, size);
        int overlapping = 0;
        for (int i = 0; i < 100'000; ++i) {
            const bool cube = i % 2 == 0;
            const IntegerPair pair = with_even_box(generate(), cube);
            const bool expected = oracle::overlaps(pair.triangle, pair.box);
            ASSERT_EQ(contains_center<Integer>(pair, cube), expected)
                << "seed " << seed << " grid " << size << " pair " << i;
            // Up to here no product rounds in double either.
            ASSERT_EQ(contains_center<double>(pair, cube), expected)
                << "seed " << seed << " grid " << size << " pair " << i;
            overlapping += expected ? 1 : 0;
        }
        EXPECT_GT(overlapping, 10'000);
        EXPECT_LT(overlapping, 90'000);
    }
}

TEST(TriangleCubeSum, IsExactInIntegersUpToTheLimitOfTheGrid)
{
    constexpr std::uint64_t seed = 104;
    PairGenerator generate(seed, 1 << 20);
    for (int i = 0; i < 100'000; ++i) {
        IntegerPair pair = with_even_box(generate(), false);
        for (auto& vertex : pair.triangle.vertices) {
            for (Integer& coordinate : vertex)
                coordinate = std::clamp<Integer>(coordinate, 0, 1 << 20);
        }
        ASSERT_EQ(contains_center<Integer>(pair, false), oracle::overlaps(pair.triangle, pair.box))
            << "seed " << seed << " pair " << i;
    }
}

TEST(TriangleCubeSum, TakesTheStatedNumberOfOperations)
{
    const CornerCoordinates<CountingNumber> vertices = {{{0, 0, 0}, {97, 13, 5}, {11, 89, 43}}};
    CountingNumber::tally = {};
    TriangleCubeSum<CountingNumber> sum(vertices);
    EXPECT_EQ(CountingNumber::tally.flops(), 61);
    CountingNumber::tally = {};
    sum.set_half_size(20);
    EXPECT_EQ(CountingNumber::tally.flops(), 27);
    CountingNumber::tally = {};
    sum.set_half_sizes({20, 20, 20});
    EXPECT_EQ(CountingNumber::tally.flops(), 49);
    CountingNumber::tally = {};
    EXPECT_TRUE(sum.contains({36, 34, 16})); // the worst case: a cell that overlaps
    EXPECT_EQ(CountingNumber::tally.flops(), 32);
    EXPECT_EQ(CountingNumber::tally.comparisons, 17);
}

} // namespace
} // namespace proxima::triangle_cube_sum_test
