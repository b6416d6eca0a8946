// Objects that move by scripts, and what a session says of them.
#include "code_of.h"
#include "counted_allocations.h"
#include "haptics/force/surface_renderer.h"
#include "haptics/loop/recording.h"
#include "haptics/scene/scripted_scene.h"
#include "haptics/scenes_to_touch.h"
#include "lab/quality_report.h"
#include "proxima/device.h"
#include "proxima/haptic_renderer.h"
#include "proxima/touch_scene.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <numbers>
#include <string>

namespace proxima::scripted_scene_test {
namespace {

using namespace testing;

constexpr double tick_seconds = 1e-3;
const double pi = std::numbers::pi;

std::vector<ObjectScript> some_scripts()
{
    return {{},
            {.kind = ObjectMotionKind::spin, .along = Vec3(1, 2, -1), .angle = 7},
            {.kind = ObjectMotionKind::spin, .along = Vec3(0, 0, 1e-3), .angle = -fastest_turn},
            {.kind = ObjectMotionKind::rock, .along = Vec3(0, 1, 1), .angle = 0.7, .seconds = 0.9},
            {.kind = ObjectMotionKind::swing, .along = Vec3(2, -1, 0.5), .seconds = 0.31}};
}

ScriptedObject object_at(const RigidTransform& pose, const ObjectScript& script = {},
                         std::optional<SurfaceMaterial> material = std::nullopt)
{
    return {.mesh_fingerprint = 0, .pose = pose, .script = script, .material = material};
}

TEST(ObjectScript, FollowsItsDescription)
{
    const RigidTransform begin = posed(0.3, Vec3(1, 1, 0), Vec3(5, 0, 1));
    const Vec3 middle(0.5, 0.25, 2);
    const ObjectScript spin = {.kind = ObjectMotionKind::spin, .along = Vec3(0, 0, 4), .angle = pi};
    const RigidTransform half = pose_at(spin, begin, middle, 1.0);
    EXPECT_LT((half(middle) - begin(middle)).norm(), 1e-14);
    const Vec3 aside = begin(Vec3::Zero()) - begin(middle);
    EXPECT_LT((half(Vec3::Zero()) - half(middle) - Vec3(-aside.x(), -aside.y(), aside.z())).norm(),
              1e-13);
    const ObjectScript rock = {
        .kind = ObjectMotionKind::rock, .along = Vec3(0, 1, 0), .angle = 0.5, .seconds = 2};
    const Mat3 turn = pose_at(rock, begin, middle, 0.5).rotation * begin.rotation.transpose();
    EXPECT_NEAR(Eigen::AngleAxisd(turn).angle(), 0.5, 1e-12);
    const ObjectScript swing = {
        .kind = ObjectMotionKind::swing, .along = Vec3(1, 2, 3), .seconds = 2};
    const RigidTransform far = pose_at(swing, begin, middle, 1.0);
    EXPECT_LT((far.translation - begin.translation - Vec3(1, 2, 3)).norm(), 1e-14);
    EXPECT_LT((pose_at(swing, begin, middle, 4).translation - begin.translation).norm(), 1e-14);
    for (const ObjectScript& script : some_scripts()) {
        const RigidTransform at_first = pose_at(script, begin, middle, 0);
        EXPECT_LT((at_first.rotation - begin.rotation).norm(), 1e-14);
        EXPECT_LT((at_first.translation - begin.translation).norm(), 1e-14);
    }
}

TEST(ObjectScript, RefusesInvalidMotions)
{
    const double nan = std::numeric_limits<double>::quiet_NaN();
    const ObjectScript good = {
        .kind = ObjectMotionKind::rock, .along = Vec3(0, 1, 0), .angle = 0.5, .seconds = 2};
    EXPECT_TRUE(check_script(good));
    ObjectScript wrong = good;
    wrong.along = Vec3::Zero();
    EXPECT_FALSE(check_script(wrong));
    wrong = good;
    wrong.seconds = 0;
    EXPECT_FALSE(check_script(wrong));
    wrong = good;
    wrong.angle = nan;
    EXPECT_FALSE(check_script(wrong));
    wrong = good;
    wrong.seconds = 2 * pi * wrong.angle / fastest_turn * (1 - 1e-9);
    EXPECT_FALSE(check_script(wrong));
    wrong = good;
    wrong.along = Vec3(1e200, 1e200, 0);
    EXPECT_FALSE(check_script(wrong));
}

// Every triangle, at every tick: also between the words, where the scene goes straight.
TEST(ScriptedScene, KeepsItsObjectsWithinItsReach)
{
    const RigidTransform begin = posed(0.8, Vec3(1, -1, 2), Vec3(0.4, 7, 1));
    const TriangleMesh mesh =
        moved(*sample_mesh("torus:12x8"), [](const Vec3& p) { return Vec3(p + Vec3(9, 0, 0)); });
    for (const ObjectScript& script : some_scripts()) {
        std::vector<TouchBody> bodies;
        bodies.push_back(body_of(mesh));
        const std::vector<ScriptedObject> objects = {object_at(begin, script)};
        const auto scripted = ScriptedScene::make(bodies, objects);
        ASSERT_TRUE(scripted);
        TouchScene& scene = (*scripted)->scene();
        const Box& reach = (*scripted)->bounds();
        const double margin = 1e-9;
        double farthest = 0;
        for (std::uint64_t tick = 0; tick < 1500; ++tick) {
            (*scripted)->send_motions(tick, tick_seconds);
            (void)scene.advance(tick_seconds);
            const RigidTransform now = scene.pose(ObjectId{0});
            for (const Vec3& p : mesh.positions()) {
                const Vec3 at = now(p);
                ASSERT_TRUE((at.array() >= reach.lower.array() - margin).all() &&
                            (at.array() <= reach.upper.array() + margin).all())
                    << static_cast<int>(script.kind) << ' ' << tick;
                farthest = std::max(farthest, (at - begin(p)).norm());
            }
            const double seconds = static_cast<double>(tick + 1) * tick_seconds;
            if ((tick + 1) % 20 != 0) continue;
            const Vec3 middle = bounding_box(mesh).center();
            const RigidTransform expected = pose_at(script, begin, middle, seconds);
            ASSERT_LT((expected(middle) - now(middle)).norm(), 1e-12) << tick;
            ASSERT_LT((expected.rotation - now.rotation).norm(), 1e-12) << tick;
        }
        EXPECT_EQ(farthest > 0.1, script.kind != ObjectMotionKind::rest);
    }
}

TriangleMesh cube_at(const Vec3& place, double size)
{
    return moved(*sample_mesh("cube"), [&](const Vec3& p) { return Vec3(size * p + place); });
}

std::unique_ptr<ScriptedScene> scene_of(const TriangleMesh& mesh, const ScriptedObject& object)
{
    const std::vector<TouchBody> bodies = {body_of(mesh)};
    const std::vector<ScriptedObject> objects = {object};
    return std::move(*ScriptedScene::make(bodies, objects));
}

// A house in coordinates of a map.
TEST(ScriptedScene, TurnsModelsFarFromTheirOriginAboutTheirMiddle)
{
    const TriangleMesh mesh = cube_at(Vec3(452000, 5403000, 50), 20);
    const Vec3 middle = bounding_box(mesh).center();
    for (const ObjectScript& script : some_scripts()) {
        if (script.kind == ObjectMotionKind::swing) continue;
        const auto scripted = scene_of(mesh, object_at({}, script));
        for (std::uint64_t tick = 0; tick < 200; ++tick) {
            scripted->send_motions(tick, tick_seconds);
            (void)scripted->scene().advance(tick_seconds);
            const Vec3 at = scripted->scene().pose(ObjectId{0})(middle);
            ASSERT_LT((at - middle).norm(), 1e-7) << static_cast<int>(script.kind) << ' ' << tick;
        }
    }
}

// Poses round by more than the bounds' own coordinates tell.
TEST(ScriptedScene, MovesModelsHoweverFarFromTheirOrigin)
{
    for (const double far : {1e11, 1e13, 1e15}) {
        const Vec3 place(far, -far / 3, far / 7);
        const TriangleMesh mesh = cube_at(place, 1);
        for (const ObjectScript& script : some_scripts()) {
            const auto scripted = scene_of(mesh, object_at(at_place(-place), script));
            for (std::uint64_t tick = 0; tick < 1000; ++tick) {
                scripted->send_motions(tick, tick_seconds);
                (void)scripted->scene().advance(tick_seconds);
            }
            scripted->rewind();
            EXPECT_EQ(scripted->scene().pose(ObjectId{0}).translation, Vec3(-place));
        }
    }
}

std::unique_ptr<ScriptedScene> moving_scene(BodySearch search = BodySearch::index)
{
    std::vector<TouchBody> bodies;
    std::vector<ScriptedObject> objects;
    const std::vector<ObjectScript> scripts = some_scripts();
    const TouchBodyOptions soft = {.material = SurfaceMaterial{.stiffness = 250}};
    bodies.push_back(body_of(*sample_mesh("torus:24x12"), soft, search));
    bodies.push_back(body_of(*sample_mesh("cube"), {}, search));
    bodies.push_back(body_of(thin_plate(), {}, search));
    objects.push_back(object_at({}, scripts[3], soft.material));
    objects.push_back(object_at(at_place(Vec3(2.2, 0, 0)), scripts[1]));
    objects.push_back(object_at(at_place(Vec3(0, 0, 1)), scripts[4]));
    return std::move(*ScriptedScene::make(bodies, objects));
}

const WorkspaceMap millimetres = {.units_per_metre = 30, .center = Vec3(0.5, 0, 0.3)};

constexpr std::uint64_t feeling_ticks = 3000;

/// What the moving scene's objects are on their ways, the fastest first.
std::vector<TriangleMesh> where_they_come_by()
{
    const auto put = [](const TriangleMesh& mesh, Vec3 at) {
        return moved(mesh, [at](const Vec3& p) { return Vec3(p + at); });
    };
    return {put(thin_plate(), Vec3(1, -0.5, 1.25)), *sample_mesh("torus:24x12"),
            put(*sample_mesh("cube"), Vec3(2.2, 0, 0))};
}

/// Feels a scene along paths about each object in turn; returns the ticks.
std::vector<RecordedTick> feel(ScriptedScene& scripted, const RenderOptions& options,
                               QualityReport* quality = nullptr)
{
    HapticRenderer renderer =
        make_haptic_renderer(scripted.scene(), millimetres, *find_device("omni"), options).value();
    QualityMeter meter(scripted.scene(), millimetres);
    const std::vector<TriangleMesh> meshes = where_they_come_by();
    std::vector<HandPath> paths;
    for (const TriangleMesh& mesh : meshes) paths.emplace_back(mesh, 4);
    std::vector<RecordedTick> ticks;
    for (std::uint64_t tick = 0; tick < feeling_ticks; ++tick) {
        DeviceState state;
        HandPath& path = paths[tick / 250 % paths.size()];
        state.pose.translation = millimetres.to_device(path.next());
        const std::size_t allocations = allocation_count();
        scripted.send_motions(tick, tick_seconds);
        const RenderTick& felt = renderer.tick(state, tick_seconds);
        meter.add(felt, state.velocity, renderer.path());
        EXPECT_EQ(allocation_count(), allocations);
        ticks.push_back(recorded(static_cast<double>(tick) * tick_seconds, state, felt));
    }
    if (quality != nullptr) *quality = meter.report();
    return ticks;
}

TEST(ScriptedScene, FeelsTheSameAgainAndWithBruteForce)
{
    for (const double radius : {0.0, 0.001, 0.008}) {
        const RenderOptions options = {.proxy_radius = radius, .max_jump = 10};
        const auto scene = moving_scene();
        QualityReport quality;
        const std::vector<RecordedTick> first = feel(*scene, options, &quality);
        EXPECT_EQ(quality.passes, 0U);
        EXPECT_EQ(quality.moving_ticks, feeling_ticks);
        ASSERT_EQ(quality.objects.size(), 3U);
        for (const ObjectQuality& object : quality.objects) {
            EXPECT_GT(object.touching_ticks, 5U);
            EXPECT_GT(object.max_carrying, 1e-4)
                << "object " << (&object - quality.objects.data()) << ", radius " << radius;
        }
        scene->rewind();
        EXPECT_TRUE(feel(*scene, options) == first);
        const auto slow = moving_scene(BodySearch::every_triangle);
        EXPECT_TRUE(feel(*slow, options) == first) << "radius " << radius;
    }
}

TEST(QualityMeter, CountsPassesWhileObjectsMove)
{
    // A renderer that knows nothing of the scene's motion: the plate comes down through its proxy.
    std::vector<TouchBody> bodies;
    bodies.push_back(body_of(thin_plate()));
    const ObjectScript down = {
        .kind = ObjectMotionKind::swing, .along = Vec3(0, 0, -0.2), .seconds = 0.4};
    const std::vector<ScriptedObject> objects = {object_at(at_place(Vec3(0, 0, 0.1)), down)};
    const auto scripted = std::move(*ScriptedScene::make(bodies, objects));
    QualityMeter meter(scripted->scene(), WorkspaceMap{});
    RenderTick still;
    still.proxy = Vec3(0.1, 0.1, 0);
    const std::array<Vec3, 1> path = {still.proxy};
    for (std::uint64_t tick = 0; tick < 200; ++tick) {
        scripted->send_motions(tick, tick_seconds);
        (void)scripted->scene().advance(tick_seconds);
        meter.add(still, Vec3::Zero(), path);
    }
    EXPECT_GE(meter.report().passes, 1U); // both skins, perhaps in one tick
    EXPECT_LE(meter.report().passes, 2U);
}

// 5 cm in coordinates whose origin is the middle of the earth, brought to that of the scene.
TEST(QualityMeter, CountsNoPassesThroughAModelFarFromItsOrigin)
{
    const Vec3 place(4201000, 172000, 4780000);
    const TriangleMesh mesh = cube_at(place, 0.05);
    const TriangleMesh near =
        moved(mesh, [&](const Vec3& p) { return Vec3(p - place); }); // as rounded
    const auto scripted = scene_of(mesh, object_at(at_place(-place)));
    const WorkspaceMap map;
    HapticRenderer renderer =
        make_haptic_renderer(scripted->scene(), map, *find_device("omni")).value();
    QualityMeter meter(scripted->scene(), map);
    HandPath path(near, 4);
    for (std::uint64_t tick = 0; tick < feeling_ticks; ++tick) {
        DeviceState state;
        state.pose.translation = map.to_device(path.next());
        const RenderTick& felt = renderer.tick(state, tick_seconds);
        meter.add(felt, state.velocity, renderer.path());
    }
    EXPECT_GT(meter.report().touching_ticks, 100U);
    EXPECT_EQ(meter.report().passes, 0U);
}

TEST(Recording, StoresAScene)
{
    const std::string path =
        (std::filesystem::temp_directory_path() / "proxima_scripted_scene_test.pxt").string();
    Recording recording;
    recording.settings.objects = {
        object_at(posed(0.4, Vec3(1, 2, 3), Vec3(4, 5, 6)), some_scripts()[3],
                  SurfaceMaterial{.stiffness = 12, .static_friction = 0.5}),
        object_at({})};
    recording.settings.objects[0].mesh_fingerprint = 7;
    recording.ticks.resize(3);
    ASSERT_TRUE(save_recording(recording, path));
    const auto again = load_recording(path);
    ASSERT_TRUE(again);
    ASSERT_EQ(again->settings.objects.size(), 2U);
    const ScriptedObject& object = again->settings.objects[0];
    const ScriptedObject& expected = recording.settings.objects[0];
    EXPECT_EQ(object.mesh_fingerprint, 7U);
    EXPECT_EQ(object.pose.rotation, expected.pose.rotation);
    EXPECT_EQ(object.pose.translation, expected.pose.translation);
    EXPECT_EQ(object.script.kind, expected.script.kind);
    EXPECT_EQ(object.script.along, expected.script.along);
    EXPECT_EQ(object.script.angle, expected.script.angle);
    EXPECT_EQ(object.script.seconds, expected.script.seconds);
    ASSERT_TRUE(object.material);
    EXPECT_EQ(object.material->stiffness, 12);
    EXPECT_FALSE(again->settings.objects[1].material);
    // What no scene can be made of.
    recording.settings.objects[1].script = {.kind = ObjectMotionKind::spin};
    ASSERT_TRUE(save_recording(recording, path));
    EXPECT_FALSE(load_recording(path));
    recording.settings.objects[1].script = {};
    recording.settings.objects[1].pose.rotation(0, 0) = 2;
    ASSERT_TRUE(save_recording(recording, path));
    const auto refused = load_recording(path);
    ASSERT_FALSE(refused);
    EXPECT_EQ(code_of(refused), ErrorCode::malformed_file);
    std::filesystem::remove(path);
}

} // namespace
} // namespace proxima::scripted_scene_test
