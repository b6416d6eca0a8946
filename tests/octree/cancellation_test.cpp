// Everything in this layer that takes long stops when asked to, and leaves nothing behind.
#include "cancellation.h"
#include "folder_test.h"
#include "octree/check_octree.h"
#include "octree/classify_cells.h"
#include "proxima/octree.h"
#include "proxima/octree_io.h"
#include "proxima/sample_meshes.h"

#include <algorithm>

namespace proxima::cancellation_test {
namespace {

using testing::cancel_at_every_stage;
using testing::files_in;

const TriangleMesh& large_mesh()
{
    static const TriangleMesh mesh = *make_spaceship(20000);
    return mesh;
}

const Octree& large_octree()
{
    static const Octree octree = *build_octree(large_mesh(), {.max_depth = 8, .threshold = 4});
    return octree;
}

class OctreeCancellation : public FolderTest {};

TEST_F(OctreeCancellation, StopsSavingAndLoadingAtEveryStage)
{
    const auto file = path("a.pxo");
    std::ofstream(file) << "old";
    const auto before = files_in(folder());
    cancel_at_every_stage(
        [&](Progress& progress) {
            return save_octree(large_octree(), file, {.execution = {.progress = &progress}});
        },
        [&] { return files_in(folder()) == before; }, 3);

    ASSERT_TRUE(save_octree(large_octree(), file));
    cancel_at_every_stage(
        [&](Progress& progress) {
            return load_octree(file, {.execution = {.progress = &progress}});
        },
        [] { return true; }, 3);
}

TEST_F(OctreeCancellation, StopsExportingAtEveryStage)
{
    for (const char* const name : {"a.vtu", "a.htg", "a.ply", "a.glb"}) {
        SCOPED_TRACE(name);
        std::ofstream(path(name)) << "old";
        const auto before = files_in(folder());
        cancel_at_every_stage(
            [&](Progress& progress) {
                return export_octree(large_octree(), large_mesh(), path(name),
                                     {.execution = {.progress = &progress}});
            },
            [&] { return files_in(folder()) == before; }, 5);
    }
}

TEST(OctreeBuildCancellation, StopsAtEveryStage)
{
    for (const Subdivision subdivision : {Subdivision::adaptive, Subdivision::uniform}) {
        for (const int threads : {1, 2}) {
            SCOPED_TRACE(threads);
            cancel_at_every_stage(
                [&](Progress& progress) {
                    return build_octree(
                        large_mesh(), {.max_depth = 6,
                                       .threshold = 4,
                                       .subdivision = subdivision,
                                       .execution = {.threads = {threads}, .progress = &progress}});
                },
                [] { return true; }, 6);
        }
    }
}

TEST(OctreeBuildCancellation, StopsWhileClassifyingAMeshWithAHole)
{
    std::vector<Vec3> positions(large_mesh().positions().begin(), large_mesh().positions().end());
    std::vector<TriangleCorners> triangles(large_mesh().triangles().begin() + 500,
                                           large_mesh().triangles().end());
    const auto open = make_triangle_mesh(std::move(positions), std::move(triangles));
    ASSERT_TRUE(open);
    const auto octree =
        build_octree(*open, {.max_depth = 7, .classification = Classification::none});
    ASSERT_TRUE(octree);
    cancel_at_every_stage(
        [&](Progress& progress) {
            return classify_cells(*octree, *open,
                                  {.execution = {.threads = {1}, .progress = &progress}});
        },
        [] { return true; }, 6);
}

TEST(OctreeCheckCancellation, ReportsThatItWasStopped)
{
    const TriangleMesh mesh = make_sphere(40, 40);
    const auto octree = build_octree(mesh, {.max_depth = 5});
    ASSERT_TRUE(octree);
    cancel_at_every_stage(
        [&](Progress& progress) { return check_octree(*octree, mesh, &progress); },
        [] { return true; }, 4);
}

} // namespace
} // namespace proxima::cancellation_test
