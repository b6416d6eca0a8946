// Objects that move and change while they are touched.
#include "counted_allocations.h"
#include "haptics/force/surface_renderer.h"
#include "haptics/scene/touch_access.h"
#include "haptics/scenes_to_touch.h"
#include "proxima/device.h"
#include "proxima/haptic_renderer.h"
#include "proxima/touch_scene.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <random>
#include <string>
#include <thread>

namespace proxima::scene_renderer_test {
namespace {

using namespace testing;

constexpr double tick_seconds = 1e-3;

/// Scene and device have the same unit here: a metre.
const WorkspaceMap same_unit{};

DeviceLimits strong_device()
{
    return {.name = "strong",
            .max_force = 1e4,
            .max_stiffness = 1e5,
            .max_damping = 100,
            .workspace_radius = 20};
}

RenderOptions plain(double friction = 0)
{
    RenderOptions options;
    options.force = {.stiffness = 500, .damping = 0, .max_slew = 1e9, .start_seconds = 0};
    options.static_friction = friction;
    options.dynamic_friction = 0.75 * friction;
    options.guard = Guard::off;
    options.max_jump = 100;
    return options;
}

DeviceState at(const Vec3& p, const Vec3& velocity = Vec3::Zero())
{
    DeviceState state;
    state.pose.translation = p;
    state.velocity = velocity;
    return state;
}

/// Whether the last tick's motion of the proxy passed anything, by every triangle: carried along
/// with the objects' motion first, then among objects that stand.
bool passed(const TouchScene& scene, const HapticRenderer& renderer, const Vec3& before)
{
    const auto path = renderer.path();
    if (passes_while_moving(scene, before, path.front())) return true;
    for (std::size_t i = 1; i < path.size(); ++i) {
        if (passes_standing(scene, path[i - 1], path[i])) return true;
    }
    return false;
}

TEST(SceneRenderer, AThinPlateThatFliesAtTheHandDoesNotPass)
{
    for (const double speed : {0.5, 5.0, 50.0}) {
        for (const double radius : {0.0, 0.005}) {
            TouchScene scene(wide_room);
            const auto plate = scene.add(body_of(thin_plate()), at_place(Vec3(0, 0, 1)));
            RenderOptions options = plain();
            options.proxy_radius = radius;
            HapticRenderer renderer =
                make_haptic_renderer(scene, same_unit, strong_device(), options).value();
            const double seconds = 2 / speed;
            ASSERT_TRUE(scene.move(*plate, {.pose = at_place(Vec3(0, 0, -1)), .seconds = seconds}));
            const Vec3 hand(0.11, 0.07, 0);
            Vec3 before = hand;
            const int ticks = static_cast<int>(seconds / tick_seconds) + 20;
            for (int tick = 0; tick < ticks; ++tick) {
                const RenderTick& felt = renderer.tick(at(hand), tick_seconds);
                ASSERT_FALSE(tick > 0 && passed(scene, renderer, before)) << speed << ' ' << tick;
                before = felt.proxy;
                ASSERT_FALSE(felt.squeezed);
                const double below = scene.pose(*plate).translation.z() - 0.0005 - radius;
                const double expected = std::min(below, 0.0);
                ASSERT_NEAR(felt.spring.z(), 500 * expected, 1e-6) << speed << ' ' << tick;
                ASSERT_LT(felt.spring.head<2>().norm(), 1e-6);
            }
            EXPECT_LT(renderer.last().spring.z(), -400);
        }
    }
}

TEST(SceneRenderer, ATurningBladeCarriesTheProxy)
{
    for (const double radius : {0.0, 0.01}) {
        TouchScene scene(wide_room);
        const auto blade =
            scene.add(body_of(box_mesh(Vec3(1, 0.0005, 0.3))), at_place(Vec3::Zero()));
        RenderOptions options = plain();
        options.proxy_radius = radius;
        HapticRenderer renderer =
            make_haptic_renderer(scene, same_unit, strong_device(), options).value();
        // 40 radians a second: 20 mm in a tick where the hand is.
        ASSERT_TRUE(scene.move(*blade, {.spin = Vec3(0, 0, 40), .coast_seconds = 10}));
        const Vec3 hand(0.35, 0.35, 0.02);
        Vec3 before = hand;
        int touching = 0;
        for (int tick = 0; tick < 1000; ++tick) {
            const RenderTick& felt = renderer.tick(at(hand), tick_seconds);
            ASSERT_FALSE(tick > 0 && passed(scene, renderer, before)) << radius << ' ' << tick;
            ASSERT_FALSE(felt.squeezed) << tick;
            ASSERT_TRUE(felt.force.allFinite());
            ASSERT_GE(distance_of(scene, felt.proxy), parts_of(renderer).proxy().radius() - 1e-10)
                << tick;
            before = felt.proxy;
            touching += felt.hold != Hold::free ? 1 : 0;
        }
        EXPECT_GT(touching, 30) << radius; // until it slips off the blade's end
    }
}

TEST(SceneRenderer, NothingPassesThroughMovingObjects)
{
    for (const std::uint32_t seed : {1U, 2U, 3U}) {
        for (const double radius : {0.0, 0.03}) {
            std::mt19937 random(seed);
            std::uniform_real_distribution<double> number(-1, 1);
            TouchScene scene(wide_room);
            std::vector<ObjectId> objects;
            for (const char* const name : {"torus:12x8", "cube", "plate"}) {
                TriangleMesh mesh =
                    std::string(name) == "plate" ? thin_plate() : *sample_mesh(name);
                const Vec3 place(4.0 * static_cast<double>(objects.size()) - 4, 0, 0);
                objects.push_back(*scene.add(body_of(std::move(mesh)), at_place(place)));
            }
            RenderOptions options = plain(seed % 2 == 0 ? 0.4 : 0);
            options.proxy_radius = radius;
            HapticRenderer renderer =
                make_haptic_renderer(scene, same_unit, strong_device(), options).value();
            const TriangleMesh about = *sample_mesh("torus:12x8");
            HandPath path(about, seed);
            Vec3 before = Vec3::Zero();
            int touching = 0;
            int squeezed = 0;
            for (int tick = 0; tick < 500; ++tick) {
                const std::string where = "seed " + std::to_string(seed) + ", radius " +
                                          std::to_string(radius) + ", tick " + std::to_string(tick);
                for (const ObjectId object : objects) {
                    if (random() % 20 != 0) continue;
                    const Vec3 axis{number(random), number(random), number(random)};
                    const Vec3 to{number(random), number(random), number(random)};
                    ASSERT_TRUE(scene.move(object, {.pose = posed(3 * number(random), axis, to),
                                                    .seconds = 0.03 * std::abs(number(random))}));
                }
                const bool was_placed = tick > 0 && parts_of(renderer).proxy().last().is_placed;
                const RenderTick& felt = renderer.tick(at(path.next()), tick_seconds);
                ASSERT_TRUE(felt.force.allFinite()) << where;
                squeezed += felt.squeezed ? 1 : 0;
                const bool is_placed = felt.is_placed;
                if (was_placed && is_placed && !felt.squeezed) {
                    ASSERT_FALSE(passed(scene, renderer, before)) << where;
                }
                if (is_placed) {
                    ASSERT_GE(distance_of(scene, felt.proxy),
                              parts_of(renderer).proxy().radius() - 2e-10)
                        << where;
                }
                before = felt.proxy;
                touching += felt.hold != Hold::free ? 1 : 0;
            }
            EXPECT_GT(touching, 80) << seed;
            EXPECT_LT(squeezed, 100) << seed;
        }
    }
}

// Hand and object that move together feel what they feel at rest.
TEST(SceneRenderer, TouchIsTheSameInAMovingFrame)
{
    const RigidTransform begin = posed(0.4, Vec3(1, 2, 3), Vec3(0.5, -0.2, 0.1));
    const Vec3 velocity(3, -2, 1);
    for (const double spin : {0.0, 2.0}) {
        TouchScene still(wide_room);
        TouchScene moving(wide_room);
        (void)*still.add(body_of(*sample_mesh("torus:24x12")), begin);
        const auto torus = moving.add(body_of(*sample_mesh("torus:24x12")), begin);
        RenderOptions options = plain();
        options.proxy_radius = 0.02;
        options.max_moves = max_slide_moves; // cut short, ways would differ by more than rounding
        HapticRenderer expected =
            make_haptic_renderer(still, same_unit, strong_device(), options).value();
        HapticRenderer renderer =
            make_haptic_renderer(moving, same_unit, strong_device(), options).value();
        ASSERT_TRUE(moving.move(
            *torus,
            {.pose = begin, .velocity = velocity, .spin = Vec3(0, 0, spin), .coast_seconds = 1}));
        const TriangleMesh about = *sample_mesh("torus:24x12");
        HandPath path(about, 9);
        // A free proxy stays where it is while the object moves on by 4 mm, so it does not begin at the
        // same position of the object. Over a dash across the model that would lead round another side.
        constexpr double longest_step = 0.05;
        Vec3 hand = path.next();
        int touching = 0;
        for (int tick = 0; tick < 500; ++tick) {
            const Vec3 step = path.next() - hand;
            hand += step * std::min(1.0, longest_step / step.norm());
            const RenderTick& should = expected.tick(at(begin(hand)), tick_seconds);
            const double time = (tick + 1) * tick_seconds;
            RigidTransform pose = begin;
            pose.translation += velocity * time;
            pose.rotation =
                Eigen::AngleAxisd(spin * time, Vec3::UnitZ()).toRotationMatrix() * begin.rotation;
            const RenderTick& is = renderer.tick(at(pose(hand)), tick_seconds);
            touching += should.hold != Hold::free ? 1 : 0;
            const Vec3 back = begin.rotation * (pose.rotation.transpose() * is.spring);
            if (is.hold != should.hold) {
                ADD_FAILURE() << spin << ' ' << tick;
                break;
            }
            ASSERT_LT((back - should.spring).norm(), 1e-4 + 1e-3 * should.spring.norm())
                << spin << ' ' << tick;
        }
        EXPECT_GT(touching, 150);
    }
}

/// Presses on a cube and lifts off at 0.3 m/s; the greatest lag of the proxy in free air.
double lag_beside(const TriangleMesh* other)
{
    TouchScene scene(Box{Vec3::Constant(-8), Vec3::Constant(8)});
    (void)scene.add(build_touch_body(testing::cube_mesh(Vec3::Zero(), 1.0)).value(), {});
    if (other != nullptr) {
        RigidTransform pose;
        pose.translation = Vec3(5, 0, 0);
        (void)scene.add(build_touch_body(*other).value(), pose);
    }
    HapticRenderer renderer =
        make_haptic_renderer(scene, {30, Vec3::Zero()}, *find_device("omni")).value();
    double lag = 0;
    for (int tick = 0; tick < 700; ++tick) {
        const double height =
            tick < 250 ? 0.05 - 1e-4 * tick : std::min(0.09, 0.025 + 3e-4 * (tick - 250));
        const RenderTick& made = renderer.tick(at(Vec3(0.001, 0.002, height)), tick_seconds);
        if (tick > 290) lag = std::max(lag, std::abs(made.proxy.z() - 30 * height));
    }
    return lag;
}

TEST(SceneRenderer, SmallAndFlatObjectsDoNotHoldTheHandAtOthers)
{
    EXPECT_LT(lag_beside(nullptr), 1e-6);
    TriangleMesh ball = testing::sphere_mesh(Vec3::Zero(), 0.01, 90, 110);
    EXPECT_LT(lag_beside(&ball), 1e-6);
    const std::array<std::array<std::uint32_t, 2>, 1> segments = {{{0, 1}}};
    const TriangleMesh segment =
        mesh_of_segments({Vec3(-1, 0, 0), Vec3(1, 0, 0)}, segments).value();
    EXPECT_LT(lag_beside(&segment), 1e-6);
    const TriangleMesh needle =
        testing::mesh_of({Vec3(-1, 0, 0), Vec3(1, 0, 0), Vec3(0, 1e-12, 0)}, {{0, 1, 2}});
    EXPECT_LT(lag_beside(&needle), 1e-6);
}

TEST(SceneRenderer, FrictionCarriesTheProxyWithTheSurface)
{
    TouchScene scene(wide_room);
    const auto belt = scene.add(body_of(box_mesh(Vec3(4, 1, 0.1))), at_place(Vec3::Zero()));
    HapticRenderer renderer =
        make_haptic_renderer(scene, same_unit, strong_device(), plain(0.5)).value();
    const double speed = 0.2;
    ASSERT_TRUE(scene.move(*belt, {.velocity = Vec3(speed, 0, 0), .coast_seconds = 5}));
    renderer.tick(at(Vec3(0, 0, 0.2)), tick_seconds);
    const Vec3 hand(0, 0, 0.09); // 10 mm deep
    double last_x = 0;
    int sticking = 0;
    for (int tick = 0; tick < 200; ++tick) {
        const RenderTick& felt = renderer.tick(at(hand), tick_seconds);
        const double lag = felt.proxy.x() - hand.x();
        if (felt.hold == Hold::sticking && tick > 0) {
            EXPECT_NEAR(lag - last_x, speed * tick_seconds, 1e-12);
            ++sticking;
        }
        EXPECT_LT(lag, 0.5 * 0.01 + 1e-9);
        EXPECT_NEAR(felt.surface_velocity.x(), speed, 1e-9);
        EXPECT_NEAR(felt.spring.z(), 500 * 0.01, 1e-5);
        last_x = lag;
    }
    EXPECT_NEAR(last_x, 0.375 * 0.01, 1e-6); // it slides at last, with the dynamic friction
    EXPECT_GT(sticking, 20);
}

TEST(SceneRenderer, DampsTheMotionRelativeToTheSurface)
{
    TouchScene scene(wide_room);
    const auto wall = scene.add(body_of(box_mesh(Vec3(1, 1, 0.1))), at_place(Vec3::Zero()));
    RenderOptions options = plain();
    options.force.damping = 10;
    HapticRenderer renderer =
        make_haptic_renderer(scene, same_unit, strong_device(), options).value();
    ASSERT_TRUE(scene.move(*wall, {.velocity = Vec3(0, 0, 0.2), .coast_seconds = 5}));
    renderer.tick(at(Vec3(0, 0, 0.2)), tick_seconds);
    for (int tick = 1; tick < 100; ++tick) {
        const double top = 0.1 + 0.2 * (tick + 1) * tick_seconds;
        // With the wall: no damping. At rest: it comes nearer at 0.2 m/s.
        const bool with_it = tick % 2 == 0;
        const Vec3 velocity(0, 0, with_it ? 0.2 : 0.0);
        const RenderTick& felt = renderer.tick(at(Vec3(0, 0, top - 0.01), velocity), tick_seconds);
        EXPECT_NEAR(felt.spring.z(), 500 * 0.01 + (with_it ? 0.0 : 2.0), 1e-5) << tick;
    }
}

TEST(SceneRenderer, EveryObjectHasItsOwnStiffness)
{
    TouchScene scene(wide_room);
    const SurfaceMaterial hard = {
        .stiffness = 2000, .damping = 0, .static_friction = 0, .dynamic_friction = 0};
    const SurfaceMaterial soft = {
        .stiffness = 100, .damping = 0, .static_friction = 0, .dynamic_friction = 0};
    ASSERT_TRUE(scene.add(body_of(box_mesh(Vec3(2, 2, 0.1)), {.material = hard}),
                          at_place(Vec3(0, 0, -0.1))));
    ASSERT_TRUE(scene.add(body_of(box_mesh(Vec3(0.1, 2, 2)), {.material = soft}),
                          at_place(Vec3(-0.1, 0, 0))));
    HapticRenderer renderer =
        make_haptic_renderer(scene, same_unit, strong_device(), plain(0.4)).value();
    renderer.tick(at(Vec3(0.5, 0, 0.5)), tick_seconds);
    const RenderTick floor = renderer.tick(at(Vec3(0.5, 0, -0.02)), tick_seconds);
    EXPECT_LT((floor.spring - Vec3(0, 0, 40)).norm(), 1e-4);
    const RenderTick corner = renderer.tick(at(Vec3(-0.03, 0, -0.02)), tick_seconds);
    EXPECT_LT((corner.spring - Vec3(3, 0, 40)).norm(), 1e-4);
    const RenderTick wall = renderer.tick(at(Vec3(-0.03, 0, 0.5)), tick_seconds);
    EXPECT_LT((wall.spring - Vec3(3, 0, 0)).norm(), 1e-4);
    // Frictionless, though the renderer's own settings are not.
    const RenderTick beside = renderer.tick(at(Vec3(-0.03, 0.001, 0.5)), tick_seconds);
    EXPECT_LT((beside.spring - Vec3(3, 0, 0)).norm(), 1e-4);
}

/// Friction far beyond the renderer's holds the proxy away from where it would be without friction.
TEST(SceneRenderer, AHandThatRestsOnRubberFeelsOneContact)
{
    const SurfaceMaterial rubber = {
        .stiffness = 500, .damping = 0, .static_friction = 1.2, .dynamic_friction = 1.2};
    for (const double usual_friction : {0.0, 0.4}) {
        TouchScene scene(wide_room);
        ASSERT_TRUE(scene.add(body_of(box_mesh(Vec3(1, 1, 0.1)), {.material = rubber}),
                              at_place(Vec3(0, 0, -0.1))));
        RenderOptions options = plain(usual_friction);
        options.texture.stick_slip = {.stiffness = 150, .max_force = 0.5};
        HapticRenderer renderer =
            make_haptic_renderer(scene, same_unit, strong_device(), options).value();
        renderer.tick(at(Vec3(0.1, 0.3, 0.001)), tick_seconds);
        for (int i = 0; i <= 100; ++i)
            renderer.tick(at(Vec3(0.1 + 2e-5 * i, 0.3, -0.002)), tick_seconds);
        const Vec3 hand(0.102, 0.3, -0.002);
        const RenderTick first = renderer.tick(at(hand), tick_seconds);
        ASSERT_EQ(first.hold, Hold::sticking);
        EXPECT_GT(first.contact_count, 0U);
        for (int i = 0; i < 10; ++i) {
            const RenderTick& felt = renderer.tick(at(hand), tick_seconds);
            EXPECT_EQ(felt.contacts[0].position, first.contacts[0].position) << i;
            EXPECT_EQ(felt.force, first.force) << i;
        }
    }
}

TEST(SceneRenderer, ExchangesBodiesWithoutAForceSpike)
{
    const DeviceLimits omni = *find_device("omni");
    // To a finer sphere, a larger one that swallows the proxy, a smaller one and a cube.
    const auto sphere = [](double size, const char* name) {
        return body_of(moved(*sample_mesh(name), [&](const Vec3& p) { return Vec3(size * p); }));
    };
    TouchScene scene(Box{Vec3(-0.2, -0.2, -0.2), Vec3(0.2, 0.2, 0.2)});
    const auto object = scene.add(sphere(0.05, "sphere:12x12"), at_place(Vec3::Zero()));
    RenderOptions options;
    options.static_friction = options.dynamic_friction = 0; // its slips are steps, too
    HapticRenderer renderer = make_haptic_renderer(scene, same_unit, omni, options).value();
    std::vector<TouchBody> bodies;
    bodies.push_back(sphere(0.05, "sphere:30x30"));
    bodies.push_back(sphere(0.06, "sphere:30x30"));
    bodies.push_back(sphere(0.045, "icosphere:2"));
    bodies.push_back(sphere(0.04, "cube"));
    std::size_t next = 0;
    Vec3 last = Vec3::Zero();
    double largest_step = 0;
    double largest = 0;
    for (int tick = 0; tick < 2600; ++tick) {
        // It comes down slowly and then rests: all steps are the exchanges'.
        const double depth = std::min(-0.01 + 1e-4 * tick, 0.004);
        const Vec3 hand = (0.048 - depth) * Vec3(0.3, 0.1, 1).normalized();
        if (tick > 400 && tick % 500 == 0 && next < bodies.size()) {
            ASSERT_TRUE(scene.exchange(*object, bodies[next++]));
        }
        const std::size_t allocations = allocation_count();
        const RenderTick& felt = renderer.tick(at(hand), tick_seconds);
        ASSERT_EQ(allocation_count(), allocations);
        ASSERT_TRUE(felt.force.allFinite());
        ASSERT_LE(felt.force.norm(), omni.max_force);
        ASSERT_TRUE(felt.is_placed) << tick;
        // Outside of every body, also of those that swallowed it.
        ASSERT_LT((moving_surface(scene).nearest_exit(felt.proxy) - felt.proxy).norm(), 1e-12)
            << tick;
        largest_step = std::max(largest_step, (felt.force - last).norm());
        largest = std::max(largest, felt.force.norm());
        last = felt.force;
    }
    EXPECT_EQ(next, bodies.size());
    std::printf("largest change of the force in a tick: %.3f N\n", largest_step);
    // The fading one loses a fiftieth of itself a tick, the rising one a 250th of at most 10 N; the
    // hand as it comes down 0.05 N.
    EXPECT_LT(largest_step, omni.max_force / 50 + 10.0 / 250);
    EXPECT_GT(largest, 1);
}

TEST(SceneRenderer, OnlyAnExchangedBodyAtTheProxyLetsTheForceFade)
{
    const auto cube = [](double size) {
        return body_of(moved(*sample_mesh("cube"), [&](const Vec3& p) { return Vec3(size * p); }));
    };
    const DeviceLimits omni = *find_device("omni");
    struct Felt {
        std::vector<Vec3> forces;
        Vec3 last_proxy = Vec3::Zero();
    };
    enum class Exchange { none, beside, grown_up_to_it, touched };
    const auto feel = [&](Exchange exchange) {
        TouchScene scene(Box{Vec3(-0.2, -0.2, -0.2), Vec3(0.2, 0.2, 0.2)});
        const auto table = scene.add(cube(0.05), at_place(Vec3(0, 0, -0.05)));
        const auto other = scene.add(cube(0.02), at_place(Vec3(0.09, 0, 0.05)));
        EXPECT_TRUE(table && other);
        HapticRenderer renderer = make_haptic_renderer(scene, same_unit, omni, {}).value();
        Felt felt;
        for (int tick = 0; tick < 1200; ++tick) {
            // Down onto the table, and along it.
            const double down = std::max(0.01 - 1e-4 * tick, -0.002);
            const Vec3 hand(-0.01 + 1e-5 * tick, 0, down);
            if (tick == 800) {
                Status exchanged;
                if (exchange == Exchange::beside) exchanged = scene.exchange(*other, cube(0.03));
                if (exchange == Exchange::grown_up_to_it)
                    exchanged = scene.exchange(*other, cube(0.1));
                if (exchange == Exchange::touched) exchanged = scene.exchange(*table, cube(0.03));
                EXPECT_TRUE(exchanged);
            }
            felt.forces.push_back(renderer.tick(at(hand), tick_seconds).force);
        }
        felt.last_proxy = renderer.last().proxy;
        return felt;
    };
    const Felt expected = feel(Exchange::none);
    EXPECT_GT(expected.forces[799].norm(), 0.5);
    const Felt beside = feel(Exchange::beside);
    EXPECT_TRUE(beside.forces == expected.forces);
    EXPECT_EQ(beside.last_proxy, expected.last_proxy);
    for (const Exchange exchange : {Exchange::grown_up_to_it, Exchange::touched}) {
        const Felt felt = feel(exchange);
        EXPECT_TRUE(
            std::equal(felt.forces.begin(), felt.forces.begin() + 800, expected.forces.begin()));
        EXPECT_LT(felt.forces[825].norm(), 0.8 * expected.forces[825].norm());
        for (std::size_t tick = 800; tick < 1200; ++tick) {
            EXPECT_LT((felt.forces[tick] - felt.forces[tick - 1]).norm(),
                      omni.max_force / 50 + 10.0 / 250);
        }
    }
}

TEST(SceneRenderer, ADeviceInsideABodyFeelsNothingWhereAnotherIsExchanged)
{
    const auto cube = [](double size) {
        return body_of(moved(*sample_mesh("cube"), [&](const Vec3& p) { return Vec3(size * p); }));
    };
    TouchScene scene(Box{Vec3(-0.2, -0.2, -0.2), Vec3(0.2, 0.2, 0.2)});
    const Vec3 center(-0.12, 0, 0);
    const auto around = scene.add(cube(0.05), at_place(center));
    const auto other = scene.add(cube(0.02), at_place(Vec3::Zero()));
    ASSERT_TRUE(around && other);
    HapticRenderer renderer =
        make_haptic_renderer(scene, same_unit, *find_device("omni"), {}).value();
    const auto run = [&](const Vec3& hand) {
        double largest = 0;
        for (int tick = 0; tick < 300; ++tick)
            largest = std::max(largest, renderer.tick(at(hand), tick_seconds).force.norm());
        return largest;
    };
    const Vec3 within = center + Vec3(0, 0.001, 0.02);
    EXPECT_EQ(run(within), 0);
    ASSERT_TRUE(scene.exchange(*other, cube(0.03)));
    EXPECT_EQ(run(within), 0);
    EXPECT_FALSE(renderer.last().is_placed);
    // It waits for the device to come out.
    EXPECT_EQ(run(center + Vec3(0, 0.001, 0.06)), 0);
    EXPECT_TRUE(renderer.last().is_placed);
    EXPECT_GT(run(center + Vec3(0, 0.001, 0.048)), 0.5);
}

TEST(SceneRenderer, ACrushedProxyFeelsNothingUntilThePressOpens)
{
    TouchScene scene(wide_room);
    const auto low = scene.add(body_of(box_mesh(Vec3(1, 1, 0.5))), at_place(Vec3(0, 0, -0.6)));
    const auto high = scene.add(body_of(box_mesh(Vec3(1, 1, 0.5))), at_place(Vec3(0, 0, 0.6)));
    RenderOptions options;
    options.proxy_radius = 0.02;
    options.max_jump = 10;
    const DeviceLimits omni = *find_device("omni");
    HapticRenderer renderer = make_haptic_renderer(scene, same_unit, omni, options).value();
    const auto close_to = [&](double z) {
        EXPECT_TRUE(scene.move(*low, {.pose = at_place(Vec3(0, 0, -0.5 - z)), .seconds = 0.1}));
        EXPECT_TRUE(scene.move(*high, {.pose = at_place(Vec3(0, 0, 0.5 + z)), .seconds = 0.1}));
    };
    Vec3 last = Vec3::Zero();
    const auto run = [&](const Vec3& hand, int ticks) {
        for (int tick = 0; tick < ticks; ++tick) {
            const RenderTick& felt = renderer.tick(at(hand), tick_seconds);
            EXPECT_TRUE(felt.force.allFinite());
            EXPECT_LE((felt.force - last).norm(), 0.2) << tick;
            last = felt.force;
        }
    };
    run(Vec3::Zero(), 10);
    EXPECT_TRUE(renderer.last().is_placed);
    close_to(-0.1); // into each other
    run(Vec3::Zero(), 300);
    EXPECT_FALSE(renderer.last().is_placed);
    EXPECT_LT(last.norm(), 1e-9);
    close_to(0.1);
    run(Vec3::Zero(), 300);
    EXPECT_TRUE(renderer.last().is_placed);
    for (int step = 1; step <= 425; ++step) run(Vec3(0, 0, -0.0002 * step), 1);
    run(Vec3(0, 0, -0.085), 100);
    EXPECT_NE(renderer.last().hold, Hold::free);
    EXPECT_NEAR(last.z(), 500 * 0.005, 1e-6);
}

TEST(SceneRenderer, AnotherThreadMayMoveAndExchangeObjects)
{
    TouchScene scene(wide_room);
    const auto cube = scene.add(body_of(*sample_mesh("cube")), at_place(Vec3::Zero()));
    HapticRenderer renderer =
        make_haptic_renderer(scene, same_unit, strong_device(), plain(0.3)).value();
    std::atomic<bool> ended{false};
    std::atomic<int> exchanges{0};
    std::thread application([&] {
        std::mt19937 random(5);
        std::uniform_real_distribution<double> number(-1, 1);
        for (int word = 0; !ended.load(); ++word) {
            const Vec3 to(0.2 * number(random), 0.2 * number(random), 0.2 * number(random));
            EXPECT_TRUE(scene.move(
                *cube, {.pose = posed(number(random), Vec3(1, 1, 0), to), .seconds = 0.005}));
            if (word % 10 == 0) {
                const char* const name = word % 20 == 0 ? "sphere:12x12" : "cube";
                EXPECT_TRUE(scene.exchange(*cube, body_of(*sample_mesh(name))));
                ++exchanges;
            }
            std::this_thread::sleep_for(std::chrono::milliseconds(2));
        }
    });
    const TriangleMesh about = *sample_mesh("cube");
    HandPath path(about, 8);
    int touching = 0;
    const ServoStatistics seen = run_servo_loop({.ticks = 400}, [&](std::uint64_t) noexcept {
        const RenderTick& felt = renderer.tick(at(path.next()), tick_seconds);
        touching += felt.hold != Hold::free ? 1 : 0;
        return felt.force.allFinite() ? Flow::proceed : Flow::stop;
    });
    ended.store(true);
    application.join();
    EXPECT_EQ(seen.ticks, 400U);
    EXPECT_GT(touching, 20);
    EXPECT_GT(exchanges.load(), 1);
}

TEST(SceneRenderer, MaterialsAreLimitedByTheDevice)
{
    TouchScene scene(wide_room);
    const SurfaceMaterial steel = {
        .stiffness = 5000, .damping = 50, .static_friction = 0, .dynamic_friction = 0};
    const SurfaceTexture honey = {.viscosity = 1000};
    ASSERT_TRUE(scene.add(body_of(box_mesh(Vec3(1, 1, 0.1)), {.material = steel, .texture = honey}),
                          at_place(Vec3(0, 0, -0.1))));
    HapticRenderer renderer =
        make_haptic_renderer(scene, same_unit, *find_device("omni"), plain()).value();
    renderer.tick(at(Vec3(0.1, 0.3, 0.001)), tick_seconds);
    renderer.tick(at(Vec3(0.1, 0.3, -0.001)), tick_seconds);
    const Vec3 velocity(0.1, 0, -0.1);
    const RenderTick& felt = renderer.tick(at(Vec3(0.1, 0.3, -0.002), velocity), tick_seconds);
    // An omni takes 700 N/m, 5 N s/m, and a quarter of that along the surface.
    EXPECT_LT((felt.spring - Vec3(-1.25 * 0.1, 0, 700 * 0.002 + 5 * 0.1)).norm(), 1e-5);
}

TEST(SceneRenderer, DampsRelativeToASurfaceOfAModelInOtherUnits)
{
    const WorkspaceMap map{20, Vec3(1, 2, 3)};
    TouchScene scene(wide_room);
    const RigidTransform below = at_place(map.center - Vec3(0, 0, 2)); // its top is at the center
    const auto wall = scene.add(body_of(box_mesh(Vec3(2, 2, 2))), below);
    RenderOptions options = plain();
    options.force.damping = 10;
    HapticRenderer renderer = make_haptic_renderer(scene, map, strong_device(), options).value();
    ASSERT_TRUE(scene.move(*wall, {.pose = below, .velocity = Vec3(0, 0, 2), .coast_seconds = 1}));
    renderer.tick(at(Vec3(0.01, 0.02, 0.05)), tick_seconds);
    for (int tick = 1; tick < 100; ++tick) {
        // It rises at 0.1 m/s of the device.
        const double top = 0.1 * (tick + 1) * tick_seconds;
        const RenderTick& felt = renderer.tick(at(Vec3(0.01, 0.02, top - 0.01)), tick_seconds);
        EXPECT_NEAR(felt.surface_velocity.z(), 0.1, 1e-9) << tick;
        EXPECT_NEAR(felt.spring.z(), 500 * 0.01 + 10 * 0.1, 1e-5) << tick;
    }
}

TEST(SceneRenderer, EveryObjectHasItsOwnStiffnessInOtherUnits)
{
    const WorkspaceMap map{20, Vec3::Zero()};
    TouchScene scene(wide_room);
    const SurfaceMaterial hard = {
        .stiffness = 2000, .damping = 0, .static_friction = 0, .dynamic_friction = 0};
    const SurfaceMaterial soft = {
        .stiffness = 100, .damping = 0, .static_friction = 0, .dynamic_friction = 0};
    ASSERT_TRUE(scene.add(body_of(box_mesh(Vec3(10, 10, 2)), {.material = hard}),
                          at_place(Vec3(0, 0, -2))));
    ASSERT_TRUE(scene.add(body_of(box_mesh(Vec3(2, 10, 10)), {.material = soft}),
                          at_place(Vec3(-2, 0, 0))));
    HapticRenderer renderer = make_haptic_renderer(scene, map, strong_device(), plain()).value();
    renderer.tick(at(Vec3(0.1, 0, 0.1)), tick_seconds);
    const RenderTick floor = renderer.tick(at(Vec3(0.1, 0, -0.02)), tick_seconds);
    EXPECT_LT((floor.spring - Vec3(0, 0, 40)).norm(), 1e-4);
    const RenderTick corner = renderer.tick(at(Vec3(-0.03, 0, -0.02)), tick_seconds);
    EXPECT_LT((corner.spring - Vec3(3, 0, 40)).norm(), 1e-4);
}

TEST(SceneRenderer, EveryObjectHasItsOwnFrictionAndDamping)
{
    TouchScene scene(wide_room);
    const SurfaceMaterial felt_cloth = {
        .stiffness = 500, .damping = 4, .static_friction = 0.6, .dynamic_friction = 0.4};
    ASSERT_TRUE(scene.add(body_of(box_mesh(Vec3(1, 1, 0.1)), {.material = felt_cloth}),
                          at_place(Vec3(0, 0, -0.1))));
    RenderOptions options = plain(0.2);
    options.force.damping = 1;
    HapticRenderer renderer =
        make_haptic_renderer(scene, same_unit, strong_device(), options).value();
    constexpr double depth = 0.01;
    renderer.tick(at(Vec3(0.1, 0.3, 0.01)), tick_seconds);
    renderer.tick(at(Vec3(0.1, 0.3, -depth)), tick_seconds);
    for (int i = 1; i <= 100; ++i) {
        // It sticks to where it was until it leans by 0.6 of the depth, and trails by 0.4 from then on.
        const double aside = 2.1e-4 * i;
        const bool sticks = aside < 0.6 * depth;
        const RenderTick& felt = renderer.tick(at(Vec3(0.1 + aside, 0.3, -depth)), tick_seconds);
        EXPECT_EQ(felt.hold, sticks ? Hold::sticking : Hold::sliding) << i;
        EXPECT_NEAR(felt.spring.x(), -500 * (sticks ? aside : 0.4 * depth), 1e-5) << i;
    }
    const Vec3 down(0, 0, -0.1);
    const RenderTick& damped = renderer.tick(at(Vec3(0.12, 0.3, -depth), down), tick_seconds);
    EXPECT_NEAR(damped.spring.z(), 500 * depth + 4 * 0.1, 1e-5);
}

} // namespace
} // namespace proxima::scene_renderer_test
