#include "cli/octree_picture.h"

#include "cancellation.h"
#include "folder_test.h"
#include "proxima/mesh/sample_meshes.h"
#include "proxima/octree/build_octree.h"

#include <algorithm>

namespace proxima {
namespace {

class OctreePicture : public FolderTest {
protected:
    TriangleMesh mesh = *make_spaceship(4000);
    Octree octree = *build_octree(mesh, {.max_depth = 5});
};

TEST_F(OctreePicture, StopsAtEveryStage)
{
    testing::cancel_at_every_stage(
        [&](Progress& progress) {
            return draw_octree(octree, mesh, {.width = 200, .height = 150, .progress = &progress});
        },
        [] { return true; }, 5);
}

TEST_F(OctreePicture, IsWrittenWholeOrNotAtAll)
{
    const auto image = draw_octree(octree, mesh, {.width = 200, .height = 150});
    ASSERT_TRUE(image);
    std::ofstream(path("a.png")) << "old";
    const auto before = testing::files_in(folder());
    testing::cancel_at_every_stage(
        [&](Progress& progress) { return write_png(*image, path("a.png"), &progress); },
        [&] { return testing::files_in(folder()) == before; }, 1);
}

TEST_F(OctreePicture, ShowsTheCellsAloneWithoutAMesh)
{
    const PictureOptions options{.width = 200, .height = 150};
    const auto both = draw_octree(octree, mesh, options);
    const auto cells = draw_octree(octree, TriangleMesh{}, options);
    ASSERT_TRUE(both && cells);
    EXPECT_NE(both->bytes, cells->bytes);
    EXPECT_GT(std::ranges::count_if(cells->bytes, [](auto byte) { return byte < 150; }), 100);
}

} // namespace
} // namespace proxima
