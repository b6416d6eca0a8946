#include "haptics/scene/material_change.h"

#include "haptics/scene/touch_access.h"
#include "haptics/scenes_to_touch.h"
#include "proxima/haptic_renderer.h"

#include <gtest/gtest.h>

#include <limits>

namespace proxima::material_change_test {
namespace {

using namespace testing;

constexpr double tick_seconds = 1e-3;
constexpr SurfaceMaterial soft{
    .stiffness = 100, .damping = 0, .static_friction = 0.4, .dynamic_friction = 0.2};
constexpr SurfaceMaterial hard{
    .stiffness = 500, .damping = 0, .static_friction = 0.8, .dynamic_friction = 0.6};

double stiffness_of(const TouchScene& scene)
{
    return moving_surface(scene).material(scene_triangle(ObjectId{0}, TriangleId{0}))->stiffness;
}

TEST(MaterialChange, EveryNumberChangesEvenly)
{
    TouchScene scene(wide_room);
    const TouchBody body = body_of(*sample_mesh("cube"), {.material = soft});
    ASSERT_TRUE(scene.add(body, at_place(Vec3::Zero())));
    ASSERT_TRUE(scene.set_material(ObjectId{0}, hard, 0.01));
    EXPECT_EQ(stiffness_of(scene), 100);
    for (int i = 1; i <= 10; ++i) {
        (void)scene.advance(tick_seconds);
        EXPECT_NEAR(stiffness_of(scene), 100 + 40 * i, 1e-9);
    }
    const auto reached = moving_surface(scene).material(scene_triangle(ObjectId{0}, TriangleId{0}));
    EXPECT_EQ(reached->stiffness, hard.stiffness);
    EXPECT_EQ(reached->static_friction, hard.static_friction);
    EXPECT_EQ(reached->dynamic_friction, hard.dynamic_friction);
    // From where it is, half way.
    ASSERT_TRUE(scene.set_material(ObjectId{0}, soft, 0.01));
    for (int i = 0; i < 5; ++i) (void)scene.advance(tick_seconds);
    EXPECT_NEAR(stiffness_of(scene), 300, 1e-9);
    ASSERT_TRUE(scene.set_material(ObjectId{0}, hard, 0.01));
    (void)scene.advance(tick_seconds);
    EXPECT_NEAR(stiffness_of(scene), 320, 1e-9);
    // At once, and until the body is exchanged; a refit of the body is none.
    ASSERT_TRUE(scene.set_material(ObjectId{0}, hard, 0));
    (void)scene.advance(tick_seconds);
    EXPECT_EQ(stiffness_of(scene), 500);
    const auto bent = refit_touch_body(body, body.mesh().positions());
    ASSERT_TRUE(bent);
    ASSERT_TRUE(scene.deform(ObjectId{0}, *bent, 0));
    (void)scene.advance(tick_seconds);
    EXPECT_EQ(stiffness_of(scene), 500);
    ASSERT_TRUE(scene.exchange(ObjectId{0}, body));
    (void)scene.advance(tick_seconds);
    EXPECT_EQ(stiffness_of(scene), 100);
}

// The force of a device at rest follows the stiffness, without a jump.
TEST(MaterialChange, TheForceFollows)
{
    TouchScene scene(wide_room);
    ASSERT_TRUE(scene.add(body_of(*sample_mesh("cube"), {.material = soft}), at_place({0, 0, -1})));
    auto renderer = make_haptic_renderer(scene, {20, Vec3::Zero()}, *find_device("omni"));
    ASSERT_TRUE(renderer);
    DeviceState state;
    const auto settle = [&](int ticks) {
        double fastest = 0;
        for (int i = 0; i < ticks; ++i) {
            const Vec3 before = renderer->last().force;
            fastest =
                std::max(fastest, (renderer->tick(state, tick_seconds).force - before).norm());
        }
        return fastest;
    };
    state.pose.translation = {0, 0, 0.002};
    (void)settle(500);
    state.pose.translation = {0, 0, -0.004};
    (void)settle(200);
    EXPECT_NEAR(renderer->last().force.z(), 0.4, 1e-9);
    ASSERT_TRUE(scene.set_material(ObjectId{0}, hard, 0.1));
    EXPECT_NEAR(settle(200), 1.6 / 100, 1e-9); // 1.6 N in 100 ticks
    EXPECT_NEAR(renderer->last().force.z(), 2, 1e-9);
}

TEST(MaterialChange, RefusesWhatIsNoMaterial)
{
    TouchScene scene(wide_room);
    ASSERT_TRUE(scene.add(body_of(*sample_mesh("cube")), at_place(Vec3::Zero())));
    constexpr double endless = std::numeric_limits<double>::infinity();
    SurfaceMaterial wrong = hard;
    wrong.dynamic_friction = 0.9;
    EXPECT_FALSE(scene.set_material(ObjectId{0}, wrong, 0));
    wrong = hard;
    wrong.stiffness = -1;
    EXPECT_FALSE(scene.set_material(ObjectId{0}, wrong, 0));
    wrong.stiffness = endless;
    EXPECT_FALSE(scene.set_material(ObjectId{0}, wrong, 0));
    EXPECT_FALSE(scene.set_material(ObjectId{0}, hard, -1));
    EXPECT_FALSE(scene.set_material(ObjectId{0}, hard, endless));
    (void)scene.advance(tick_seconds);
    EXPECT_FALSE(moving_surface(scene).material(scene_triangle(ObjectId{0}, TriangleId{0})));
    // A body without a material gets the given one at once.
    ASSERT_TRUE(scene.set_material(ObjectId{0}, hard, 1));
    (void)scene.advance(tick_seconds);
    EXPECT_EQ(stiffness_of(scene), 500);
}

} // namespace
} // namespace proxima::material_change_test
