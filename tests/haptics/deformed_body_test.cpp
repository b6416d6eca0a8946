// Bodies with other vertex positions: what they feel like beside other ways to the same surface, and
// which positions are refused.
#include "code_of.h"
#include "haptics/changing_shapes.h"
#include "haptics/scene/move_with_objects.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <string>
#include <thread>
#include <vector>

namespace proxima::deformed_body_test {
namespace {

using namespace testing;

// The tree gives the proxy and the force the bits that testing every triangle gives them.
TEST(DeformedBody, HasTheBitsOfEveryTriangle)
{
    const TriangleMesh flat = flat_cloth(16);
    const Wave wave = {0.01, 3, 0.1, 0.3, 0.4};
    for (const double radius : {0.0, 0.002}) {
        RenderOptions options = plain(0.3, radius);
        options.shading = ForceShading::on;
        TouchScene scene(room);
        TouchScene slow(room);
        const TouchBodyOptions shaded = {.material = {}, .shading = ForceShading::on};
        const TouchBody body = body_of(flat, shaded);
        const TouchBody every = body_of(flat, shaded, BodySearch::every_triangle);
        const auto object = scene.add(body, {});
        const auto same = slow.add(every, {});
        HapticRenderer renderer =
            make_haptic_renderer(scene, same_unit, strong_device(), options).value();
        HapticRenderer expected =
            make_haptic_renderer(slow, same_unit, strong_device(), options).value();
        int touching = 0;
        for (int tick = 0; tick < 800; ++tick) {
            if (tick % 17 == 0) {
                const auto positions = wave.positions(flat, (tick + 17) * tick_seconds);
                ASSERT_TRUE(scene.deform(*object, *refit_touch_body(body, positions), 0.0167));
                ASSERT_TRUE(slow.deform(*same, *refit_touch_body(every, positions), 0.0167));
            }
            const Vec3 hand = hand_at(Script::stroke, 0.01, tick * tick_seconds);
            const RenderTick& is = renderer.tick(at(hand), tick_seconds);
            const RenderTick& should = expected.tick(at(hand), tick_seconds);
            ASSERT_EQ(is.force, should.force) << radius << ' ' << tick;
            ASSERT_EQ(is.proxy, should.proxy) << radius << ' ' << tick;
            touching += is.hold != Hold::free ? 1 : 0;
        }
        EXPECT_GT(touching, 500);
    }
}

// A cloth whose vertices all move alike is a plate that moves.
TEST(DeformedBody, FeelsLikeAnObjectThatMovesAsItsVerticesDo)
{
    const TriangleMesh flat = flat_cloth(30);
    TouchScene changing(room);
    TouchScene moving(room);
    const TouchBody body = body_of(flat);
    const auto cloth = changing.add(body, {});
    const auto plate = moving.add(body, {});
    RenderOptions options = plain(0.4, 0);
    options.force.damping = 2;
    HapticRenderer renderer =
        make_haptic_renderer(changing, same_unit, strong_device(), options).value();
    HapticRenderer expected =
        make_haptic_renderer(moving, same_unit, strong_device(), options).value();
    const Vec3 hand(0.0123, 0.0071, -0.003);
    for (TouchScene* const scene : {&changing, &moving}) {
        HapticRenderer& of = scene == &changing ? renderer : expected;
        of.tick(at(Vec3(0.0123, 0.0071, 0.01)), tick_seconds);
    }
    int sticking = 0;
    for (int tick = 0; tick < 600; ++tick) {
        if (tick % 20 == 0) {
            const double t = 0.001 * (tick + 20);
            const Vec3 to(0.004 * std::sin(9 * t), 0.002 * std::sin(5 * t),
                          0.002 * std::sin(12 * t));
            std::vector<Vec3> positions(flat.positions().begin(), flat.positions().end());
            for (Vec3& p : positions) p += to;
            ASSERT_TRUE(changing.deform(*cloth, *refit_touch_body(body, positions), 0.02));
            ASSERT_TRUE(moving.move(*plate, {.pose = at_place(to), .seconds = 0.02}));
        }
        const RenderTick& is = renderer.tick(at(hand), tick_seconds);
        const RenderTick& should = expected.tick(at(hand), tick_seconds);
        ASSERT_EQ(is.hold, should.hold) << tick;
        ASSERT_LT((is.force - should.force).norm(), 1e-5) << tick;
        ASSERT_LT((is.surface_velocity - should.surface_velocity).norm(), 1e-9) << tick;
        sticking += is.hold == Hold::sticking ? 1 : 0;
    }
    EXPECT_GT(sticking, 20);
    EXPECT_LT(sticking, 590);
}

TEST(DeformedBody, RefusesWhatIsNoShapeOfTheObject)
{
    TouchScene scene(room);
    const TriangleMesh flat = flat_cloth(4);
    const TouchBody body = body_of(flat);
    const auto object = scene.add(body, {});
    std::vector<Vec3> positions(flat.positions().begin(), flat.positions().end());
    const auto refit = refit_touch_body(body, positions);
    ASSERT_TRUE(refit);
    // A body with equal triangles that was built on its own is no refit.
    EXPECT_EQ(code_of(scene.deform(*object, body_of(flat), 0.01)), ErrorCode::invalid_argument);
    EXPECT_FALSE(scene.deform(*object, *refit, -1));
    EXPECT_FALSE(scene.deform(*object, *refit, std::nan("")));
    EXPECT_TRUE(scene.deform(*object, *refit, 0.01));
    // A refit of a refit, and back to the first.
    EXPECT_TRUE(scene.deform(*object, *refit_touch_body(*refit, positions), 0.01));
    EXPECT_TRUE(scene.deform(*object, body, 0.01));
    positions[0] = Vec3(2, 0, 0);
    EXPECT_NE(scene.deform(*object, *refit_touch_body(body, positions), 0.01)
                  .error()
                  .message.find("bounds"),
              std::string::npos);
    positions[0].x() = std::nan("");
    EXPECT_EQ(code_of(refit_touch_body(body, positions)), ErrorCode::invalid_mesh);
    positions.pop_back();
    const auto few = refit_touch_body(body, positions);
    ASSERT_FALSE(few);
    EXPECT_NE(few.error().message.find("has 24 positions, and its body has 25 vertices"),
              std::string::npos);
}

/// An object that shrinks is as large as it was until it has shrunk.
TEST(DeformedBody, StaysWithinBoundsWhileItChanges)
{
    TouchScene scene(Box{Vec3::Constant(-1), Vec3::Constant(1)});
    const TriangleMesh large = cube_mesh(Vec3::Zero(), 0.5);
    const TouchBody body = body_of(large);
    const auto object = scene.add(body, {});
    std::vector<Vec3> positions;
    for (const Vec3& p : large.positions()) positions.emplace_back(0.2 * p);
    ASSERT_TRUE(scene.deform(*object, *refit_touch_body(body, positions), 0.1));
    HapticRenderer renderer =
        make_haptic_renderer(scene, same_unit, strong_device(), plain(0, 0)).value();
    const ObjectMotion aside = {.pose = at_place(Vec3(0.8, 0, 0)), .seconds = 0.01};
    const auto tick_for = [&](int ticks) {
        for (int i = 0; i < ticks; ++i) renderer.tick(at(Vec3(0, 0, 0.9)), tick_seconds);
    };
    tick_for(50);
    EXPECT_EQ(code_of(scene.move(*object, aside)), ErrorCode::invalid_argument);
    tick_for(60);
    EXPECT_TRUE(scene.move(*object, aside));
}

// A refit is a body of its own, too: what was built from the same positions gives the same bits.
TEST(DeformedBody, ARefitIsABodyOfItsOwn)
{
    const TriangleMesh ball =
        moved(*sample_mesh("icosphere:3"), [](const Vec3& p) { return 0.1 * p; });
    const auto stretched = [](const Vec3& p) { return Vec3(0.8 * p.x(), 1.3 * p.y(), p.z()); };
    std::vector<Vec3> positions;
    for (const Vec3& p : ball.positions()) positions.push_back(stretched(p));
    const TouchBody refit = *refit_touch_body(body_of(ball), positions);
    const TouchBody built = body_of(moved(ball, stretched));
    for (const double radius : {0.0, 0.003}) {
        TouchScene scene(room);
        TouchScene same(room);
        ASSERT_TRUE(scene.add(refit, {}));
        ASSERT_TRUE(same.add(built, {}));
        HapticRenderer renderer =
            make_haptic_renderer(scene, same_unit, strong_device(), plain(0.3, radius)).value();
        HapticRenderer expected =
            make_haptic_renderer(same, same_unit, strong_device(), plain(0.3, radius)).value();
        HandPath path(refit.mesh(), 4);
        int touching = 0;
        renderer.tick(at(Vec3(0.3, 0, 0)), tick_seconds); // it starts outside
        expected.tick(at(Vec3(0.3, 0, 0)), tick_seconds);
        for (int tick = 0; tick < 600; ++tick) {
            const Vec3 hand = path.next();
            ASSERT_EQ(renderer.tick(at(hand), tick_seconds).force,
                      expected.tick(at(hand), tick_seconds).force)
                << radius << ' ' << tick;
            touching += renderer.last().hold != Hold::free ? 1 : 0;
        }
        EXPECT_GT(touching, 150);
    }
}

// While a closed shape is on its way back to the body that was built, that body's inside is not its own.
TEST(DeformedBody, AShapeOnItsWayToTheBuiltBodyIsFeltFromOutside)
{
    const TriangleMesh ball =
        moved(*sample_mesh("icosphere:3"), [](const Vec3& p) { return 0.1 * p; });
    std::vector<Vec3> half;
    for (const Vec3& p : ball.positions()) half.emplace_back(0.5 * p);
    const TouchBody body = body_of(ball);
    const auto small = refit_touch_body(body, half);
    TouchScene scene(room);
    const auto object = scene.add(body, {});
    ASSERT_TRUE(scene.deform(*object, *small, 0));
    (void)scene.advance(tick_seconds);
    ASSERT_TRUE(scene.deform(*object, body, 100));
    HapticRenderer renderer =
        make_haptic_renderer(scene, same_unit, strong_device(), plain(0, 0)).value();
    const Vec3 beside(0.001, 0.002, 0.075);
    EXPECT_TRUE(renderer.tick(at(beside), tick_seconds).is_placed);
    for (int tick = 0; tick < 350; ++tick)
        renderer.tick(at(beside - Vec3(0, 0, 1e-4 * tick)), tick_seconds);
    EXPECT_NEAR(renderer.last().proxy.z(), 0.05, 1e-3);
    EXPECT_GT(renderer.last().force.z(), 1);
    // Once it is there, who begins in it is inside.
    for (int tick = 0; tick < 100; ++tick) (void)scene.advance(1);
    renderer.reset();
    EXPECT_FALSE(renderer.tick(at(beside), tick_seconds).is_placed);
}

// More triangles are near than there is memory for: the triangle that holds the proxy takes it along.
TEST(DeformedBody, TheContactCarriesTheProxyInACrowd)
{
    TouchScene scene(room);
    const TriangleMesh flat = flat_cloth(72);
    const TouchBody body = body_of(flat);
    const auto object = scene.add(body, {});
    CarryScratch scratch;
    const double radius = 0.002;
    const Vec3 p(1e-4, 2e-4, radius);
    std::vector<Vec3> positions(flat.positions().begin(), flat.positions().end());
    Contact contact;
    contact.triangle = scene_triangle(*object, TriangleId{2 * 36 * 72 + 73});
    contact.pressure = 1;
    Vec3 at = p;
    for (const Vec3& way : {Vec3(0, 0, 0.001), Vec3(0.5, 0, 0)}) {
        for (Vec3& each : positions) each += way;
        ASSERT_TRUE(scene.deform(*object, *refit_touch_body(body, positions), 0));
        (void)scene.advance(tick_seconds);
        const CarriedGoal goal =
            carried_position(moving_surface(scene), radius, {&contact, 1}, at, scratch);
        EXPECT_LT((goal.position - at - way).norm(), 1e-9);
        at += way;
    }
}

TEST(DeformedBody, AnotherThreadMayGiveShapes)
{
    const TriangleMesh ball =
        moved(*sample_mesh("icosphere:3"), [](const Vec3& p) { return 0.1 * p; });
    TouchScene scene(room);
    const TouchBody body = body_of(ball);
    const auto object = scene.add(body, {});
    HapticRenderer renderer =
        make_haptic_renderer(scene, same_unit, strong_device(), plain(0.3, 0)).value();
    std::atomic<bool> ended{false};
    std::atomic<int> shapes{0};
    std::thread application([&] {
        for (int frame = 0; !ended.load(); ++frame) {
            std::vector<Vec3> positions;
            for (const Vec3& p : ball.positions())
                positions.push_back(p * (1 + 0.03 * std::sin(frame)));
            EXPECT_TRUE(scene.deform(*object, *refit_touch_body(body, positions), 0.002));
            if (frame % 50 == 49) {
                EXPECT_TRUE(scene.exchange(*object, body));
            }
            ++shapes;
            std::this_thread::sleep_for(std::chrono::microseconds(700));
        }
    });
    int touching = 0;
    const ServoStatistics seen = run_servo_loop({.ticks = 400}, [&](std::uint64_t tick) noexcept {
        const double down = 0.0002 * static_cast<double>(std::min<std::uint64_t>(tick, 100));
        const RenderTick& felt = renderer.tick(at(Vec3(0.01, 0.02, 0.11 - down)), tick_seconds);
        touching += felt.hold != Hold::free ? 1 : 0;
        return felt.force.allFinite() ? Flow::proceed : Flow::stop;
    });
    ended.store(true);
    application.join();
    EXPECT_EQ(seen.ticks, 400U);
    EXPECT_GT(touching, 100);
    EXPECT_GT(shapes.load(), 0);
}

} // namespace
} // namespace proxima::deformed_body_test
