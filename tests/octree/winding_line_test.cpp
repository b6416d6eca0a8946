#include "octree/winding_line.h"

#include "octree/empty_cells.h"
#include "octree/grow_part.h"
#include "octree/nasty_meshes.h"
#include "octree/small_meshes.h"
#include "octree/winding_number.h"
#include "proxima/sample_meshes.h"

#include <gtest/gtest.h>
#include <random>

namespace proxima::winding_line_test {
namespace {

using namespace testing;

std::vector<Cell> empty_leaves(const Octree& octree)
{
    struct Collector {
        std::vector<Cell>& leaves;
        static bool should_enter(const Cell&) { return true; }
        Flow visit_leaf(const Cell& cell, std::span<const TriangleId> triangles)
        {
            if (triangles.empty()) leaves.push_back(cell);
            return Flow::proceed;
        }
    };
    std::vector<Cell> leaves;
    traverse(octree, Collector{leaves});
    return leaves;
}

/// The octree's crossings, those of the whole list of triangles, and the sum of solid angles.
/// Returns how many cells there were.
std::size_t expect_windings(const TriangleMesh& mesh, const OctreeOptions& options)
{
    const Octree octree = build_octree(mesh, options).value();
    const auto leaves = empty_leaves(octree);
    for (const Cell& cell : leaves) {
        const WindingLine line = winding_line(octree.frame(), options.max_depth, cell.key);
        const std::int64_t counted = count_crossings(octree, mesh, line);
        EXPECT_EQ(counted, count_crossings(octree.frame(), options.max_depth, mesh, line))
            << cell.key.bits;
        EXPECT_EQ(counted, std::lround(brute_winding_number(mesh, octree.box(cell).center())))
            << cell.key.bits;
    }
    return leaves.size();
}

TEST(WindingLine, CountsTheWindingNumbersOfClosedMeshes)
{
    for (const char* const name :
         {"sphere:20x24", "spaceship:3000", "torus:24x12", "icosphere:2"}) {
        SCOPED_TRACE(name);
        const TriangleMesh mesh = sample_mesh(name).value();
        EXPECT_GT(expect_windings(mesh, {.max_depth = 5, .threshold = 3}), 200U);
    }
}

TEST(WindingLine, CountsShellsWithinAndAcrossEachOther)
{
    const TriangleMesh ball = sphere_mesh(Vec3(0.1, 0.2, 0.3), 1.0, 12, 12);
    const TriangleMesh twice = joined(ball, ball);
    EXPECT_GT(expect_windings(twice, {.max_depth = 4}), 100U);
    EXPECT_GT(expect_windings(joined(twice, cube_mesh(Vec3(1, 0, 0), 0.6)), {.max_depth = 5}),
              100U);
}

/// Cubes whose faces, edges and corners lie on cell planes, lines through edges and corners included.
TEST(WindingLine, StandsOffEdgesAndCorners)
{
    std::mt19937 random(7);
    const auto whole = [&](int end) {
        return static_cast<int>(random() % static_cast<unsigned>(end));
    };
    for (int round = 0; round < 30; ++round) {
        TriangleMesh mesh = cube_mesh(Vec3(8, 8, 8), 8.0);
        for (int i = 0; i < 3; ++i) {
            const double half = 1.0 + whole(3);
            mesh = joined(mesh, cube_mesh(Vec3(4 + whole(9), 4 + whole(9), 4 + whole(9)), half));
        }
        SCOPED_TRACE(round);
        EXPECT_GT(expect_windings(mesh, {.max_depth = 3 + round % 2}), 10U);
    }
}

TEST(WindingLine, PartsAddUpToTheWhole)
{
    for (std::uint32_t seed = 0; seed < 60; ++seed) {
        SCOPED_TRACE(seed);
        const TriangleMesh mesh = nasty_mesh(seed); // not closed: sums agree whatever they mean
        const OctreeOptions options{.max_depth = 4, .threshold = 2};
        const Octree octree = build_octree(mesh, options).value();
        if (octree.is_leaf(octree.root())) continue;
        std::array<std::vector<TriangleId>, 8> lists;
        std::vector<CellTriangles> cells;
        for (int octant = 0; octant < 8; ++octant) {
            auto& list = lists[static_cast<std::size_t>(octant)];
            struct Collector {
                std::vector<TriangleId>& list;
                static bool should_enter(const Cell&) { return true; }
                Flow visit_leaf(const Cell&, std::span<const TriangleId> triangles)
                {
                    list.insert(list.end(), triangles.begin(), triangles.end());
                    return Flow::proceed;
                }
            };
            traverse_below(octree, octree.child(octree.root(), octant), Collector{list});
            std::ranges::sort(list);
            list.erase(std::unique(list.begin(), list.end()), list.end());
            cells.push_back({child({}, octant), list});
        }
        const GrowCellsOptions grow{.max_depth = 4, .threshold = 2};
        std::vector<GrownPart> parts;
        for (const auto& some : {std::span(cells).first(3), std::span(cells).subspan(3)}) {
            parts.push_back(
                grow_part(mesh, octree.frame(), some, CellsElsewhere::recorded, grow).value());
        }
        for (const Cell& cell : empty_leaves(octree)) {
            const WindingLine line = winding_line(octree.frame(), 4, cell.key);
            std::int64_t sum = 0;
            for (const GrownPart& part : parts) {
                const Octree of =
                    Octree::adopt(octree.frame(), part_parameters(grow), mesh.triangle_count(),
                                  part.arrays.nodes.span(), part.arrays.references.span(), nullptr);
                sum += count_crossings(of, mesh, line);
            }
            ASSERT_EQ(sum, count_crossings(octree, mesh, line)) << cell.key.bits;
        }
    }
}

} // namespace
} // namespace proxima::winding_line_test
