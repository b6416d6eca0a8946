// The viewer without a window: models, the mouse, work in the background, settings by name.
#include "code_of.h"
#include "proxima/sample_meshes.h"
#include "viewer/background_work.h"
#include "viewer/shown_viewer.h"

#include <algorithm>
#include <cmath>
#include <new>
#include <numbers>

namespace proxima::viewer_test {
namespace {

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
    EXPECT_EQ(code_of(status), ErrorCode::file_not_found);
}

TEST(Viewer, OpensModelsInPlaceOfOthersOrBesideThem)
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

TEST(Viewer, ContinuesWhenAModelCannotBeOpened)
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

TEST(Viewer, LoadingReportsProgressAndCanBeStopped)
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

TEST(Viewer, LoadingStopsWhileItShadesTheSurface)
{
    const TriangleMesh mesh = make_icosphere(3);
    int stopped = 0;
    for (std::uint64_t reports = 1;; ++reports) {
        Progress progress;
        progress.cancel_after(reports);
        const auto model = make_view_model("ball", mesh, Vec3::UnitZ(), 0,
                                           {.threads = {1}, .progress = &progress});
        if (model) break;
        EXPECT_EQ(code_of(model), ErrorCode::cancelled);
        if (std::string_view(progress.stage()) == "shading the surface") ++stopped;
    }
    EXPECT_EQ(stopped, 3) << "as it begins, flat and smooth";
}

TEST(Viewer, RefusesModelsBeyondItsMemory)
{
    Viewer viewer({.execution = {.budget = {20'000'000}}});
    viewer.open({"icosphere:4"}); // 5,120 triangles
    const Status small = viewer.finish();
    ASSERT_TRUE(small) << describe(small.error());
    viewer.open({"icosphere:6"}); // 81,920 triangles
    const Status large = viewer.finish();
    ASSERT_FALSE(large);
    EXPECT_EQ(code_of(large), ErrorCode::budget_exceeded);
    EXPECT_NE(describe(large.error()).find("icosphere:6"), std::string::npos);
    EXPECT_NE(large.error().message.find("the budget is 20 MB"), std::string::npos);
    EXPECT_EQ(viewer.models()[0]->mesh.triangle_count(), 5120U);
}

TEST(Viewer, MouseOrbitsPansAndZooms)
{
    Shown shown({"icosphere:2"}, "model");
    Viewer& viewer = shown.viewer;
    const OrbitCamera before = viewer.camera();
    const Vec3 in_front = before.target + View(before, shown_size).back();
    const auto column = [&] { return View(viewer.camera(), shown_size).project(in_front).x; };
    const double middle = column();
    viewer.press(MouseButton::left, {200, 150});
    viewer.move({260, 170});
    viewer.release({260, 170});
    EXPECT_GT(column(), middle + 10) << "the front follows the mouse to the right";
    EXPECT_GT(viewer.camera().elevation, before.elevation);
    EXPECT_EQ(viewer.camera().target, before.target);
    EXPECT_FALSE(viewer.picked()) << "a drag is no click";

    // What the mouse holds follows it.
    const View view(viewer.camera(), shown_size);
    const Vec3 held = viewer.camera().target + 0.1 * view.right();
    const ScreenPoint from = view.project(held);
    viewer.press(MouseButton::right, {from.x, from.y});
    viewer.move({from.x + 30, from.y - 12});
    viewer.release({from.x + 30, from.y - 12});
    const ScreenPoint to = View(viewer.camera(), shown_size).project(held);
    EXPECT_NEAR(to.x, from.x + 30, 1e-6);
    EXPECT_NEAR(to.y, from.y - 12, 1e-6);

    const double distance = viewer.camera().distance;
    viewer.wheel(2.0);
    EXPECT_LT(viewer.camera().distance, distance);
    viewer.frame_all();
    EXPECT_LT((viewer.camera().target - before.target).norm(), 0.05);
}

TEST(Viewer, ShiftPansAndADoubleClickCentres)
{
    Shown shown({"icosphere:3"}, "model");
    Viewer& viewer = shown.viewer;
    const OrbitCamera before = viewer.camera();
    viewer.press(MouseButton::left, {200, 150}, true);
    viewer.move({230, 160});
    viewer.release({230, 160});
    EXPECT_EQ(viewer.camera().azimuth, before.azimuth);
    EXPECT_GT((viewer.camera().target - before.target).norm(), 0.05);

    viewer.frame_all();
    const View view(viewer.camera(), shown_size);
    const Vec2 at(230, 120);
    const auto hit = pick(viewer.models(),
                          {.origin = view.eye(), .direction = view.direction({at.x(), at.y()})});
    ASSERT_TRUE(hit);
    viewer.double_click(at);
    const View after(viewer.camera(), shown_size);
    const ScreenPoint seen = after.project(hit->point);
    EXPECT_NEAR(seen.x, 0.5 * shown_size.width, 1e-6);
    EXPECT_NEAR(seen.y, 0.5 * shown_size.height, 1e-6);
    EXPECT_NEAR(after.depth(hit->point), view.depth(hit->point), 1e-9);
}

TEST(Viewer, TheWheelMovesAHandleThatIsHeldAway)
{
    Shown shown({"icosphere:3"}, "closest");
    Viewer& viewer = shown.viewer;
    const View view(viewer.camera(), shown_size);
    const Vec3 before = viewer.handles()[0];
    const ScreenPoint from = view.project(before);
    viewer.press(MouseButton::left, {from.x, from.y});
    viewer.wheel(3.0);
    viewer.release({from.x, from.y});
    const Vec3 after = viewer.handles()[0];
    EXPECT_NEAR(view.depth(after), 1.06 * view.depth(before), 1e-9);
    EXPECT_NEAR(view.project(after).x, from.x, 1e-6);
    EXPECT_FALSE(viewer.picked()) << "it was no click";
}

TEST(Viewer, ClickPicksWhatIsUnderIt)
{
    Shown shown({"icosphere:3"}, "closest");
    Viewer& viewer = shown.viewer;
    viewer.frame_all();
    const Vec3 front = View(viewer.camera(), shown_size).back();
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

TEST(Viewer, PicksTheVertexOrTheEdgeThatIsNear)
{
    const std::array<Vec3, 3> corners = {Vec3(0, 0, 0), Vec3(3, 0, 0), Vec3(1, 2, 0)};
    const TriangleMesh mesh =
        make_triangle_mesh({corners.begin(), corners.end()}, {{0, 1, 2}}).value();
    const ViewModels models = {make_view_model("triangle", mesh, Vec3::UnitZ(), 0, {}).value()};
    const auto picked_at = [&](double a, double b) {
        const Vec3 point = a * corners[0] + b * corners[1] + (1 - a - b) * corners[2];
        const auto found =
            pick(models, {.origin = point + Vec3(0, 0, 5), .direction = Vec3(0, 0, -1)});
        EXPECT_TRUE(found);
        EXPECT_LT((found->point - point).norm(), 1e-12);
        return found->nearest;
    };
    const auto edge = [&](std::uint32_t a, std::uint32_t b) {
        return Feature{FeatureKind::edge,
                       to_index(models[0]->topology.find_edge(VertexId{a}, VertexId{b}))};
    };
    EXPECT_EQ(picked_at(0.85, 0.1), (Feature{FeatureKind::vertex, 0}));
    EXPECT_EQ(picked_at(0.1, 0.85), (Feature{FeatureKind::vertex, 1}));
    EXPECT_EQ(picked_at(0.1, 0.05), (Feature{FeatureKind::vertex, 2}));
    EXPECT_EQ(picked_at(0.05, 0.45), edge(1, 2));
    EXPECT_EQ(picked_at(0.45, 0.05), edge(0, 2));
    EXPECT_EQ(picked_at(0.45, 0.5), edge(0, 1));
    EXPECT_EQ(picked_at(0.75, 0.13), (Feature{FeatureKind::face, 0}));
    EXPECT_EQ(picked_at(0.3, 0.3), (Feature{FeatureKind::face, 0}));
}

TEST(Viewer, HandlesFollowTheMouseInTheirPlane)
{
    Shown shown({"icosphere:3"}, "closest");
    Viewer& viewer = shown.viewer;
    const View view(viewer.camera(), shown_size);
    const Vec3 before = viewer.handles()[0];
    const OrbitCamera camera = viewer.camera();
    const ScreenPoint from = view.project(before);
    viewer.press(MouseButton::left, {from.x + 3, from.y});
    viewer.move({from.x + 43, from.y - 25});
    viewer.release({from.x + 43, from.y - 25});
    const Vec3 after = viewer.handles()[0];
    const ScreenPoint to = view.project(after);
    EXPECT_NEAR(view.depth(after), view.depth(before), 1e-9);
    EXPECT_NEAR(to.x, from.x + 43, 1e-6);
    EXPECT_NEAR(to.y, from.y - 25, 1e-6);
    EXPECT_EQ(viewer.camera().azimuth, camera.azimuth);
    EXPECT_EQ(viewer.camera().elevation, camera.elevation);
    EXPECT_EQ(viewer.camera().target, camera.target);
}

TEST(Viewer, AnglesOfSettingsAreInDegrees)
{
    Shown shown({"icosphere:1"}, "model", {"azimuth=30", "elevation=45"});
    constexpr double degree = std::numbers::pi / 180;
    EXPECT_NEAR(shown.viewer.camera().azimuth, 30 * degree, 1e-12);
    EXPECT_NEAR(shown.viewer.camera().elevation, 45 * degree, 1e-12);
    const Vec3 back = View(shown.viewer.camera(), shown_size).back();
    EXPECT_NEAR(back.dot(shown.viewer.camera().up), std::sqrt(0.5), 1e-12);
}

TEST(Viewer, ChecksSettingsAgainAndChangesNothing)
{
    Viewer viewer;
    ASSERT_TRUE(viewer.choose_panel("octree"));
    const auto offer = [&](Controls& controls) { viewer.offer(controls); };
    const std::vector<std::string> settings = {"model=5", "depth=4"};
    ASSERT_TRUE(apply_settings(settings, offer)) << "before there are models";
    viewer.open({"cube", "octahedron"});
    ASSERT_TRUE(viewer.finish_loading());
    const Status refused = check_settings(settings, offer);
    ASSERT_FALSE(refused);
    EXPECT_NE(refused.error().message.find("1 to 2"), std::string::npos) << refused.error().message;
    EXPECT_TRUE(check_settings({"model=1", "depth=7", "panel=octree", "show all=press"}, offer));
    const std::vector<ControlDescription> controls = describe_controls(offer);
    EXPECT_EQ(std::ranges::find(controls, "depth", &ControlDescription::name)->value, "4");
    viewer.open({"cube"});
    ASSERT_TRUE(viewer.finish());
    EXPECT_NE(check_settings({"model=1"}, offer).error().message.find("several models"),
              std::string::npos);
}

TEST(Viewer, CancelsWorkAndStartsAgain)
{
    Shown shown({"icosphere:5"}, "model");
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

TEST(BackgroundWork, ReportsThatMemoryRanOut)
{
    BackgroundWork<Status> work;
    work.start([](Progress& /*progress*/) -> Status { throw std::bad_alloc(); });
    const Status done = work.take();
    ASSERT_FALSE(done);
    EXPECT_EQ(code_of(done), ErrorCode::budget_exceeded);
}

TEST(Viewer, MayBeDestroyedWhileItWorks)
{
    Viewer viewer;
    ASSERT_TRUE(viewer.choose_panel("closest"));
    viewer.open({"icosphere:6"});
    viewer.update(0.0);
}

TEST(NamedSettings, ReportUnknownNamesAndBadValues)
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
    EXPECT_NE(message("depth=3.5").find("a whole number from 0 to 12"), std::string::npos);
    EXPECT_NE(message("depth=three").find("a whole number"), std::string::npos);
    EXPECT_NE(message("elevation=three").find(": a number from -90 to 90"), std::string::npos);
    EXPECT_NE(message("depht=3").find("no setting here: they are panel, model, depth"),
              std::string::npos);
    EXPECT_NE(message("depth").find("NAME=VALUE"), std::string::npos);
    EXPECT_NE(message("method=best").find("separating-axis"), std::string::npos);
    EXPECT_NE(message("inner=yes").find("on or off"), std::string::npos);
    EXPECT_EQ(message("cut plane=on"), "fine");
    EXPECT_EQ(message("cut axis=z"), "fine");
    EXPECT_NE(viewer.choose_panel("octrees").error().message.find("model, octree"),
              std::string::npos);
}

TEST(NamedSettings, AreSetOnce)
{
    Viewer viewer;
    ASSERT_TRUE(viewer.choose_panel("octree"));
    const Status twice =
        apply_settings({"depth=3", "depth=4"}, [&](Controls& controls) { viewer.offer(controls); });
    ASSERT_FALSE(twice);
    EXPECT_EQ(twice.error().message, "\"depth\" is set twice: leave one out");
}

TEST(NamedSettings, AreAppliedInAnyOrder)
{
    Viewer viewer;
    ASSERT_TRUE(viewer.choose_panel("octree"));
    // "cut at" is offered only once there is a cut plane.
    EXPECT_TRUE(apply_settings({"cut at=0.5", "cut plane=on"},
                               [&](Controls& controls) { viewer.offer(controls); }));
}

} // namespace
} // namespace proxima::viewer_test
