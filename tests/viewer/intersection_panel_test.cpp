// Two meshes that meet, or do not, without a window.
#include "code_of.h"
#include "proxima/mesh_io.h"
#include "proxima/sample_meshes.h"
#include "viewer/panels/panels.h"
#include "viewer/shown_viewer.h"
#include "viewer/view_models.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace proxima::intersection_panel_test {
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

/// A sphere of a tenth of the size, as a file that is removed in the end.
class SmallSphere {
public:
    explicit SmallSphere(std::string path) : path_(std::move(path))
    {
        const TriangleMesh unit = make_icosphere(1);
        std::vector<Vec3> positions;
        for (const Vec3& p : unit.positions()) positions.emplace_back(0.1 * p);
        const auto triangles = unit.triangles();
        const auto mesh =
            make_triangle_mesh(std::move(positions), {triangles.begin(), triangles.end()});
        EXPECT_TRUE(mesh && write_mesh(*mesh, path_));
    }
    SmallSphere(const SmallSphere&) = delete;
    SmallSphere& operator=(const SmallSphere&) = delete;
    ~SmallSphere() { std::filesystem::remove(path_); }

    [[nodiscard]] const std::string& path() const { return path_; }

private:
    std::string path_;
};

/// How much of the picture's width or height the contour spans; more than 1 where it is cut off.
double span_of_contour(const Shown& shown, ViewSize size)
{
    const View view(shown.viewer.camera(), size);
    Box box; // of the picture [-1, 1]^2
    for (const SceneLines& lines : shown.scene().lines) {
        if (lines.name != "contour") continue;
        for (const auto& segment : lines.segments) {
            const ScreenPoint at = view.project(segment[0]);
            box.extend({2.0 * at.x / size.width - 1.0, 2.0 * at.y / size.height - 1.0, 0.0});
        }
    }
    if (box.empty()) return 0.0;
    const double farthest =
        std::max(box.lower.cwiseAbs().maxCoeff(), box.upper.cwiseAbs().maxCoeff());
    return farthest > 1.0 ? farthest : 0.5 * box.extent().maxCoeff();
}

bool same(const OrbitCamera& a, const OrbitCamera& b)
{
    return a.target == b.target && a.distance == b.distance && a.azimuth == b.azimuth &&
           a.elevation == b.elevation && a.zoom == b.zoom;
}

TEST(IntersectionPanel, BeginsAtTheContact)
{
    const SmallSphere small("contact_test.obj");
    Shown shown({"icosphere:3", small.path()}, "intersection");
    EXPECT_GT(span_of_contour(shown, shown_size), 0.3);
    EXPECT_LT(span_of_contour(shown, shown_size), 1.0);
    constexpr ViewSize tall = {.width = 300, .height = 500};
    shown.viewer.resize(tall);
    EXPECT_GT(span_of_contour(shown, tall), 0.3);
    EXPECT_LT(span_of_contour(shown, tall), 1.0);
    // What is dragged away or into contact later does not move the camera.
    const OrbitCamera before = shown.viewer.camera();
    shown.set({"position x=3"});
    EXPECT_EQ(shown.fact("meet"), "no");
    EXPECT_TRUE(same(before, shown.viewer.camera()));
    shown.set({"position x=0.95", "position y=0", "position z=0"});
    EXPECT_EQ(shown.fact("meet"), "yes");
    EXPECT_TRUE(same(before, shown.viewer.camera()));
    // Another panel shows everything, and this one the contact of now.
    shown.set({"panel=model"});
    const OrbitCamera of_models = shown.viewer.camera();
    shown.set({"panel=intersection"});
    EXPECT_FALSE(same(of_models, shown.viewer.camera()));
    EXPECT_GT(span_of_contour(shown, tall), 0.3);
    EXPECT_LT(span_of_contour(shown, tall), 1.0);
}

TEST(IntersectionPanel, TurnsAboutTheAxisUpAfterItTiltsAcross)
{
    const std::string path = "turned_bar_test.obj";
    std::vector<Vec3> bar;
    const TriangleMesh cube = make_cube();
    for (const Vec3& p : cube.positions()) bar.emplace_back(4 * p.x(), 2 * p.y(), p.z());
    const auto triangles = cube.triangles();
    const auto mesh = make_triangle_mesh(std::move(bar), {triangles.begin(), triangles.end()});
    ASSERT_TRUE(mesh && write_mesh(*mesh, path));
    const auto extent = [&](const char* turn, const char* tilt) -> Vec3 {
        const Shown shown({"cube", path}, "intersection",
                          {std::string("turn=") + turn, std::string("tilt=") + tilt});
        const SceneLayer& moved =
            *std::ranges::find_if(shown.viewer.layers(), [](const SceneLayer& layer) {
                return !layer.pose.rotation.isIdentity() || layer.pose.translation.norm() > 0;
            });
        return bounding_box(std::span(&moved, 1)).extent();
    };
    // y is up in .obj files. Tilting is about an axis across it, which swaps it with x or with z.
    EXPECT_TRUE(extent("0", "0").isApprox(Vec3(8, 4, 2)));
    EXPECT_TRUE(extent("90", "0").isApprox(Vec3(2, 4, 8)));
    const Vec3 tilted = extent("0", "90");
    EXPECT_TRUE(tilted.isApprox(Vec3(8, 2, 4)) || tilted.isApprox(Vec3(4, 8, 2))) << tilted;
    EXPECT_TRUE(extent("90", "90").isApprox(Vec3(tilted.z(), tilted.y(), tilted.x())));
    std::filesystem::remove(path);
}

TEST(IntersectionPanel, LeavesACameraThatAPersonMovedMeanwhile)
{
    const SmallSphere small("moved_camera_test.obj");
    Viewer viewer;
    viewer.resize(shown_size);
    ASSERT_TRUE(viewer.choose_panel("intersection"));
    viewer.open({"icosphere:3", small.path()});
    while (viewer.models().empty()) viewer.update(0.0);
    // The task has begun, and nobody has taken what it found.
    const OrbitCamera at_first = viewer.camera();
    viewer.wheel(1.0);
    const OrbitCamera moved = viewer.camera();
    EXPECT_FALSE(same(at_first, moved));
    ASSERT_TRUE(viewer.finish());
    EXPECT_TRUE(same(moved, viewer.camera()));
}

TEST(IntersectionPanel, LeavesTheCameraWhereNothingMetAtFirst)
{
    const SmallSphere small("apart_at_first_test.obj");
    Viewer viewer;
    viewer.resize(shown_size);
    ASSERT_TRUE(viewer.choose_panel("intersection"));
    viewer.open({"icosphere:3", small.path()});
    while (viewer.models().empty()) viewer.update(0.0);
    const auto put = [&](const std::vector<std::string>& settings) {
        const Status applied =
            apply_settings(settings, [&](Controls& controls) { viewer.offer(controls); });
        return applied && viewer.finish();
    };
    ASSERT_TRUE(put({"position x=3"}));
    const OrbitCamera apart = viewer.camera();
    ASSERT_TRUE(put({"position x=0.95", "position y=0", "position z=0"}));
    EXPECT_TRUE(viewer.picture().focus.has_value());
    EXPECT_TRUE(same(apart, viewer.camera()));
}

TEST(IntersectionPanel, StopsWhereItIsAskedTo)
{
    const auto models = load_view_models(std::vector<std::string>{"icosphere:3", "torus:32x16"},
                                         Primitives::triangles, {});
    ASSERT_TRUE(models);
    const auto panel = make_intersection_panel();
    panel->models_changed(*models, Vec3::UnitZ());
    const PanelTask task = panel->task(*models);
    ASSERT_TRUE(task({})); // the octrees are kept
    Progress stopped;
    stopped.cancel();
    const auto picture = task({.progress = &stopped});
    ASSERT_FALSE(picture);
    EXPECT_EQ(code_of(picture), ErrorCode::cancelled);
    // At every report, until there are no more.
    std::set<std::string> stages;
    for (std::uint64_t report = 1;; ++report) {
        ASSERT_LT(report, 1000U);
        Progress progress;
        progress.cancel_after(report);
        const auto result = task({.progress = &progress});
        if (!progress.cancelled()) break;
        stages.insert(progress.stage());
        ASSERT_FALSE(result) << report;
        EXPECT_EQ(code_of(result), ErrorCode::cancelled);
    }
    EXPECT_EQ(stages,
              (std::set<std::string>{"collecting triangles", "finding the intersection contour",
                                     "intersecting meshes"}));
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
    const SmallSphere small("containment_test.obj");
    for (const bool is_small_first : {false, true}) {
        Shown both(is_small_first ? std::vector<std::string>{small.path(), "icosphere:2"}
                                  : std::vector<std::string>{"icosphere:2", small.path()},
                   "intersection");
        // Of very different sizes they meet as well at first.
        EXPECT_EQ(both.fact("meet"), "yes") << is_small_first;
        both.set({"position x=0", "position y=0", "position z=0"});
        EXPECT_EQ(both.fact("meet"), "no");
        EXPECT_EQ(both.fact("inside"), is_small_first ? "A is inside of B" : "B is inside of A");
    }
}

} // namespace
} // namespace proxima::intersection_panel_test
