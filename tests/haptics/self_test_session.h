// Self-tests of devices, watched tick by tick.
#pragma once

#include "counted_allocations.h"
#include "haptics/device/self_test_report.h"
#include "lab/self_test_hand.h"
#include "proxima/device.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <functional>
#include <utility>

namespace proxima::testing {

/// A simulated hand and device, and what a test does to its readings and to the forces on it.
class ChangedHand final : public Device {
public:
    using ChangeReading = std::function<void(std::uint64_t tick, DeviceReading& reading)>;
    using ChangeForce = std::function<Vec3(std::uint64_t tick, const Vec3& force)>;

    explicit ChangedHand(const HandModel& model, ChangeReading reading = {}, ChangeForce force = {},
                         const DeviceLimits& limits = *find_device("omni"))
        : hand_("hand", model, limits), reading_(std::move(reading)), force_(std::move(force))
    {}
    void follow(const SelfTest& test) noexcept { hand_.follow(test); }
    [[nodiscard]] const DeviceInfo& info() const noexcept override { return hand_.info(); }
    [[nodiscard]] DeviceReading read() noexcept override
    {
        DeviceReading reading = hand_.read();
        if (reading_) reading_(tick_, reading);
        return reading;
    }
    void write(const DeviceCommand& command) noexcept override
    {
        DeviceCommand changed = command;
        if (force_) changed.force = force_(tick_, command.force);
        hand_.write(changed);
        ++tick_;
    }

private:
    SelfTestHand hand_;
    ChangeReading reading_;
    ChangeForce force_;
    std::uint64_t tick_ = 0;
};

/// What is needed of a session, without waiting for a person.
inline SelfTestOptions quick_options()
{
    return {.wait_seconds = 1, .prepare_seconds = 0, .slow_seconds = 5, .fast_seconds = 2};
}

struct SelfTestSession {
    SelfTestReport report;
    SelfTestFault fault = SelfTestFault::none;
    bool finished = false;
    double largest_force = 0; ///< N
    std::uint64_t ticks = 0;
    std::uint64_t pushed_ticks = 0; ///< with a force
};

/// Runs a test to its end. In every tick the force is finite, along one axis, within the limit, and
/// zero while a person has the device; nothing is allocated; and the last force is zero.
template <class D>
SelfTestSession run_self_test(D& device, const SelfTestOptions& options = quick_options(),
                              const std::function<void(std::uint64_t, SelfTest&)>& watch = {},
                              Pace pace = Pace::unpaced)
{
    SelfTestSession session;
    auto test = SelfTest::make(device.info(), options);
    EXPECT_TRUE(test) << describe(test.error());
    if constexpr (requires { device.follow(*test); }) device.follow(*test);
    const double most = options.force_share * device.info().limits.max_force;
    std::uint64_t bad = 0;
    std::size_t allocated = 0;
    Vec3 last = Vec3::Zero();
    const auto begin = std::chrono::steady_clock::now();
    const ServoStatistics servo =
        device.run({.rate = 1 / options.tick_seconds, .ticks = 400000, .pace = pace},
                   [&](std::uint64_t tick) noexcept {
                       const std::size_t before = allocation_count();
                       const double seconds = pace == Pace::unpaced
                                                  ? static_cast<double>(tick) * options.tick_seconds
                                                  : std::chrono::duration<double>(
                                                        std::chrono::steady_clock::now() - begin)
                                                        .count();
                       const DeviceReading reading = device.read();
                       const DeviceCommand command = test->tick(reading, seconds, seconds);
                       device.write(command);
                       allocated += allocation_count() - before;
                       const Vec3& force = command.force;
                       const SelfTestStep step = test->step();
                       const bool motors = step == SelfTestStep::ramp || step == SelfTestStep::push;
                       const bool right = force.allFinite() && force.norm() <= most &&
                                          (force.array() != 0).count() <= 1 &&
                                          (motors || force.norm() == 0) && command.plane_count == 0;
                       bad += right ? 0U : 1U;
                       session.pushed_ticks += force.norm() > 0 ? 1U : 0U;
                       session.largest_force = std::max(session.largest_force, force.norm());
                       last = force;
                       if (watch) watch(tick, *test);
                       return test->has_ended() ? Flow::stop : Flow::proceed;
                   });
    EXPECT_EQ(bad, 0U);
    EXPECT_EQ(allocated, 0U);
    EXPECT_EQ(last.norm(), 0);
    session.ticks = servo.ticks;
    session.finished = test->has_ended();
    session.fault = test->fault();
    session.report = report_of(*test, device.info().limits);
    return session;
}

} // namespace proxima::testing
