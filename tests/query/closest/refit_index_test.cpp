// Refitted indexes against brute force on the moved mesh.
#include "proxima/mesh_index.h"

#include "cancellation.h"
#include "code_of.h"
#include "index/check_structure.h"
#include "index/damaged_index.h"
#include "index/index_parts.h"
#include "index/listed_index.h"
#include "index/lists/proximity_lists.h"
#include "index/test_meshes.h"
#include "proxima/closest_feature.h"
#include "proxima/index_io.h"
#include "proxima/sample_meshes.h"
#include "query/closest/brute_force.h"
#include "query/closest/find_closest.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <random>
#include <vector>

namespace proxima::testing::refit_index_test {
namespace {

/// The mesh with some vertices elsewhere.
template <class Move>
TriangleMesh moved(const TriangleMesh& mesh, const Move& move)
{
    std::vector<Vec3> positions(mesh.positions().begin(), mesh.positions().end());
    for (std::size_t i = 0; i < positions.size(); ++i) positions[i] = move(i, positions[i]);
    const auto triangles = mesh.triangles();
    return make_triangle_mesh(std::move(positions), {triangles.begin(), triangles.end()}).value();
}

Vec3 random_step(std::mt19937_64& random, double length)
{
    std::uniform_real_distribution<double> part(-1, 1);
    return length * Vec3{part(random), part(random), part(random)};
}

void expect_answers(const MeshIndex& index, const TriangleMesh& mesh, const Topology& topology,
                    std::span<const Vec3> points)
{
    const Box box = bounding_box(mesh);
    const double diagonal = box.extent().norm();
    const double reach = box.lower.cwiseAbs().cwiseMax(box.upper.cwiseAbs()).maxCoeff();
    ClosestFeature last;
    for (const Vec3& p : points) {
        const ClosestFeature truth = closest_feature_by_brute_force(mesh, topology, p);
        const ClosestFeature found = closest_feature(index, p).value();
        // From any answer the same comes out.
        for (const ClosestFeature& earlier : {found, last, ClosestFeature{}}) {
            const ClosestFeature warm = closest_feature(index, p, {.start_from = &earlier}).value();
            ASSERT_EQ(warm.feature, found.feature) << "at " << p.transpose();
            ASSERT_EQ(warm.squared_distance, found.squared_distance);
        }
        last = found;
        const double scale = diagonal + (p - box.center()).norm() + 1e-3 * reach;
        ASSERT_NEAR(std::sqrt(found.squared_distance), std::sqrt(truth.squared_distance),
                    1e-12 * scale)
            << "at " << p.transpose();
        ASSERT_EQ(found.feature, truth.feature) << "at " << p.transpose();
        ASSERT_EQ(found.triangle, truth.triangle);
        ASSERT_NEAR((found.point - truth.point).norm(), 0, 1e-12 * scale);
    }
}

/// Where it was, and where it moved to.
std::vector<Vec3> points_about(const TriangleMesh& before, const TriangleMesh& after,
                               std::size_t count)
{
    std::vector<Vec3> points = proximity_points(after, static_cast<int>(count), 11);
    std::mt19937_64 random(12);
    const double diagonal = bounding_box(after).extent().norm();
    std::size_t near = 0;
    for (std::size_t i = 0; i < after.vertex_count() && near < count; ++i) {
        if (before.positions()[i] == after.positions()[i]) continue;
        points.push_back(after.positions()[i] + random_step(random, 0.02 * diagonal));
        points.push_back(before.positions()[i] + random_step(random, 0.02 * diagonal));
        near += 2;
    }
    return points;
}

TEST(RefitIndex, AnswersLikeBruteForce)
{
    for (const NamedMesh& named : proximity_meshes()) {
        const TriangleMesh& mesh = named.mesh;
        const auto topology = build_topology(mesh).value();
        const Box box = bounding_box(mesh);
        const double diagonal = box.extent().norm();
        if (!(diagonal > 0)) continue;
        const MeshIndex plain = build_mesh_index(mesh).value();
        const MeshIndex built = with_lists(plain).value();
        for (const int how : {0, 1, 2}) {
            SCOPED_TRACE(named.name + (how == 0 ? " scattered" : how == 1 ? " dented" : " far"));
            std::mt19937_64 random(7 + static_cast<unsigned>(how));
            const Vec3 dent = mesh.positions()[random() % mesh.vertex_count()];
            const auto chosen = [&](const Vec3& p) {
                if (how == 1) return (p - dent).norm() < 0.1 * diagonal;
                return random() % 50 == 0;
            };
            const TriangleMesh other = moved(mesh, [&](std::size_t /*i*/, const Vec3& p) -> Vec3 {
                if (!chosen(p)) return p;
                const Vec3 to = p + random_step(random, (how == 2 ? 0.2 : 1e-2) * diagonal);
                return to.cwiseMax(box.lower).cwiseMin(box.upper);
            });
            const auto refitted = refit_index(built, other, topology);
            ASSERT_TRUE(refitted) << describe(refitted.error());
            EXPECT_EQ(refitted->mesh_fingerprint(), mesh_fingerprint(other));
            expect_answers(*refitted, other, topology, points_about(mesh, other, 60));
            const Status sound = check_structure(refit_index(plain, other, topology).value());
            ASSERT_TRUE(sound) << describe(sound.error());
            // And back again, by what is left of the lists.
            const auto back = refit_index(*refitted, mesh, topology);
            ASSERT_TRUE(back);
            expect_answers(*back, mesh, topology, points_about(other, mesh, 20));
        }
    }
}

/// The refitted index with lists answers like that without.
void expect_same_distances(const MeshIndex& plain, const MeshIndex& listed,
                           const TriangleMesh& after, const Topology& topology,
                           std::span<const Vec3> points)
{
    const MeshIndex by_tree = refit_index(plain, after, topology).value();
    const MeshIndex by_lists = refit_index(listed, after, topology).value();
    for (const Vec3& p : points) {
        ASSERT_EQ(closest_feature(by_lists, p)->squared_distance,
                  closest_feature(by_tree, p)->squared_distance)
            << "at " << p.transpose();
    }
}

TEST(RefitIndex, AsksTheTreeInAllCellsThatAMovedTriangleReaches)
{
    std::mt19937_64 random(3);
    for (const char* const name : {"icosphere:1", "icosphere:2"}) {
        const TriangleMesh mesh = sample_mesh(name).value();
        const auto topology = build_topology(mesh).value();
        const MeshIndex plain = build_mesh_index(mesh).value();
        const MeshIndex listed = with_lists(plain).value();
        for (const double inward : {0.3, 0.6, 1.0}) {
            const std::size_t vertex = random() % mesh.vertex_count();
            const TriangleMesh after = moved(mesh, [&](std::size_t i, const Vec3& p) -> Vec3 {
                return i == vertex ? Vec3((1 - inward) * p) : p;
            });
            std::vector<Vec3> points;
            for (int i = 0; i < 4000; ++i) points.push_back(random_step(random, 1.2));
            expect_same_distances(plain, listed, after, topology, points);
        }
    }
}

TEST(RefitIndex, LooksAtAllBlocksOfALongList)
{
    // Triangles that share no vertex: none is found by its neighbours.
    const TriangleMesh joined_mesh = sample_mesh("sphere:20x20").value();
    std::vector<Vec3> positions;
    std::vector<TriangleCorners> triangles;
    for (std::uint32_t i = 0; i < joined_mesh.triangle_count(); ++i) {
        for (const Vec3& corner : joined_mesh.triangle(TriangleId{i}).vertices)
            positions.push_back(corner);
        triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
    }
    const TriangleMesh mesh = make_triangle_mesh(positions, triangles).value();
    const auto topology = build_topology(mesh).value();
    const MeshIndex plain = build_mesh_index(mesh).value();
    const MeshIndex listed = with_lists(plain).value();
    std::mt19937_64 random(5);
    for (int round = 0; round < 25; ++round) {
        const std::size_t triangle = random() % triangles.size();
        const Vec3 middle =
            (positions[3 * triangle] + positions[3 * triangle + 1] + positions[3 * triangle + 2]) /
            3;
        const TriangleMesh after = moved(mesh, [&](std::size_t i, const Vec3& p) -> Vec3 {
            return i / 3 == triangle ? Vec3(p + 0.35 * middle.normalized()) : p;
        });
        std::vector<Vec3> points;
        for (int i = 0; i < 4000; ++i)
            points.emplace_back(0.2 * middle + random_step(random, 0.25));
        expect_same_distances(plain, listed, after, topology, points);
    }
}

TEST(RefitIndex, KnowsTheTrianglesOfWideBlocks)
{
    const TriangleMesh mesh =
        moved(sample_mesh("torus:24x36").value(), [](std::size_t /*i*/, const Vec3& p) -> Vec3 {
            return (p * 0x1p20).array().round().matrix() * 0x1p-20; // coordinates that floats hold
        });
    const auto topology = build_topology(mesh).value();
    const MeshIndex plain = build_mesh_index(mesh).value();
    const MeshIndex listed = with_lists(plain).value();
    EditableIndex wide(with_signs(with_slabs(listed).value()).value());
    widen_blocks(wide);
    std::mt19937_64 random(9);
    for (int round = 0; round < 20; ++round) {
        const std::size_t vertex = random() % mesh.vertex_count();
        const Vec3 step = random_step(random, 0.2);
        const TriangleMesh after = moved(mesh, [&](std::size_t i, const Vec3& p) -> Vec3 {
            return i == vertex ? Vec3(p + step) : p;
        });
        const MeshIndex narrow = refit_index(listed, after, topology).value();
        const MeshIndex refitted = refit_index(wide.adopted(), after, topology).value();
        EXPECT_GT(refitted.parts().lists()->statistics().stale_leaves, 0U);
        EXPECT_EQ(refitted.parts().lists()->statistics(), narrow.parts().lists()->statistics());
        expect_answers(refitted, after, topology, points_about(mesh, after, 20));
    }
}

TEST(RefitIndex, KeepsListsAwayFromMovedTriangles)
{
    const TriangleMesh mesh = sample_mesh("sphere:60x60").value();
    const auto topology = build_topology(mesh).value();
    const auto built = testing::listed_index(mesh).value();
    const TriangleMesh dented = moved(
        mesh, [](std::size_t, const Vec3& p) -> Vec3 { return p.x() > 0.97 ? Vec3(0.99 * p) : p; });
    const auto refitted = refit_index(built, dented, topology).value();
    const ProximityStatistics& counts = refitted.parts().lists()->statistics();
    EXPECT_GT(counts.stale_leaves, 0U);
    EXPECT_LT(counts.stale_leaves, built.parts().lists()->statistics().leaves / 5);
    EXPECT_EQ(counts.searched_leaves,
              built.parts().lists()->statistics().searched_leaves + counts.stale_leaves);
    QuerySteps steps;
    (void)closest_feature(refitted, {-1.01, 0.1, 0.1}, {}, steps);
    EXPECT_EQ(steps.searches, 0U);
    EXPECT_GT(steps.blocks, 0U);

    const auto same = refit_index(built, mesh, topology).value();
    EXPECT_EQ(same.parts().lists()->statistics(), built.parts().lists()->statistics());
}

TEST(RefitIndex, LooksForNoLeavesWhereNoListIsLeft)
{
    const TriangleMesh mesh = sample_mesh("sphere:20x20").value();
    const auto topology = build_topology(mesh).value();
    const auto built = testing::listed_index(mesh).value();
    const TriangleMesh smaller =
        moved(mesh, [](std::size_t, const Vec3& p) -> Vec3 { return 0.99 * p; });
    Progress progress;
    const auto refitted =
        refit_index(built, smaller, topology, {.execution = {.progress = &progress}}).value();
    EXPECT_STREQ(progress.stage(), "moving boxes"); // no stage after it
    const ProximityStatistics& counts = refitted.parts().lists()->statistics();
    EXPECT_EQ(counts.searched_leaves, counts.leaves);
    expect_answers(refitted, smaller, topology, points_about(mesh, smaller, 60));
    // And from there on.
    const auto back =
        refit_index(refitted, mesh, topology, {.execution = {.progress = &progress}}).value();
    EXPECT_STREQ(progress.stage(), "moving boxes");
    expect_answers(back, mesh, topology, points_about(smaller, mesh, 60));
}

TEST(RefitIndex, LooksForNoLeavesBelowCellsWithoutLists)
{
    const TriangleMesh mesh = sample_mesh("sphere:60x60").value();
    const auto topology = build_topology(mesh).value();
    const auto built = testing::listed_index(mesh).value();
    const TriangleMesh other = moved(
        mesh, [](std::size_t, const Vec3& p) -> Vec3 { return p.x() > 0 ? Vec3(0.99 * p) : p; });
    // It reports a step for each of the 512 cells that it looks below: few but those where x is about 0.
    Progress progress;
    progress.cancel_after(150);
    const auto refitted =
        refit_index(built, other, topology, {.execution = {.progress = &progress}});
    ASSERT_TRUE(refitted) << describe(refitted.error());
    EXPECT_STREQ(progress.stage(), "leaves that triangles moved into");
    expect_answers(*refitted, other, topology, points_about(mesh, other, 60));
}

TEST(RefitIndex, IsTheSameForAnyNumberOfThreads)
{
    const TriangleMesh mesh = sample_mesh("torus:40x30").value();
    const auto topology = build_topology(mesh).value();
    const auto built = testing::listed_index(mesh).value();
    std::mt19937_64 random(3);
    const TriangleMesh other = moved(mesh, [&](std::size_t i, const Vec3& p) -> Vec3 {
        return i % 90 == 0 ? Vec3(p + random_step(random, 0.01)) : p;
    });
    const auto one = refit_index(built, other, topology, {.execution = {.threads = {1}}}).value();
    const auto four = refit_index(built, other, topology, {.execution = {.threads = {4}}}).value();
    EXPECT_TRUE(std::ranges::equal(one.parts().lists()->arrays().nodes,
                                   four.parts().lists()->arrays().nodes));
    EXPECT_TRUE(std::ranges::equal(one.parts().lists()->arrays().table,
                                   four.parts().lists()->arrays().table));
    EXPECT_EQ(one.parts().lists()->statistics(), four.parts().lists()->statistics());
}

// An animation refits each frame's index from that of the frame before.
TEST(RefitIndex, KeepsAliveWhatWasBuiltAndNoIndexBetween)
{
    const TriangleMesh mesh = sample_mesh("sphere:8x8").value();
    const auto topology = build_topology(mesh).value();
    // The index, with lists that die together with what is watched.
    const auto watched = [](const MeshIndex& index, bool is_built,
                            std::weak_ptr<const void>& life) {
        const auto all = std::make_shared<const MeshIndex>(index);
        life = all;
        const ProximityLists& lists = *index.parts().lists();
        return make_mesh_index(
            index.parts().adopt_lists(std::make_shared<const ProximityLists>(ProximityLists::adopt(
                lists.frame(), lists.table_depth(), lists.arrays(), lists.statistics(), all,
                is_built ? nullptr : lists.shared_storage()))));
    };
    std::weak_ptr<const void> built;
    std::weak_ptr<const void> between;
    MeshIndex index = watched(testing::listed_index(mesh).value(), true, built);
    for (int frame = 0; frame < 3; ++frame) {
        std::weak_ptr<const void> last;
        const TriangleMesh other = moved(mesh, [&](std::size_t i, const Vec3& p) -> Vec3 {
            return i == 5 ? Vec3((1 - 0.01 * frame) * p) : p;
        });
        index = watched(refit_index(index, other, topology).value(), false, last);
        EXPECT_TRUE(between.expired());
        EXPECT_FALSE(built.expired());
        between = last;
    }
    index = {};
    EXPECT_TRUE(between.expired());
    EXPECT_TRUE(built.expired());
}

TEST(RefitIndex, RefusesAnotherMesh)
{
    const TriangleMesh mesh = sample_mesh("sphere:8x8").value();
    const auto topology = build_topology(mesh).value();
    const auto built = testing::listed_index(mesh).value();
    const TriangleMesh cube = sample_mesh("cube").value();
    const auto expect_refused = [&](const TriangleMesh& other, const Topology& its,
                                    const std::string& why) {
        const auto refitted = refit_index(built, other, its);
        ASSERT_FALSE(refitted);
        EXPECT_EQ(code_of(refitted), ErrorCode::invalid_argument);
        EXPECT_NE(describe(refitted.error()).find(why), std::string::npos)
            << describe(refitted.error());
    };
    expect_refused(cube, build_topology(cube).value(), "other triangles");
    std::vector<TriangleCorners> turned(mesh.triangles().begin(), mesh.triangles().end());
    std::swap(turned[3][0], turned[3][1]);
    const TriangleMesh other =
        make_triangle_mesh({mesh.positions().begin(), mesh.positions().end()}, turned).value();
    expect_refused(other, build_topology(other).value(), "other triangles");
    expect_refused(
        moved(mesh,
              [](std::size_t i, const Vec3& p) -> Vec3 { return i == 5 ? Vec3(9, 0, 0) : p; }),
        topology, "root");
    const auto away = moved(
        mesh, [](std::size_t i, const Vec3& p) -> Vec3 { return i == 5 ? Vec3(0.9 * p) : p; });
    const auto refitted = refit_index(built, away, topology).value();
    const auto path = std::filesystem::temp_directory_path() / "proxima_refitted.pxi";
    const Status saved = save_index(refitted, path);
    ASSERT_FALSE(saved);
    EXPECT_NE(describe(saved.error()).find("refitted"), std::string::npos);
    EXPECT_FALSE(std::filesystem::exists(path));
}

TEST(RefitIndex, StopsAtEveryStage)
{
    const TriangleMesh mesh = sample_mesh("sphere:30x30").value();
    const auto topology = build_topology(mesh).value();
    const auto built = testing::listed_index(mesh).value();
    const TriangleMesh other = moved(mesh, [](std::size_t i, const Vec3& p) -> Vec3 {
        return i % 50 == 0 ? Vec3(0.99 * p) : p;
    });
    cancel_at_every_stage(
        [&](Progress& progress) {
            return refit_index(built, other, topology,
                               {.execution = {.threads = {1}, .progress = &progress}});
        },
        [] { return true; });
}

} // namespace
} // namespace proxima::testing::refit_index_test
