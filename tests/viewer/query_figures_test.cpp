// Figures of queries show what those answer, and what slow oracles do.
#include "proxima/intersect_meshes.h"
#include "proxima/mesh_index.h"
#include "proxima/octree.h"
#include "query/closest/brute_force.h"
#include "viewer/figure_parts.h"
#include "viewer/figures/query_figures.h"
#include "viewer/figures/ray_figures.h"
#include "viewer/query_shapes.h"

#include <algorithm>
#include <gtest/gtest.h>
#include <set>

namespace proxima::query_figures_test {
namespace {

/// Leaves in which a ray has a stretch of some length, by cutting it to each leaf's slabs.
std::set<std::uint64_t> leaves_on_ray(const LitCells& lit)
{
    struct Collector {
        const LitCells& lit;
        std::set<std::uint64_t>& keys;

        [[nodiscard]] bool should_enter(const Cell&) const { return true; }
        Flow visit_leaf(const Cell& cell, std::span<const TriangleId>)
        {
            const Box box = lit.octree.box(cell);
            double enter = lit.ray.t_min;
            double exit = lit.ray.t_max;
            for (int axis = 0; axis < 3; ++axis) {
                const double start = lit.ray.origin[axis];
                const double step = lit.ray.direction[axis];
                if (step == 0.0) {
                    if (start <= box.lower[axis] || start >= box.upper[axis]) exit = -1e300;
                    continue;
                }
                const double one = (box.lower[axis] - start) / step;
                const double other = (box.upper[axis] - start) / step;
                enter = std::max(enter, std::min(one, other));
                exit = std::min(exit, std::max(one, other));
            }
            if (exit - enter > 1e-9) keys.insert(cell.key.bits);
            return Flow::proceed;
        }
    };
    std::set<std::uint64_t> keys;
    traverse(lit.octree, Collector{lit, keys});
    return keys;
}

TEST(QueryFigures, LitCellsAreThoseAlongTheRayWithTheirWeights)
{
    for (const bool fully : {true, false}) {
        const auto lit = fully ? fully_lit_cells({}) : variously_lit_cells({});
        const auto content = fully ? figure_5_5({}) : figure_5_6({});
        ASSERT_TRUE(lit && content);
        std::set<std::uint64_t> keys;
        for (const CellOnRay& cell : lit->cells) keys.insert(cell.cell.key.bits);
        EXPECT_EQ(keys, leaves_on_ray(*lit));
        EXPECT_GE(keys.size(), 8U);
        const ScenePanel& panel = scene_of(*content);
        const auto shown = surfaces_named(panel.scene, "cell");
        ASSERT_EQ(shown.size(), lit->cells.size());
        // The picture has the colour of each cell.
        const auto colors = pixels_by_color(picture_of(panel));
        for (std::size_t i = 0; i < shown.size(); ++i) {
            const double weight = lit->cells[i].penetration;
            if (fully) {
                EXPECT_NEAR(weight, 1.0, 1e-12);
            }
            const Color expected = intensity_color(weight);
            EXPECT_TRUE((shown[i]->color == expected).all());
            const Canvas one(1, 1, {expected, expected});
            const auto found = colors.find(one.image().pixel(0, 0));
            EXPECT_TRUE(found != colors.end() && found->second > 50) << "cell " << i;
        }
    }
}

TEST(QueryFigures, TouchedPointAgreesWithBruteForce)
{
    const auto touched = touched_feature({});
    ASSERT_TRUE(touched);
    const auto topology = build_topology(touched->mesh);
    const auto closest = closest_feature_by_brute_force(touched->mesh, *topology, touched->cursor);
    EXPECT_EQ(touched->closest.feature, closest.feature);
    EXPECT_TRUE(touched->leaf.contains(touched->cursor));
    std::vector<TriangleId> around;
    const TriangleCorners own = touched->mesh.triangles()[closest.feature.id];
    for (std::uint32_t i = 0; i < touched->mesh.triangle_count(); ++i) {
        const bool shares = std::ranges::any_of(touched->mesh.triangles()[i], [&](auto corner) {
            return std::ranges::find(own, corner) != own.end();
        });
        if (shares && i != closest.feature.id) around.push_back(TriangleId{i});
    }
    EXPECT_EQ(touched->around, around);
    const auto content = figure_5_2({});
    ASSERT_TRUE(content) << content.error().message;
    const DrawnScene& scene = scene_of(*content).scene;
    EXPECT_EQ(surfaces_named(scene, "closest").at(0)->triangles.size(), 1U);
    EXPECT_EQ(surfaces_named(scene, "around").at(0)->triangles.size(), around.size());
    EXPECT_EQ(surfaces_named(scene, "mesh").at(0)->triangles.size(),
              touched->mesh.triangle_count() - around.size() - 1);
    EXPECT_EQ(surfaces_named(scene, "leaf").size(), 1U);
}

TEST(QueryFigures, YellowTrianglesAreAllThatCanIntersect)
{
    const auto spheres = meeting_spheres({});
    ASSERT_TRUE(spheres);
    const auto index_a = build_mesh_index(spheres->a);
    ASSERT_TRUE(index_a);
    const auto pairs = intersecting_pairs(*index_a, *index_a, spheres->pose_b);
    EXPECT_GT(pairs.size(), 50U);
    for (const TrianglePair& pair : pairs) {
        EXPECT_TRUE(std::ranges::binary_search(spheres->candidates.a, pair.a));
        EXPECT_TRUE(std::ranges::binary_search(spheres->candidates.b, pair.b));
    }
    const auto content = figure_5_4({});
    ASSERT_TRUE(content);
    const DrawnScene& scene = scene_of(*content).scene;
    const auto yellow = surfaces_named(scene, "candidates");
    ASSERT_EQ(yellow.size(), 2U);
    EXPECT_EQ(yellow[0]->triangles.size(), spheres->candidates.a.size());
    EXPECT_EQ(yellow[1]->triangles.size(), spheres->candidates.b.size());
    for (const bool of_a : {true, false}) {
        std::set<std::uint64_t> keys;
        for (const LeafPair& pair : spheres->leaves) keys.insert((of_a ? pair.a : pair.b).key.bits);
        const auto lines =
            std::ranges::find(scene.lines, of_a ? "leaves of A" : "leaves of B", &SceneLines::name);
        ASSERT_NE(lines, scene.lines.end());
        EXPECT_EQ(lines->segments.size(), 12 * keys.size());
    }
}

TEST(QueryFigures, CulledCellsAreOutsideOfAPlane)
{
    const auto ship = culled_ship({});
    ASSERT_TRUE(ship);
    struct Collector {
        const CulledShip& ship;
        std::set<std::uint64_t>& keys;
        std::set<TriangleId>& triangles;

        [[nodiscard]] bool should_enter(const Cell&) const { return true; }
        Flow visit_leaf(const Cell& cell, std::span<const TriangleId> held)
        {
            if (held.empty()) return Flow::proceed;
            const Box box = ship.octree.box(cell);
            for (const ViewPlane& plane : ship.volume.planes()) {
                double most = plane.offset;
                for (int k = 0; k < 3; ++k) {
                    most +=
                        std::max(plane.normal[k] * box.lower[k], plane.normal[k] * box.upper[k]);
                }
                if (most < 0.0) return Flow::proceed;
            }
            keys.insert(cell.key.bits);
            triangles.insert(held.begin(), held.end());
            return Flow::proceed;
        }
    };
    std::set<std::uint64_t> keys;
    std::set<TriangleId> triangles;
    traverse(ship->octree, Collector{*ship, keys, triangles});
    std::set<std::uint64_t> shown;
    for (const Cell& cell : ship->cells) shown.insert(cell.key.bits);
    EXPECT_EQ(shown, keys);
    EXPECT_EQ(ship->triangles, std::vector<TriangleId>(triangles.begin(), triangles.end()));
    const auto content = figure_5_7({});
    ASSERT_TRUE(content);
    const DrawnScene& scene = scene_of(*content).scene;
    EXPECT_EQ(surfaces_named(scene, "visible").at(0)->triangles.size(), triangles.size());
    EXPECT_EQ(surfaces_named(scene, "culled").at(0)->triangles.size(),
              ship->mesh.triangle_count() - triangles.size());
}

} // namespace
} // namespace proxima::query_figures_test
