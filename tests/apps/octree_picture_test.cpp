#include "cli/octree_picture.h"

#include "cancellation.h"
#include "folder_test.h"
#include "proxima/octree.h"
#include "proxima/sample_meshes.h"

#include <algorithm>
#include <array>

namespace proxima::octree_picture_test {
namespace {

class OctreePicture : public FolderTest {
protected:
    TriangleMesh mesh = *make_spaceship(4000);
    Octree octree = *build_octree(mesh, {.max_depth = 5});

    /// So many times the mesh's box.
    [[nodiscard]] Box mesh_frame(double times) const
    {
        const Box box = bounding_box(mesh);
        const Vec3 half = 0.5 * times * box.extent();
        return {box.center() - half, box.center() + half};
    }
};

TEST_F(OctreePicture, StopsAtEveryStage)
{
    testing::cancel_at_every_stage(
        [&](Progress& progress) {
            return draw_octree(
                octree, mesh, {.view = {.size = {200, 150}}, .execution = {.progress = &progress}});
        },
        [] { return true; }, 5);
}

TEST_F(OctreePicture, IsWrittenWholeOrNotAtAll)
{
    const auto image = draw_octree(octree, mesh, {.view = {.size = {200, 150}}});
    ASSERT_TRUE(image);
    std::ofstream(path("a.png")) << "old";
    const auto before = testing::files_in(folder());
    testing::cancel_at_every_stage(
        [&](Progress& progress) { return write_png(*image, path("a.png"), &progress); },
        [&] { return testing::files_in(folder()) == before; }, 2);
}

TEST_F(OctreePicture, ShowsOnlyTheCellsWithoutAMesh)
{
    const PictureOptions options{.view = {.size = {200, 150}}};
    const auto both = draw_octree(octree, mesh, options);
    const auto cells = draw_octree(octree, TriangleMesh{}, options);
    ASSERT_TRUE(both && cells);
    EXPECT_NE(both->bytes, cells->bytes);
    EXPECT_GT(std::ranges::count_if(cells->bytes, [](auto byte) { return byte < 150; }), 100);
}

TEST_F(OctreePicture, ComparesDepthsFromOnePlace)
{
    const Octree coarse = *build_octree(mesh, {.max_depth = 3});
    const auto pixels_of_color = [&](const Octree& of, const PictureOptions& options) {
        const auto image = draw_octree(of, TriangleMesh{}, options);
        EXPECT_TRUE(image);
        std::array<int, 2> counts = {}; // rather red, rather blue
        for (int y = 0; y < image->height; ++y) {
            for (int x = 0; x < image->width; ++x) {
                const auto pixel = image->pixel(x, y);
                if (pixel[0] > pixel[2] + 40) ++counts[0];
                if (pixel[2] > pixel[0] + 40) ++counts[1];
            }
        }
        return counts;
    };
    PictureOptions options{.view = {.size = {200, 150}}};
    const auto alone = pixels_of_color(coarse, options);
    EXPECT_GT(alone[1], 100) << "the coarsest are blue";
    options.depths = {0, 3};
    const auto last = pixels_of_color(coarse, options);
    EXPECT_GT(last[0], 100) << "the last of these depths is red";
    options.frame = mesh_frame(2.0);
    const auto small = pixels_of_color(coarse, options);
    EXPECT_LT(small[0], last[0]) << "in a large frame it is small";
    EXPECT_GT(small[0], 10);
}

} // namespace
} // namespace proxima::octree_picture_test
