#include "proxima/thesis.h"

#include "code_of.h"
#include "geometry/triangle_box.h"
#include "octree/check_structure.h"
#include "octree/nasty_meshes.h"
#include "octree/random_octree_options.h"
#include "octree/same_cells.h"
#include "proxima/octree.h"
#include "proxima/sample_meshes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <thread>

namespace proxima::build_octree_by_test {
namespace {

using testing::nasty_mesh;
using testing::random_octree_options;

constexpr std::array all_methods = {OverlapMethod::fast, OverlapMethod::index_tracking,
                                    OverlapMethod::minkowski, OverlapMethod::separating_axis,
                                    OverlapMethod::pairwise};

TEST(BuildOctreeBy, AllMethodsGiveTheSameExactTree)
{
    for (std::uint32_t seed = 0; seed < 120; ++seed) {
        const TriangleMesh mesh = nasty_mesh(seed);
        const OctreeOptions options = random_octree_options(seed);
        const auto expected = build_octree(mesh, options);
        ASSERT_TRUE(expected) << describe(expected.error());
        for (const OverlapMethod method : all_methods) {
            SCOPED_TRACE(::testing::Message()
                         << "seed " << seed << " method " << static_cast<int>(method));
            const auto octree =
                build_octree_by(mesh, {.method = method, .exactness = Exactness::exact}, options);
            ASSERT_TRUE(octree) << describe(octree.error());
            ASSERT_TRUE(same_cells(*octree, *expected));
        }
    }
}

TEST(BuildOctreeBy, RoundedMethodsLoseNoTriangle)
{
    for (std::uint32_t seed = 0; seed < 120; ++seed) {
        const TriangleMesh mesh = nasty_mesh(seed);
        const OctreeOptions options = random_octree_options(seed);
        for (const OverlapMethod method : all_methods) {
            SCOPED_TRACE(::testing::Message()
                         << "seed " << seed << " method " << static_cast<int>(method));
            const auto octree = build_octree_by(mesh, {.method = method}, options);
            ASSERT_TRUE(octree) << describe(octree.error());
            ASSERT_TRUE(check_structure(*octree));
            std::vector<bool> is_listed(mesh.triangle_count(), false);
            for (const TriangleId id : octree->references()) is_listed[to_index(id)] = true;
            EXPECT_EQ(std::ranges::count(is_listed, false), 0);
        }
    }
}

/// Triangles that only one of two leaves of the same cell lists.
std::vector<TriangleId> listed_once(std::span<const TriangleId> a, std::span<const TriangleId> b)
{
    std::vector<TriangleId> once;
    std::ranges::set_symmetric_difference(a, b, std::back_inserter(once));
    return once;
}

TEST(BuildOctreeBy, RoundedMethodsDifferFromExactOnlyOnTouchingTriangles)
{
    const TriangleMesh mesh = make_sphere(100, 100);
    const auto exact = build_octree(mesh, {});
    ASSERT_TRUE(exact);
    // Far beyond rounding, far below any triangle's size.
    const Vec3 step = exact->frame().edge * 1e-12;
    std::size_t differences = 0;
    for (const OverlapMethod method : all_methods) {
        const auto rounded = build_octree_by(mesh, {.method = method});
        ASSERT_TRUE(rounded);
        std::vector<std::pair<Cell, Cell>> pending = {{exact->root(), rounded->root()}};
        while (!pending.empty()) {
            const auto [cell, other] = pending.back();
            pending.pop_back();
            ASSERT_EQ(exact->is_leaf(cell), rounded->is_leaf(other));
            if (!exact->is_leaf(cell)) {
                for (int octant = 0; octant < 8; ++octant) {
                    pending.emplace_back(exact->child(cell, octant), rounded->child(other, octant));
                }
                continue;
            }
            const Box box = exact->box(cell);
            const Box grown{box.lower - step, box.upper + step};
            const Box shrunk{box.lower + step, box.upper - step};
            for (const TriangleId id :
                 listed_once(exact->triangles(cell), rounded->triangles(other))) {
                ++differences;
                EXPECT_TRUE(triangle_overlaps_box(mesh.triangle(id), grown)) << to_index(id);
                EXPECT_FALSE(triangle_overlaps_box(mesh.triangle(id), shrunk)) << to_index(id);
            }
        }
    }
    EXPECT_GT(differences, 0U);
}

TEST(BuildOctreeBy, RefusesMeshesBeyondTheBudget)
{
    for (const OverlapMethod method : all_methods) {
        const auto octree = build_octree_by(make_sphere(100, 100), {.method = method},
                                            {.max_depth = 9, .execution = {.budget = {300'000}}});
        ASSERT_FALSE(octree);
        EXPECT_EQ(code_of(octree), ErrorCode::budget_exceeded) << describe(octree.error());
    }
}

TEST(BuildOctreeBy, RecordsTheMethod)
{
    for (const OverlapMethod method : all_methods) {
        const auto octree = build_octree_by(make_cube(), {.method = method});
        ASSERT_TRUE(octree);
        EXPECT_EQ(octree->parameters().method, method);
        EXPECT_EQ(octree->parameters().exact, method == OverlapMethod::fast);
    }
}

TEST(BuildOctreeTwoPass, TwoPassesUseTheLongestListAsThreshold)
{
    const TriangleMesh mesh = make_torus(60, 40);
    const auto first = build_octree(mesh, {});
    const auto second = build_octree_two_pass(mesh);
    ASSERT_TRUE(first && second);
    const std::uint64_t longest = octree_statistics(*first).max_triangles;
    EXPECT_EQ(second->parameters().threshold, longest);
    EXPECT_EQ(octree_statistics(*second).max_triangles, longest);
    EXPECT_LT(second->nodes().size(), first->nodes().size());
}

TEST(BuildOctreeTwoPass, TheSecondPassClassifiesAsAsked)
{
    const TriangleMesh mesh = make_torus(60, 40);
    const auto second = build_octree_two_pass(mesh);
    ASSERT_TRUE(second);
    EXPECT_TRUE(second->parameters().classified);
    EXPECT_GT(octree_statistics(*second).inner, 0U);
    EXPECT_TRUE(
        same_cells(*second, *build_octree(mesh, {.threshold = second->parameters().threshold})));
    const auto unclassified =
        build_octree_two_pass(mesh, {}, {.classification = Classification::none});
    ASSERT_TRUE(unclassified);
    EXPECT_FALSE(unclassified->parameters().classified);
}

TEST(BuildOctreeBy, StopsWhenCancelled)
{
    const TriangleMesh mesh = make_sphere(300, 300);
    for (const OverlapMethod method : all_methods) {
        Progress progress;
        progress.cancel();
        const auto before = build_octree_by(mesh, {.method = method},
                                            {.max_depth = 9, .execution = {.progress = &progress}});
        ASSERT_FALSE(before);
        EXPECT_EQ(code_of(before), ErrorCode::cancelled);
    }
    // While it works: the slow method would take minutes.
    Progress progress;
    std::thread canceller([&] {
        while (progress.stage()[0] == '\0') std::this_thread::yield();
        progress.cancel();
    });
    const auto octree = build_octree_by(mesh, {.method = OverlapMethod::pairwise},
                                        {.max_depth = 12, .execution = {.progress = &progress}});
    canceller.join();
    ASSERT_FALSE(octree);
    EXPECT_EQ(code_of(octree), ErrorCode::cancelled);
}

} // namespace
} // namespace proxima::build_octree_by_test
