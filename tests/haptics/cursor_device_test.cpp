#include "haptics/device/cursor_device.h"

#include "counted_allocations.h"
#include "proxima/device.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <limits>
#include <thread>

namespace proxima::cursor_device_test {
namespace {

TEST(CursorDevice, FollowsAJumpingCursorSmoothly)
{
    CursorDevice cursor;
    const Vec3 target(0.05, -0.02, 0.01);
    cursor.move_to(target, 1);
    const double pull = 2.69 / 0.02;
    DeviceReading last = cursor.read();
    for (int tick = 2; tick <= 300; ++tick) {
        const DeviceReading reading = cursor.read();
        // The step's answer, in closed form.
        const double t = tick * 1e-3;
        const Vec3 wanted = target * (1 - (1 + pull * t) * std::exp(-pull * t));
        EXPECT_LT((reading.state.pose.translation - wanted).norm(), 1e-12) << tick;
        const Vec3 way = reading.state.pose.translation - last.state.pose.translation;
        EXPECT_LT(way.norm(), 0.0035); // of 54.8 mm at once
        EXPECT_EQ(reading.sample, last.sample + 1);
        EXPECT_EQ(reading.state.buttons, 1U);
        EXPECT_EQ(reading.state.condition, InputCondition::well);
        if (tick == 20) {
            EXPECT_NEAR((reading.state.pose.translation - target).norm(), 0.25 * target.norm(),
                        0.001);
        }
        last = reading;
    }
    EXPECT_LT((last.state.pose.translation - target).norm(), 1e-9);
    EXPECT_LT(last.state.velocity.norm(), 1e-7);
}

TEST(CursorDevice, ReportsTheVelocityOfItsMotion)
{
    CursorDevice fine({.tick_seconds = 1e-6});
    fine.move_to(Vec3(0.1, 0, 0));
    Vec3 before = fine.read().state.pose.translation;
    for (int tick = 0; tick < 50000; ++tick) {
        const DeviceReading reading = fine.read();
        const Vec3 difference = (reading.state.pose.translation - before) / 1e-6;
        EXPECT_NEAR(difference.x(), reading.state.velocity.x(), 1.5e-3);
        before = reading.state.pose.translation;
    }
}

TEST(CursorDevice, IsPlacedAtOnceAndFollowsAtOnceWithoutDelay)
{
    CursorDevice cursor;
    cursor.place_at(Vec3(0.03, 0, 0));
    EXPECT_EQ(cursor.read().state.pose.translation, Vec3(0.03, 0, 0));
    EXPECT_EQ(cursor.read().state.velocity, Vec3::Zero());
    CursorDevice stiff({.follow_seconds = 0});
    stiff.move_to(Vec3(0.001, 0, 0));
    const DeviceReading reading = stiff.read();
    EXPECT_EQ(reading.state.pose.translation, Vec3(0.001, 0, 0));
    EXPECT_NEAR(reading.state.velocity.x(), 1, 1e-12);
}

TEST(CursorDevice, IgnoresPositionsThatAreNotFinite)
{
    CursorDevice cursor;
    cursor.place_at(Vec3(0.01, 0, 0));
    cursor.move_to(Vec3(std::numeric_limits<double>::quiet_NaN(), 0, 0));
    cursor.place_at(Vec3(0, std::numeric_limits<double>::infinity(), 0));
    for (int tick = 0; tick < 10; ++tick)
        EXPECT_EQ(cursor.read().state.pose.translation, Vec3(0.01, 0, 0));
}

TEST(CursorDevice, HandsOverBetweenThreadsWithoutAllocating)
{
    CursorDevice cursor;
    std::atomic<bool> ended{false};
    std::atomic<int> moves{0};
    std::thread window([&] {
        std::uint64_t ticks = 0;
        while (!ended.load()) {
            const int move = moves.fetch_add(1);
            cursor.move_to(Vec3(0.05 * std::sin(0.001 * move), 0, 0));
            const CursorFeedback& feedback = cursor.feedback();
            EXPECT_GE(feedback.ticks, ticks);
            // What was written in one tick is seen together.
            EXPECT_EQ(feedback.force, -100 * feedback.position);
            ticks = feedback.ticks;
        }
    });
    while (moves.load() == 0) std::this_thread::yield();
    const std::size_t before = testing::allocation_count();
    const ServoStatistics seen =
        cursor.run({.ticks = 20000, .pace = Pace::unpaced}, [&](std::uint64_t) noexcept {
            const DeviceReading reading = cursor.read();
            cursor.write({.force = -100 * reading.state.pose.translation});
            return Flow::proceed;
        });
    const std::size_t after = testing::allocation_count();
    ended.store(true);
    window.join();
    EXPECT_EQ(seen.ticks, 20000U);
    EXPECT_EQ(before, after);
    EXPECT_EQ(cursor.feedback().ticks, 20000U);
}

} // namespace
} // namespace proxima::cursor_device_test
