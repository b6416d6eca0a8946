// Objects whose shape changes while they are touched: nothing is passed, by every triangle.
#include "counted_allocations.h"
#include "haptics/changing_shapes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <random>
#include <string>
#include <vector>

namespace proxima::deforming_surface_test {
namespace {

using namespace testing;

struct Account {
    int touching = 0;
    int sticking = 0;
    double largest_lift = 0; ///< by which a proxy that sticks came away from the surface in a tick
    int squeezed = 0;
    double largest_step = 0;
    double largest = 0;
};

/// Touches a cloth for a second; everything is tested in every tick.
Account touch(const TriangleMesh& flat, const Wave& wave, Script script,
              const RenderOptions& options, const std::string& where)
{
    TouchScene scene(room);
    const TouchBody body = body_of(flat);
    const auto object = scene.add(body, {});
    HapticRenderer renderer =
        make_haptic_renderer(scene, same_unit, strong_device(), options).value();
    Vertices vertices(flat);
    Account account;
    Vec3 before = Vec3::Zero();
    Vec3 force = Vec3::Zero();
    double gap = 0;
    bool stuck = false;
    int frame = 0;
    for (int tick = 0; tick < 1000; ++tick) {
        const double seconds = tick * tick_seconds;
        if (seconds >= frame * frame_seconds) {
            ++frame;
            const auto positions = wave.positions(flat, frame * frame_seconds);
            const auto bent = refit_touch_body(body, positions);
            EXPECT_TRUE(bent && scene.deform(*object, *bent, frame_seconds)) << where;
            vertices.deform(positions, frame_seconds);
        }
        vertices.advance();
        const Vec3 hand = hand_at(script, wave.height, seconds);
        const std::size_t allocations = allocation_count();
        const RenderTick& felt = renderer.tick(at(hand), tick_seconds);
        EXPECT_EQ(allocation_count(), allocations);
        const std::string problem = problem_of(scene, renderer, vertices, before);
        if (!problem.empty()) {
            ADD_FAILURE() << where << ", tick " << tick << ": " << problem;
            return account;
        }
        before = felt.proxy;
        if (felt.hold == Hold::sticking) {
            const double now = vertices.distance(felt.proxy) - parts_of(renderer).proxy().radius();
            if (stuck) account.largest_lift = std::max(account.largest_lift, now - gap);
            gap = now;
            ++account.sticking;
        }
        stuck = felt.hold == Hold::sticking;
        account.squeezed += felt.squeezed ? 1 : 0;
        account.touching += felt.hold != Hold::free ? 1 : 0;
        if (seconds > 0.15)
            account.largest_step = std::max(account.largest_step, (felt.force - force).norm());
        account.largest = std::max(account.largest, felt.force.norm());
        force = felt.force;
    }
    return account;
}

/// Two triangles over a square of side 2, at that height and slope along x.
TriangleMesh plate(double height, double slope)
{
    std::vector<Vec3> corners = {Vec3(-1, -1, 0), Vec3(1, -1, 0), Vec3(1, 1, 0), Vec3(-1, 1, 0)};
    for (Vec3& p : corners) p.z() = height + slope * p.x();
    return make_triangle_mesh(std::move(corners),
                              {TriangleCorners{0, 1, 2}, TriangleCorners{0, 2, 3}})
        .value();
}

std::vector<Vec3> positions_of(const TriangleMesh& mesh)
{
    return {mesh.positions().begin(), mesh.positions().end()};
}

// A plate at rest, and one above it that closes like jaws and drives the hand out of them: at the
// border it must not end below the plate at rest, where the mean of what the two plates do would
// take it.
TEST(DeformingSurface, AHandThatJawsDriveOutStaysOnItsSide)
{
    enum class Way { move, deform, move_beside_idle_deformation };
    const Box space{Vec3(-4, -4, -4), Vec3(4, 4, 4)};
    int left = 0;
    for (const Way way : {Way::move, Way::deform, Way::move_beside_idle_deformation}) {
        for (const double slope : {0.05, 0.2, 0.5, 1.0}) {
            for (const int ticks : {5, 20, 60}) {
                const double down = 2.5 * slope;
                TouchScene scene(space);
                const TouchBody low = body_of(plate(0, 0));
                const TouchBody high = body_of(plate(slope, slope));
                const auto lower = scene.add(low, {});
                const auto upper = scene.add(high, {});
                HapticRenderer renderer =
                    make_haptic_renderer(scene, same_unit, strong_device(), plain(0, 0)).value();
                const DeviceState hand = at(Vec3(0.5, 0, 0.75 * slope));
                (void)renderer.tick(hand, tick_seconds);
                if (way == Way::deform) {
                    const auto closed =
                        refit_touch_body(high, positions_of(plate(slope - down, slope)));
                    ASSERT_TRUE(closed && scene.deform(*upper, *closed, ticks * tick_seconds));
                } else {
                    ASSERT_TRUE(scene.move(*upper, {.pose = at_place(Vec3(0, 0, -down)),
                                                    .seconds = ticks * tick_seconds}));
                }
                if (way == Way::move_beside_idle_deformation) {
                    const auto same = refit_touch_body(low, positions_of(low.mesh()));
                    ASSERT_TRUE(same && scene.deform(*lower, *same, ticks * tick_seconds));
                }
                bool out = false;
                for (int tick = 0; tick < ticks + 2; ++tick) {
                    const RenderTick& felt = renderer.tick(hand, tick_seconds);
                    ASSERT_TRUE(felt.is_placed);
                    out = out || felt.proxy.x() > 0.999;
                    ASSERT_GT(felt.proxy.z(), 0)
                        << static_cast<int>(way) << " slope " << slope << ", tick " << tick;
                }
                left += out ? 1 : 0;
            }
        }
    }
    EXPECT_GT(left, 0);
}

// The lower side of the upper box is one plane: what slides along it grazes its other triangles, and
// its border.
TEST(DeformingSurface, AHandBetweenClosingBoxesEscapesAsFromBoxesThatMove)
{
    constexpr std::uint32_t seed = 2601;
    std::mt19937 random(seed);
    const auto number = [&](double least, double most) {
        return std::uniform_real_distribution<double>(least, most)(random);
    };
    int touching = 0;
    for (int run = 0; run < 60; ++run) {
        const TriangleMesh flat = box_mesh(Vec3(1, 1, 0.3));
        const RigidTransform tilt =
            posed(number(0.001, 0.1), Vec3(number(-1, 1), 1, 0), Vec3::Zero());
        const double gap = number(0.15, 0.4);
        const Vec3 middle(number(-0.3, 0.3), number(-0.3, 0.3), 0.3 + gap);
        const TriangleMesh tilted =
            moved(flat, [&](const Vec3& p) { return Vec3(tilt(p) + middle); });
        const Vec3 down(number(-0.05, 0.05), number(-0.05, 0.05), -number(gap, gap + 0.3));
        const int ticks = 5 + run;
        const double part = number(0.3, 0.6);
        const Vec3 place(number(-0.4, 0.4), number(-0.4, 0.4), part * gap);
        for (const bool deforms : {false, true}) {
            TouchScene scene(Box{Vec3(-4, -4, -4), Vec3(4, 4, 4)});
            const TouchBody low =
                body_of(moved(flat, [](const Vec3& p) { return Vec3(p - Vec3(0, 0, 0.3)); }));
            const TouchBody high = body_of(tilted);
            ASSERT_TRUE(scene.add(low, {}));
            const auto upper = scene.add(high, {});
            HapticRenderer renderer =
                make_haptic_renderer(scene, same_unit, strong_device(), plain(0, 0)).value();
            (void)renderer.tick(at(place), tick_seconds);
            if (!renderer.last().is_placed || renderer.last().hold != Hold::free) continue;
            if (deforms) {
                const auto closed = refit_touch_body(
                    high,
                    positions_of(moved(tilted, [&](const Vec3& p) { return Vec3(p + down); })));
                ASSERT_TRUE(closed && scene.deform(*upper, *closed, ticks * tick_seconds));
            } else {
                ASSERT_TRUE(
                    scene.move(*upper, {.pose = at_place(down), .seconds = ticks * tick_seconds}));
            }
            for (int tick = 0; tick < ticks + 5; ++tick) {
                const RenderTick& felt = renderer.tick(at(place), tick_seconds);
                ASSERT_FALSE(felt.squeezed)
                    << "deforms " << deforms << ", seed " << seed << ", run " << run;
                ASSERT_TRUE(felt.is_placed);
                touching += felt.hold != Hold::free ? 1 : 0;
            }
        }
    }
    EXPECT_GT(touching, 100);
}

TEST(DeformingSurface, AWaveOfTwentyThousandTrianglesPassesNothing)
{
    const TriangleMesh flat = flat_cloth(100);
    ASSERT_EQ(flat.triangle_count(), 20000U);
    for (const std::uint32_t seed : {1U, 2U}) {
        std::mt19937 random(seed);
        std::uniform_real_distribution<double> phase(0, 2 * std::numbers::pi);
        for (const Script script : {Script::rest, Script::stroke, Script::poke}) {
            const bool even = seed % 2 == 0;
            const Wave wave = {even ? 0.01 : 0.005, even ? 4.0 : 2.0, 0.08, phase(random),
                               phase(random)};
            const RenderOptions options = plain(even ? 0.4 : 0, even ? 0.003 : 0);
            const std::string where = "seed " + std::to_string(seed) + ", script " +
                                      std::to_string(static_cast<int>(script));
            const Account account = touch(flat, wave, script, options, where);
            EXPECT_EQ(account.squeezed, 0) << where;
            EXPECT_GT(account.touching, 300) << where;
            // It is pressed in to twice the height of the wave, and never goes down on the far side.
            EXPECT_GT(account.largest, 500 * 1.5 * wave.height) << where;
            // The gentle wave turns the force by less than a facet of it a tick; nothing fades.
            if (!even) {
                EXPECT_LT(account.largest_step, 0.1 * account.largest) << where;
            }
            // Planes of triangles that turn lift it by up to 0.05 mm, and it goes down again.
            EXPECT_EQ(account.sticking > 30, even) << where;
            EXPECT_LT(account.largest_lift, 1e-9) << where;
            if (HasFailure()) return;
        }
    }
}

/// A shape of a mesh with a little noise, or a lot.
std::vector<Vec3> shaken(const TriangleMesh& mesh, std::mt19937& random, double size)
{
    std::uniform_real_distribution<double> number(-size, size);
    std::vector<Vec3> result(mesh.positions().begin(), mesh.positions().end());
    const Vec3 push(number(random), number(random), number(random));
    for (Vec3& p : result) p += push + 0.3 * Vec3(number(random), number(random), number(random));
    return result;
}

// Shapes at any time, of any duration, some of which never are begun, of objects that move as well.
TEST(DeformingSurface, NothingPassesWhateverShapesAreGiven)
{
    const std::vector<std::string> names = {"icosphere:2", "torus:16x8", "cube"};
    int touching = 0;
    int squeezed = 0;
    int ticks = 0;
    for (const std::uint32_t seed : {1U, 2U, 3U, 4U, 5U, 6U}) {
        std::mt19937 random(seed);
        std::uniform_real_distribution<double> number(-1, 1);
        const TriangleMesh mesh = moved(*sample_mesh(names[seed % names.size()]),
                                        [](const Vec3& p) { return Vec3(0.1 * p); });
        TouchScene scene(room);
        const TouchBody body = body_of(mesh);
        const auto object = scene.add(body, {});
        RenderOptions options = plain(seed % 2 == 0 ? 0.5 : 0, seed % 4 < 2 ? 0 : 0.004);
        HapticRenderer renderer =
            make_haptic_renderer(scene, same_unit, strong_device(), options).value();
        Vertices vertices(mesh);
        HandPath path(mesh, seed);
        Vec3 before = Vec3::Zero();
        for (int tick = 0; tick < 1500; ++tick) {
            while (random() % 8 == 0) {
                const double size = random() % 5 == 0 ? 0.03 : 0.003;
                const auto positions = shaken(mesh, random, size);
                const double seconds = random() % 4 == 0 ? 0.0 : 0.02 * std::abs(number(random));
                const auto bent = refit_touch_body(body, positions);
                ASSERT_TRUE(bent && scene.deform(*object, *bent, seconds));
                vertices.deform(positions, seconds);
            }
            if (random() % 40 == 0) {
                const Vec3 axis{number(random), number(random), number(random)};
                const Vec3 to{number(random), number(random), number(random)};
                ASSERT_TRUE(
                    scene.move(*object, {.pose = posed(0.1 * number(random), axis, 0.02 * to),
                                         .seconds = 0.05 * std::abs(number(random))}));
            }
            vertices.advance();
            const RenderTick& felt = renderer.tick(at(path.next()), tick_seconds);
            const std::string problem = problem_of(scene, renderer, vertices, before);
            ASSERT_EQ(problem, "") << "seed " << seed << ", tick " << tick;
            before = felt.proxy;
            touching += felt.hold != Hold::free ? 1 : 0;
            squeezed += felt.squeezed ? 1 : 0;
            ++ticks;
        }
    }
    std::printf("%d ticks, %d of touch, %d squeezed\n", ticks, touching, squeezed);
    EXPECT_GT(touching, ticks / 4);
    EXPECT_LT(squeezed, ticks / 100);
}

// A cloth that comes at a hand at rest, and goes beyond it: slowly, in one tick, and by way of shapes
// of which the servo loop sees the last alone.
TEST(DeformingSurface, AClothThatComesAtTheHandTakesTheProxyAlong)
{
    const TriangleMesh flat = flat_cloth(20);
    const auto at_height = [&](double z) {
        std::vector<Vec3> positions(flat.positions().begin(), flat.positions().end());
        for (Vec3& p : positions) p.z() += z;
        return positions;
    };
    const Vec3 hand(0.0123, 0.0071, 0.02);
    struct Given {
        std::vector<double> heights;
        double seconds;
    };
    const std::vector<Given> all = {
        {{0.03}, 0.1}, {{0.03}, 0.002}, {{0.03}, 0}, {{0.03, 0.0301}, 0}, {{-0.2, 0.4, 0.03}, 0}};
    for (const double radius : {0.0, 0.002}) {
        for (const Given& given : all) {
            const std::string where = std::to_string(given.heights.size()) + " shapes, " +
                                      std::to_string(given.seconds) + " s, radius " +
                                      std::to_string(radius);
            TouchScene scene(room);
            const TouchBody body = body_of(flat);
            const auto object = scene.add(body, {});
            HapticRenderer renderer =
                make_haptic_renderer(scene, same_unit, strong_device(), plain(0, radius)).value();
            Vertices vertices(flat);
            Vec3 before = hand;
            for (int tick = 0; tick < 200; ++tick) {
                if (tick == 20) {
                    for (const double z : given.heights) {
                        const auto bent = refit_touch_body(body, at_height(z));
                        ASSERT_TRUE(bent && scene.deform(*object, *bent, given.seconds));
                        vertices.deform(at_height(z), given.seconds);
                    }
                }
                vertices.advance();
                const RenderTick& felt = renderer.tick(at(hand), tick_seconds);
                ASSERT_EQ(problem_of(scene, renderer, vertices, before), "")
                    << where << ' ' << tick;
                ASSERT_FALSE(felt.squeezed) << where;
                before = felt.proxy;
            }
            const double depth = given.heights.back() + radius - hand.z();
            EXPECT_NEAR(renderer.last().spring.z(), 500 * depth, 1e-5) << where;
        }
    }
}

} // namespace
} // namespace proxima::deforming_surface_test
