#include "proxima/octree.h"

#include "base/simd.h"
#include "code_of.h"
#include "geometry/triangle_box.h"
#include "octree/check_octree.h"
#include "octree/check_structure.h"
#include "octree/nasty_meshes.h"
#include "octree/random_octree_options.h"
#include "octree/same_cells.h"
#include "octree/same_octree.h"
#include "octree/slow_builder.h"
#include "proxima/mesh_report.h"
#include "proxima/sample_meshes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <random>

namespace proxima::build_octree_test {
namespace {

using testing::nasty_mesh;
using testing::random_octree_options;
using testing::same_arrays;
using testing::slow_octree;

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

TEST(BuildOctree, EqualsTheSlowBuilder)
{
    for (std::uint32_t seed = 0; seed < 400; ++seed) {
        SCOPED_TRACE(::testing::Message() << "seed " << seed);
        const TriangleMesh mesh = nasty_mesh(seed);
        OctreeOptions options = random_octree_options(seed);
        const auto octree = build_octree(mesh, options);
        ASSERT_TRUE(octree) << describe(octree.error());
        ASSERT_NO_FATAL_FAILURE(expect_right(*octree, mesh, options));
    }
}

TEST(BuildOctree, IsExactAtTheGreatestDepth)
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
                                                 .classification = Classification::none,
                                                 .execution = {.threads = {1}}});
        ASSERT_TRUE(octree) << describe(octree.error());
        const Octree slow = slow_octree(
            *mesh, {.max_depth = max_octree_depth, .threshold = 0, .root = octree->frame()},
            triangle_overlaps_box);
        ASSERT_TRUE(same_cells(*octree, slow));
    }
}

TEST(SameCells, DistinguishesOctrees)
{
    const TriangleMesh mesh = make_torus(20, 12);
    const auto build = [&](const OctreeOptions& options) { return *build_octree(mesh, options); };
    const Octree octree = build({});
    EXPECT_TRUE(same_cells(octree, build({.execution = {.threads = {1}}})));
    EXPECT_FALSE(same_cells(octree, build({.classification = Classification::none})));
    EXPECT_FALSE(same_cells(octree, build({.max_depth = 4})));
    EXPECT_FALSE(same_cells(octree, build({.root_shape = RootShape::box})));
}

TEST(BuildOctree, HasTheSameBitsForEveryThreadCountAndInstructionSet)
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

TEST(BuildOctree, ReproducesTheSphereOfTheThesis)
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
        const auto octree = build_octree(mesh, {.max_depth = row.depth});
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
        const auto octree = build_octree(mesh, {.threshold = threshold});
        ASSERT_TRUE(octree);
        EXPECT_EQ(octree_statistics(*octree).total, total) << "threshold " << threshold;
    }
}

TEST(BuildOctree, IsExactForTheSmallestMeshes)
{
    const TriangleMesh ball = make_icosphere(1);
    for (const double size : {1e-280, 1e-289, 1e-291, 1e-299, 1e-300, 1e-305, 1e-310, 1e-320}) {
        std::vector<Vec3> positions;
        for (const Vec3& p : ball.positions()) positions.emplace_back(size * p);
        const TriangleMesh mesh =
            *make_triangle_mesh(positions, {ball.triangles().begin(), ball.triangles().end()});
        const auto octree =
            build_octree(mesh, {.max_depth = 3, .classification = Classification::none});
        ASSERT_TRUE(octree) << size << ": " << describe(octree.error());
        const Status status = check_octree(*octree, mesh);
        EXPECT_TRUE(status) << size << ": " << describe(status.error());
    }
}

TEST(BuildOctree, UniformSubdivisionSplitsEverything)
{
    for (std::uint32_t seed = 0; seed < 60; ++seed) {
        SCOPED_TRACE(::testing::Message() << "seed " << seed);
        const TriangleMesh mesh = nasty_mesh(seed);
        OctreeOptions options = random_octree_options(seed);
        options.max_depth %= 5;
        options.subdivision = Subdivision::uniform;
        const auto octree = build_octree(mesh, options);
        ASSERT_TRUE(octree) << describe(octree.error());
        EXPECT_EQ(octree_statistics(*octree).leaves, std::uint64_t{1} << (3 * options.max_depth));
        ASSERT_NO_FATAL_FAILURE(expect_right(*octree, mesh, options));
    }
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

/// What tight_root is, found in steps from one double to the next; empty after too many.
std::optional<OctreeFrame> stepped_root(const Box& box, RootShape shape)
{
    const double magnitude =
        std::max(box.lower.cwiseAbs().maxCoeff(), box.upper.cwiseAbs().maxCoeff());
    Vec3 edge = box.extent();
    if (shape == RootShape::cube) edge = Vec3::Constant(edge.maxCoeff());
    OctreeFrame frame;
    int steps = 0;
    for (int axis = 0; axis < 3; ++axis) {
        if (!(edge[axis] > 0)) edge[axis] = 1e-6 * std::max(magnitude, 1.0);
        frame.lower[axis] = std::min(box.center()[axis] - edge[axis] / 2, box.lower[axis]);
        while (frame.lower[axis] + edge[axis] < box.upper[axis]) {
            if (++steps > 10'000) return std::nullopt;
            edge[axis] = std::nextafter(edge[axis], std::numeric_limits<double>::max());
        }
        frame.edge[axis] = edge[axis];
    }
    if (shape == RootShape::cube) frame.edge = Vec3::Constant(frame.edge.maxCoeff());
    return frame;
}

TEST(BuildOctree, TightRootIsTheSmallestThatReachesTheEnd)
{
    int stepped = 0;
    int longer = 0;
    for (std::uint64_t seed = 0; seed < 40'000; ++seed) {
        std::mt19937_64 random(seed);
        std::uniform_real_distribution<double> unit(-1, 1);
        Box box;
        if (seed < 2000) {
            box = bounding_box(nasty_mesh(static_cast<std::uint32_t>(seed)));
        } else {
            const Vec3 at =
                std::exp2(10 * unit(random)) * Vec3(unit(random), unit(random), unit(random));
            const double size = std::exp2(10 * unit(random));
            for (int i = 0; i < 2; ++i)
                box.extend(at + size * Vec3(unit(random), unit(random), unit(random)));
        }
        for (const RootShape shape : {RootShape::cube, RootShape::box}) {
            const auto expected = stepped_root(box, shape);
            if (!expected) continue;
            ++stepped;
            const OctreeFrame frame = tight_root(box, shape);
            ASSERT_EQ(frame.lower, expected->lower) << "seed " << seed;
            ASSERT_EQ(frame.edge, expected->edge) << "seed " << seed;
            if ((frame.edge.array() > box.extent().maxCoeff()).any()) ++longer;
        }
    }
    // Most boxes are judged, and many of them need steps.
    EXPECT_GT(stepped, 70'000);
    EXPECT_GT(longer, 1000);
}

TEST(BuildOctree, TightRootIsFoundAtOnceFarFromTheOrigin)
{
    for (const double far : {1e9, 1e11, 1e12, 1e13, 1e15, 1e300}) {
        for (const double sign : {-1.0, 1.0}) {
            SCOPED_TRACE(sign * far);
            for (int seed = 0; seed < 200; ++seed) {
                std::mt19937_64 random(static_cast<std::uint64_t>(seed));
                std::uniform_real_distribution<double> unit(-9, 9);
                Box box;
                for (int i = 0; i < 2; ++i) {
                    box.extend(
                        Vec3(sign * far + unit(random), unit(random), sign * far + unit(random)));
                }
                for (const RootShape shape : {RootShape::cube, RootShape::box}) {
                    const OctreeFrame frame = tight_root(box, shape);
                    const Vec3 end = frame.lower + frame.edge;
                    EXPECT_TRUE((frame.lower.array() <= box.lower.array()).all());
                    EXPECT_TRUE((end.array() >= box.upper.array()).all());
                    // Larger by a few steps of the coordinates' doubles at most.
                    const double step = std::nextafter(far, HUGE_VAL) - far;
                    EXPECT_LE(frame.edge.maxCoeff(),
                              std::max(box.extent().maxCoeff(), 1e-6 * far) + 4 * step);
                }
            }
        }
    }
}

TEST(BuildOctree, RefusesInvalidMeshesAndOptions)
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
    for (int axis = 0; axis < 3; ++axis) { // which holds the lower corner, but not the upper one
        OctreeFrame small{Vec3::Constant(-1), Vec3::Constant(2)};
        small.edge[axis] = 1.5;
        EXPECT_NE(code(cube, {.root = small}).find("contain"), std::string::npos);
        small.edge[axis] = 0;
        EXPECT_NE(code(cube, {.root = small}).find("positive"), std::string::npos);
    }
    EXPECT_NE(code(cube, {.root = OctreeFrame{Vec3::Zero(), Vec3::Zero()}}).find("positive"),
              std::string::npos);
    const double infinity = std::numeric_limits<double>::infinity();
    for (const OctreeFrame& root : {OctreeFrame{Vec3::Constant(-9), Vec3(infinity, 20, 20)},
                                    OctreeFrame{Vec3(-infinity, -9, -9), Vec3::Constant(20)},
                                    OctreeFrame{Vec3::Constant(-9), Vec3(20, nan, 20)}})
        EXPECT_NE(code(cube, {.root = root}).find("finite corners"), std::string::npos);
    for (const double far : {-1.1e100, 1.1e100}) {
        const auto huge = make_triangle_mesh({{0, 0, 0}, {1, 0, 0}, {0, far, 0}}, {{0, 1, 2}});
        EXPECT_NE(code(*huge, {}).find("1e100"), std::string::npos);
    }
    const std::string message =
        code(make_sphere(100, 100), {.max_depth = 9, .execution = {.budget = {300'000}}});
    EXPECT_NE(message.find("budget"), std::string::npos) << message;
    EXPECT_NE(code(cube, {.max_depth = 19, .subdivision = Subdivision::uniform}).find("uniform"),
              std::string::npos);
}

TEST(BuildOctree, IsTheSameWithinAnyBudgetThatIsEnough)
{
    constexpr unsigned seed = 1;
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> unit(0, 1);
    const auto point = [&] { return Vec3(unit(random), unit(random), unit(random)); };
    std::vector<Vec3> positions;
    std::vector<TriangleCorners> triangles;
    for (std::uint32_t i = 0; i < 20'000; ++i) {
        const Vec3 at = 0.99 * point();
        const double size = i % 12 == 5 ? 1 : 0.01; // some as large as the root
        for (int k = 0; k < 3; ++k) positions.emplace_back((1 - size) * at + size * point());
        triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
    }
    const auto mesh = make_triangle_mesh(std::move(positions), std::move(triangles));
    OctreeOptions options{
        .max_depth = 3, .threshold = 2000, .classification = Classification::none};
    for (const int threads : {1, 3}) {
        options.execution = {.threads = {threads}};
        const Octree whole = build_octree(*mesh, options).value();
        int built = 0;
        for (std::uint64_t budget = 64'000'000;; budget -= budget / 8) {
            options.execution.budget = {budget};
            const auto octree = build_octree(*mesh, options);
            if (!octree) {
                EXPECT_EQ(code_of(octree), ErrorCode::budget_exceeded);
                break;
            }
            EXPECT_TRUE(same_arrays(*octree, whole)) << budget;
            ++built;
        }
        EXPECT_GT(built, 10);
    }
}

TEST(BuildOctree, RefusesWhatTheReportSays)
{
    for (const double reach : {1e-308, 1e-101, 1.0, 9.99e99, 1.01e100, 1e300}) {
        const auto mesh =
            make_triangle_mesh({{0, 0, 0}, {reach, 0, 0}, {0, -reach, 0}}, {{0, 1, 2}});
        const auto report = report_mesh(*mesh);
        ASSERT_TRUE(report);
        EXPECT_EQ(report->outlook[0].query, QueryKind::octree);
        EXPECT_EQ(report->outlook[0].outlook != Outlook::refused, build_octree(*mesh).has_value())
            << reach;
    }
}

TEST(BuildOctree, StopsWhenCancelled)
{
    Progress progress;
    progress.cancel();
    const auto octree =
        build_octree(make_sphere(300, 300), {.max_depth = 9, .execution = {.progress = &progress}});
    ASSERT_FALSE(octree);
    EXPECT_EQ(code_of(octree), ErrorCode::cancelled);
}

TEST(BuildOctree, IsInvariantToScalingByPowersOfTwoAndToReordering)
{
    for (std::uint32_t seed = 0; seed < 60; ++seed) {
        SCOPED_TRACE(::testing::Message() << "seed " << seed);
        const TriangleMesh mesh = nasty_mesh(seed);
        OctreeOptions options = random_octree_options(seed);
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
} // namespace proxima::build_octree_test
