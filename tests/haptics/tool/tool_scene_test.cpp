// Tools that touch scenes whose objects move.
#include "code_of.h"
#include "counted_allocations.h"
#include "haptics/tool/every_pair.h"
#include "haptics/tool/rigid_motion.h"
#include "haptics/tool/tool_guard.h"
#include "haptics/tool/tool_on_table.h"
#include "haptics/tool/tool_proxy.h"
#include "haptics/touch_meshes.h"
#include "proxima/sample_meshes.h"
#include "proxima/tool_renderer.h"
#include "proxima/touch_scene.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <gtest/gtest.h>
#include <iostream>
#include <numbers>
#include <string>
#include <vector>

namespace proxima::testing::tool_scene_test {
namespace {

using namespace tool_on_table;

/// A tool in a scene of objects that the test moves.
class SceneBench {
public:
    explicit SceneBench(const TriangleMesh& tool) : tool_(index_of(tool)) {}

    ObjectId add(const TriangleMesh& mesh, const RigidTransform& pose,
                 const std::optional<SurfaceMaterial>& material = std::nullopt)
    {
        return add(build_touch_body(mesh, {.material = material}).value(), pose);
    }
    ObjectId add(const TouchBody& body, const RigidTransform& pose)
    {
        return scene_.add(body, pose).value();
    }
    void start(const RigidTransform& device, const ToolRenderOptions& options = plain_springs(),
               const DeviceLimits& limits = strong_device())
    {
        renderer_.emplace(
            make_tool_renderer(tool_, scene_, WorkspaceMap{}, limits, options).value());
        tick(device);
    }
    const ToolTick& tick(const RigidTransform& device)
    {
        DeviceState state;
        state.pose = device;
        return renderer_->tick(state, tick_seconds);
    }
    const ToolTick& rest(const RigidTransform& device, int ticks)
    {
        for (int i = 0; i < ticks; ++i) tick(device);
        return renderer_->last();
    }
    void move(ObjectId object, const RigidTransform& pose, double seconds)
    {
        ASSERT_TRUE(scene_.move(object, {.pose = pose, .seconds = seconds}).has_value());
    }
    [[nodiscard]] TouchScene& scene() { return scene_; }
    [[nodiscard]] const ToolRenderer& renderer() const { return *renderer_; }
    [[nodiscard]] const MeshIndex& tool() const { return tool_; }

private:
    MeshIndex tool_;
    TouchScene scene_{Box{Vec3::Constant(-1), Vec3::Constant(1)}};
    std::optional<ToolRenderer> renderer_;
};

TEST(ToolInScene, AnObjectThatRisesPushesTheTool)
{
    for (const double speed : {0.02, 0.5, 1.0}) { // m/s
        SceneBench bench(box_mesh(Vec3::Constant(half)));
        const ObjectId plate = bench.add(box_mesh({0.05, 0.05, 2e-5}), pose_at({0, 0, 0}));
        const RigidTransform device = pose_at({0, 0, 0.02});
        bench.start(device);
        bench.move(plate, pose_at({0, 0, 0.014}), 0.014 / speed);
        const ToolTick& tick = bench.rest(device, static_cast<int>(14 / speed) + 20);
        // Its top is at 14.02 mm.
        const double stretch = 0.014 + 2e-5 + clearance + half - 0.02;
        EXPECT_NEAR(tick.force.z(), stiffness * stretch, force_error) << speed;
        EXPECT_LT(tick.force.head<2>().norm(), force_error);
        EXPECT_EQ(tick.end, ToolEnd::settled);
        ASSERT_GE(tick.contact_count, 1U);
        EXPECT_EQ(tick.contacts[0].object, to_index(plate));
        // And back: the tool is free again, and where the device is.
        bench.move(plate, pose_at({0, 0, 0}), 0.05);
        const ToolTick& after = bench.rest(device, 80);
        EXPECT_EQ(after.force, Vec3(Vec3::Zero()));
        EXPECT_EQ(after.proxy.translation, device.translation);
    }
}

TEST(ToolInScene, AToolOnAFrictionlessObjectSlidesWhateverElseThereIs)
{
    const SurfaceMaterial ice = {
        .stiffness = 500, .damping = 0, .static_friction = 0, .dynamic_friction = 0};
    const SurfaceMaterial rubber = {
        .stiffness = 500, .damping = 0, .static_friction = 0.8, .dynamic_friction = 0.8};
    for (const bool is_alone : {true, false}) {
        SceneBench bench(box_mesh(Vec3::Constant(half)));
        bench.add(box_mesh({0.1, 0.1, 0.01}), pose_at({0, 0, -0.01}), ice);
        if (!is_alone) bench.add(box_mesh({0.1, 0.1, 0.01}), pose_at({0.5, 0, -0.01}), rubber);
        bench.start(pose_at({0, 0, half + 0.001}));
        EXPECT_EQ(bench.rest(pose_at({0, 0, half - 0.001}), 20).hold, Hold::sliding);
        if (is_alone) continue;
        bench.rest(pose_at({0, 0, half + 0.001}), 20);
        bench.rest(pose_at({0.5, 0, half + 0.001}), 20);
        EXPECT_EQ(bench.rest(pose_at({0.5, 0, half - 0.001}), 20).hold, Hold::sticking);
    }
}

/// Nothing changes between a tool and what it rests on while device and object move alike.
TEST(ToolInScene, AnObjectThatMovesWithTheDeviceFeelsLikeOneAtRest)
{
    const double depth = 0.001;
    for (const double step : {0.2e-3, 1e-3, 5e-3}) { // m in a tick
        for (const Vec3& way : {Vec3(0, 0, step), Vec3(0, 0, -step), Vec3(step, 0, step)}) {
            SceneBench bench(box_mesh(Vec3::Constant(half)));
            const ObjectId plate = bench.add(box_mesh({0.1, 0.1, 0.01}), pose_at({0, 0, -0.01}));
            bench.add(box_mesh({0.02, 0.02, 0.02}), pose_at({0, 0.9, 0})); // is passed by
            bench.start(pose_at({0, 0, half + 0.001}));
            bench.rest(pose_at({0, 0, half - depth}), 20);
            for (int i = 1; i <= 100; ++i) {
                const Vec3 moved = i * way;
                bench.move(plate, pose_at(Vec3(0, 0, -0.01) + moved), 0);
                const ToolTick& tick = bench.tick(pose_at(Vec3(0, 0, half - depth) + moved));
                ASSERT_NEAR(tick.force.z(), stiffness * (depth + clearance), force_error)
                    << step << ", tick " << i;
                ASSERT_LT(tick.force.head<2>().norm(), force_error) << step << ", tick " << i;
            }
        }
    }
}

/// A hand that strokes a floor and a wall, in a train of both.
TEST(ToolInScene, ATrainFeelsLikeAHouse)
{
    const auto forces = [](const auto& train_at) {
        SceneBench bench(box_mesh(Vec3::Constant(half)));
        const RigidTransform floor = pose_at({0, 0, -0.01});
        const RigidTransform wall = pose_at({0.06, 0, 0.05});
        const ObjectId below = bench.add(box_mesh({0.1, 0.1, 0.01}), floor);
        const ObjectId beside = bench.add(box_mesh({0.01, 0.1, 0.04}), wall);
        const auto carried = [](const RigidTransform& train, const RigidTransform& pose) {
            return RigidTransform{train.rotation * pose.rotation, train(pose.translation)};
        };
        bench.start(pose_at({0.03, 0, half + 0.001}));
        std::vector<Vec3> felt;
        for (int i = 0; i < 1000; ++i) {
            const RigidTransform train = train_at(i);
            bench.move(below, carried(train, floor), 0);
            bench.move(beside, carried(train, wall), 0);
            const double t = 6e-3 * i;
            const RigidTransform hand = pose_at({0.03 + 0.015 * std::sin(t), 0.02 * std::sin(2 * t),
                                                 half + 0.002 * std::cos(3 * t) - 0.001},
                                                {0, 0, 0.1 * std::sin(t)});
            felt.emplace_back(train.rotation.transpose() * bench.tick(carried(train, hand)).force);
        }
        return felt;
    };
    const auto house = forces([](int) { return RigidTransform{}; });
    int touching = 0;
    for (const Vec3& force : house) touching += force.norm() > 0 ? 1 : 0;
    EXPECT_GT(touching, 500);
    for (const double speed : {0.5, 5.0}) { // m/s, to and fro within the scene; as many rad/s
        const auto train = forces([&](int i) {
            const double way = 1e-3 * speed * (i % 100 < 50 ? i % 100 : 100 - i % 100);
            return pose_at({way, -way, 0.5 * way}, {way, 0, 2 * way});
        });
        for (std::size_t i = 0; i < house.size(); ++i)
            ASSERT_LT((train[i] - house[i]).norm(), 1e-3) << speed << " m/s, tick " << i;
    }
}

/// However fast an object moves along that the device is inside of and touches nowhere.
TEST(ToolInScene, FreeInsideOfAnObjectThatMovesItFeelsNothing)
{
    for (const double step : {1e-3, 0.04, 0.3}) { // m in a tick
        SceneBench bench(box_mesh(Vec3::Constant(half)));
        TriangleMesh room = box_mesh(Vec3::Constant(0.06));
        std::vector<TriangleCorners> inward(room.triangles().begin(), room.triangles().end());
        for (TriangleCorners& corners : inward) std::swap(corners[0], corners[1]);
        room =
            make_triangle_mesh({room.positions().begin(), room.positions().end()}, inward).value();
        const ObjectId box = bench.add(room, pose_at({0, 0, 0}));
        bench.start(pose_at({0, 0, 0.01}));
        const Vec3 turn(0.001, -0.002, 0.0015);
        for (int i = 1; i <= 100; ++i) {
            const double at = i % 3 * step;
            bench.move(box, pose_at({at, 0.3 * at, 0}, i * turn), 0);
            const RigidTransform device = pose_at({at, 0.3 * at, 0.01}, i * turn);
            const ToolTick& tick = bench.tick(device);
            ASSERT_EQ(tick.end, ToolEnd::settled) << step << ", tick " << i;
            ASSERT_EQ(tick.force, Vec3(Vec3::Zero())) << step << ", tick " << i;
            ASSERT_EQ(tick.proxy.translation, device.translation);
        }
    }
}

/// What the passivity guard saw of a table at that height and a tool that is that far above it at
/// first, after 2.5 s.
SwingReport watched(const std::function<double(int)>& table_at,
                    const std::function<double(int)>& tool_at)
{
    ToolRenderOptions options = plain_springs();
    options.guard = Guard::observe;
    SceneBench bench(box_mesh(Vec3::Constant(half)));
    const ObjectId ground = bench.add(table(), pose_at({0, 0, 0}));
    bench.start(pose_at({0, 0, 0.0105}), options, *find_device("delta"));
    for (int i = 0; i < 2500; ++i) {
        bench.move(ground, pose_at({0, 0, table_at(i)}), 1e-3);
        bench.tick(pose_at({0, 0, 0.007 + tool_at(i)}));
    }
    return guard_of(bench.renderer()).passivity().report();
}

/// The passivity guard judges the tool's own motion, in the frame of what carries it: a tool that shakes
/// on a lift is what it is on a table, and a table that shakes below a tool that stands still is no
/// swing of the tool.
TEST(ToolInScene, TheGuardJudgesTheMotionOfTheToolOnWhatCarriesIt)
{
    const auto still = [](int) { return 0.0; };
    // It grows, as by forces that are late, after a second on the way.
    const auto shakes = [](int i) {
        return i < 1000 ? 0.0
                        : std::min(1e-4 * std::exp(0.01 * (i - 1000)), 0.002) * std::sin(0.25 * i);
    };
    const auto rises = [](int i) { return 1e-4 * i; };
    const SwingReport on_table = watched(still, shakes);
    const SwingReport on_lift = watched(rises, [&](int i) { return rises(i) + shakes(i); });
    const SwingReport stands = watched(shakes, still);
    EXPECT_GT(on_table.swings, 0U);
    EXPECT_EQ(on_lift.swings, on_table.swings);
    EXPECT_GT(on_lift.most_given, 0.3 * on_table.most_given); // answered at other legs of the swing
    EXPECT_LT(on_lift.most_given, 3 * on_table.most_given);
    EXPECT_NEAR(on_lift.most_damping, on_table.most_damping, 0.1 * on_table.most_damping);
    EXPECT_EQ(stands.swings, 0U);
    EXPECT_EQ(stands.softenings, 0U);
}

/// The object's own friction carries the tool as far as it reaches.
TEST(ToolInScene, AnObjectThatMovesAsideCarriesTheToolByFriction)
{
    const double depth = 0.003;
    const double load = stiffness * (depth + clearance);
    const SurfaceMaterial material = {.static_friction = 0.5, .dynamic_friction = 0.4};
    SceneBench bench(box_mesh(Vec3::Constant(half)));
    const ObjectId ground = bench.add(table(), pose_at({0, 0, 0}), material);
    bench.start(pose_at({0, 0, 0.02}));
    const RigidTransform device = pose_at({0, 0, half - depth});
    bench.rest(device, 50);
    // 1 mm is less than mu_s N / K: it sticks.
    bench.move(ground, pose_at({0.001, 0, 0}), 0.05);
    const ToolTick stuck = bench.rest(device, 100);
    EXPECT_EQ(stuck.hold, Hold::sticking);
    EXPECT_NEAR(stuck.force.x(), stiffness * 0.001, 1e-3 * stiffness * 0.001);
    EXPECT_NEAR(stuck.force.z(), load, force_error);
    // Beyond that it slides below the tool.
    bench.move(ground, pose_at({0.02, 0, 0}), 0.1);
    const ToolTick sliding = bench.rest(device, 95);
    EXPECT_EQ(sliding.hold, Hold::sliding);
    EXPECT_NEAR(sliding.force.x(), 0.4 * load, 1e-3 * load);
    EXPECT_NEAR(sliding.force.z(), load, force_error);
}

/// A turntable turns the tool on its axis, and the springs hold it back.
TEST(ToolInScene, ATurntableTurnsTheTool)
{
    const double depth = 0.004;
    const double load = stiffness * (depth + clearance);
    const SurfaceMaterial material = {.static_friction = 0.3, .dynamic_friction = 0.3};
    SceneBench bench(box_mesh(Vec3::Constant(half)));
    const ObjectId disk = bench.add(table(), pose_at({0, 0, 0}), material);
    bench.start(pose_at({0, 0, 0.02}));
    const RigidTransform device = pose_at({0, 0, half - depth});
    bench.rest(device, 50);
    bench.move(disk, pose_at({0, 0, 0}, {0, 0, 0.5}), 0.2);
    const ToolTick& tick = bench.rest(device, 195);
    const double moment = 0.3 * load * half * std::numbers::sqrt2;
    EXPECT_NEAR(tick.torque.z(), moment, 1e-2 * moment);
    EXPECT_NEAR(tick.force.z(), load, 10 * force_error);
}

/// Between two plates that close, objects stay behind rather than enter the tool.
TEST(ToolInScene, ObjectsThatSqueezeTheToolWait)
{
    SceneBench bench(box_mesh(Vec3::Constant(half)));
    const TriangleMesh plate = box_mesh({0.05, 0.05, 0.001});
    const ObjectId below = bench.add(plate, pose_at({0, 0, -0.03}));
    const ObjectId above = bench.add(plate, pose_at({0, 0, 0.03}));
    const RigidTransform device = pose_at({0, 0, 0});
    bench.start(device);
    bench.move(below, pose_at({0, 0, -0.006}), 0.1);
    bench.move(above, pose_at({0, 0, 0.004}), 0.1);
    const ToolTick squeezed = bench.rest(device, 150);
    EXPECT_EQ(squeezed.end, ToolEnd::limited);
    EXPECT_LT(squeezed.proxy.translation.norm(), 0.02);
    // One opens, and the other one pushes the tool to where it is.
    bench.move(above, pose_at({0, 0, 0.05}), 0.1);
    const ToolTick& pushed = bench.rest(device, 200);
    EXPECT_EQ(pushed.end, ToolEnd::settled);
    EXPECT_NEAR(pushed.force.z(), stiffness * (-0.006 + 0.001 + clearance + half), force_error);
}

/// Such a tool goes on where the hand is, but not while it would be inside of something there.
TEST(ToolInScene, ObjectsThatSqueezeTheToolLetItGoOnceTheDeviceIsFree)
{
    SceneBench bench(box_mesh(Vec3::Constant(half)));
    const TriangleMesh plate = box_mesh({0.05, 0.05, 0.001});
    const ObjectId below = bench.add(plate, pose_at({0, 0, -0.03}));
    const ObjectId above = bench.add(plate, pose_at({0, 0, 0.03}));
    bench.start(pose_at({0, 0, 0}));
    bench.move(below, pose_at({0, 0, -0.006}), 0.1);
    bench.move(above, pose_at({0, 0, 0.004}), 0.1);
    const ToolTick squeezed = bench.rest(pose_at({0, 0, 0}), 2000);
    EXPECT_TRUE(squeezed.is_placed);
    EXPECT_NE(squeezed.end, ToolEnd::settled);
    const RigidTransform outside = pose_at({0.004, 0, 0.03});
    EXPECT_GT(bench.tick(outside).force.norm(), 1);
    double last = HUGE_VAL;
    for (int i = 0; i < 1000; ++i) {
        const double force = bench.tick(outside).force.norm();
        EXPECT_LE(force, last + force_error) << i; // it fades
        last = force;
    }
    const ToolTick& free = bench.rest(outside, 1);
    EXPECT_EQ(free.end, ToolEnd::settled);
    EXPECT_EQ(free.force, Vec3(Vec3::Zero()));
    EXPECT_EQ(free.proxy.translation, outside.translation);
}

TEST(ToolInScene, AtRestItFeelsLikeObjectsAtRest)
{
    const TriangleMesh ball =
        moved(*sample_mesh("icosphere:3"), [](const Vec3& p) { return Vec3(0.03 * p); });
    const TriangleMesh tool = box_mesh({0.01, 0.006, 0.004});
    SceneBench scene(tool);
    scene.add(ball, pose_at({0, 0, 0}));
    const ToolRenderOptions options = springs_with_friction(0.4, 0.3);
    ToolBench alone(tool, {{index_of(ball), {}}}, options);
    const RigidTransform begin = pose_at({0, 0, 0.05});
    scene.start(begin, options);
    alone.start(begin);
    int touching = 0;
    for (int i = 0; i < 200; ++i) {
        const RigidTransform device =
            pose_at({5e-5 * i, 0, 0.05 - 1e-4 * i}, {0, 1e-3 * i, 2e-3 * i});
        const ToolTick& tick = scene.tick(device);
        ASSERT_EQ(tick.force, alone.tick(device).force) << i;
        touching += tick.contact_count > 0 ? 1 : 0;
    }
    EXPECT_GT(touching, 20);
}

TEST(ToolInScene, ARefitIsFeltWhereItsVerticesAre)
{
    const TriangleMesh plate = box_mesh({0.05, 0.05, 0.005});
    std::vector<Vec3> positions;
    for (const Vec3& p : plate.positions()) positions.emplace_back(p + Vec3(0, 0, 0.03));
    const TouchBody body = build_touch_body(plate).value();
    const TouchBody refit = refit_touch_body(body, positions).value();
    const TriangleMesh tool = box_mesh(Vec3::Constant(half));
    for (const bool changes : {false, true}) {
        SceneBench scene(tool);
        const ObjectId object = scene.add(changes ? body : refit, pose_at({0, 0, 0}));
        if (changes) {
            ASSERT_TRUE(scene.scene().deform(object, refit, 0).has_value());
        }
        ToolBench alone(tool, {{index_of(refit.mesh()), {}}}, plain_springs());
        const RigidTransform begin = pose_at({0, 0, 0.06});
        scene.start(begin);
        alone.start(begin);
        int touching = 0;
        for (int i = 0; i < 200; ++i) {
            const RigidTransform device = pose_at({0, 0, 0.06 - 1e-4 * i});
            const ToolTick& tick = scene.tick(device);
            ASSERT_EQ(tick.force, alone.tick(device).force) << changes << ' ' << i;
            touching += tick.contact_count > 0 ? 1 : 0;
        }
        EXPECT_GT(touching, 20) << changes;
    }
}

TEST(ToolInScene, NoObjectIsAddedThatAToolWouldNotFeel)
{
    TouchScene scene(Box{Vec3::Constant(-1), Vec3::Constant(1)});
    const TouchBody body = build_touch_body(table()).value();
    ASSERT_TRUE(scene.add(body, pose_at({0, 0, 0})).has_value());
    const auto point = make_haptic_renderer(scene, WorkspaceMap{}, strong_device());
    ASSERT_TRUE(point.has_value());
    ASSERT_TRUE(scene.add(body, pose_at({0, 0, 0.2})).has_value());
    {
        const auto tool = make_tool_renderer(index_of(box_mesh(Vec3::Constant(half))), scene,
                                             WorkspaceMap{}, strong_device(), plain_springs());
        ASSERT_TRUE(tool.has_value());
        const auto added = scene.add(body, pose_at({0, 0, 0.4}));
        ASSERT_FALSE(added.has_value());
        EXPECT_EQ(code_of(added), ErrorCode::invalid_argument);
        EXPECT_NE(added.error().message.find("before a ToolRenderer is made"), std::string::npos);
        EXPECT_EQ(scene.object_count(), 2U);
    }
    EXPECT_TRUE(scene.add(body, pose_at({0, 0, 0.4})).has_value());
}

TEST(ToolInScene, TicksWithMovingObjectsAllocateNothing)
{
    SceneBench bench(box_mesh(Vec3::Constant(half)));
    const ObjectId plate = bench.add(box_mesh({0.05, 0.05, 0.001}), pose_at({0, 0, 0}));
    const RigidTransform device = pose_at({0, 0, 0.015});
    bench.start(device);
    bench.move(plate, pose_at({0, 0, 0.01}, {0.2, 0, 0.5}), 0.05);
    const std::size_t before = allocation_count();
    const ToolTick& tick = bench.rest(device, 80);
    EXPECT_EQ(allocation_count(), before);
    EXPECT_GT(tick.contact_count, 0U);
}

TEST(ToolInScene, ASceneHasNoMoreToolsThanItHasViews)
{
    SceneBench bench(box_mesh(Vec3::Constant(half)));
    bench.add(table(), pose_at({0, 0, 0}));
    std::vector<ToolRenderer> renderers;
    for (std::size_t i = 0; i < max_scene_tools; ++i) {
        renderers.push_back(make_tool_renderer(bench.tool(), bench.scene(), WorkspaceMap{},
                                               strong_device(), plain_springs())
                                .value());
    }
    EXPECT_FALSE(make_tool_renderer(bench.tool(), bench.scene(), WorkspaceMap{}, strong_device(),
                                    plain_springs())
                     .has_value());
    renderers.pop_back();
    EXPECT_TRUE(make_tool_renderer(bench.tool(), bench.scene(), WorkspaceMap{}, strong_device(),
                                   plain_springs())
                    .has_value());
}

RigidTransform seen_from(const RigidTransform& object, const RigidTransform& tool)
{
    const Mat3 back = object.rotation.transpose();
    return {back * tool.rotation, back * (tool.translation - object.translation)};
}

/// Objects and tool fly through each other and turn, up to 1 m/s and 15 rad/s each. As each object sees
/// it, the tool enters nothing and passes nothing: all pairs of triangles, along the path of every tick.
TEST(ToolAmongMovingObjects, PassesNothing)
{
    const auto scaled = [](const TriangleMesh& mesh, double factor) {
        return moved(mesh, [&](const Vec3& p) { return Vec3(factor * p); });
    };
    const std::vector<TriangleMesh> tools = {box_mesh({0.008, 0.005, 0.003}),
                                             scaled(*sample_mesh("icosphere:1"), 0.006),
                                             box_mesh({0.01, 0.006, 2e-5})};
    const std::vector<TriangleMesh> shapes = {box_mesh(Vec3::Constant(0.01)),
                                              box_mesh({0.02, 0.02, 5e-5}),
                                              scaled(*sample_mesh("torus:12x6"), 0.01)};
    double nearest = 1;
    int touches = 0;
    int behind = 0; // a single object
    int ticks = 0;
    int alone = 0; // of them with one object
    for (std::uint32_t seed = 1; seed <= 18; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Random random(seed);
        const TriangleMesh& tool = tools[seed % tools.size()];
        const double friction = seed % 2 == 0 ? 0 : 0.5;
        double reach = 0;
        for (const Vec3& p : tool.positions()) reach = std::max(reach, p.norm());
        std::vector<SeenObject> objects;
        std::vector<std::vector<BoxedTriangle>> triangles;
        std::vector<RigidTransform> poses;
        std::vector<Twist> velocities;
        const std::size_t count = 1 + seed % 3;
        for (std::size_t i = 0; i < count; ++i) {
            const TriangleMesh& shape = shapes[(seed + i) % shapes.size()];
            poses.push_back(pose_at(0.05 * random.direction(), 3 * random.direction()));
            velocities.push_back({Vec3(-random(0.2e-3, 1e-3) * poses[i].translation.normalized()),
                                  Vec3(random(0, 15e-3) * random.direction())});
            objects.push_back({.body = RigidBody::build(index_of(shape)).value(),
                               .pose = poses[i],
                               .goal = poses[i],
                               .friction = {friction, 0.8 * friction}});
            triangles.push_back(boxed(shape));
        }
        ToolProxy proxy(RigidBody::build(index_of(tool)).value(), std::move(objects),
                        {.clearance = clearance, .turning_length = 0.03, .max_work = 800});
        RigidTransform device = pose_at(0.003 * random.direction(), 3 * random.direction());
        if (!proxy.place(device)) continue;
        const Twist hand = {Vec3(random(0, 0.5e-3) * random.direction()),
                            Vec3(random(0, 10e-3) * random.direction())};
        for (int tick = 0; tick < 150; ++tick) {
            ++ticks;
            alone += count == 1 ? 1 : 0;
            device = moved_by(device, hand.scaled(tick < 75 ? 1 : -1), 1);
            for (std::size_t i = 0; i < count; ++i) {
                poses[i] = moved_by(poses[i], velocities[i], 1);
                proxy.set_object(i, poses[i], {friction, 0.8 * friction});
            }
            proxy.follow(device);
            touches += proxy.contacts().empty() ? 0 : 1;
            const auto path = proxy.path();
            for (std::size_t i = 0; i < count; ++i) {
                behind += count == 1 && proxy.objects()[i].is_behind() ? 1 : 0;
                const auto seen = proxy.object_path(i);
                for (std::size_t k = 0; k + 1 < path.size(); ++k) {
                    const RigidTransform from = seen_from(seen[k], path[k]);
                    const Twist twist = twist_between(from, seen_from(seen[k + 1], path[k + 1]));
                    const int parts = 1 + static_cast<int>(twist.path_length(reach) / 2e-4);
                    for (int part = 1; part <= parts; ++part) {
                        const RigidTransform pose =
                            moved_by(from, twist, part / static_cast<double>(parts));
                        const double distance =
                            distance_of(triangles[i], boxed(tool, pose), 2 * clearance);
                        nearest = std::min(nearest, distance);
                        ASSERT_GT(distance, 0.5 * clearance - 1e-9) << "tick " << tick;
                    }
                }
                const RigidTransform last = seen_from(proxy.objects()[i].pose, proxy.pose());
                ASSERT_EQ(seen_from(seen.back(), path.back()).translation, last.translation);
            }
        }
    }
    std::cout << ticks << " ticks, " << touches << " in contact, " << behind
              << " times a single object was behind; no nearer than " << 1e6 * nearest << " um\n";
    EXPECT_GT(touches, 500);
    // Nothing squeezes the tool then: it gives way in time.
    EXPECT_LT(behind, alone / 20);
}

/// What the passivity guard saw of a tool that shakes on a table that rises, in a model of so many units
/// to a metre, in 2.5 s.
SwingReport watched_on_a_lift(double units)
{
    const auto scaled = [&](const TriangleMesh& mesh) {
        return moved(mesh, [&](const Vec3& p) { return Vec3(units * p); });
    };
    ToolRenderOptions options = plain_springs();
    options.guard = Guard::observe;
    TouchScene scene(Box{Vec3::Constant(-units), Vec3::Constant(units)});
    const ObjectId lift = scene.add(build_touch_body(scaled(table())).value(), {}).value();
    ToolRenderer renderer =
        make_tool_renderer(index_of(scaled(box_mesh(Vec3::Constant(half)))), scene,
                           WorkspaceMap{units, Vec3::Zero()}, *find_device("delta"), options)
            .value();
    for (int i = 0; i < 2500; ++i) {
        const double height = 1e-4 * i;
        const double growing = std::min(1e-4 * std::exp(0.01 * (i - 1000)), 0.002);
        const double shaken = i < 1000 ? 0 : growing * std::sin(0.25 * i);
        EXPECT_TRUE(scene.move(lift, {.pose = pose_at({0, 0, units * height}), .seconds = 1e-3}));
        DeviceState state;
        state.pose = pose_at({0, 0, (i == 0 ? 0.0105 : 0.007) + height + shaken});
        renderer.tick(state, tick_seconds);
    }
    return guard_of(renderer).passivity().report();
}

TEST(ToolInScene, TheGuardJudgesTheMotionInMetresWhateverTheUnits)
{
    const SwingReport in_metres = watched_on_a_lift(1);
    const SwingReport in_millimetres = watched_on_a_lift(1000);
    EXPECT_GT(in_metres.swings, 0U);
    EXPECT_EQ(in_millimetres.swings, in_metres.swings);
    EXPECT_NEAR(in_millimetres.most_given, in_metres.most_given, 1e-3 * in_metres.most_given);
    EXPECT_NEAR(in_millimetres.most_damping, in_metres.most_damping, 1e-3 * in_metres.most_damping);
}

} // namespace
} // namespace proxima::testing::tool_scene_test
