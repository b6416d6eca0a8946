// Every leaf lists the closest feature of each of its points: of closed cells, corners included.
#include "counted_allocations.h"
#include "index/index_parts.h"
#include "index/listed_index.h"
#include "index/lists/proximity_cells.h"
#include "index/lists/proximity_lists.h"
#include "index/test_meshes.h"
#include "octree/small_meshes.h"
#include "proxima/closest_feature.h"
#include "query/closest/brute_force.h"
#include "query/closest/leaf_candidates.h"
#include "query/neighbourhood/incident_triangles.h"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <random>

namespace proxima::leaf_coverage_test {
namespace {

using namespace testing;

struct Coverage {
    std::size_t leaves = 0;
    std::size_t points = 0;
    std::size_t missed = 0;
};

/// Asks the corners, the centre and some random points of every leaf.
Coverage ask_every_leaf(const MeshIndex& index, const MeshIndex& without_lists,
                        const Topology& topology, int random_points)
{
    std::mt19937_64 random(11);
    std::uniform_real_distribution<double> part(-1, 1);
    const ProximityArrays& arrays = index.parts().lists()->arrays();
    const RootFrame& frame = index.parts().lists()->frame();
    Coverage coverage;
    std::vector<std::uint32_t> ranks;
    std::vector<TriangleId> listed;
    std::vector<ProximityCell> pending = {{root_word(arrays).value(), 0, {}}};
    while (!pending.empty()) {
        const ProximityCell cell = pending.back();
        pending.pop_back();
        if (!proximity_word::is_leaf(cell.word)) {
            for (std::uint32_t octant = 0; octant < 8; ++octant)
                pending.push_back(child(arrays, cell, octant));
            continue;
        }
        ++coverage.leaves;
        read_list(arrays, cell.word, ranks);
        EXPECT_EQ(ranks.size(), list_length(arrays, cell.word));
        if (ranks.empty()) continue; // answered without a list
        listed.clear();
        for (const std::uint32_t rank : ranks) listed.push_back(index.ids()[rank]);
        std::ranges::sort(listed);
        EXPECT_EQ(std::ranges::adjacent_find(listed), listed.end()) << "a triangle twice";

        const double half = std::ldexp(frame.half, -cell.depth);
        Vec3 center = frame.center;
        for (int axis = 0; axis < 3; ++axis)
            center[axis] += (2.0 * cell.at[static_cast<std::size_t>(axis)] + 1) * half - frame.half;
        const auto ask = [&](const Vec3& away) {
            const Vec3 p = center + half * away;
            const ClosestFeature truth = closest_feature(without_lists, p).value();
            const auto holding = incident_triangles(topology, truth.feature, truth.triangle);
            const bool found = std::ranges::any_of(holding, [&](TriangleId triangle) {
                return std::ranges::binary_search(listed, triangle);
            });
            ++coverage.points;
            if (!found) ++coverage.missed;
        };
        for (int corner = 0; corner < 8; ++corner) {
            ask(Vec3((corner & 1) != 0 ? 1 : -1, (corner & 2) != 0 ? 1 : -1,
                     (corner & 4) != 0 ? 1 : -1));
        }
        ask(Vec3::Zero());
        for (int i = 0; i < random_points; ++i) ask(Vec3{part(random), part(random), part(random)});
    }
    return coverage;
}

TEST(LeafCandidates, ListTheClosestFeatureOfEveryPointOfTheirBox)
{
    std::mt19937_64 random(12);
    std::uniform_real_distribution<double> part(0, 1);
    int with_lists = 0;
    int without = 0;
    int outside = 0;
    for (const NamedMesh& named : proximity_meshes()) {
        SCOPED_TRACE(named.name);
        const Topology topology = build_topology(named.mesh).value();
        for (const std::uint64_t bytes_per_triangle : {20U, 200U, 600U}) {
            const std::uint64_t budget = 2048 + bytes_per_triangle * named.mesh.triangle_count();
            const auto index = testing::listed_index(named.mesh, {.list_bytes = budget}).value();
            std::vector<TriangleId> buffer(index.parts().lists()->statistics().max_list);
            for (const Vec3& p : proximity_points(named.mesh, 40, 13)) {
                const std::size_t before = allocation_count();
                const auto leaf = leaf_candidates(index.parts(), p, buffer);
                ASSERT_EQ(allocation_count(), before);
                if (!leaf) {
                    EXPECT_FALSE(index.parts().lists()->frame().contains(p)) << p.transpose();
                    ++outside;
                    continue;
                }
                ++(leaf->has_list ? with_lists : without);
                if (!leaf->has_list) {
                    EXPECT_EQ(leaf->count, 0U);
                    continue;
                }
                ASSERT_GT(leaf->count, 0U);
                ASSERT_LE(leaf->count, buffer.size());
                const std::vector<TriangleId> listed(
                    buffer.begin(), buffer.begin() + static_cast<std::ptrdiff_t>(leaf->count));
                EXPECT_TRUE(std::ranges::is_sorted(listed));
                const double slack = 1e-12 * index.parts().lists()->frame().half;
                EXPECT_TRUE(((p - leaf->box.lower).array() >= -slack).all() &&
                            ((leaf->box.upper - p).array() >= -slack).all())
                    << p.transpose();
                const auto expect_held = [&](const Vec3& at) {
                    const ClosestFeature truth =
                        closest_feature_by_brute_force(named.mesh, topology, at);
                    const auto holding =
                        incident_triangles(topology, truth.feature, truth.triangle);
                    EXPECT_TRUE(std::ranges::any_of(holding, [&](TriangleId id) {
                        return std::ranges::binary_search(listed, id);
                    })) << at.transpose();
                };
                expect_held(p);
                expect_held(leaf->box.lower);
                expect_held(leaf->box.upper);
                for (int i = 0; i < 3; ++i) {
                    expect_held(leaf->box.lower +
                                Vec3{part(random), part(random), part(random)}.cwiseProduct(
                                    leaf->box.extent()));
                }
                // What does not fit is told by the count.
                const auto first = leaf_candidates(index.parts(), p, std::span(buffer).first(1));
                EXPECT_EQ(first->count, leaf->count);
                EXPECT_TRUE(std::ranges::binary_search(listed, buffer[0]));
            }
            EXPECT_FALSE(leaf_candidates(index.parts(), Vec3(0, std::nan(""), 0), buffer));
            EXPECT_FALSE(leaf_candidates(index.parts(), Vec3::Constant(1e300), buffer));
        }
    }
    EXPECT_GT(with_lists, 1000);
    EXPECT_GT(without, 3);
    EXPECT_GT(outside, 10);
}

TEST(LeafCoverage, EveryLeafListsTheClosestFeatureOfItsPoints)
{
    const TriangleMesh inner =
        moved(make_sphere(16, 20), [](const Vec3& p) { return Vec3(p / 2); });
    std::vector<NamedMesh> meshes = {
        {"sphere", make_sphere(30, 40)},
        {"torus", make_torus(48, 24)},
        {"spaceship", sample_mesh("spaceship:2000").value()},
        {"nested spheres", joined(make_sphere(20, 30), inner)},
        {"open sphere", without(make_sphere(24, 30), [](std::size_t i) { return i % 4 == 0; })}};
    for (NamedMesh& named : proximity_meshes()) meshes.push_back(std::move(named));
    std::size_t leaves = 0;
    for (const NamedMesh& named : meshes) {
        SCOPED_TRACE(named.name);
        const auto topology = build_topology(named.mesh);
        ASSERT_TRUE(topology);
        const auto plain = build_mesh_index(named.mesh);
        ASSERT_TRUE(plain);
        for (const std::uint64_t bytes_per_triangle : {20U, 200U, 600U}) {
            SCOPED_TRACE(bytes_per_triangle);
            const std::uint64_t budget = 2048 + bytes_per_triangle * named.mesh.triangle_count();
            const auto index = testing::listed_index(named.mesh, {.list_bytes = budget});
            ASSERT_TRUE(index) << describe(index.error());
            const Coverage coverage = ask_every_leaf(*index, *plain, *topology, 3);
            EXPECT_EQ(coverage.missed, 0U) << "of " << coverage.points;
            EXPECT_EQ(coverage.leaves, index->parts().lists()->statistics().leaves);
            leaves += coverage.leaves;
        }
    }
    EXPECT_GT(leaves, 20000U);
}

} // namespace
} // namespace proxima::leaf_coverage_test
