#include "thesis/object_intersections/intersect_octrees.h"

#include "cancellation.h"
#include "counted_allocations.h"
#include "geometry/triangle_contact.h"
#include "octree/nasty_meshes.h"
#include "octree/small_meshes.h"
#include "proxima/octree.h"
#include "proxima/sample_meshes.h"

#include <algorithm>
#include <gtest/gtest.h>
#include <random>
#include <set>

namespace proxima::intersect_octrees_test {
namespace {

using namespace testing;
using Long = Eigen::Matrix<long double, 3, 1>;
using Corners = std::array<Long, 8>;
using Pair = std::pair<CellKey, CellKey>;

Corners corners_of(const Box& box, const RigidTransform& pose)
{
    const Eigen::Matrix<long double, 3, 3> rotation = pose.rotation.cast<long double>();
    Corners corners;
    for (unsigned i = 0; i < 8; ++i) {
        const Vec3 corner((i & 1U) != 0 ? box.upper.x() : box.lower.x(),
                          (i & 2U) != 0 ? box.upper.y() : box.lower.y(),
                          (i & 4U) != 0 ? box.upper.z() : box.lower.z());
        corners[i] = rotation * corner.cast<long double>() + pose.translation.cast<long double>();
    }
    return corners;
}

/// The widest gap of two boxes on 15 axes, all corners projected: above 0 if and only if they are
/// apart.
long double widest_gap(const Corners& a, const Corners& b)
{
    std::vector<Long> axes;
    const auto edge = [](const Corners& c, unsigned i) -> Long {
        return (c[1U << i] - c[0]).normalized();
    };
    for (unsigned i = 0; i < 3; ++i) {
        axes.push_back(edge(a, (i + 1) % 3).cross(edge(a, (i + 2) % 3)));
        axes.push_back(edge(b, (i + 1) % 3).cross(edge(b, (i + 2) % 3)));
        for (unsigned j = 0; j < 3; ++j) {
            const Long axis = edge(a, i).cross(edge(b, j));
            if (axis.norm() > 1e-9L) axes.push_back(axis.normalized());
        }
    }
    long double gap = -1e300L;
    for (const Long& axis : axes) {
        const auto range = [&](const Corners& c) {
            std::array<long double, 8> on_axis{};
            for (std::size_t i = 0; i < 8; ++i) on_axis[i] = axis.dot(c[i]);
            const auto [low, high] = std::ranges::minmax(on_axis);
            return std::pair(low, high);
        };
        const auto [a_low, a_high] = range(a);
        const auto [b_low, b_high] = range(b);
        gap = std::max({gap, a_low - b_high, b_low - a_high});
    }
    return gap;
}

struct Leaf {
    CellKey key;
    Corners corners;
};

std::vector<Leaf> occupied_leaves(const Octree& octree, const RigidTransform& pose)
{
    struct Collector {
        const Octree& octree;
        const RigidTransform& pose;
        std::vector<Leaf> leaves = {};
        static bool should_enter(const Cell& /*cell*/) { return true; }
        Flow visit_leaf(const Cell& cell, std::span<const TriangleId> triangles)
        {
            if (!triangles.empty())
                leaves.push_back({cell.key, corners_of(octree.box(cell), pose)});
            return Flow::proceed;
        }
    };
    Collector collector{octree, pose};
    traverse(octree, collector);
    return collector.leaves;
}

std::set<Pair> keys_of(const std::vector<LeafPair>& pairs)
{
    std::set<Pair> keys;
    for (const LeafPair& pair : pairs) keys.emplace(pair.a.key, pair.b.key);
    EXPECT_EQ(keys.size(), pairs.size()) << "a pair came twice";
    return keys;
}

/// Returns how many pairs meet. Gaps below `band` may be decided either way, but overlaps not.
std::size_t compare(const Octree& a, const Octree& b, const RigidTransform& pose, long double band)
{
    const std::set<Pair> found = keys_of(intersecting_leaves(a, b, pose));
    const std::vector<Leaf> leaves_a = occupied_leaves(a, {});
    const std::vector<Leaf> leaves_b = occupied_leaves(b, pose);
    std::size_t meeting = 0;
    for (const Leaf& leaf_a : leaves_a) {
        for (const Leaf& leaf_b : leaves_b) {
            const long double gap = widest_gap(leaf_a.corners, leaf_b.corners);
            const bool listed = found.contains({leaf_a.key, leaf_b.key});
            if (gap <= 0) {
                EXPECT_TRUE(listed) << static_cast<double>(gap);
            }
            if (gap > band) {
                EXPECT_FALSE(listed) << static_cast<double>(gap);
            }
            meeting += listed ? 1U : 0U;
        }
        if (::testing::Test::HasFailure()) break;
    }
    EXPECT_EQ(meeting, found.size());
    return meeting;
}

RigidTransform random_pose(std::mt19937& random, double reach)
{
    const auto number = [&] { return std::uniform_real_distribution<double>(-1, 1)(random); };
    const Eigen::Quaterniond turn{number(), number(), number(), number()};
    return {turn.normalized().toRotationMatrix(), reach * Vec3{number(), number(), number()}};
}

Octree octree_of(const TriangleMesh& mesh, int depth, RootShape shape = RootShape::cube)
{
    return build_octree(mesh, {.max_depth = depth,
                               .threshold = 4,
                               .root_shape = shape,
                               .classification = Classification::none})
        .value();
}

TEST(IntersectOctrees, AgreesWithAllPairs)
{
    constexpr unsigned seed = 11;
    SCOPED_TRACE(::testing::Message() << "seed " << seed);
    std::mt19937 random(seed);
    std::size_t meeting = 0;
    for (int i = 0; i < 12; ++i) {
        const Octree a =
            octree_of(make_sphere(6, 7), 1 + i % 3, i % 2 == 0 ? RootShape::cube : RootShape::box);
        const Octree b = octree_of(torus_mesh(1.0, 0.3, 9, 5), 3 - i % 3,
                                   i % 4 < 2 ? RootShape::cube : RootShape::box);
        meeting += compare(a, b, random_pose(random, 1.5), 1e-13L);
        if (HasFailure()) return;
    }
    EXPECT_GT(meeting, 1000U);
}

TEST(IntersectOctrees, AgreesWithAllPairsOnNastyMeshesAndSkewPoses)
{
    constexpr unsigned seed = 12;
    SCOPED_TRACE(::testing::Message() << "seed " << seed);
    std::mt19937 random(seed);
    std::size_t meeting = 0;
    for (std::uint32_t i = 0; i < 24; ++i) {
        const TriangleMesh mesh_a = nasty_mesh(i);
        const TriangleMesh mesh_b = nasty_mesh(i + 1);
        const double reach = bounding_box(mesh_a).extent().norm();
        RigidTransform pose = random_pose(random, reach);
        pose.translation +=
            bounding_box(mesh_a).center() - pose.rotation * bounding_box(mesh_b).center();
        pose.rotation(0, 1) += 5e-10; // as much as make_rigid_transform allows
        const double size = bounding_box(mesh_a).upper.cwiseAbs().maxCoeff() + reach +
                            bounding_box(mesh_b).upper.cwiseAbs().maxCoeff();
        meeting += compare(octree_of(mesh_a, 3), octree_of(mesh_b, 2), pose,
                           1e-13L * static_cast<long double>(size));
        if (HasFailure()) return;
    }
    EXPECT_GT(meeting, 1000U);
}

TEST(IntersectOctrees, CountsTouchingCellsAsMeeting)
{
    // Cells with whole coordinates: nothing rounds, and there is no band.
    const auto octree = [](int depth) {
        return build_octree(make_cube(), {.max_depth = depth,
                                          .threshold = 0,
                                          .root = OctreeFrame{Vec3(-1, -1, -1), Vec3(2, 2, 2)},
                                          .classification = Classification::none})
            .value();
    };
    Mat3 quarter;
    quarter << 0, -1, 0, 1, 0, 0, 0, 0, 1;
    for (const Mat3& rotation : {Mat3(Mat3::Identity()), quarter, Mat3(quarter * quarter)}) {
        for (const Vec3& place : {Vec3(2, 0, 0), Vec3(2, 2, 0), Vec3(2, 2, 2), Vec3(1, 0, -2)}) {
            EXPECT_GT(compare(octree(2), octree(1), {rotation, place}, 0), 0U);
        }
        EXPECT_TRUE(
            intersecting_leaves(octree(2), octree(1), {rotation, Vec3(2.25, 0, 0)}).empty());
    }
}

TEST(IntersectOctrees, LosesNoPairWhereDepthsDiffer)
{
    const Octree deep = octree_of(make_sphere(20, 20), 5);
    const Octree flat = octree_of(make_cube(), 1);
    const RigidTransform pose = {Eigen::AngleAxisd(0.4, Vec3(1, 2, 3).normalized()).matrix(),
                                 Vec3(1, 0.5, 0.25)};
    const std::set<Pair> one_way = keys_of(intersecting_leaves(deep, flat, pose));
    std::set<Pair> other_way;
    for (const auto& [a, b] : keys_of(intersecting_leaves(flat, deep, pose.inverse())))
        other_way.emplace(b, a);
    EXPECT_EQ(one_way, other_way);
    EXPECT_EQ(one_way.size(), compare(deep, flat, pose, 1e-13L));
    // In both orders the deeper octree's leaves lie below the other one's.
    EXPECT_TRUE(std::ranges::any_of(one_way, [](const Pair& p) { return depth(p.first) > 2; }));
}

TEST(IntersectOctrees, StopsOnRequestAndDoesNotAllocate)
{
    const Octree a = octree_of(make_sphere(10, 10), 4);
    int visits = 0;
    const std::uint64_t before = allocation_count();
    const std::uint64_t tests = visit_intersecting_leaves(a, a, {}, [&](const LeafPair&) {
        ++visits;
        return Flow::stop;
    });
    EXPECT_EQ(allocation_count(), before);
    EXPECT_EQ(visits, 1);
    // On the way to the first pair of leaves, the first children of all four levels meet.
    EXPECT_EQ(tests, 1U + 4U);
}

TEST(IntersectOctrees, ListsAllTrianglesThatMeet)
{
    const TriangleMesh sphere = make_sphere(30, 30);
    const Octree octree = octree_of(sphere, 5);
    const RigidTransform pose = {Mat3::Identity(), Vec3(1, 0, 0)};
    const CandidateTriangles candidates =
        candidate_triangles(octree, octree, intersecting_leaves(octree, octree, pose)).value();
    EXPECT_TRUE(std::ranges::is_sorted(candidates.a));
    EXPECT_EQ(std::ranges::adjacent_find(candidates.a), candidates.a.end());
    EXPECT_GT(candidates.a.size(), 50U);
    // Leaves that meet are next to each other: of what they list nothing is farther from the other
    // sphere than their diagonals and a triangle are long.
    const double diagonal = octree.frame().edge.norm() / 32;
    for (const TriangleId id : candidates.a) {
        const Triangle triangle = sphere.triangle(id);
        const double size =
            std::max({(triangle[1] - triangle[0]).norm(), (triangle[2] - triangle[1]).norm(),
                      (triangle[0] - triangle[2]).norm()});
        const double away = std::abs((triangle[0] - pose.translation).norm() - 1);
        EXPECT_LE(away, 2 * diagonal + 2 * size);
    }
    std::size_t meeting = 0;
    for (std::uint32_t i = 0; i < sphere.triangle_count(); ++i) {
        for (std::uint32_t j = 0; j < sphere.triangle_count(); ++j) {
            if (!triangles_meet(sphere.triangle(TriangleId{i}),
                                pose(sphere.triangle(TriangleId{j}))))
                continue;
            ++meeting;
            ASSERT_TRUE(std::ranges::binary_search(candidates.a, TriangleId{i}));
            ASSERT_TRUE(std::ranges::binary_search(candidates.b, TriangleId{j}));
        }
    }
    EXPECT_GT(meeting, 50U);
}

TEST(IntersectOctrees, ListingTrianglesIsCancelledAtEveryReport)
{
    const Octree octree = octree_of(make_sphere(60, 60), 6);
    const std::vector<LeafPair> pairs = intersecting_leaves(octree, octree);
    cancel_at_every_stage(
        [&](Progress& progress) { return candidate_triangles(octree, octree, pairs, &progress); },
        [] { return true; }, 3);
}

} // namespace
} // namespace proxima::intersect_octrees_test
