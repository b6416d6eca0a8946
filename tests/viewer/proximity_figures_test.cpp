// Figures of Voronoi regions and proximity octrees show what they must.
#include "proxima/execution.h"
#include "query/closest/brute_force.h"
#include "viewer/figure_parts.h"
#include "viewer/figures/voronoi_figures.h"
#include "viewer/query_shapes.h"

#include <algorithm>
#include <gtest/gtest.h>
#include <random>
#include <set>

namespace proxima::proximity_figures_test {
namespace {

TEST(ProximityFigures, ListedCellsAreThoseThatMeetTheRegion)
{
    const auto shown = sphere_with_listed_feature({});
    ASSERT_TRUE(shown);
    const auto topology = build_topology(shown->mesh);
    std::set<std::uint64_t> listing;
    for (const ThesisCell& cell : shown->listing) listing.insert(cell.key.bits);
    // Points whose closest feature is the vertex lie in listed cells only.
    std::mt19937_64 random(5);
    std::uniform_real_distribution<double> coordinate(-1.7, 1.7);
    std::set<std::uint64_t> met;
    for (int i = 0; i < 40000; ++i) {
        const Vec3 point{coordinate(random), coordinate(random), coordinate(random)};
        const auto cell = shown->octree.locate(point);
        if (!cell || shown->octree.type(*cell) != CellClass::outer) continue;
        const auto closest = closest_feature_by_brute_force(shown->mesh, *topology, point);
        if (closest.feature != shown->feature) continue;
        EXPECT_TRUE(listing.contains(cell->key.bits));
        met.insert(cell->key.bits);
    }
    EXPECT_GT(met.size(), listing.size() / 3);
    const auto content = figure_4_2({});
    ASSERT_TRUE(content);
    EXPECT_EQ(surfaces_named(scene_of(*content, 1).scene, "cell").size(), listing.size());
}

TEST(ProximityFigures, VoronoiRegionsAreBoundedByTheirPlanes)
{
    struct Expectation {
        Result<FigureContent> (*make)(const Execution&);
        std::size_t planes;
        std::size_t rays;
    };
    for (const auto& [make, planes, rays] :
         {Expectation{figure_4_3, 3, 3}, Expectation{figure_4_4, 4, 4},
          Expectation{figure_4_5, 4, 4}}) {
        const auto content = make({});
        ASSERT_TRUE(content) << content.error().message;
        const DrawnScene& scene = scene_of(*content).scene;
        EXPECT_EQ(surfaces_named(scene, "normal").size(), planes);
        EXPECT_EQ(surfaces_named(scene, "ray").size(), rays);
    }
    const auto bodies = figure_4_6({});
    ASSERT_TRUE(bodies);
    // The cube: 8 corners, 12 edges that are bent, 12 triangles.
    const DrawnScene& cube = scene_of(*bodies, 0).scene;
    EXPECT_EQ(surfaces_named(cube, "vertex").size(), 8U);
    EXPECT_EQ(surfaces_named(cube, "edge").size(), 12U);
    EXPECT_EQ(surfaces_named(cube, "face").size(), 12U);
}

TEST(ProximityFigures, ObstructingFacetsAreThoseThatRaysCross)
{
    const auto content = figure_4_9({});
    ASSERT_TRUE(content) << content.error().message;
    for (std::size_t panel = 0; panel < 3; ++panel) {
        const DrawnScene& scene = scene_of(*content, panel).scene;
        const auto normals = surfaces_named(scene, "normal");
        const auto rays = surfaces_named(scene, "ray");
        ASSERT_FALSE(normals.empty());
        ASSERT_FALSE(rays.empty());
        // Arrows begin with a vertex of the shaft and end at their tips.
        for (const SceneSurface* const normal : normals) {
            const auto direction = [](const SceneSurface& arrow) -> Vec3 {
                return arrow.positions[6] - arrow.positions[0];
            };
            const bool along_a_ray = std::ranges::any_of(rays, [&](const SceneSurface* ray) {
                return direction(*normal).dot(direction(*ray)) > 0.0;
            });
            EXPECT_TRUE(along_a_ray);
        }
    }
}

TEST(ProximityFigures, ListsGetShorterWithDepth)
{
    const auto content = figure_5_3({});
    ASSERT_TRUE(content && content->drawing);
    std::vector<double> means;
    for (std::size_t at = content->caption.find(": "); at != std::string::npos;
         at = content->caption.find(": ", at + 1)) {
        means.push_back(std::stod(content->caption.substr(at + 2)));
    }
    ASSERT_EQ(means.size(), 4U);
    EXPECT_TRUE(std::ranges::is_sorted(means, std::greater<>()));
}

} // namespace
} // namespace proxima::proximity_figures_test
