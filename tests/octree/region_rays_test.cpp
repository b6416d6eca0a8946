#include "octree/region_rays.h"

#include "octree/hole_caps.h"
#include "octree/small_meshes.h"
#include "octree/winding_number.h"
#include "proxima/octree.h"
#include "proxima/sample_meshes.h"

#include <gtest/gtest.h>
#include <random>

namespace proxima::region_rays_test {
namespace {

using namespace testing;

/// Every group of empty cells a region of its own: the rays then go from group to group.
struct Groups {
    explicit Groups(const TriangleMesh& mesh, int max_depth, std::uint32_t threshold = 4)
        : caps(hole_caps(mesh, nullptr).value()),
          octree(build_octree(mesh, {.max_depth = max_depth,
                                     .threshold = threshold,
                                     .classification = Classification::none})
                     .value()),
          groups(octree)
    {
        const auto ignore = [](std::uint32_t, std::uint32_t) {};
        EmptyFaces(octree, groups, ignore, nullptr).visit_all();
        for (std::uint32_t i = 0; i < groups.count(); ++i) {
            regions.of_group.push_back(i);
            regions.start.push_back(groups[i].first_cell());
        }
    }

    TriangleMesh caps;
    Octree octree;
    EmptyGroups groups;
    EmptyRegions regions;
};

/// Casts every ray of a sample of the groups and compares with sums of solid angles.
/// Returns how many rays came to an end.
int expect_differences(const TriangleMesh& mesh, const Groups& of, std::uint32_t step)
{
    const RegionRays rays(of.octree, mesh, of.caps, of.groups, of.regions);
    const auto winding = [&](std::uint32_t group) {
        const Vec3 point = cell_box(of.octree.frame(), of.regions.start[group]).center();
        return std::lround(brute_winding_number(mesh, point) +
                           brute_winding_number(of.caps, point));
    };
    int ended = 0;
    RegionRays::Scratch scratch;
    for (std::uint32_t group = 0; group < of.groups.count(); group += step) {
        const long here = winding(group);
        for (int direction = 0; direction < RegionRays::directions; ++direction) {
            const auto end = rays.cast(group, direction, scratch);
            if (!end) continue;
            ++ended;
            const long there = end->region == EmptyRegions::none ? 0 : winding(end->region);
            EXPECT_EQ(there - here, end->change) << "group " << group << " direction " << direction;
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
        EXPECT_GT(expect_differences(mesh, Groups(mesh, 5), 7), 100);
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
        EXPECT_GT(expect_differences(mesh, Groups(mesh, 4), 3), 100);
    }
    Groups of(holed, 4);
    EXPECT_GT(of.caps.triangle_count(), 0U);
    for (std::uint32_t group = 0; group < of.groups.count(); ++group) {
        Box box;
        for (int octant = 0; octant < 8; ++octant) {
            if ((of.groups[group].octants >> octant & 1) == 0) continue;
            const Box cell = cell_box(of.octree.frame(), child(of.groups[group].parent, octant));
            box.extend(cell.lower);
            box.extend(cell.upper);
        }
        const Box caps = bounding_box(of.caps);
        const bool apart = (box.lower.array() > caps.upper.array()).any() ||
                           (box.upper.array() < caps.lower.array()).any();
        if (!apart) of.regions.of_group[group] = EmptyRegions::none;
    }
    const RegionRays rays(of.octree, holed, of.caps, of.groups, of.regions);
    int through = 0;
    RegionRays::Scratch scratch;
    for (std::uint32_t group = 0; group < of.groups.count(); ++group) {
        if (of.regions.of_group[group] == EmptyRegions::none) continue;
        const auto winding = [&](std::uint32_t at) {
            const Vec3 point = cell_box(of.octree.frame(), of.regions.start[at]).center();
            return std::lround(brute_winding_number(holed, point) +
                               brute_winding_number(of.caps, point));
        };
        for (int direction = 0; direction < RegionRays::directions; ++direction) {
            const auto end = rays.cast(group, direction, scratch);
            if (!end) continue;
            const long there = end->region == EmptyRegions::none ? 0 : winding(end->region);
            EXPECT_EQ(there - winding(group), end->change);
            through += end->change != 0 ? 1 : 0;
        }
    }
    EXPECT_GT(through, 20);
}

TEST(RegionRays, AgreeWhereFacesLieOnPlanesOfCells)
{
    for (const double half : {1.0, 0.5, 0.375}) {
        const TriangleMesh mesh =
            joined(cube_mesh(Vec3(0, 0, 0), 1.0), cube_mesh(Vec3(0, 0, 0), half));
        const Groups of(mesh, 4, 1);
        const auto rays = static_cast<int>(of.groups.count()) * RegionRays::directions;
        EXPECT_EQ(expect_differences(mesh, of, 1), rays);
    }
}

TEST(RegionRays, GiveUpAtEdges)
{
    // A box in a cube, with edges where rays run: they give up rather than count.
    constexpr int max_depth = 4;
    const TriangleMesh outer = cube_mesh(Vec3::Zero(), 1.0);
    const OctreeFrame frame = Groups(outer, max_depth, 1).octree.frame();
    const auto ray_through = [&](std::uint32_t cell) {
        constexpr std::array<double, 3> parts = {0.381966, 0.276393, 0.447214}; // of a cell's edges
        Vec3 point;
        for (int axis = 0; axis < 3; ++axis) {
            const double below = frame.plane(axis, cell, max_depth);
            const double above = frame.plane(axis, cell + 1, max_depth);
            point[axis] = below + parts[static_cast<std::size_t>(axis)] * (above - below);
        }
        return point;
    };
    int given_up = 0;
    for (const auto& [first, last] : {std::pair(5U, 10U), std::pair(6U, 9U)}) {
        const Vec3 lower = ray_through(first);
        const Vec3 upper = ray_through(last);
        const TriangleMesh box = moved(cube_mesh(Vec3::Zero(), 1.0), [&](const Vec3& p) {
            return Vec3((p.array() < 0).select(lower, upper));
        });
        const TriangleMesh mesh = joined(outer, box);
        const Groups of(mesh, max_depth, 1);
        const auto rays = static_cast<int>(of.groups.count()) * RegionRays::directions;
        const int ended = expect_differences(mesh, of, 1);
        EXPECT_GT(ended, 1000);
        given_up += rays - ended;
    }
    EXPECT_GT(given_up, 20);
}

TEST(RegionRays, TieEveryRegionOfASpaceshipToTheOutside)
{
    const TriangleMesh mesh = sample_mesh("spaceship:20000").value();
    const Groups of(mesh, 7);
    const RegionRays rays(of.octree, mesh, of.caps, of.groups, of.regions);
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
} // namespace proxima::region_rays_test
