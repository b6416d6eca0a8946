// A cube that a device touches, watched tick by tick.
#pragma once

#include "counted_allocations.h"
#include "haptics/force/surface_renderer.h"
#include "haptics/loop/recording.h"
#include "haptics/surface/contact_surface.h"
#include "lab/quality_report.h"
#include "lab/simulated_hand.h"
#include "proxima/device.h"
#include "proxima/haptic_renderer.h"
#include "proxima/sample_meshes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <vector>

namespace proxima::testing {

inline constexpr double session_tick = 1e-3;

/// The cube, within the workspace of a device.
struct CubeScene {
    explicit CubeScene(double workspace_radius = 0.1)
        : mesh(*sample_mesh("cube")), surface(mesh),
          map(fit_workspace(bounding_box(mesh), workspace_radius)),
          half(0.5 * bounding_box(mesh).extent().x() / map.units_per_metre)
    {}
    TriangleMesh mesh;
    MeshContactSurface surface;
    WorkspaceMap map;
    double half; ///< of an edge, m of the device
};

/// What a session measured.
struct SessionResult {
    Recording recording;
    InputReport input;
    QualityReport quality;
    ServoStatistics servo;
    std::vector<double> forces; ///< N, a tick each
};

/// Touches the cube. In every tick the force is finite, within the device's limit and no faster
/// than the slew limit; nothing is allocated; and replaying the recording has the same bits.
inline SessionResult run_session(const CubeScene& scene, Device& device, std::uint64_t ticks,
                                 InputOptions options = {},
                                 const std::function<void(std::uint64_t, DeviceInput&)>& watch = {},
                                 Pace pace = Pace::unpaced)
{
    const DeviceLimits limits = device.info().limits;
    HapticRenderer renderer = make_surface_renderer(scene.surface, scene.map, limits);
    QualityMeter meter(scene.surface, scene.map);
    DeviceInput input = make_device_input(device.info(), options).value();
    SessionResult session;
    session.recording.ticks.resize(ticks);
    session.forces.resize(ticks);
    std::uint64_t bad = 0;
    std::size_t allocated = 0;
    Vec3 before = Vec3::Zero();
    const double step = renderer.options().force.max_slew * session_tick * (1 + 1e-9);
    std::uint64_t count = 0;
    session.servo = device.run({.ticks = ticks, .pace = pace}, [&](std::uint64_t tick) noexcept {
        const std::size_t before_tick = allocation_count();
        const DeviceState& state = input.accept(device.read());
        const RenderTick& result = renderer.tick(state, session_tick);
        device.write(input.command(renderer));
        allocated += allocation_count() - before_tick;
        const Vec3 force = result.force;
        // A jump that the renderer itself finds begins anew, from nothing.
        const bool steady = (force - before).norm() <= step || result.fault == InputFault::jumped;
        const bool right = force.allFinite() && force.norm() <= limits.max_force && steady;
        bad += right ? 0U : 1U;
        before = force;
        session.recording.ticks[tick] =
            recorded(static_cast<double>(tick) * session_tick, state, result);
        session.forces[tick] = force.norm();
        meter.add(result, state.velocity, renderer.path());
        if (watch) watch(tick, input);
        ++count;
        return Flow::proceed;
    });
    session.recording.ticks.resize(count);
    session.forces.resize(count);
    EXPECT_EQ(bad, 0U);
    EXPECT_EQ(allocated, 0U);
    session.input = input.report();
    session.quality = meter.report();
    session.recording.settings.render = renderer.options();
    session.recording.settings.map = scene.map;
    HapticRenderer again = make_surface_renderer(scene.surface, scene.map, limits);
    EXPECT_EQ(count_differences(session.recording, again), 0U);
    return session;
}

/// A hand that presses onto the cube's upper face and stays, trembling as hands do, and what a test
/// does to its readings.
class PressingDevice final : public Device {
public:
    using Change = std::function<void(std::uint64_t tick, DeviceReading& reading)>;

    explicit PressingDevice(const CubeScene& scene, Change change = {}, const HandModel& hand = {})
        : change_(std::move(change)), target_(0, 0, scene.half - 0.015),
          hand_(hand, Vec3(0, 0, scene.half + 0.01))
    {
        info_.limits = *find_device("omni");
    }
    [[nodiscard]] const DeviceInfo& info() const noexcept override { return info_; }
    [[nodiscard]] DeviceInfo& info() noexcept { return info_; }
    [[nodiscard]] DeviceReading read() noexcept override
    {
        DeviceReading reading{hand_.state(), ++sample_};
        if (change_) change_(tick_, reading);
        sample_ = reading.sample;
        return reading;
    }
    void write(const DeviceCommand& command) noexcept override
    {
        ++tick_;
        const double phase = 0.07 * static_cast<double>(tick_);
        hand_.step(command.force, target_ + 2e-5 * Vec3(std::sin(phase), std::cos(phase), 0));
    }

private:
    Change change_;
    Vec3 target_;
    SimulatedHand hand_;
    DeviceInfo info_;
    std::uint64_t sample_ = 0;
    std::uint64_t tick_ = 0;
};

} // namespace proxima::testing
