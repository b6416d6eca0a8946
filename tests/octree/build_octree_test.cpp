#include "proxima/octree.h"

#include "base/simd.h"
#include "geometry/triangle_box.h"
#include "octree/check_octree.h"
#include "octree/check_structure.h"
#include "octree/nasty_meshes.h"
#include "octree/same_cells.h"
#include "octree/same_octree.h"
#include "octree/slow_builder.h"
#include "proxima/sample_meshes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <random>
#include <thread>

namespace proxima {
namespace {

using testing::nasty_mesh;
using testing::same_arrays;
using testing::slow_octree;

constexpr std::array all_methods = {OverlapMethod::fast, OverlapMethod::index_tracking,
                                    OverlapMethod::minkowski, OverlapMethod::separating_axis,
                                    OverlapMethod::pairwise};

/// Depths and thresholds that keep a nasty mesh's octree small.
OctreeOptions random_options(std::uint32_t seed)
{
    std::mt19937 random(seed ^ 0x9E3779B9U);
    OctreeOptions options;
    options.max_depth = static_cast<int>(random() % 6);
    options.threshold = random() % 2 == 0 ? 1U : static_cast<std::uint32_t>(random() % 12);
    options.root_shape = random() % 4 == 0 ? RootShape::box : RootShape::cube;
    options.classification = Classification::none;
    options.execution.threads = {1};
    return options;
}

/// The octree is the slow builder's, and every invariant holds.
void expect_right(const Octree& octree, const TriangleMesh& mesh, const OctreeOptions& options)
{
    const Octree slow = slow_octree(mesh,
                                    {.max_depth = options.max_depth,
                                     .threshold = options.threshold,
                                     .subdivision = options.subdivision,
                                     .root = octree.frame()},
                                    triangle_overlaps_box);
    ASSERT_TRUE(same_cells(octree, slow));
    const Status status = check_octree(octree, mesh);
    ASSERT_TRUE(status) << describe(status.error());
}

TEST(BuildOctree, FastAndExactEqualsTheSlowBuilder)
{
    for (std::uint32_t seed = 0; seed < 400; ++seed) {
        SCOPED_TRACE(::testing::Message() << "seed " << seed);
        const TriangleMesh mesh = nasty_mesh(seed);
        OctreeOptions options = random_options(seed);
        const auto octree = build_octree(mesh, options);
        ASSERT_TRUE(octree) << describe(octree.error());
        ASSERT_NO_FATAL_FAILURE(expect_right(*octree, mesh, options));
    }
}

TEST(BuildOctree, FewTrianglesAtTheGreatestDepthStayExact)
{
    for (std::uint32_t seed = 0; seed < 40; ++seed) {
        SCOPED_TRACE(::testing::Message() << "seed " << seed);
        std::mt19937_64 random(seed);
        const auto real = [&] { return std::uniform_real_distribution<double>(-1, 1)(random); };
        // A speck and a shard that almost touch it far down, in a root kept large by two corners.
        const Vec3 at(0.5 * real(), 0.5 * real(), 0.5 * real());
        const auto near = [&](double size) {
            return Vec3(at + size * Vec3{real(), real(), real()});
        };
        const std::vector<Vec3> positions = {near(1e-6),         near(1e-6),       near(1e-6),
                                             near(1e-6),         near(1e-5),       near(1e-5),
                                             Vec3::Constant(-1), Vec3::Constant(1)};
        const auto mesh =
            make_triangle_mesh(positions, {{0, 1, 2}, {3, 4, 5}, {6, 6, 6}, {7, 7, 7}});
        const auto octree = build_octree(*mesh, {.max_depth = max_octree_depth,
                                                 .threshold = 0,
                                                 .exactness = Exactness::exact,
                                                 .classification = Classification::none,
                                                 .execution = {.threads = {1}}});
        ASSERT_TRUE(octree) << describe(octree.error());
        const Octree slow = slow_octree(
            *mesh, {.max_depth = max_octree_depth, .threshold = 0, .root = octree->frame()},
            triangle_overlaps_box);
        ASSERT_TRUE(same_cells(*octree, slow));
    }
}

TEST(SameCells, TellsOctreesApart)
{
    const TriangleMesh mesh = make_torus(20, 12);
    const auto build = [&](const OctreeOptions& options) { return *build_octree(mesh, options); };
    const Octree octree = build({});
    EXPECT_TRUE(same_cells(
        octree, build({.method = OverlapMethod::pairwise, .exactness = Exactness::exact})));
    EXPECT_FALSE(same_cells(octree, build({.classification = Classification::none})));
    EXPECT_FALSE(same_cells(octree, build({.max_depth = 4})));
    EXPECT_FALSE(same_cells(octree, build({.root_shape = RootShape::box})));
}

TEST(BuildOctree, AllMethodsGiveTheSameExactTree)
{
    for (std::uint32_t seed = 0; seed < 120; ++seed) {
        const TriangleMesh mesh = nasty_mesh(seed);
        OctreeOptions options = random_options(seed);
        options.exactness = Exactness::exact;
        const auto expected = build_octree(mesh, options);
        ASSERT_TRUE(expected) << describe(expected.error());
        for (const OverlapMethod method : all_methods) {
            SCOPED_TRACE(::testing::Message()
                         << "seed " << seed << " method " << static_cast<int>(method));
            options.method = method;
            const auto octree = build_octree(mesh, options);
            ASSERT_TRUE(octree) << describe(octree.error());
            ASSERT_TRUE(same_cells(*octree, *expected));
        }
    }
}

TEST(BuildOctree, RoundedMethodsLoseNoTriangle)
{
    for (std::uint32_t seed = 0; seed < 120; ++seed) {
        const TriangleMesh mesh = nasty_mesh(seed);
        OctreeOptions options = random_options(seed);
        for (const OverlapMethod method : all_methods) {
            SCOPED_TRACE(::testing::Message()
                         << "seed " << seed << " method " << static_cast<int>(method));
            options.method = method;
            const auto octree = build_octree(mesh, options);
            ASSERT_TRUE(octree) << describe(octree.error());
            ASSERT_TRUE(check_structure(*octree));
            std::vector<bool> is_listed(mesh.triangle_count(), false);
            for (const TriangleId id : octree->references()) is_listed[index(id)] = true;
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

TEST(BuildOctree, RoundedMethodsDifferFromExactOnlyOnTouchingTriangles)
{
    const TriangleMesh mesh = make_sphere(100, 100);
    const auto exact = build_octree(mesh, {});
    ASSERT_TRUE(exact);
    // Far beyond rounding, far below any triangle's size.
    const Vec3 step = exact->frame().edge * 1e-12;
    for (const OverlapMethod method : all_methods) {
        const auto rounded = build_octree(mesh, {.method = method});
        ASSERT_TRUE(rounded);
        std::size_t differences = 0;
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
                EXPECT_TRUE(triangle_overlaps_box(mesh.triangle(id), grown)) << index(id);
                EXPECT_FALSE(triangle_overlaps_box(mesh.triangle(id), shrunk)) << index(id);
            }
        }
        std::printf("method %d: %zu of %zu references decided otherwise by rounding\n",
                    static_cast<int>(method), differences, exact->references().size());
        // The separating axes have most: 96. That each of them touches is what counts, above.
        EXPECT_LE(differences, exact->references().size() / 400);
    }
}

TEST(BuildOctree, SameBitsForEveryThreadCountAndInstructionSet)
{
    std::vector<TriangleMesh> meshes;
    meshes.push_back(make_sphere(100, 100));
    meshes.push_back(*make_spaceship(6000));
    for (std::uint32_t seed = 0; seed < 30; ++seed) meshes.push_back(nasty_mesh(seed));
    for (std::size_t i = 0; i < meshes.size(); ++i) {
        OctreeOptions options{
            .max_depth = i < 2 ? 7 : 5, .threshold = 4, .execution = {.threads = {1}}};
        const auto expected = build_octree(meshes[i], options);
        ASSERT_TRUE(expected) << describe(expected.error());
        for (const int threads : {2, 3, 8}) {
            options.execution.threads = {threads};
            const auto octree = build_octree(meshes[i], options);
            ASSERT_TRUE(octree);
            EXPECT_TRUE(same_arrays(*octree, *expected)) << "mesh " << i << " threads " << threads;
        }
        options.execution.threads = {1};
        for (const SimdTarget& target : simd_targets()) {
            force_simd_target(target);
            const auto octree = build_octree(meshes[i], options);
            restore_simd_targets();
            ASSERT_TRUE(octree);
            EXPECT_TRUE(same_arrays(*octree, *expected)) << "mesh " << i << ' ' << target.name;
        }
    }
}

TEST(BuildOctree, SphereOfTheThesis)
{
    struct Row {
        int depth;
        std::uint64_t total, leaves, references, min, max;
        double occupied;
    };
    // Thesis table 2.1; references, minima and maxima of closed and exact overlap.
    constexpr Row rows[] = {{1, 9, 8, 22392, 2799, 2799, 100.0},
                            {2, 73, 64, 24280, 78, 1101, 87.5},
                            {3, 521, 456, 28208, 9, 570, 59.6},
                            {4, 2697, 2360, 36360, 3, 315, 49.2},
                            {5, 11977, 10480, 54344, 1, 198, 45.4}};
    const TriangleMesh mesh = make_sphere(100, 100);
    for (const Row& row : rows) {
        const auto octree =
            build_octree(mesh, {.max_depth = row.depth, .exactness = Exactness::exact});
        ASSERT_TRUE(octree);
        const OctreeStatistics found = octree_statistics(*octree);
        EXPECT_EQ(found.total, row.total);
        EXPECT_EQ(found.leaves, row.leaves);
        EXPECT_EQ(found.references, row.references);
        EXPECT_EQ(found.min_triangles, row.min);
        EXPECT_EQ(found.max_triangles, row.max);
        EXPECT_NEAR(found.occupied_percent, row.occupied, 0.05);
    }
    const std::pair<std::uint32_t, std::uint64_t> totals[] = {
        {1, 11977}, {50, 3017}, {150, 777}, {200, 713}};
    for (const auto& [threshold, total] : totals) {
        const auto octree =
            build_octree(mesh, {.threshold = threshold, .exactness = Exactness::exact});
        ASSERT_TRUE(octree);
        EXPECT_EQ(octree_statistics(*octree).total, total) << "threshold " << threshold;
    }
}

TEST(BuildOctree, UniformSubdivisionSplitsEverything)
{
    for (std::uint32_t seed = 0; seed < 60; ++seed) {
        SCOPED_TRACE(::testing::Message() << "seed " << seed);
        const TriangleMesh mesh = nasty_mesh(seed);
        OctreeOptions options = random_options(seed);
        options.max_depth %= 5;
        options.exactness = Exactness::exact;
        options.subdivision = Subdivision::uniform;
        const auto octree = build_octree(mesh, options);
        ASSERT_TRUE(octree) << describe(octree.error());
        EXPECT_EQ(octree_statistics(*octree).leaves, std::uint64_t{1} << (3 * options.max_depth));
        ASSERT_NO_FATAL_FAILURE(expect_right(*octree, mesh, options));
    }
}

TEST(BuildOctree, TwoPassesUseTheLongestListAsThreshold)
{
    const TriangleMesh mesh = make_torus(60, 40);
    const auto first = build_octree(mesh, {});
    const auto second = build_octree_two_pass(mesh, {});
    ASSERT_TRUE(first && second);
    const std::uint64_t longest = octree_statistics(*first).max_triangles;
    EXPECT_EQ(second->parameters().threshold, longest);
    EXPECT_EQ(octree_statistics(*second).max_triangles, longest);
    EXPECT_LT(second->nodes().size(), first->nodes().size());
}

TEST(BuildOctree, TightRootContainsTheMesh)
{
    for (std::uint32_t seed = 0; seed < 2000; ++seed) {
        const Box box = bounding_box(nasty_mesh(seed));
        for (const RootShape shape : {RootShape::cube, RootShape::box}) {
            const OctreeFrame frame = tight_root(box, shape);
            const Box root = cell_box(frame, {});
            EXPECT_TRUE(root.contains(box.lower) && root.contains(box.upper)) << "seed " << seed;
            const double widest = box.extent().maxCoeff();
            if (widest > 0) {
                EXPECT_NEAR(frame.edge.maxCoeff() / widest, 1.0, 1e-9);
            }
        }
    }
}

TEST(BuildOctree, RefusesWhatItCannotBuild)
{
    const TriangleMesh cube = make_cube();
    const auto code = [](const TriangleMesh& mesh, const OctreeOptions& options) {
        const auto octree = build_octree(mesh, options);
        return octree ? std::string("built") : describe(octree.error());
    };
    EXPECT_NE(code(cube, {.max_depth = 20}).find("0 to 19, not 20"), std::string::npos);
    EXPECT_NE(code(cube, {.max_depth = -1}).find("0 to 19, not -1"), std::string::npos);
    EXPECT_NE(code(TriangleMesh{}, {}).find("no triangles"), std::string::npos);
    const double nan = std::numeric_limits<double>::quiet_NaN();
    const auto broken = make_triangle_mesh({{0, 0, 0}, {1, 0, 0}, {0, nan, 0}}, {{0, 1, 2}});
    EXPECT_NE(code(*broken, {}).find("vertex 2"), std::string::npos);
    // A vertex that no triangle uses may be anything.
    const auto unused =
        make_triangle_mesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {nan, 1e300, 0}}, {{0, 1, 2}});
    EXPECT_EQ(code(*unused, {}), "built");
    EXPECT_NE(code(cube, {.root = OctreeFrame{Vec3::Zero(), Vec3::Ones()}}).find("contain"),
              std::string::npos);
    EXPECT_NE(code(cube, {.root = OctreeFrame{Vec3::Zero(), Vec3::Zero()}}).find("positive"),
              std::string::npos);
    for (const OverlapMethod method : all_methods) {
        const std::string message =
            code(make_sphere(100, 100),
                 {.max_depth = 9, .method = method, .execution = {.budget = {300'000}}});
        EXPECT_NE(message.find("budget"), std::string::npos) << message;
    }
    EXPECT_NE(code(cube, {.max_depth = 19, .subdivision = Subdivision::uniform}).find("uniform"),
              std::string::npos);
}

TEST(BuildOctree, StopsWhenCancelled)
{
    const TriangleMesh mesh = make_sphere(300, 300);
    for (const OverlapMethod method : all_methods) {
        Progress progress;
        progress.cancel();
        const auto before = build_octree(
            mesh, {.max_depth = 9, .method = method, .execution = {.progress = &progress}});
        ASSERT_FALSE(before);
        EXPECT_EQ(before.error().code, ErrorCode::cancelled);
    }
    // While it works: the slow method would take minutes.
    Progress progress;
    std::thread canceller([&] {
        while (progress.stage()[0] == '\0') std::this_thread::yield();
        progress.cancel();
    });
    const auto octree = build_octree(
        mesh,
        {.max_depth = 12, .method = OverlapMethod::pairwise, .execution = {.progress = &progress}});
    canceller.join();
    ASSERT_FALSE(octree);
    EXPECT_EQ(octree.error().code, ErrorCode::cancelled);
}

TEST(BuildOctree, ScalingByPowersOfTwoAndReorderingChangeNothing)
{
    for (std::uint32_t seed = 0; seed < 60; ++seed) {
        SCOPED_TRACE(::testing::Message() << "seed " << seed);
        const TriangleMesh mesh = nasty_mesh(seed);
        OctreeOptions options = random_options(seed);
        options.exactness = Exactness::exact;
        const auto octree = build_octree(mesh, options);
        std::vector<Vec3> scaled(mesh.positions().begin(), mesh.positions().end());
        for (Vec3& position : scaled) position *= 0x1p-13;
        const std::vector<TriangleCorners> triangles(mesh.triangles().begin(),
                                                     mesh.triangles().end());
        const auto small = build_octree(*make_triangle_mesh(scaled, triangles), options);
        ASSERT_TRUE(octree && small);
        if (octree->frame().edge[0] > 1e-5) {
            EXPECT_TRUE(same_arrays(*octree, *small));
        }
        // Reversed triangles: the same counts everywhere.
        const std::vector<TriangleCorners> reversed(triangles.rbegin(), triangles.rend());
        const std::vector<Vec3> positions(mesh.positions().begin(), mesh.positions().end());
        const auto other = build_octree(*make_triangle_mesh(positions, reversed), options);
        ASSERT_TRUE(other);
        EXPECT_EQ(other->references().size(), octree->references().size());
        EXPECT_EQ(other->nodes().size(), octree->nodes().size());
    }
}

} // namespace
} // namespace proxima
