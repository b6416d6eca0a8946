// Two meshes that meet, or do not, without a window.
#include "proxima/mesh_io.h"
#include "proxima/sample_meshes.h"
#include "viewer/shown_viewer.h"

#include <filesystem>

namespace proxima {
namespace {

TEST(IntersectionPanel, MovesTheSecondModel)
{
    Shown shown({"icosphere:3", "torus:32x16"}, "intersection");
    EXPECT_EQ(shown.fact("meet"), "yes");
    EXPECT_GT(shown.segments("contour"), 8U);
    EXPECT_GT(shown.segments("leaves of A"), 0U);
    shown.set({"position x=3"});
    EXPECT_EQ(shown.fact("meet"), "no");
    EXPECT_EQ(shown.segments("contour"), 0U);
    const Box box = bounding_box(shown.viewer.layers());
    EXPECT_GT(box.upper.x(), 3.5) << "the torus stands where it was put";
}

TEST(IntersectionPanel, ShowsBothModelsWhereAllIsAskedFor)
{
    for (const std::vector<std::string>& models :
         {std::vector<std::string>{"icosphere:3", "torus:32x16"}, {"spaceship:2000"}}) {
        Shown shown(models, "intersection");
        shown.viewer.frame_all();
        const View view(shown.viewer.camera(), shown_size);
        for (const SceneLayer& layer : shown.viewer.layers()) {
            for (const SceneSurface& surface : layer.scene->surfaces) {
                for (const Vec3& position : surface.positions) {
                    const ScreenPoint at = view.project(layer.pose(position));
                    ASSERT_TRUE(at.x > 0.0 && at.x < shown_size.width && at.y > 0.0 &&
                                at.y < shown_size.height);
                }
            }
        }
    }
}

TEST(IntersectionPanel, ReportsTheDistanceOfMeshes)
{
    Shown shown({"icosphere:2", "cube"}, "intersection");
    EXPECT_EQ(shown.fact("meet"), "yes");
    EXPECT_EQ(shown.fact("apart"), "");
    EXPECT_EQ(shown.segments("shortest path"), 0U);
    shown.set({"position x=4", "position y=0", "position z=0", "turn=0", "tilt=0"});
    EXPECT_EQ(shown.fact("meet"), "no");
    // The cube reaches from 3 on, the sphere to 1 or a bit less.
    const double apart = shown.number("apart");
    EXPECT_GT(apart, 2.0 - 1e-9);
    EXPECT_LT(apart, 2.1);
    ASSERT_EQ(shown.segments("shortest path"), 1U);
    for (const SceneLines& lines : shown.scene().lines) {
        if (lines.name != "shortest path") continue;
        EXPECT_NEAR((lines.segments[0][1] - lines.segments[0][0]).norm(), apart, 1e-4);
        EXPECT_NEAR(lines.segments[0][1].x(), 3.0, 1e-12);
    }
    EXPECT_EQ(shown.fact("inside"), "");
}

TEST(IntersectionPanel, ReportsContainment)
{
    Shown shown({"icosphere:2", "icosphere:1"}, "intersection");
    const std::string path = "intersection_panel_test.obj";
    TriangleMesh small = make_icosphere(1);
    std::vector<Vec3> positions;
    for (const Vec3& p : small.positions()) positions.emplace_back(0.1 * p);
    const auto triangles = small.triangles();
    const auto mesh =
        make_triangle_mesh(std::move(positions), {triangles.begin(), triangles.end()});
    ASSERT_TRUE(mesh && write_mesh(*mesh, path));
    for (const bool is_small_first : {false, true}) {
        Shown both(is_small_first ? std::vector<std::string>{path, "icosphere:2"}
                                  : std::vector<std::string>{"icosphere:2", path},
                   "intersection");
        // Of very different sizes they meet as well at first.
        EXPECT_EQ(both.fact("meet"), "yes") << is_small_first;
        both.set({"position x=0", "position y=0", "position z=0"});
        EXPECT_EQ(both.fact("meet"), "no");
        EXPECT_EQ(both.fact("inside"), is_small_first ? "A is inside of B" : "B is inside of A");
    }
    std::filesystem::remove(path);
}

} // namespace
} // namespace proxima
