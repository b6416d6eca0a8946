// Several tools in one scene, each with a servo loop of its own. The oracle: a scene for each tool,
// told the same at the same time.
#include "code_of.h"
#include "counted_allocations.h"
#include "haptics/scene/moving_surface.h"
#include "haptics/scene/scene_clock.h"
#include "haptics/scene/scene_views.h"
#include "haptics/scene/touch_access.h"
#include "haptics/scenes_to_touch.h"
#include "haptics/touch_meshes.h"
#include "proxima/device.h"
#include "proxima/haptic_renderer.h"
#include "proxima/touch_scene.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <functional>
#include <memory>
#include <optional>
#include <random>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace proxima::tools_in_one_scene_test {
namespace {

using namespace testing;

constexpr double tick_seconds = 1e-3;
constexpr SceneTime tick_time = 1'000'000;

DeviceState at(const Vec3& p)
{
    DeviceState state;
    state.pose.translation = p;
    return state;
}

RenderOptions options_of(std::size_t tool)
{
    RenderOptions options;
    options.proxy_radius = 0.01 * static_cast<double>(tool);
    options.max_jump = 100;
    return options;
}

HapticRenderer tool_in(TouchScene& scene, std::size_t tool)
{
    DeviceLimits strong = *find_device("omni");
    strong.max_force = 1e4;
    return make_haptic_renderer(scene, WorkspaceMap{}, strong, options_of(tool)).value();
}

TriangleMesh sheet()
{
    return bumpy_sheet(8);
}

/// A torus that moves, a body that is exchanged, and a sheet that deforms.
struct Objects {
    explicit Objects(TouchScene& into)
        : scene(&into), sheet_body(body_of(sheet())),
          torus(*into.add(body_of(*sample_mesh("torus:12x8")), at_place(Vec3(0.5, 0, 0)))),
          other(*into.add(body_of(*sample_mesh("cube")), at_place(Vec3(-1.5, 0.3, 0)))),
          cloth(*into.add(sheet_body, at_place(Vec3(0, 0, -1))))
    {}

    void exchange(bool ball) const
    {
        const auto body = body_of(*sample_mesh(ball ? "icosphere:2" : "cube"));
        EXPECT_TRUE(scene->exchange(other, body));
    }
    void deform(double height, double seconds) const
    {
        std::vector<Vec3> positions(sheet_body.mesh().positions().begin(),
                                    sheet_body.mesh().positions().end());
        for (Vec3& p : positions) p.z() += height * std::sin(3 * p.x() + 40 * height);
        EXPECT_TRUE(scene->deform(cloth, *refit_touch_body(sheet_body, positions), seconds));
    }

    TouchScene* scene;
    TouchBody sheet_body;
    ObjectId torus;
    ObjectId other;
    ObjectId cloth;
};

ObjectMotion any_motion(std::mt19937& random, const Vec3& about)
{
    std::uniform_real_distribution<double> number(-1, 1);
    ObjectMotion motion;
    motion.pose = posed(2 * number(random), Vec3(1, number(random), 2),
                        about + 0.3 * Vec3(number(random), number(random), number(random)));
    motion.seconds = random() % 4 == 0 ? 0 : 0.03 * std::abs(number(random));
    motion.velocity = Vec3(number(random), 0, number(random));
    motion.spin = Vec3(0, number(random), 1);
    motion.coast_seconds = random() % 2 == 0 ? 0 : 0.02;
    return motion;
}

// The scene's own view waits for its next renderer, and then goes on at the scene's time: what an
// object did meanwhile is no velocity of its first tick.
TEST(ToolsInOneScene, TheNextFirstToolFindsObjectsWhereTheyAre)
{
    TouchScene scene(wide_room);
    const Objects objects(scene);
    std::optional<HapticRenderer> first = tool_in(scene, 0);
    HapticRenderer other = tool_in(scene, 1);
    const Vec3 away(0, 0, 5);
    first->tick(at(away), tick_seconds);
    other.tick(at(away), tick_seconds);
    first.reset();
    const RigidTransform pose = scene.pose(objects.torus);
    ASSERT_TRUE(scene.move(objects.torus, {.pose = pose,
                                           .seconds = 0,
                                           .velocity = Vec3::UnitX(),
                                           .spin = Vec3::Zero(),
                                           .coast_seconds = 0.2}));
    for (int tick = 0; tick < 100; ++tick) other.tick(at(away), tick_seconds);
    first = tool_in(scene, 0);
    first->tick(at(away), tick_seconds);
    EXPECT_NEAR(scene.velocity(objects.torus, pose.translation).norm(), 1, 1e-6);
    EXPECT_NEAR((scene.pose(objects.torus).translation - pose.translation).x(), 0.1, 0.004);
}

// Tools whose ticks interleave at random, up to three ahead of another, feel to the bit what each of
// them feels in a scene of its own.
TEST(ToolsInOneScene, FeelWhatEachFeelsInASceneOfItsOwn)
{
    constexpr std::size_t tools = 3;
    for (const std::uint32_t seed : {1U, 2U, 3U, 4U}) {
        std::mt19937 random(seed);
        TouchScene shared(wide_room);
        const Objects objects(shared);
        std::vector<TouchScene> own;
        std::vector<Objects> own_objects;
        std::vector<HapticRenderer> together;
        std::vector<HapticRenderer> alone;
        std::vector<HandPath> paths;
        std::vector<TriangleMesh> about = {*sample_mesh("torus:12x8"), *sample_mesh("cube"),
                                           sheet()};
        own.reserve(tools);
        for (std::size_t tool = 0; tool < tools; ++tool) {
            own_objects.emplace_back(own.emplace_back(wide_room));
            together.push_back(tool_in(shared, tool));
            alone.push_back(tool_in(own[tool], tool));
            paths.emplace_back(about[tool], seed + static_cast<std::uint32_t>(tool));
        }
        const std::array<Vec3, tools> middle = {Vec3(0.5, 0, 0), Vec3(-1.5, 0.3, 0),
                                                Vec3(0, 0, -1)};
        std::array<int, tools> ticks{};
        // What tools that are behind hear in their own scenes, and after which of their ticks. One
        // motion at a time: of several that begin ahead of a tool the last counts.
        std::array<std::optional<std::pair<int, std::function<void()>>>, tools> later;
        for (std::size_t tool = 0; tool < tools; ++tool) { // all begin at the same time
            for (HapticRenderer* const renderer : {&together[tool], &alone[tool]})
                renderer->tick(at(Vec3(0, 0, 5)), tick_seconds);
        }
        int touching = 0;
        int early = 0;
        int told = -1; // the tick after which there was a motion
        for (int step = 0; step < 4000; ++step) {
            const auto [least, most] = std::ranges::minmax(ticks);
            if (least > told && random() % 12 == 0) {
                told = most;
                const bool which = random() % 2 == 0;
                const ObjectMotion motion = any_motion(random, which ? middle[0] : middle[1]);
                const auto move = [motion, which](const Objects& of) {
                    EXPECT_TRUE(of.scene->move(which ? of.torus : of.other, motion));
                };
                move(objects);
                for (std::size_t tool = 0; tool < tools; ++tool) {
                    if (ticks[tool] == most) {
                        move(own_objects[tool]);
                    } else {
                        ++early;
                        later[tool] = {most, [&, tool, move] { move(own_objects[tool]); }};
                    }
                }
            }
            if (most == least && random() % 8 == 0) {
                const bool ball = random() % 2 == 0;
                const bool exchanges = random() % 10 == 0;
                const double height = 0.1 * static_cast<double>(random() % 8) / 8;
                const double seconds = 0.001 * static_cast<double>(random() % 20);
                const auto change = [&](const Objects& of) {
                    if (exchanges) return of.exchange(ball);
                    of.deform(height, seconds);
                };
                change(objects);
                for (const Objects& of : own_objects) change(of);
            }
            const std::size_t tool = random() % tools;
            if (ticks[tool] - least == 3) continue;
            const Vec3 hand = middle[tool] + paths[tool].next();
            const std::size_t allocations = allocation_count();
            const RenderTick& is = together[tool].tick(at(hand), tick_seconds);
            ASSERT_EQ(allocation_count(), allocations);
            const RenderTick& should = alone[tool].tick(at(hand), tick_seconds);
            ++ticks[tool];
            ASSERT_EQ(is.force, should.force) << seed << ' ' << step << ' ' << tool;
            ASSERT_EQ(is.proxy, should.proxy) << seed << ' ' << step << ' ' << tool;
            ASSERT_EQ(is.surface_velocity, should.surface_velocity) << seed << ' ' << step;
            ASSERT_EQ(is.contact_count, should.contact_count) << seed << ' ' << step;
            touching += is.hold != Hold::free ? 1 : 0;
            if (later[tool] && later[tool]->first == ticks[tool]) {
                later[tool]->second();
                later[tool].reset();
            }
        }
        std::printf("seed %u: %d ticks touch\n", seed, touching);
        EXPECT_GT(touching, 300) << seed;
        EXPECT_GT(early, 20) << seed;
    }
}

/// Whether two views show the same objects at the same positions, to the bit.
void expect_same_view(const MovingSurface& is, const MovingSurface& should)
{
    for (std::uint32_t i = 0; i < should.object_count(); ++i) {
        EXPECT_EQ(is.object(ObjectId{i}).now.translation,
                  should.object(ObjectId{i}).now.translation);
        EXPECT_EQ(is.object(ObjectId{i}).now.rotation, should.object(ObjectId{i}).now.rotation);
        EXPECT_EQ(is.object(ObjectId{i}).body, should.object(ObjectId{i}).body);
    }
    std::vector<ContactTriangle> is_near(4096);
    std::vector<ContactTriangle> should_near(4096);
    for (std::vector<ContactTriangle>* const near : {&is_near, &should_near}) {
        const MovingSurface& view = near == &is_near ? is : should;
        near->resize(view.collect(Vec3(0, 0, -0.5), 1.2, *near));
        std::ranges::sort(*near, {}, &ContactTriangle::id);
    }
    ASSERT_EQ(is_near.size(), should_near.size());
    for (std::size_t i = 0; i < is_near.size(); ++i) {
        EXPECT_EQ(is_near[i].id, should_near[i].id);
        EXPECT_EQ(is_near[i].corners.vertices, should_near[i].corners.vertices);
    }
}

// A tool that comes late finds objects on their way, and shapes between two.
TEST(ToolsInOneScene, ComeAndGo)
{
    TouchScene scene(wide_room);
    const Objects objects(scene);
    SceneViews& views = scene_views(scene);
    std::vector<SceneView> tools;
    tools.push_back(*views.take());
    std::mt19937 random(7);
    for (int tick = 0; tick < 300; ++tick) {
        if (random() % 10 == 0) {
            ASSERT_TRUE(scene.move(objects.torus, any_motion(random, Vec3(0.5, 0, 0))));
            objects.deform(0.1 * static_cast<double>(random() % 8) / 8, 0.015);
        }
        if (random() % 60 == 0) objects.exchange(random() % 2 == 0);
        if (random() % 5 == 0 && tools.size() < max_scene_tools) tools.push_back(*views.take());
        if (random() % 20 == 0 && tools.size() > 1)
            tools.erase(tools.begin() + 1 + static_cast<long>(random() % (tools.size() - 1)));
        for (const SceneView& tool : tools) (void)tool->advance(tick_seconds);
        for (const SceneView& tool : tools) expect_same_view(*tool, *tools.front());
        if (HasFailure()) FAIL() << tick;
    }
}

TEST(ToolsInOneScene, AreLimitedInNumber)
{
    TouchScene scene(wide_room);
    const Objects objects(scene);
    std::vector<HapticRenderer> tools;
    for (std::size_t tool = 0; tool < max_scene_tools; ++tool)
        tools.push_back(tool_in(scene, tool));
    const auto refused = make_haptic_renderer(scene, WorkspaceMap{}, *find_device("omni"));
    ASSERT_FALSE(refused);
    EXPECT_EQ(code_of(refused), ErrorCode::invalid_argument);
    EXPECT_EQ(refused.error().message,
              "a scene cannot have more than 8 renderers at a time: destroy one first");
    tools.erase(tools.begin() + 3);
    EXPECT_TRUE(make_haptic_renderer(scene, WorkspaceMap{}, *find_device("omni")));
}

TEST(ToolsInOneScene, FreeOldBodiesAndNeverInATick)
{
    std::atomic<int> alive{0};
    std::atomic<int> freed_in_ticks{0};
    std::atomic<bool> ticks{false};
    const auto counted = [&](const TouchBody& body) {
        const auto held = TouchAccess::unwrap(body);
        ++alive;
        return TouchAccess::wrap(
            std::shared_ptr<const ContactBody>(held.get(), [&, held](const ContactBody*) {
                --alive;
                freed_in_ticks += ticks.load() ? 1 : 0;
            }));
    };
    constexpr int tools = 3;
    // Of each tool the two that it reads, the newest, and the one to be overwritten next.
    constexpr int most = 4 * tools;
    {
        TouchScene scene(wide_room);
        const TouchBody flat = body_of(sheet());
        const ObjectId cloth = *scene.add(counted(flat), {});
        std::vector<HapticRenderer> renderers;
        for (std::size_t tool = 0; tool < tools; ++tool) renderers.push_back(tool_in(scene, tool));
        std::vector<Vec3> positions(flat.mesh().positions().begin(), flat.mesh().positions().end());
        for (int tick = 0; tick < 300; ++tick) {
            positions[3].z() = 0.001 * tick;
            const TouchBody next = counted(*refit_touch_body(flat, positions));
            if (tick % 3 == 0) {
                ASSERT_TRUE(scene.exchange(cloth, next));
            } else {
                ASSERT_TRUE(scene.deform(cloth, next, 0.002));
            }
            ticks = true;
            // The last one stands still before it ends.
            for (std::size_t tool = 0; tool < renderers.size(); ++tool) {
                if (tool < 2 || tick < 100) renderers[tool].tick(at(Vec3(0, 0, 1)), tick_seconds);
            }
            ticks = false;
            // Each change holds the body before it, too.
            ASSERT_LE(alive, 2 * most) << tick;
            if (tick != 250) continue;
            const int kept = alive;
            renderers.pop_back();
            EXPECT_LT(alive, kept); // what only that one had
        }
    }
    EXPECT_EQ(alive, 0);
    EXPECT_EQ(freed_in_ticks, 0);
}

TEST(ToolClock, AToolThatLosesTicksLagsByThreeMilliseconds)
{
    SceneClock scene;
    ToolClock steady(0);
    ToolClock slow(1); // loses every 50th tick
    for (int tick = 1; tick < 10'000; ++tick) {
        EXPECT_EQ(steady.advance(scene, tick_seconds), tick_seconds);
        EXPECT_EQ(scene.now(), tick * tick_time);
        if (tick % 50 == 0) continue;
        const SceneTime before = slow.now();
        const double passed = slow.advance(scene, tick_seconds);
        EXPECT_EQ(passed, seconds_between(before, slow.now()));
        EXPECT_LE(scene.now() - slow.now(), 3 * tick_time);
    }
    EXPECT_EQ(scene.now() - slow.now(), 3 * tick_time);
    // One that stood still for a second is back at once; one that begins is there at once.
    for (int tick = 0; tick < 1000; ++tick) (void)steady.advance(scene, tick_seconds);
    EXPECT_NEAR(slow.advance(scene, tick_seconds), 1, 1e-12);
    EXPECT_EQ(slow.now(), scene.now() - 3 * tick_time);
    ToolClock late(2);
    late.start(scene);
    (void)steady.advance(scene, tick_seconds);
    (void)late.advance(scene, tick_seconds);
    EXPECT_EQ(late.now(), scene.now());
}

TEST(ToolClock, BurstsDoNotMakeTheSceneRunFast)
{
    SceneClock scene;
    std::array<ToolClock, 2> tools = {ToolClock(0), ToolClock(1)};
    for (ToolClock& tool : tools) (void)tool.advance(scene, tick_seconds);
    for (int burst = 0; burst < 1000; ++burst) {
        for (ToolClock& tool : tools) {
            for (int tick = 0; tick < 3; ++tick) (void)tool.advance(scene, tick_seconds);
        }
    }
    EXPECT_EQ(scene.now(), 3001 * tick_time);
}

TEST(ToolClock, TicksOfAnyLengthNeverTurnTimeBack)
{
    SceneClock scene;
    ToolClock tool(0);
    for (int tick = 0; tick < 20'000; ++tick) {
        const SceneTime before = tool.now();
        EXPECT_EQ(tool.advance(scene, 1e300), 1e300);
        ASSERT_GE(tool.now(), before) << tick;
        ASSERT_EQ(scene.now(), tool.now()) << tick;
    }
}

// Servo loops in threads of their own, an application that moves, exchanges and deforms, and a tool that
// comes and goes.
TEST(ToolsInOneScene, RunInThreadsOfTheirOwn)
{
    TouchScene scene(wide_room);
    const Objects objects(scene);
    std::atomic<int> running{2};
    std::atomic<std::size_t> allocations{0};
    std::atomic<int> touching{0};
    const auto run = [&](HapticRenderer& renderer, std::size_t tool, std::uint64_t ticks) {
        const TriangleMesh about = *sample_mesh("cube");
        HandPath path(about, static_cast<std::uint32_t>(tool));
        const Vec3 middle = tool % 2 == 0 ? Vec3(0, 0, -1) : Vec3(-1.5, 0.3, 0);
        (void)run_servo_loop({.ticks = ticks}, [&](std::uint64_t) noexcept {
            const Vec3 hand = middle + path.next();
            const std::size_t before = allocation_count();
            const RenderTick& felt = renderer.tick(at(hand), tick_seconds);
            allocations += allocation_count() - before;
            touching += felt.hold != Hold::free ? 1 : 0;
            return felt.force.allFinite() ? Flow::proceed : Flow::stop;
        });
    };
    std::vector<HapticRenderer> renderers;
    renderers.push_back(tool_in(scene, 0));
    renderers.push_back(tool_in(scene, 1));
    std::vector<std::thread> threads;
    for (std::size_t tool = 0; tool < 2; ++tool) {
        threads.emplace_back([&, tool] {
            run(renderers[tool], tool, 400);
            --running;
        });
    }
    threads.emplace_back([&] {
        while (running > 0) {
            HapticRenderer guest = tool_in(scene, 2);
            run(guest, 2, 20);
        }
    });
    threads.emplace_back([&] { // the motions of the torus come from a thread of their own
        std::mt19937 random(3);
        while (running > 0) {
            EXPECT_TRUE(scene.move(objects.torus, any_motion(random, Vec3(0.5, 0, 0))));
            std::this_thread::sleep_for(std::chrono::milliseconds(2));
        }
    });
    std::mt19937 random(5);
    for (int word = 0; running > 0; ++word) {
        objects.deform(0.01 * (word % 10), 0.01);
        if (word % 8 == 0) objects.exchange(word % 16 == 0);
        EXPECT_TRUE(scene.move(objects.other, any_motion(random, Vec3(-1.5, 0.3, 0))));
        std::this_thread::sleep_for(std::chrono::milliseconds(3));
    }
    for (std::thread& thread : threads) thread.join();
    EXPECT_EQ(allocations, 0U);
    EXPECT_GT(touching, 50);
}

} // namespace
} // namespace proxima::tools_in_one_scene_test
