#include "thesis/octree_generation/triangle_cube_descent.h"

#include "geometry/triangle_box.h"
#include "minkowski/counting_number.h"
#include "oracles/integer_overlap.h"

#include <gtest/gtest.h>

#include <bit>
#include <random>

namespace proxima::triangle_cube_descent_test {
namespace {

using Integer = std::int64_t;
using Descent = TriangleCubeDescent<Integer>;
using oracle::IntegerBox;
using oracle::IntegerTriangle;

constexpr Integer root_edge = Integer{1} << 20;
constexpr int deepest = 19;

CellPlanes<Integer> planes_of(const Triple<Integer>& lower, Integer edge)
{
    CellPlanes<Integer> planes;
    for (std::size_t k = 0; k < 3; ++k) {
        planes.lower[k] = lower[k];
        planes.middle[k] = lower[k] + edge / 2;
        planes.upper[k] = lower[k] + edge;
    }
    return planes;
}

IntegerBox child_box(const CellPlanes<Integer>& planes, int octant)
{
    IntegerBox box = {};
    for (std::size_t k = 0; k < 3; ++k) {
        const bool upper = (static_cast<std::size_t>(octant) >> k & 1U) != 0;
        box.lower[k] = upper ? planes.middle[k] : planes.lower[k];
        box.upper[k] = upper ? planes.upper[k] : planes.middle[k];
    }
    return box;
}

Vec3 to_double(const oracle::Point& p)
{
    return {static_cast<double>(p[0]), static_cast<double>(p[1]), static_cast<double>(p[2])};
}

bool overlaps_in_double(const IntegerTriangle& triangle, const IntegerBox& box)
{
    const auto& v = triangle.vertices;
    return triangle_overlaps_box({{to_double(v[0]), to_double(v[1]), to_double(v[2])}},
                                 {to_double(box.lower), to_double(box.upper)});
}

// Triangles of every size in the root whose corners prefer planes of cells, so that they touch.
class TriangleGenerator {
public:
    explicit TriangleGenerator(std::uint64_t seed) : random_(seed) {}

    Integer below(Integer count)
    {
        return std::uniform_int_distribution<Integer>(0, count - 1)(random_);
    }

    IntegerTriangle operator()()
    {
        const auto reach_bits = static_cast<int>(1 + below(20));
        const Integer reach = Integer{1} << reach_bits;
        const int grid_bits = static_cast<int>(below(reach_bits + 1));
        IntegerTriangle triangle;
        oracle::Point place;
        for (Integer& coordinate : place) coordinate = below(root_edge + 1);
        for (oracle::Point& vertex : triangle.vertices) {
            for (std::size_t k = 0; k < 3; ++k) {
                Integer value =
                    std::clamp<Integer>(place[k] + below(2 * reach + 1) - reach, 0, root_edge);
                if (below(4) != 0) value = value >> grid_bits << grid_bits;
                vertex[k] = value;
            }
        }
        auto& v = triangle.vertices;
        switch (below(8)) {
        case 0:
            v[1] = v[0];
            break; // a segment or a point
        case 1:
            v[1] = v[2] = v[0];
            break; // a point
        case 2: {  // parallel to an axis plane
            const auto k = static_cast<std::size_t>(below(3));
            v[1][k] = v[2][k] = v[0][k];
            break;
        }
        case 3: // a sliver
            for (std::size_t k = 0; k < 3; ++k) v[2][k] = (v[0][k] + v[1][k]) / 2;
            break;
        default:
            break;
        }
        return triangle;
    }

private:
    std::mt19937_64 random_;
};

// Walks down a random path of overlapped cells, all eight children checked at every depth.
struct PathChecks {
    std::int64_t children = 0;
    std::int64_t overlapping = 0;
    std::int64_t accepted_by_box = 0;
    std::int64_t accepted_by_vertex = 0;
    int deepest_cell = 0;
};

void check_path(const IntegerTriangle& triangle, Integer margin, TriangleGenerator& generate,
                PathChecks& checks)
{
    const Descent descent(triangle.vertices, root_edge, margin);
    Descent::Level level = descent.root_level();
    Descent::Cell cell = descent.root_cell();
    Triple<Integer> lower = {0, 0, 0};
    for (int depth = 0; depth < deepest; ++depth) {
        const Integer edge = root_edge >> depth;
        const CellPlanes<Integer> planes = planes_of(lower, edge);
        unsigned expected = 0;
        for (int octant = 0; octant < 8; ++octant) {
            IntegerBox box = child_box(planes, octant);
            for (std::size_t k = 0; k < 3; ++k) { // inflating the box is inflating the triangle
                box.lower[k] -= margin;
                box.upper[k] += margin;
            }
            const bool overlaps = oracle::overlaps(triangle, box);
            ASSERT_EQ(overlaps_in_double(triangle, box), overlaps) << "depth " << depth;
            expected |= static_cast<unsigned>(overlaps) << octant;
        }
        const unsigned boxed = descent.box_octants(planes);
        const unsigned at_vertices = descent.vertex_octants(planes);
        ASSERT_EQ(descent.half_space_octants(level, cell) & boxed, expected) << "depth " << depth;
        ASSERT_EQ(descent.overlapped_octants(level, cell, planes), expected) << "depth " << depth;
        ASSERT_EQ(at_vertices & ~expected, 0U) << "depth " << depth;
        if (std::has_single_bit(boxed)) {
            ASSERT_EQ(expected, boxed) << "depth " << depth;
            ++checks.accepted_by_box;
        }
        checks.children += 8;
        checks.overlapping += std::popcount(expected);
        checks.accepted_by_vertex += std::popcount(at_vertices);
        checks.deepest_cell = std::max(checks.deepest_cell, depth + 1);
        ASSERT_NE(expected, 0U);
        int octant = static_cast<int>(generate.below(8));
        while ((expected >> octant & 1U) == 0) octant = (octant + 1) % 8;
        lower = child_box(planes, octant).lower;
        cell = Descent::child(level, cell, octant);
        if (depth + 1 < deepest) level = descent.next_level(level);
    }
}

TEST(TriangleCubeDescent, EqualsTheOraclesAtEveryDepth)
{
    constexpr std::uint64_t seed = 111;
    for (const Integer margin : {0, 1}) {
        SCOPED_TRACE(::testing::Message() << "seed " << seed << " margin " << margin);
        TriangleGenerator generate(seed);
        PathChecks checks;
        for (int path = 0; path < 5'000; ++path) {
            SCOPED_TRACE(::testing::Message() << "path " << path);
            check_path(generate(), margin, generate, checks);
            if (HasFatalFailure()) return;
        }
        EXPECT_EQ(checks.deepest_cell, deepest);
        EXPECT_GT(checks.children, 700'000);
        EXPECT_GT(checks.overlapping, checks.children / 8);
        EXPECT_GT(checks.accepted_by_box, 5'000);
        EXPECT_GT(checks.accepted_by_vertex, 20'000);
    }
}

TEST(TriangleCubeDescent, TracksTheValuesOfACellComputedDirectly)
{
    constexpr std::uint64_t seed = 112;
    TriangleGenerator generate(seed);
    for (int path = 0; path < 2'000; ++path) {
        const IntegerTriangle triangle = generate();
        const TriangleCubeSum<Integer> sum(triangle.vertices);
        const Descent descent(triangle.vertices, root_edge, 0);
        Descent::Level level = descent.root_level();
        Descent::Cell cell = descent.root_cell();
        oracle::Point lower = {0, 0, 0};
        for (int depth = 0; depth < deepest; ++depth) {
            const CellPlanes<Integer> planes = planes_of(lower, root_edge >> depth);
            const auto octant = static_cast<int>(generate.below(8));
            lower = child_box(planes, octant).lower;
            cell = Descent::child(level, cell, octant);
            const auto from = oracle::subtract(lower, triangle.vertices[0]);
            ASSERT_EQ(static_cast<oracle::Wide>(cell.plane),
                      oracle::dot(sum.triangle_normal(), from))
                << "seed " << seed << " path " << path << " depth " << depth;
            for (int k = 0; k < 3; ++k) {
                for (int i = 0; i < 3; ++i) {
                    const auto& side = sum.edge_side(k, i);
                    const auto to_corner =
                        oracle::subtract(lower, triangle.vertices[static_cast<std::size_t>(i)]);
                    ASSERT_EQ(cell.side[static_cast<std::size_t>(3 * k + i)],
                              side.u * to_corner[static_cast<std::size_t>((k + 1) % 3)] +
                                  side.w * to_corner[static_cast<std::size_t>((k + 2) % 3)])
                        << "seed " << seed << " path " << path << " depth " << depth;
                }
            }
            if (depth + 1 < deepest) level = descent.next_level(level);
        }
    }
}

// The largest values the bounds allow: triangles between corners of the root. (The sanitizer build
// sees overflow of the recurrence itself.)
TEST(TriangleCubeDescent, DoesNotOverflowBetweenCornersOfTheRoot)
{
    constexpr std::uint64_t seed = 115;
    const IntegerBox root = {{0, 0, 0}, {root_edge, root_edge, root_edge}};
    TriangleGenerator generate(seed);
    PathChecks checks;
    for (unsigned corners = 0; corners < 512; ++corners) {
        const IntegerTriangle triangle = {{oracle::corner(root, corners & 7U),
                                           oracle::corner(root, corners >> 3U & 7U),
                                           oracle::corner(root, corners >> 6U)}};
        for (const Integer margin : {0, 1}) {
            SCOPED_TRACE(::testing::Message() << "seed " << seed << " corners " << corners);
            check_path(triangle, margin, generate, checks);
            if (HasFatalFailure()) return;
        }
    }
}

// The original triangle lies within half a unit of the snapped one; tested on a grid 64 times
// finer.
TEST(TriangleCubeDescent, MarginOfOneUnitMissesNothingOfTheOriginal)
{
    constexpr std::uint64_t seed = 113;
    constexpr Integer fine = 64;
    constexpr Integer edge = Integer{1} << 14; // so that the fine oracle stays in its range
    TriangleGenerator generate(seed);
    for (int i = 0; i < 3'000; ++i) {
        IntegerTriangle original = generate();
        CornerCoordinates<Integer> snapped;
        for (std::size_t j = 0; j < 3; ++j) {
            for (std::size_t k = 0; k < 3; ++k) {
                original.vertices[j][k] = original.vertices[j][k] % (edge * fine + 1);
                snapped[j][k] = (original.vertices[j][k] + fine / 2) / fine;
            }
        }
        const Descent descent(snapped, edge, 1);
        Descent::Level level = descent.root_level();
        Descent::Cell cell = descent.root_cell();
        Triple<Integer> lower = {0, 0, 0};
        for (int depth = 0; depth < 13; ++depth) {
            const CellPlanes<Integer> planes = planes_of(lower, edge >> depth);
            const unsigned kept = descent.overlapped_octants(level, cell, planes);
            unsigned needed = 0;
            for (int octant = 0; octant < 8; ++octant) {
                IntegerBox box = child_box(planes, octant);
                for (std::size_t k = 0; k < 3; ++k) {
                    box.lower[k] *= fine;
                    box.upper[k] *= fine;
                }
                needed |= static_cast<unsigned>(oracle::overlaps(original, box)) << octant;
            }
            ASSERT_EQ(needed & ~kept, 0U) << "seed " << seed << " triangle " << i;
            ASSERT_NE(needed, 0U);
            int octant = static_cast<int>(generate.below(8));
            while ((needed >> octant & 1U) == 0) octant = (octant + 1) % 8;
            lower = child_box(planes, octant).lower;
            cell = Descent::child(level, cell, octant);
            if (depth + 1 < 13) level = descent.next_level(level);
        }
    }
}

TEST(TriangleCubeDescent, DoublesAgreeWhileNothingRounds)
{
    constexpr std::uint64_t seed = 114;
    TriangleGenerator generate(seed);
    for (int i = 0; i < 5'000; ++i) {
        IntegerTriangle triangle = generate();
        CornerCoordinates<double> vertices;
        for (std::size_t j = 0; j < 3; ++j) {
            for (std::size_t k = 0; k < 3; ++k) {
                triangle.vertices[j][k] >>= 6; // 14 bits: products of three stay below 2^53
                vertices[j][k] = static_cast<double>(triangle.vertices[j][k]);
            }
        }
        const Descent exact(triangle.vertices, root_edge >> 6, 1);
        const TriangleCubeDescent<double> rounded(vertices, static_cast<double>(root_edge >> 6), 1);
        Descent::Level level = exact.root_level();
        Descent::Cell cell = exact.root_cell();
        auto rounded_level = rounded.root_level();
        auto rounded_cell = rounded.root_cell();
        for (int depth = 0; depth < 12; ++depth) {
            ASSERT_EQ(exact.half_space_octants(level, cell),
                      rounded.half_space_octants(rounded_level, rounded_cell))
                << "seed " << seed << " triangle " << i;
            const auto octant = static_cast<int>(generate.below(8));
            cell = Descent::child(level, cell, octant);
            rounded_cell = TriangleCubeDescent<double>::child(rounded_level, rounded_cell, octant);
            level = exact.next_level(level);
            rounded_level = rounded.next_level(rounded_level);
        }
    }
}

TEST(TriangleCubeDescent, TakesTheStatedNumberOfOperations)
{
    using Counting = TriangleCubeDescent<CountingNumber>;
    const CornerCoordinates<CountingNumber> vertices = {{{0, 0, 0}, {97, 13, 5}, {11, 89, 43}}};
    CountingNumber::tally = {};
    const Counting descent(vertices, 128, 0);
    EXPECT_EQ(CountingNumber::tally.flops(), 96);
    CountingNumber::tally = {};
    const Counting inflated(vertices, 128, 1);
    EXPECT_EQ(CountingNumber::tally.flops(), 142);
    CountingNumber::tally = {};
    (void)Counting::half_space_octants(descent.root_level(), descent.root_cell());
    EXPECT_EQ(CountingNumber::tally.additions, 34);
    EXPECT_EQ(CountingNumber::tally.multiplications, 0);
    CountingNumber::tally = {};
    (void)Counting::child(descent.root_level(), descent.root_cell(), 7);
    EXPECT_EQ(CountingNumber::tally.additions, 21);
    EXPECT_EQ(CountingNumber::tally.multiplications, 0);
}

} // namespace
} // namespace proxima::triangle_cube_descent_test
