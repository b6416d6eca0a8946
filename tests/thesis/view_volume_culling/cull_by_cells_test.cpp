#include "proxima/thesis.h"

#include "geometry/test_volumes.h"
#include "geometry/view_contact.h"
#include "octree/nasty_meshes.h"
#include "proxima/octree.h"
#include "proxima/sample_meshes.h"

#include <gtest/gtest.h>

#include <set>

namespace proxima::cull_by_cells_test {
namespace {

using namespace testing;

/// What the leaves list whose box meets the volume.
struct Listed {
    std::set<TriangleId> ids;
    std::uint64_t occupied = 0; ///< leaves
    std::uint64_t empty = 0;
};

Listed listed_by_brute_force(const Octree& octree, const ViewVolume& volume)
{
    Listed listed;
    std::vector<Cell> pending = {octree.root()};
    while (!pending.empty()) {
        const Cell cell = pending.back();
        pending.pop_back();
        if (octree.is_leaf(cell)) {
            if (!meets_volume(volume, octree.box(cell))) continue;
            const auto list = octree.triangles(cell);
            listed.ids.insert(list.begin(), list.end());
            ++(list.empty() ? listed.empty : listed.occupied);
        } else {
            for (int octant = 0; octant < 8; ++octant)
                pending.push_back(octree.child(cell, octant));
        }
    }
    return listed;
}

TEST(CullByCells, ListsTheTrianglesOfTheCellsThatMeetTheVolume)
{
    std::size_t beside = 0;
    std::size_t visible = 0;
    std::uint64_t empty = 0;
    for (std::uint32_t seed = 0; seed < 200; ++seed) {
        const TriangleMesh mesh = seed % 4 == 0 ? make_torus(30, 20) : nasty_mesh(seed);
        const auto octree = build_octree(mesh, {.max_depth = static_cast<int>(seed % 6)});
        ASSERT_TRUE(octree);
        VolumeGenerator generate(mesh.positions(), seed);
        for (int i = 0; i < 10; ++i) {
            SCOPED_TRACE(::testing::Message() << "seed " << seed << " volume " << i);
            const ViewVolume volume = generate();
            const CellCulling culled = cull_by_cells(*octree, volume);
            const Listed truth = listed_by_brute_force(*octree, volume);
            ASSERT_EQ(culled.triangles,
                      std::vector<TriangleId>(truth.ids.begin(), truth.ids.end()));
            ASSERT_EQ(culled.cells, truth.occupied);
            empty += truth.empty;
            for (std::uint32_t id = 0; id < mesh.triangle_count(); ++id) {
                const bool meets = meets_volume(volume, mesh.triangle(TriangleId{id}));
                const bool listed = truth.ids.contains(TriangleId{id});
                ASSERT_TRUE(listed || !meets) << id;
                visible += meets ? 1U : 0U;
                beside += listed && !meets ? 1U : 0U;
            }
        }
    }
    EXPECT_GT(visible, 1000U);
    EXPECT_GT(beside, 1000U);
    EXPECT_GT(empty, 1000U);
}

} // namespace
} // namespace proxima::cull_by_cells_test
