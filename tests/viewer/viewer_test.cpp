// The viewer without a window: panels, the mouse, work in the background.
#include "proxima/octree/build_octree.h"
#include "proxima/octree/statistics.h"
#include "proxima/proximity/brute_force.h"
#include "viewer/named_settings.h"
#include "viewer/viewer.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <gtest/gtest.h>

namespace proxima {
namespace {

constexpr ViewSize size = {.width = 400, .height = 300};

/// A viewer that shows what the settings say, at rest.
class Shown {
public:
    Shown(std::vector<std::string> models, std::string_view panel,
          const std::vector<std::string>& settings = {})
    {
        viewer.resize(size);
        EXPECT_TRUE(viewer.choose_panel(panel));
        viewer.open(std::move(models));
        const Status done = viewer.finish();
        EXPECT_TRUE(done) << describe(done.error());
        set(settings);
    }

    void set(const std::vector<std::string>& settings)
    {
        const Status applied =
            apply_settings(settings, [&](Controls& controls) { viewer.offer(controls); });
        EXPECT_TRUE(applied) << describe(applied.error());
        const Status done = viewer.finish();
        EXPECT_TRUE(done) << describe(done.error());
    }

    [[nodiscard]] std::string fact(std::string_view name) const
    {
        const auto found = std::ranges::find(viewer.facts(), name, &PanelFact::name);
        return found == viewer.facts().end() ? "" : found->value;
    }

    [[nodiscard]] double number(std::string_view name) const
    {
        const std::string text = fact(name);
        double value = std::nan("");
        std::from_chars(text.data(), text.data() + text.size(), value);
        return value;
    }

    [[nodiscard]] Scene scene() const { return flattened(viewer.layers(), viewer.backdrop()); }

    /// Triangles of all surfaces of a name.
    [[nodiscard]] std::size_t triangles(std::string_view name) const
    {
        std::size_t count = 0;
        for (const SceneSurface& surface : scene().surfaces)
            if (surface.name == name) count += surface.triangles.size();
        return count;
    }
    [[nodiscard]] std::size_t segments(std::string_view name) const
    {
        std::size_t count = 0;
        for (const SceneLines& lines : scene().lines)
            if (lines.name == name) count += lines.segments.size();
        return count;
    }

    Viewer viewer;
};

TEST(Viewer, ShowsSeveralModels)
{
    const Shown shown({"icosphere:2", "cube"}, "model");
    EXPECT_EQ(shown.viewer.models().size(), 2U);
    EXPECT_EQ(shown.triangles("mesh"), 320U + 12U);
    EXPECT_NE(shown.scene().surfaces[0].color[0], shown.scene().surfaces[1].color[0]);
}

TEST(Viewer, OpensNothingFromABrokenFile)
{
    Viewer viewer;
    viewer.open({"/no/such/file.ply"});
    const Status status = viewer.finish();
    ASSERT_FALSE(status);
    EXPECT_EQ(status.error().code, ErrorCode::file_not_found);
}

TEST(Viewer, OpensModelsInsteadOfOthersOrBesideThem)
{
    Shown shown({"icosphere:2"}, "model");
    shown.viewer.open({"cube", "octahedron"}, Placing::beside);
    ASSERT_TRUE(shown.viewer.finish());
    ASSERT_EQ(shown.viewer.models().size(), 3U);
    EXPECT_EQ(shown.viewer.models()[0]->name, "icosphere:2");
    EXPECT_EQ(shown.viewer.models()[2]->name, "octahedron");
    const auto color = [&](std::size_t model) { return shown.viewer.models()[model]->color[0]; };
    EXPECT_NE(color(1), color(0));
    EXPECT_NE(color(2), color(0));
    shown.viewer.open({"cube"});
    ASSERT_TRUE(shown.viewer.finish());
    EXPECT_EQ(shown.viewer.models().size(), 1U);
    EXPECT_EQ(shown.triangles("mesh"), 12U);
}

TEST(Viewer, GoesOnWhereAModelCannotBeOpened)
{
    Shown shown({"icosphere:2"}, "model");
    Viewer& viewer = shown.viewer;
    viewer.open({"cube", "/no/such/file.ply"}, Placing::beside);
    EXPECT_EQ(viewer.models().size(), 1U) << "all or none";
    while (viewer.is_loading()) viewer.update(0.0);
    ASSERT_TRUE(viewer.loading_error());
    EXPECT_NE(viewer.problem().find("/no/such/file.ply"), std::string::npos);
    EXPECT_EQ(viewer.models().size(), 1U);
    // The message stays while panels do their work.
    ASSERT_TRUE(apply_settings({"edges=on"}, [&](Controls& controls) { viewer.offer(controls); }));
    while (!viewer.is_settled()) viewer.update(0.0);
    EXPECT_EQ(shown.segments("edges"), 480U);
    EXPECT_FALSE(viewer.problem().empty());
    viewer.forget_problem();
    EXPECT_EQ(viewer.problem(), "");
    viewer.open({"cube"});
    ASSERT_TRUE(viewer.finish());
    EXPECT_EQ(viewer.models()[0]->name, "cube");
}

TEST(Viewer, LoadingIsWatchedAndStopped)
{
    Shown shown({"cube"}, "model");
    Viewer& viewer = shown.viewer;
    viewer.open({"icosphere:8"});
    EXPECT_NE(viewer.progress(), nullptr);
    viewer.cancel();
    while (viewer.is_loading()) viewer.update(0.0);
    EXPECT_EQ(viewer.problem(), "loading was stopped on request");
    EXPECT_EQ(viewer.models()[0]->name, "cube");
    viewer.open({"icosphere:8"});
    viewer.open({"octahedron"}); // somebody has thought better of it
    ASSERT_TRUE(viewer.finish());
    EXPECT_EQ(viewer.problem(), "");
    EXPECT_EQ(viewer.models()[0]->name, "octahedron");
}

TEST(Viewer, RefusesWhatIsBeyondItsMemory)
{
    Viewer viewer({.budget = {20'000'000}});
    viewer.open({"icosphere:4"}); // 5,120 triangles
    const Status small = viewer.finish();
    ASSERT_TRUE(small) << describe(small.error());
    viewer.open({"icosphere:6"}); // 81,920 triangles
    const Status large = viewer.finish();
    ASSERT_FALSE(large);
    EXPECT_EQ(large.error().code, ErrorCode::budget_exceeded);
    EXPECT_NE(describe(large.error()).find("icosphere:6"), std::string::npos);
    EXPECT_NE(large.error().message.find("the budget is 20 MB"), std::string::npos);
    EXPECT_EQ(viewer.models()[0]->mesh.triangle_count(), 5120U);
}

TEST(Viewer, PanelsOfSmallThingsBeginNearThem)
{
    Shown shown({"icosphere:5"}, "model");
    const double distance = shown.viewer.camera().distance;
    for (const char* const panel : {"panel=closest", "panel=voronoi", "panel=touch"}) {
        shown.set({panel});
        EXPECT_LT(shown.viewer.camera().distance, 0.8 * distance) << panel;
        // What it is about is in the picture.
        const View view(shown.viewer.camera(), size);
        const ScreenPoint at = view.project(shown.viewer.handles().front());
        EXPECT_GT(at.x, 0.2 * size.width) << panel;
        EXPECT_LT(at.x, 0.8 * size.width) << panel;
        EXPECT_GT(at.y, 0.2 * size.height) << panel;
        EXPECT_LT(at.y, 0.8 * size.height) << panel;
    }
    EXPECT_GT(shown.number("force"), 0.1) << "it is touched at once";
    shown.viewer.frame_all();
    EXPECT_EQ(shown.viewer.camera().distance, distance);
}

TEST(Viewer, CullingPanelHasItsVolumeInThePicture)
{
    const Shown shown({"icosphere:4"}, "culling");
    const View view(shown.viewer.camera(), size);
    for (const SceneLines& lines : shown.scene().lines) {
        if (lines.name != "volume") continue;
        for (const auto& segment : lines.segments) {
            for (const Vec3& end : segment) {
                const ScreenPoint at = view.project(end);
                EXPECT_TRUE(at.x > 0 && at.x < size.width && at.y > 0 && at.y < size.height);
            }
        }
    }
}

TEST(Viewer, OctreePanelShowsTheOctreesCells)
{
    Shown shown({"icosphere:3"}, "octree", {"depth=4", "threshold=2"});
    const auto octree =
        build_octree(shown.viewer.models()[0]->mesh, {.max_depth = 4, .threshold = 2});
    ASSERT_TRUE(octree);
    const OctreeStatistics statistics = octree_statistics(*octree);
    EXPECT_EQ(shown.number("boundary"), static_cast<double>(statistics.boundary));
    EXPECT_EQ(shown.number("inner"), static_cast<double>(statistics.inner));
    // Leaves of one size share edges: between 3 and 12 edges each.
    EXPECT_GT(shown.segments("cells"), 3 * statistics.boundary);
    EXPECT_LT(shown.segments("cells"), 12 * statistics.boundary);
    const std::size_t boundary_alone = shown.segments("cells");
    shown.set({"inner=on", "outer=on"});
    EXPECT_GT(shown.segments("cells"), boundary_alone);
    shown.set({"boundary=off", "inner=off", "outer=off"});
    EXPECT_EQ(shown.segments("cells"), 0U);
}

TEST(Viewer, UniformOctreeHasALatticeOfEdgesEachOnce)
{
    Shown shown({"cube"}, "octree",
                {"depth=2", "subdivision=uniform", "inner=on", "outer=on", "boundary=on",
                 "colour by=class"});
    shown.set({"mesh=off"});
    EXPECT_EQ(shown.number("leaves"), 64.0);
    // 4 x 4 x 4 cells have 3 * 4 * 25 edges; where classes meet they are drawn once for each.
    EXPECT_GE(shown.segments("cells"), 300U);
    EXPECT_LT(shown.segments("cells"), 600U);
    EXPECT_EQ(shown.triangles("mesh"), 0U);
}

TEST(Viewer, CutPlaneFillsASliceAndCutsTheMesh)
{
    Shown shown({"icosphere:3"}, "octree",
                {"depth=3", "cut plane=on", "cut axis=z", "cut at=0", "inner=on", "outer=on"});
    double area = 0.0;
    for (const SceneSurface& surface : shown.scene().surfaces) {
        for (const TriangleCorners& corners : surface.triangles) {
            const auto& at = surface.positions;
            const Triangle triangle = {{at[corners[0]], at[corners[1]], at[corners[2]]}};
            if (surface.name == "cut cells") area += 0.5 * scaled_normal(triangle).norm();
            if (surface.name != "mesh") continue;
            for (const Vec3& corner : triangle.vertices) EXPECT_LE(corner.z(), 1e-12);
        }
    }
    const Vec3 root = shown.viewer.models()[0]->box.extent();
    EXPECT_NEAR(area, std::pow(root.maxCoeff(), 2), 1e-9);
}

TEST(Viewer, ClosestPanelFindsWhatBruteForceFinds)
{
    Shown shown({"torus:24x12"}, "closest");
    const ViewModel& model = *shown.viewer.models()[0];
    for (const Vec3& cursor : {Vec3(0.3, -0.7, 0.9), Vec3(1.1, 1.2, 0.2), Vec3(0, 0, 0.05)}) {
        shown.set({"cursor x=" + std::to_string(cursor.x()),
                   "cursor y=" + std::to_string(cursor.y()),
                   "cursor z=" + std::to_string(cursor.z()), "rings=2"});
        const ClosestFeature expected =
            closest_feature_by_brute_force(model.mesh, model.topology, cursor);
        EXPECT_NEAR(shown.number("distance"), std::sqrt(expected.squared_distance), 1e-5);
        EXPECT_GT(shown.triangles("patch"), 3U);
        EXPECT_EQ(shown.triangles("cursor"), 1280U);
    }
}

TEST(Viewer, VoronoiPanelShowsThePickedFeature)
{
    Shown shown({"cube"}, "voronoi", {"feature=vertex", "number=3"});
    EXPECT_EQ(shown.fact("feature"), "vertex 3");
    EXPECT_EQ(shown.fact("region"), "drawn");
    EXPECT_GT(shown.triangles("region"), 3U);
    EXPECT_GT(shown.triangles("listed"), 0U);
}

TEST(Viewer, VoronoiPanelBeginsWithARegionNearTheCursor)
{
    for (const char* const model : {"cube", "torus:24x12", "spaceship:2000"}) {
        Shown shown({model}, "voronoi");
        for (const char* const kind : {"feature=vertex", "feature=edge", "feature=face"}) {
            shown.set({kind});
            EXPECT_EQ(shown.fact("region"), "drawn") << model << ' ' << kind;
        }
    }
}

TEST(Viewer, VoronoiPanelSaysWhereThereIsNoConvexRegion)
{
    Shown shown({"torus:24x12"}, "voronoi", {"feature=edge"});
    bool refused = false;
    for (int number = 0; number < 40 && !refused; ++number) {
        shown.set({"number=" + std::to_string(number)});
        refused = shown.fact("region").starts_with("none: ");
    }
    EXPECT_TRUE(refused) << "edges of the hole are bent inward";
}

TEST(Viewer, RayPanelLightsEveryCellAlongTheRay)
{
    Shown shown({"icosphere:3"}, "rays", {"depth=4"});
    EXPECT_EQ(shown.number("triangles hit"), 2.0);
    EXPECT_EQ(static_cast<double>(shown.triangles("cell")),
              12.0 * shown.number("cells along the ray"));
    EXPECT_EQ(shown.triangles("hit"), 2U * 1280U);
    shown.set({"occupied only=on"});
    EXPECT_LT(shown.number("shown"), shown.number("cells along the ray"));
}

TEST(Viewer, CullingPanelShowsVisibleTrianglesAlone)
{
    Shown shown({"icosphere:4"}, "culling");
    const double visible = shown.number("visible");
    EXPECT_GT(visible, 0.0);
    EXPECT_LT(visible, 5120.0);
    EXPECT_EQ(static_cast<double>(shown.triangles("visible")), visible);
    shown.set({"mode=exact"});
    EXPECT_LE(shown.number("visible"), visible);
    shown.set({"far=0.31"}); // a volume in front of the model
    EXPECT_EQ(shown.number("visible"), 0.0);
}

TEST(Viewer, IntersectionPanelMovesTheSecondModel)
{
    Shown shown({"icosphere:3", "torus:32x16"}, "intersection");
    EXPECT_EQ(shown.fact("meet"), "yes");
    EXPECT_GT(shown.segments("contour"), 8U);
    EXPECT_GT(shown.segments("leaves of A"), 0U);
    shown.set({"place x=3"});
    EXPECT_EQ(shown.fact("meet"), "no");
    EXPECT_EQ(shown.segments("contour"), 0U);
    const Box box = bounding_box(shown.viewer.layers());
    EXPECT_GT(box.upper.x(), 3.5) << "the torus stands where it was put";
}

TEST(Viewer, MinkowskiPanelPushesPlanesOutward)
{
    Shown shown({"cube"}, "minkowski",
                {"A=cube", "B=octahedron", "size of B=0.5", "copies of B=off"});
    EXPECT_EQ(shown.fact("facets"), "26");
    EXPECT_EQ(shown.fact("of A"), "6");
    EXPECT_EQ(shown.fact("of B"), "8");
    EXPECT_EQ(shown.fact("swept"), "12");
    EXPECT_NEAR(bounding_box(shown.viewer.layers()).upper.x(), 1.5, 1e-12);
    shown.set({"pushed=0.5"});
    EXPECT_NEAR(bounding_box(shown.viewer.layers()).upper.x(), 1.25, 1e-12);
    shown.set({"play=on"});
    EXPECT_TRUE(shown.viewer.is_moving());
    shown.viewer.update(0.1);
    ASSERT_TRUE(shown.viewer.finish());
    EXPECT_GT(bounding_box(shown.viewer.layers()).upper.x(), 1.25);
}

TEST(Viewer, FramesWhatAPanelShows)
{
    Shown shown({"icosphere:2"}, "model");
    const double distance = shown.viewer.camera().distance;
    shown.set({"panel=minkowski", "size of B=2"});
    EXPECT_GT(shown.viewer.camera().distance, 1.2 * distance);
    shown.set({"panel=octree"});
    EXPECT_EQ(shown.viewer.camera().distance, distance);
}

TEST(Viewer, TouchPanelFeelsTheSurface)
{
    Shown shown({"icosphere:3"}, "touch", {"hand x=0", "hand y=0", "hand z=0.7"});
    EXPECT_NE(shown.fact("contact"), "free");
    EXPECT_GT(shown.number("force"), 0.5);
    // The proxy stays on the unit sphere although the hand pulls below it.
    for (const SceneSurface& surface : shown.scene().surfaces) {
        if (surface.name != "proxy") continue;
        Box box;
        for (const Vec3& place : surface.positions) box.extend(place);
        EXPECT_NEAR(box.center().norm(), 1.0, 0.02);
    }
    shown.set({"hand z=1.5"});
    EXPECT_EQ(shown.fact("contact"), "free");
    EXPECT_EQ(shown.number("force"), 0.0);
}

TEST(Viewer, TouchIsLiveWhereThePicturesAre)
{
    Viewer viewer({.pictures = Pictures::live});
    ASSERT_TRUE(viewer.choose_panel("touch"));
    viewer.open({"icosphere:2"});
    ASSERT_TRUE(viewer.finish());
    EXPECT_TRUE(viewer.is_moving());
    const auto has_rate = [&] {
        return std::ranges::find(viewer.facts(), std::string("servo rate"), &PanelFact::name) !=
               viewer.facts().end();
    };
    while (!has_rate()) viewer.update(0.01);
    ASSERT_TRUE(viewer.choose_panel("model"));
    EXPECT_FALSE(viewer.is_moving()) << "another panel ends the loop";
}

TEST(Viewer, MouseTurnsMovesAndGoesNearer)
{
    Shown shown({"icosphere:2"}, "model");
    Viewer& viewer = shown.viewer;
    const OrbitCamera before = viewer.camera();
    viewer.press(MouseButton::left, {200, 150});
    viewer.move({260, 170});
    viewer.release({260, 170});
    EXPECT_NE(viewer.camera().azimuth, before.azimuth);
    EXPECT_GT(viewer.camera().elevation, before.elevation);
    EXPECT_EQ(viewer.camera().target, before.target);
    EXPECT_FALSE(viewer.picked()) << "a drag is no click";

    // What the mouse holds follows it.
    const View view(viewer.camera(), size);
    const Vec3 held = viewer.camera().target + 0.1 * view.right();
    const ScreenPoint from = view.project(held);
    viewer.press(MouseButton::right, {from.x, from.y});
    viewer.move({from.x + 30, from.y - 12});
    viewer.release({from.x + 30, from.y - 12});
    const ScreenPoint to = View(viewer.camera(), size).project(held);
    EXPECT_NEAR(to.x, from.x + 30, 1e-6);
    EXPECT_NEAR(to.y, from.y - 12, 1e-6);

    const double distance = viewer.camera().distance;
    viewer.wheel(2.0);
    EXPECT_LT(viewer.camera().distance, distance);
    viewer.frame_all();
    EXPECT_EQ(viewer.camera().target, before.target);
}

TEST(Viewer, ClickPicksWhatIsUnderIt)
{
    Shown shown({"icosphere:3"}, "closest");
    Viewer& viewer = shown.viewer;
    const Vec3 front = View(viewer.camera(), size).back();
    viewer.press(MouseButton::left, {200, 150});
    viewer.release({200, 150});
    ASSERT_TRUE(viewer.picked());
    EXPECT_LT((viewer.picked()->point - front).norm(), 0.02) << "the sphere's nearest point";
    ASSERT_TRUE(viewer.finish());
    EXPECT_GT(viewer.handles()[0].norm(), 1.05) << "the cursor is above it";
    viewer.press(MouseButton::left, {3, 3});
    viewer.release({3, 3});
    EXPECT_FALSE(viewer.picked());
}

TEST(Viewer, HandlesFollowTheMouseInTheirPlane)
{
    Shown shown({"icosphere:3"}, "closest");
    Viewer& viewer = shown.viewer;
    const View view(viewer.camera(), size);
    const Vec3 before = viewer.handles()[0];
    const ScreenPoint from = view.project(before);
    viewer.press(MouseButton::left, {from.x + 3, from.y});
    viewer.move({from.x + 43, from.y - 25});
    viewer.release({from.x + 43, from.y - 25});
    const Vec3 after = viewer.handles()[0];
    const ScreenPoint to = view.project(after);
    EXPECT_NEAR(view.depth(after), view.depth(before), 1e-9);
    EXPECT_NEAR(to.x, from.x + 43, 1e-6);
    EXPECT_NEAR(to.y, from.y - 25, 1e-6);
    EXPECT_EQ(viewer.camera().azimuth, OrbitCamera(viewer.camera()).azimuth);
}

TEST(Viewer, CancelsWorkAndBeginsAgain)
{
    Shown shown({"icosphere:6"}, "model");
    Viewer& viewer = shown.viewer;
    ASSERT_TRUE(viewer.choose_panel("closest"));
    viewer.update(0.0);
    ASSERT_TRUE(viewer.is_busy());
    ASSERT_NE(viewer.progress(), nullptr);
    viewer.cancel();
    while (viewer.is_busy()) viewer.update(0.0);
    EXPECT_NE(viewer.problem().find("stopped on request"), std::string::npos);
    EXPECT_TRUE(viewer.is_settled()) << "it does not begin again by itself";
    EXPECT_FALSE(viewer.layers().empty()) << "what was shown is shown still";
    shown.set({"rings=2"});
    EXPECT_TRUE(viewer.problem().empty());
    EXPECT_FALSE(shown.fact("distance").empty());
}

TEST(Viewer, MayBeDestroyedInTheMiddleOfWork)
{
    Viewer viewer;
    ASSERT_TRUE(viewer.choose_panel("closest"));
    viewer.open({"icosphere:6"});
    viewer.update(0.0);
}

TEST(NamedSettings, SayWhatDoesNotFit)
{
    Viewer viewer;
    ASSERT_TRUE(viewer.choose_panel("octree"));
    const auto message = [&](const std::string& setting) {
        const Status status =
            apply_settings({setting}, [&](Controls& controls) { viewer.offer(controls); });
        return status ? std::string("fine") : status.error().message;
    };
    EXPECT_EQ(message("depth=3"), "fine");
    EXPECT_NE(message("depth=99").find("0 to 12"), std::string::npos);
    EXPECT_NE(message("depth=three").find("a number"), std::string::npos);
    EXPECT_NE(message("depht=3").find("no setting here: they are panel, depth"), std::string::npos);
    EXPECT_NE(message("depth").find("NAME=VALUE"), std::string::npos);
    EXPECT_NE(message("method=best").find("separating-axis"), std::string::npos);
    EXPECT_NE(message("inner=yes").find("on or off"), std::string::npos);
    EXPECT_EQ(message("cut plane=on"), "fine");
    EXPECT_EQ(message("cut axis=z"), "fine");
    EXPECT_NE(viewer.choose_panel("octrees").error().message.find("model, octree"),
              std::string::npos);
}

TEST(NamedSettings, AreFoundWhateverTheirOrder)
{
    Viewer viewer;
    ASSERT_TRUE(viewer.choose_panel("octree"));
    // "cut at" is offered only once there is a cut plane.
    EXPECT_TRUE(apply_settings({"cut at=0.5", "cut plane=on"},
                               [&](Controls& controls) { viewer.offer(controls); }));
}

} // namespace
} // namespace proxima
