// Stiffness and damping that a self-test suggests, held against walls in theory.
#include "haptics/device/self_test_report.h"
#include "haptics/known_device.h"
#include "haptics/theory_wall.h"

#include <gtest/gtest.h>

#include <utility>

namespace proxima::suggested_settings_test {
namespace {

using testing::device;
using testing::theory_swing;

MotionFit motion(double mass, const Fitted& damping, const Fitted& friction)
{
    return {.mass = {mass, 0}, .damping = damping, .friction = friction, .found = true};
}

TEST(SuggestedSettings, AreStableAndNearTheLimit)
{
    // Walls in theory, on devices that nobody holds: what is suggested calms down, and a third above
    // the limit by the delay oscillates.
    const DeviceLimits limits = *find_device("omega");
    for (const auto& [damping, delay] : {std::pair(0.2, 0), std::pair(0.2, 1), std::pair(0.2, 3),
                                         std::pair(1.0, 0), std::pair(1.0, 1), std::pair(1.0, 3)}) {
        HandModel model = device(0.15, damping, 0, 0, delay);
        model.hand_stiffness = model.hand_damping = 0;
        model.velocity = VelocityEstimate::exact;
        const SuggestedSettings settings =
            suggest_settings(limits, 1e-3, delay, motion(0.15, {damping, 0}, {}), 0);
        SCOPED_TRACE(::testing::Message() << damping << ' ' << delay << ": " << settings.stiffness
                                          << ' ' << settings.damping);
        EXPECT_GT(settings.stiffness, 0);
        EXPECT_LT(theory_swing(model, {settings.stiffness, settings.damping}, 20000), 1e-4);
        EXPECT_GT(theory_swing(model, {1.3 * settings.by_delay, settings.damping}, 20000), 1e-2);
        EXPECT_NEAR(settings.by_delay, (damping + settings.damping) / (1e-3 * (0.5 + delay)),
                    1e-9 * settings.by_delay);
    }
}

TEST(SuggestedSettings, FollowTheLimits)
{
    const DeviceLimits omni = *find_device("omni"); // 700 N/m, 5 N s/m
    // 2 f / D = 400 N/m, and its damping is limited by f T / D = 0.2 N s/m.
    const SuggestedSettings coarse =
        suggest_settings(omni, 1e-3, 0, motion(0.1, {0.5, 0.01}, {0.01, 1e-4}), 5e-5);
    EXPECT_NEAR(*coarse.by_encoder, 400, 1e-9);
    EXPECT_NEAR(*coarse.passive, 1000, 1e-9);
    EXPECT_NEAR(coarse.damping, 0.2, 1e-9);
    EXPECT_EQ(coarse.limit, StiffnessLimit::encoder);
    EXPECT_NEAR(coarse.stiffness, 320, 1e-9);
    // Nothing of the device's own is known: its damping counts as none.
    const SuggestedSettings unknown =
        suggest_settings(omni, 1e-3, 2, motion(0.1, {0.1, 0.1}, {}), 0);
    EXPECT_FALSE(unknown.passive);
    EXPECT_FALSE(unknown.by_encoder);
    EXPECT_NEAR(unknown.by_delay, unknown.damping / 2.5e-3, 1e-9);
    EXPECT_EQ(unknown.limit, StiffnessLimit::device); // with enough of the surface's damping
    EXPECT_EQ(unknown.stiffness, 700);
    EXPECT_NEAR(unknown.damping, 2.2, 1e-9); // 700 / 0.8 * 2.5 ms = 2.19
    // A delay that no damping makes up for.
    const SuggestedSettings late = suggest_settings(omni, 1e-3, 20, motion(10, {0.5, 0.01}, {}), 0);
    EXPECT_EQ(late.limit, StiffnessLimit::delay);
    EXPECT_EQ(late.damping, 5);
    EXPECT_NEAR(late.by_delay, 5.5 / 20.5e-3, 1e-9);
    EXPECT_NEAR(late.stiffness, 210, 1e-9); // 0.8 * 268.3
    // A light device, which late damping would drive.
    const SuggestedSettings light = suggest_settings(omni, 1e-3, 2, motion(0.01, {}, {}), 0);
    EXPECT_NEAR(light.damping, 1.2, 1e-9); // 0.3 * 0.01 / 2.5 ms
}

} // namespace
} // namespace proxima::suggested_settings_test
