#include "proxima/cull.h"

#include "counted_allocations.h"
#include "geometry/test_volumes.h"
#include "geometry/view_contact.h"
#include "geometry/view_plane.h"
#include "index/test_meshes.h"
#include "proxima/octree.h"

#include <gtest/gtest.h>

#include <array>

namespace proxima::cull_cells_test {
namespace {

using namespace testing;

struct LeafCollector {
    std::vector<Cell>& leaves;

    [[nodiscard]] bool should_enter(const Cell& /*cell*/) const { return true; }
    Flow visit_leaf(const Cell& cell, std::span<const TriangleId> /*triangles*/)
    {
        leaves.push_back(cell);
        return Flow::proceed;
    }
};

TEST(CullCells, AgreesWithAllLeaves)
{
    std::array<std::size_t, 4> counts{}; // outside, passing only, met, inside
    std::uint64_t seed = 1;
    for (const NamedMesh& named : proximity_meshes()) {
        const Octree octree = build_octree(named.mesh, {.max_depth = 4, .threshold = 4}).value();
        std::vector<Cell> leaves;
        traverse(octree, LeafCollector{leaves});
        VolumeGenerator generate(named.mesh.positions(), seed++);
        for (int i = 0; i < 12; ++i) {
            SCOPED_TRACE(::testing::Message()
                         << named.name << ", seed " << seed - 1 << ", volume " << i);
            const ViewVolume volume = generate();
            for (const CullMode mode : {CullMode::conservative, CullMode::exact}) {
                const auto seen = visible_cells(octree, volume, mode);
                std::size_t next = 0;
                for (const Cell& leaf : leaves) {
                    const Box box = octree.box(leaf);
                    const bool truth = mode == CullMode::exact ? meets_volume(volume, box)
                                                               : passes_planes(volume, box);
                    const bool found = next < seen.size() && seen[next].cell.key == leaf.key;
                    ASSERT_EQ(found, truth);
                    if (!found) {
                        counts[mode == CullMode::exact && passes_planes(volume, box) ? 1 : 0] += 1;
                        continue;
                    }
                    ASSERT_EQ(seen[next].cell.node, leaf.node);
                    ASSERT_EQ(seen[next].cell.type, leaf.type);
                    bool inside = true;
                    for (const ViewPlane& plane : volume.planes()) {
                        inside = inside && side_of_plane(plane, outermost_corner(plane, box)) >= 0;
                    }
                    ASSERT_EQ(seen[next].is_inside, inside);
                    counts[inside ? 3 : 2] += 1;
                    ++next;
                }
                ASSERT_EQ(next, seen.size());
            }
        }
    }
    for (const std::size_t count : counts) EXPECT_GT(count, 100U);
}

TEST(CullCells, DoesNotAllocateAndStopsOnRequest)
{
    const TriangleMesh mesh = torus_mesh(1.0, 0.4, 60, 40);
    const Octree octree = build_octree(mesh, {.max_depth = 5}).value();
    const ViewVolume volume =
        make_perspective_volume({.eye = Vec3(0, 0, 3), .field_of_view = 0.3}).value();
    const std::size_t before = allocation_count();
    for (const CullMode mode : {CullMode::conservative, CullMode::exact}) {
        std::size_t count = 0;
        visible_cells(octree, volume, mode, [&](const VisibleCell& /*at*/) {
            ++count;
            return Flow::proceed;
        });
        EXPECT_GT(count, 20U);
        std::size_t first_few = 0;
        visible_cells(octree, volume, mode, [&](const VisibleCell& /*at*/) {
            return ++first_few == 3 ? Flow::stop : Flow::proceed;
        });
        EXPECT_EQ(first_few, 3U);
    }
    EXPECT_EQ(allocation_count(), before);
    const auto nothing =
        make_view_volume(std::vector<ViewPlane>{{Vec3::UnitX(), 0}, {-Vec3::UnitX(), -1e-9}});
    EXPECT_TRUE(visible_cells(octree, *nothing).empty());
    EXPECT_TRUE(visible_cells(Octree(), volume).empty());
}

} // namespace
} // namespace proxima::cull_cells_test
