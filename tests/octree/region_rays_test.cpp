#include "octree/region_rays.h"

#include "octree/hole_caps.h"
#include "octree/small_meshes.h"
#include "octree/winding_number.h"
#include "proxima/octree.h"
#include "proxima/sample_meshes.h"

#include <gtest/gtest.h>
#include <random>

namespace proxima {
namespace {

using namespace testing;

/// Every empty cell a region of its own: the rays then go from cell to cell.
struct Cells {
    explicit Cells(const TriangleMesh& mesh, int max_depth, std::uint32_t threshold = 4)
        : caps(hole_caps(mesh, nullptr).value()),
          octree(build_octree(mesh, {.max_depth = max_depth,
                                     .threshold = threshold,
                                     .classification = Classification::none})
                     .value()),
          cells(collect_empty_cells(octree))
    {
        for (std::uint32_t i = 0; i < cells.keys.size(); ++i) {
            regions.of_cell.push_back(i);
            regions.start.push_back(i);
        }
    }

    TriangleMesh caps;
    Octree octree;
    EmptyCells cells;
    EmptyRegions regions;
};

/// Casts every ray of a sample of the cells and compares with sums of solid angles.
/// Returns how many rays came to an end.
int expect_differences(const TriangleMesh& mesh, const Cells& of, std::uint32_t step)
{
    const RegionRays rays(of.octree, mesh, of.caps, of.cells, of.regions);
    const auto winding = [&](std::uint32_t cell) {
        const Vec3 point = cell_box(of.octree.frame(), of.cells.keys[cell]).center();
        return std::lround(brute_winding_number(mesh, point) +
                           brute_winding_number(of.caps, point));
    };
    int ended = 0;
    for (std::uint32_t cell = 0; cell < of.cells.keys.size(); cell += step) {
        const long here = winding(cell);
        for (int direction = 0; direction < RegionRays::directions; ++direction) {
            const auto end = rays.cast(cell, direction);
            if (!end) continue;
            ++ended;
            const long there = end->region == EmptyRegions::none ? 0 : winding(end->region);
            EXPECT_EQ(there - here, end->change) << "cell " << cell << " direction " << direction;
        }
    }
    return ended;
}

TEST(RegionRays, AgreeWithSolidAnglesOnClosedMeshes)
{
    for (const char* const name :
         {"sphere:20x24", "spaceship:3000", "torus:24x12", "icosphere:2"}) {
        SCOPED_TRACE(name);
        const TriangleMesh mesh = sample_mesh(name).value();
        EXPECT_GT(expect_differences(mesh, Cells(mesh, 5), 7), 100);
    }
}

TEST(RegionRays, CountCrossingsOfOverlapsAndHoles)
{
    const TriangleMesh ball = sphere_mesh(Vec3(0.1, 0.2, 0.3), 1.0, 12, 12);
    std::vector<TriangleCorners> open(ball.triangles().begin() + 30, ball.triangles().end());
    const TriangleMesh holed = mesh_of({ball.positions().begin(), ball.positions().end()}, open);
    // Cells that caps touch have no whole winding number: the solid angles tell which.
    for (const TriangleMesh& mesh :
         {joined(ball, ball), joined(ball, cube_mesh(Vec3(1, 0, 0), 0.6))}) {
        EXPECT_GT(expect_differences(mesh, Cells(mesh, 4), 3), 100);
    }
    Cells of(holed, 4);
    EXPECT_GT(of.caps.triangle_count(), 0U);
    for (std::uint32_t cell = 0; cell < of.cells.keys.size(); ++cell) {
        const Box box = cell_box(of.octree.frame(), of.cells.keys[cell]);
        const Box caps = bounding_box(of.caps);
        const bool apart = (box.lower.array() > caps.upper.array()).any() ||
                           (box.upper.array() < caps.lower.array()).any();
        if (!apart) of.regions.of_cell[cell] = EmptyRegions::none;
    }
    const RegionRays rays(of.octree, holed, of.caps, of.cells, of.regions);
    int through = 0;
    for (std::uint32_t cell = 0; cell < of.cells.keys.size(); ++cell) {
        if (of.regions.of_cell[cell] == EmptyRegions::none) continue;
        const auto winding = [&](std::uint32_t at) {
            const Vec3 point = cell_box(of.octree.frame(), of.cells.keys[at]).center();
            return std::lround(brute_winding_number(holed, point) +
                               brute_winding_number(of.caps, point));
        };
        for (int direction = 0; direction < RegionRays::directions; ++direction) {
            const auto end = rays.cast(cell, direction);
            if (!end) continue;
            const long there = end->region == EmptyRegions::none ? 0 : winding(end->region);
            EXPECT_EQ(there - winding(cell), end->change);
            through += end->change != 0 ? 1 : 0;
        }
    }
    EXPECT_GT(through, 20);
}

TEST(RegionRays, GiveUpAtEdges)
{
    // Faces on the planes of the cells, edges along the axes: whatever a ray meets exactly, it
    // gives up rather than count.
    for (const double half : {1.0, 0.5, 0.375}) {
        const TriangleMesh mesh =
            joined(cube_mesh(Vec3(0, 0, 0), 1.0), cube_mesh(Vec3(0, 0, 0), half));
        (void)expect_differences(mesh, Cells(mesh, 4, 1), 1);
    }
}

TEST(RegionRays, TieEveryRegionOfASpaceshipToTheOutside)
{
    const TriangleMesh mesh = sample_mesh("spaceship:20000").value();
    const Cells of(mesh, 7);
    const RegionRays rays(of.octree, mesh, of.caps, of.cells, of.regions);
    std::vector<std::vector<std::uint32_t>> roots;
    for (const int threads : {1, 3}) {
        DisjointOffsets windings(of.regions.start.size() + 1);
        tie_regions(rays, windings, {threads}, nullptr);
        std::uint32_t untied = 0;
        std::vector<std::uint32_t> smallest;
        for (std::uint32_t region = 0; region < rays.region_count(); ++region) {
            untied += are_tied(windings, region, rays.region_count()) ? 0 : 1;
            smallest.push_back(windings.find(region).smallest);
        }
        // A region stays untied only where its rays of all directions meet an edge.
        EXPECT_EQ(untied, 0U);
        roots.push_back(smallest);
    }
    EXPECT_EQ(roots[0], roots[1]);
}

} // namespace
} // namespace proxima
