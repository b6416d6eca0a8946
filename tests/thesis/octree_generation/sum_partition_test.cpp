// Partitions of sums against all of the sum's half-spaces, one after the other.
#include "thesis/octree_generation/sum_partition.h"

#include "code_of.h"
#include "minkowski/polytopes.h"

#include <gtest/gtest.h>

#include <cmath>

namespace proxima::sum_partition_test {
namespace {

using test::Points;

MinkowskiSum sum_of(const ConvexPolyhedron& a, const ConvexPolyhedron& b)
{
    auto sum = minkowski_sum(a, b);
    if (!sum) throw std::runtime_error(describe(sum.error()));
    return *sum;
}

SumPartition partition_of(const MinkowskiSum& sum, const PartitionOptions& options = {})
{
    auto partition = partition_sum(sum, options);
    if (!partition) throw std::runtime_error(describe(partition.error()));
    return *partition;
}

/// How far beyond the facet's plane that it is farthest beyond.
double farthest_beyond(const MinkowskiSum& sum, const Vec3& point)
{
    double beyond = -std::numeric_limits<double>::infinity();
    for (std::uint32_t facet = 0; facet < sum.facet_count(); ++facet) {
        const HalfSpace plane = sum.half_space(facet);
        beyond = std::max(beyond, plane.normal.dot(point) - plane.offset);
    }
    return beyond;
}

/// Points in and around the bounding box, and close to corners, edges and facets of the sum.
Points query_points(std::mt19937& random, const MinkowskiSum& sum, const Box& box, int count)
{
    std::uniform_real_distribution<double> unit(0, 1);
    std::uniform_int_distribution<std::uint32_t> vertex(
        0, static_cast<std::uint32_t>(sum.vertex_count() - 1));
    const auto in_box = [&](double margin) {
        Vec3 point;
        for (int axis = 0; axis < 3; ++axis) {
            const double extent = box.extent()[axis];
            point[axis] =
                box.lower[axis] - margin * extent + (1 + 2 * margin) * extent * unit(random);
        }
        return point;
    };
    Points points;
    for (int i = 0; i < count; ++i) {
        switch (i % 4) {
        case 0:
            points.push_back(in_box(0));
            break;
        case 1:
            points.push_back(in_box(0.1));
            break;
        case 2: { // on the boundary or near it, or on a chord of corners
            const double t = unit(random);
            points.emplace_back((1 - t) * sum.position(vertex(random)) +
                                t * sum.position(vertex(random)));
            points.back() += 1e-9 * (unit(random) - 0.5) * in_box(0);
            break;
        }
        default:
            points.push_back(sum.position(vertex(random)));
            points.back() += (i % 8 == 3 ? 1e-6 : 0.0) * (in_box(0) - points.back());
            break;
        }
    }
    return points;
}

void expect_same_answers(const MinkowskiSum& sum, const SumPartition& partition,
                         std::mt19937& random, int count)
{
    const double size = partition.bounds().extent().maxCoeff();
    for (const Vec3& point : query_points(random, sum, partition.bounds(), count)) {
        const double beyond = farthest_beyond(sum, point);
        PartitionEvaluations evaluations;
        const bool found = partition.contains(point);
        EXPECT_EQ(found, partition.contains(point, evaluations));
        EXPECT_GT(evaluations.total(), 0);
        if (std::abs(beyond) < 1e-13 * size) continue;
        EXPECT_EQ(found, beyond < 0);
    }
}

TEST(SumPartition, AnswersLikeATestOfAllFacets)
{
    int bodies = 0;
    for (unsigned seed = 0; seed < 400; ++seed) {
        SCOPED_TRACE(seed);
        std::mt19937 random(seed);
        const MinkowskiSum sum = sum_of(test::hull_of(test::nasty_points(random)),
                                        test::hull_of(test::nasty_points(random)));
        if (sum.dimension() != 3) {
            EXPECT_EQ(code_of(partition_sum(sum)), ErrorCode::invalid_argument);
            continue;
        }
        ++bodies;
        expect_same_answers(sum, partition_of(sum), random, 400);
    }
    EXPECT_GT(bodies, 200);
}

TEST(SumPartition, AnswersForTriangleAndCube)
{
    const ConvexPolyhedron cube = test::hull_of(test::cube_points(0.25));
    for (unsigned seed = 0; seed < 200; ++seed) {
        SCOPED_TRACE(seed);
        std::mt19937 random(seed);
        std::uniform_real_distribution<double> coordinate(-1, 1);
        Points triangle(3);
        for (Vec3& point : triangle)
            for (double& value : point) value = coordinate(random);
        const MinkowskiSum sum = sum_of(test::hull_of(triangle), cube);
        ASSERT_EQ(sum.facet_count(), 17U);
        const SumPartition partition = partition_of(sum);
        EXPECT_EQ(partition.facet_count(), 17U);
        expect_same_answers(sum, partition, random, 400);
    }
}

/// On half-grid points every touching query is exact: the closed sum holds its boundary.
TEST(SumPartition, ContainsItsBoundary)
{
    for (unsigned seed = 0; seed < 100; ++seed) {
        SCOPED_TRACE(seed);
        std::mt19937 random(seed);
        // Octagonal prisms and boxes: normals whose products with halves are exact.
        const double h = 1 + static_cast<double>(seed % 3);
        const MinkowskiSum sum =
            sum_of(test::hull_of(test::cube_points(h)), test::hull_of(test::octahedron_points(2)));
        const SumPartition partition = partition_of(sum);
        std::uniform_int_distribution<int> half(-12, 12);
        for (int i = 0; i < 200; ++i) {
            const Vec3 point(half(random) / 2.0, half(random) / 2.0, half(random) / 2.0);
            const Vec3 outside_cube = (point.cwiseAbs().array() - h).max(0).matrix();
            const bool expected = outside_cube.sum() <= 2;
            // Where a slanted facet's rounded plane decides, it may say either.
            if (outside_cube.sum() == 2 && outside_cube.maxCoeff() < 2) continue;
            EXPECT_EQ(partition.contains(point), expected);
        }
    }
}

TEST(SumPartition, NeedsFarFewerEvaluationsOnManyFacets)
{
    std::mt19937 random(3);
    const MinkowskiSum sum = sum_of(test::hull_of(test::round_points(random, 150, 1e6)),
                                    test::hull_of(test::round_points(random, 150, 1e6)));
    const SumPartition partition = partition_of(sum);
    const SumPartition flat = partition_of(sum, {.max_depth = 0});
    EXPECT_EQ(flat.leaf_count(), 1U);
    EXPECT_EQ(flat.split_count(), 0U);
    expect_same_answers(sum, partition, random, 1000);
    expect_same_answers(sum, flat, random, 200);
    PartitionEvaluations by_tree;
    PartitionEvaluations by_list;
    for (const Vec3& point : query_points(random, sum, partition.bounds(), 4000)) {
        static_cast<void>(partition.contains(point, by_tree));
        static_cast<void>(flat.contains(point, by_list));
    }
    EXPECT_GT(by_list.total(), 20 * by_tree.total());
}

TEST(SumPartition, RefusesUnboundedSums)
{
    const ConvexPolyhedron ray = test::hull_of({Vec3::Zero()}, {Vec3(1, 2, 3)});
    const ConvexPolyhedron cube = test::hull_of(test::cube_points(1));
    EXPECT_EQ(code_of(partition_sum(sum_of(cube, ray))), ErrorCode::invalid_argument);
}

} // namespace
} // namespace proxima::sum_partition_test
