#include "haptics/device/button_queue.h"
#include "haptics/device/velocity_bounds.h"
#include "haptics/device_session.h"
#include "haptics/scenes_to_touch.h"
#include "proxima/device.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <thread>
#include <vector>

namespace proxima::device_input_test {
namespace {

using testing::CubeScene;
using testing::PressingDevice;
using testing::run_session;
using testing::SessionResult;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr std::uint64_t ticks = 2500;
constexpr std::uint64_t fault_begin = 1000;
constexpr std::uint64_t fault_end = 1500;
/// After the patience of 20 ms and the fading of 50 ms nothing is left.
constexpr std::uint64_t faded = fault_begin + 75;

/// Touches with a fault from fault_begin up to fault_end, and looks at the force around it.
SessionResult with_fault(const PressingDevice::Change& fault, std::uint64_t fades_by = faded,
                         const InputOptions& options = {})
{
    const CubeScene scene;
    PressingDevice device(scene, [&](std::uint64_t tick, DeviceReading& reading) {
        if (tick >= fault_begin && tick < fault_end) fault(tick, reading);
    });
    SessionResult session = run_session(scene, device, ticks, options);
    EXPECT_GT(session.forces[fault_begin - 1], 1.0);
    for (std::uint64_t tick = fades_by; tick < fault_end; ++tick) {
        EXPECT_EQ(session.forces[tick], 0) << tick;
        if (session.forces[tick] != 0) break;
    }
    EXPECT_GT(session.forces[ticks - 1], 1.0);
    EXPECT_EQ(session.input.recoveries, 1U);
    EXPECT_LT(session.input.longest_recovery, 1.2 * ForceOptions{}.loss_seconds);
    return session;
}

TEST(DeviceInput, CommandsAreOfTheMaterialThatIsTouched)
{
    const SurfaceMaterial ice = {
        .stiffness = 100, .damping = 0, .static_friction = 0, .dynamic_friction = 0};
    const SurfaceMaterial steel = {
        .stiffness = 5000, .damping = 50, .static_friction = 0.8, .dynamic_friction = 0.2};
    const DeviceLimits omni = *find_device("omni");
    const RenderOptions options{.force = {.start_seconds = 0}, .guard = Guard::off};
    for (const SurfaceMaterial& material : {ice, steel}) {
        TouchScene scene(testing::wide_room);
        ASSERT_TRUE(scene.add(
            testing::body_of(testing::box_mesh(Vec3(0.5, 0.5, 0.1)), {.material = material}),
            testing::at_place(Vec3(0, 0, -0.1))));
        HapticRenderer renderer = make_haptic_renderer(scene, {}, omni, options).value();
        DeviceInput input = make_device_input({}).value();
        DeviceReading reading;
        const auto command_at = [&](double z) {
            ++reading.sample;
            reading.state.pose.translation = Vec3(0.01, 0.02, z);
            renderer.tick(input.accept(reading), 1e-3);
            return input.command(renderer);
        };
        const DeviceCommand free = command_at(0.002);
        EXPECT_EQ(free.stiffness, options.force.stiffness);
        EXPECT_EQ(free.static_friction, options.static_friction);
        command_at(-0.001);
        const DeviceCommand held = command_at(-0.001);
        const double stiffness = std::min(material.stiffness, omni.max_stiffness);
        EXPECT_NEAR(renderer.last().spring.z(), stiffness * 0.001, 1e-3);
        EXPECT_EQ(held.stiffness, stiffness);
        EXPECT_EQ(held.damping, std::min(material.damping, omni.max_damping));
        EXPECT_EQ(held.static_friction, material.static_friction);
        EXPECT_EQ(held.dynamic_friction, material.dynamic_friction);
    }
}

TEST(DeviceInput, PassesAGoodHandUnchanged)
{
    const CubeScene scene;
    PressingDevice device(scene);
    const SessionResult session = run_session(scene, device, ticks);
    EXPECT_EQ(session.input.samples, ticks);
    EXPECT_EQ(session.input.faulty_ticks, 0U);
    EXPECT_EQ(session.quality.faulty_ticks, 0U);
    EXPECT_EQ(session.quality.passes, 0U);
    EXPECT_NEAR(session.forces.back(), 150 * (0.015 - session.forces.back() / 500), 0.01);
}

TEST(DeviceInput, FadesTheForceOnPositionsThatAreNotFinite)
{
    for (const double wrong : {nan, std::numeric_limits<double>::infinity(), 1e300, -11.0}) {
        const SessionResult session = with_fault([&](std::uint64_t tick, DeviceReading& reading) {
            reading.state.pose.translation[static_cast<int>(tick % 3)] = wrong;
        });
        EXPECT_EQ(session.input.not_finite, fault_end - fault_begin);
        EXPECT_EQ(session.input.faulty_ticks, fault_end - fault_begin);
        EXPECT_EQ(session.quality.faulty_ticks, session.input.faulty_ticks);
        EXPECT_NEAR(session.input.longest_fault, 0.5, 1e-9);
    }
}

TEST(DeviceInput, TreatsVelocitiesThatAreNotFiniteAsRest)
{
    const CubeScene scene;
    PressingDevice device(scene, [](std::uint64_t, DeviceReading& reading) {
        reading.state.velocity = Vec3(nan, 0, nan);
    });
    const SessionResult session = run_session(scene, device, ticks);
    EXPECT_EQ(session.input.faulty_ticks, 0U);
    EXPECT_GT(session.forces.back(), 1.0);
}

/// The largest change of the force between two ticks, N, from a tick on.
double largest_step(const SessionResult& session, std::size_t from)
{
    double largest = 0;
    for (std::size_t i = from; i < session.recording.ticks.size(); ++i) {
        const auto& a = session.recording.ticks[i - 1].force;
        const auto& b = session.recording.ticks[i].force;
        largest = std::max(largest, std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]));
    }
    return largest;
}

TEST(DeviceInput, IgnoresVelocitiesThatContradictPositions)
{
    const CubeScene scene;
    PressingDevice plausible(scene);
    const SessionResult good = run_session(scene, plausible, ticks);
    EXPECT_EQ(good.input.velocities, 0U);
    const double most = largest_step(good, fault_begin) + 0.05;
    EXPECT_LT(most, 0.1);
    std::mt19937_64 random(4);
    using Wrong = std::function<void(std::uint64_t, Vec3&)>;
    const std::vector<Wrong> wrongs = {
        [](std::uint64_t tick, Vec3& v) {
            if (tick % 100 == 0) v.z() = -1000;
        },
        [](std::uint64_t, Vec3& v) { v *= 1000; }, // mm/s
        [](std::uint64_t tick, Vec3& v) { v.setConstant(tick % 2 == 0 ? 1e300 : -1e300); },
        [](std::uint64_t tick, Vec3& v) { v = Vec3(0, 0, tick % 2 == 0 ? nan : -50); },
        [&](std::uint64_t, Vec3& v) {
            v *= std::pow(10.0, static_cast<double>(random() % 12)) * (random() % 2 == 0 ? -1 : 1);
        }};
    for (std::size_t i = 0; i < wrongs.size(); ++i) {
        PressingDevice device(scene, [&](std::uint64_t tick, DeviceReading& reading) {
            if (tick >= fault_begin) wrongs[i](tick, reading.state.velocity);
        });
        const SessionResult session = run_session(scene, device, ticks);
        EXPECT_GT(session.input.velocities, 10U) << i;
        EXPECT_EQ(session.input.faulty_ticks, 0U) << i;
        EXPECT_LE(largest_step(session, fault_begin), most) << i;
    }
}

TEST(DeviceInput, UsesPlausibleVelocities)
{
    // Exact and by differences, with and without an encoder, thrown about and hit against a wall.
    std::mt19937_64 random(8);
    std::uniform_real_distribution<double> unit(-1, 1);
    for (const VelocityEstimate estimate :
         {VelocityEstimate::exact, VelocityEstimate::backward_difference}) {
        for (const double step : {0.0, 1e-6, 2e-5, 5e-5}) {
            HandModel model;
            model.velocity = estimate;
            model.encoder_step = step;
            SimulatedHand hand(model, Vec3::Zero());
            VelocityBounds bounds;
            double fastest = 0;
            Vec3 target = Vec3::Zero();
            for (int tick = 0; tick < 20000; ++tick) {
                if (tick % 150 == 0) target = 0.1 * Vec3{unit(random), unit(random), unit(random)};
                const DeviceState state = hand.state();
                const double depth = std::max(-state.pose.translation.x(), 0.0);
                bounds.add(state.pose.translation, 1e-3);
                ASSERT_EQ(bounds.plausible(state.velocity), state.velocity)
                    << static_cast<int>(estimate) << ' ' << step << ' ' << tick;
                fastest = std::max(fastest, state.velocity.norm());
                hand.step(Vec3(std::min(1000 * depth, 8.0), 0, 0), target);
            }
            EXPECT_GT(fastest, 0.5);
        }
    }
}

TEST(DeviceInput, FadesTheForceWhenTheDeviceIsGone)
{
    const SessionResult session = with_fault([](std::uint64_t, DeviceReading& reading) {
        reading.state.condition = InputCondition::gone;
        reading.state.pose.translation.setConstant(nan);
    });
    EXPECT_EQ(session.input.losses, 1U);
    EXPECT_EQ(session.input.faulty_ticks, fault_end - fault_begin);
}

TEST(DeviceInput, ToleratesSilenceForItsPatience)
{
    const SessionResult session =
        with_fault([](std::uint64_t, DeviceReading& reading) { --reading.sample; });
    EXPECT_EQ(session.input.silences, 1U);
    // All but the patience of 20 ms, which ends between two ticks.
    EXPECT_NEAR(static_cast<double>(session.input.faulty_ticks), fault_end - fault_begin - 20, 1);
    // Less than the patience is no fault.
    const CubeScene scene;
    PressingDevice device(scene, [](std::uint64_t tick, DeviceReading& reading) {
        if (tick % 19 != 0) --reading.sample;
    });
    EXPECT_EQ(run_session(scene, device, ticks).input.faulty_ticks, 0U);
}

TEST(DeviceInput, FadesTheForceWhenADeviceFreezesForWhichThatIsImpossible)
{
    DeviceState frozen;
    const auto freeze = [&](std::uint64_t tick, DeviceReading& reading) {
        if (tick == fault_begin) frozen = reading.state;
        reading.state = frozen;
    };
    const SessionResult session = with_fault(
        freeze, faded + 100, {.stillness = Stillness::impossible, .frozen_seconds = 0.1});
    EXPECT_EQ(session.input.suspicions, 1U);
    EXPECT_EQ(session.input.freezes, 1U);
    // All but the 100 ms before it counts as frozen.
    EXPECT_NEAR(static_cast<double>(session.input.faulty_ticks), fault_end - fault_begin - 100, 1);
    // Away from the surface nothing pushes.
    const CubeScene scene;
    PressingDevice device(scene, [&](std::uint64_t, DeviceReading& reading) {
        reading.state.pose.translation = Vec3(0, 0, scene.half + 0.002);
    });
    device.info().stillness = Stillness::impossible;
    EXPECT_EQ(run_session(scene, device, ticks).input.suspicions, 0U);
}

TEST(DeviceInput, KeepsTheForceOfAHandThatHoldsStill)
{
    // New samples that repeat the last one, for two seconds and twice: the declaration of the device,
    // or the option in its place, decides what is reported. Neither takes the force.
    const CubeScene scene;
    const auto still = [&](std::uint64_t tick, DeviceReading& reading) {
        const double depth = tick < 100 ? -0.002 : tick > 1200 && tick < 1250 ? 0.0021 : 0.002;
        reading.state.pose.translation = Vec3(0, 0, scene.half - depth);
        reading.state.velocity = Vec3::Zero();
    };
    for (const Stillness declared : {Stillness::usual, Stillness::suspicious}) {
        for (const bool option : {false, true}) {
            PressingDevice device(scene, still);
            device.info().stillness = option ? Stillness::impossible : declared;
            InputOptions options;
            if (option) options.stillness = declared;
            const SessionResult session = run_session(scene, device, ticks, options);
            EXPECT_EQ(session.input.suspicions, declared == Stillness::usual ? 0U : 2U) << option;
            EXPECT_EQ(session.input.freezes, 0U);
            EXPECT_EQ(session.input.faulty_ticks, 0U);
            for (std::uint64_t tick = 300; tick < ticks; ++tick)
                ASSERT_NEAR(session.forces[tick], 1.0, 0.06) << tick;
        }
    }
}

TEST(DeviceInput, KeepsTheForceThroughTheFrictionOfADevice)
{
    // Dry friction and an encoder hold the device on one position for seconds at a time.
    const CubeScene scene;
    HandModel model;
    model.coulomb_friction = 0.05;
    model.encoder_step = 5e-5;
    PressingDevice device(scene, {}, model);
    const SessionResult session = run_session(scene, device, 17000);
    EXPECT_GE(session.input.suspicions, 1U);
    EXPECT_EQ(session.input.faulty_ticks, 0U);
    for (std::size_t tick = 1000; tick < session.forces.size(); ++tick)
        ASSERT_GT(session.forces[tick], 1.0) << tick;
}

TEST(DeviceInput, DoesNotTrustAJumpOfAMetreAtOnce)
{
    // For 30 ms somewhere else: never accepted, and well when it is back.
    const CubeScene scene;
    PressingDevice device(scene, [](std::uint64_t tick, DeviceReading& reading) {
        if (tick >= fault_begin && tick < fault_begin + 30) reading.state.pose.translation.x() += 1;
    });
    const SessionResult session = run_session(scene, device, ticks);
    EXPECT_EQ(session.input.jumps, 1U);
    EXPECT_EQ(session.input.faulty_ticks, 30U);
    EXPECT_EQ(session.input.recoveries, 1U);
    for (const RecordedTick& tick : session.recording.ticks) EXPECT_LT(tick.position[0], 0.5);
}

TEST(DeviceInput, TrustsALastingJumpOnceTheForceIsZero)
{
    const CubeScene scene;
    PressingDevice device(scene, [](std::uint64_t tick, DeviceReading& reading) {
        if (tick >= fault_begin) reading.state.pose.translation.x() += 1;
    });
    const SessionResult session = run_session(scene, device, ticks);
    EXPECT_EQ(session.input.jumps, 1U);
    EXPECT_EQ(session.input.faulty_ticks, 100U); // settle_seconds
    EXPECT_GT(session.recording.ticks[fault_begin + 101].position[0], 0.9);
    EXPECT_EQ(session.forces[fault_begin + 60], 0); // before it is accepted
    EXPECT_EQ(session.forces[fault_begin + 100], 0);
}

TEST(DeviceInput, NeverTrustsADeviceThatKeepsJumping)
{
    const SessionResult session = with_fault([](std::uint64_t tick, DeviceReading& reading) {
        reading.state.pose.translation.x() += tick % 2 == 0 ? 1.0 : -1.0;
    });
    EXPECT_EQ(session.input.jumps, fault_end - fault_begin);
}

/// Ticks of exactly representable lengths, and jumps of more than half a metre.
InputOptions dyadic_options()
{
    return {.tick_seconds = 0x1p-10, .max_jump = 0.5, .settle_seconds = 4 * 0x1p-10};
}

/// The next good sample of a device, at x.
InputCondition accept_at(DeviceInput& input, double x)
{
    static std::uint64_t sample = 0;
    DeviceReading reading;
    reading.sample = ++sample;
    reading.state.pose.translation = Vec3(x, 0, 0);
    return input.accept(reading).condition;
}

TEST(DeviceInput, TrustsAJumpWhenItHasLastedForTheSettlingTimeExactly)
{
    DeviceInput input = make_device_input({}, dyadic_options()).value();
    EXPECT_EQ(accept_at(input, 0), InputCondition::well);
    // The sample that jumps, and those of less than four ticks after it.
    for (int i = 0; i < 4; ++i) EXPECT_EQ(accept_at(input, 2), InputCondition::unsure) << i;
    EXPECT_EQ(accept_at(input, 2), InputCondition::well);
    EXPECT_EQ(input.state().pose.translation.x(), 2);
    InputOptions at_once = dyadic_options();
    at_once.settle_seconds = 0;
    DeviceInput trusting = make_device_input({}, at_once).value();
    EXPECT_EQ(accept_at(trusting, 0), InputCondition::well);
    EXPECT_EQ(accept_at(trusting, 2), InputCondition::well);
}

TEST(DeviceInput, MovesOfTheLargestJumpAreNoJumps)
{
    DeviceInput input = make_device_input({}, dyadic_options()).value();
    EXPECT_EQ(accept_at(input, 0), InputCondition::well);
    EXPECT_EQ(accept_at(input, 0.5), InputCondition::well);
    // Nor do they end the agreement of samples after a jump.
    for (int i = 0; i < 4; ++i)
        EXPECT_EQ(accept_at(input, i % 2 == 0 ? 2 : 2.5), InputCondition::unsure) << i;
    EXPECT_EQ(accept_at(input, 2), InputCondition::well);
    EXPECT_EQ(input.report().jumps, 1U);
}

TEST(DeviceInput, HasNoPositionBeforeTheFirstGoodSample)
{
    DeviceInput input = make_device_input({}).value();
    const auto is_nowhere = [&] { return input.state().pose.translation.array().isNaN().all(); };
    EXPECT_TRUE(is_nowhere());
    EXPECT_EQ(accept_at(input, nan), InputCondition::unsure);
    EXPECT_TRUE(is_nowhere());
    EXPECT_EQ(accept_at(input, 0.25), InputCondition::well);
    EXPECT_EQ(input.state().pose.translation, Vec3(0.25, 0, 0));
}

TEST(DeviceInput, TouchesNothingBeforeTheFirstGoodSample)
{
    const CubeScene scene;
    PressingDevice device(scene, [](std::uint64_t tick, DeviceReading& reading) {
        if (tick < 300) reading.sample = 0;
        if (tick >= 300 && tick < 600) reading.state.pose.translation.setConstant(nan);
    });
    const SessionResult session = run_session(scene, device, ticks);
    for (std::uint64_t tick = 0; tick < 600; ++tick) EXPECT_EQ(session.forces[tick], 0) << tick;
    EXPECT_EQ(session.input.silences, 0U);
    EXPECT_EQ(session.input.faulty_ticks, 600U);
    EXPECT_NEAR(session.input.longest_fault, 0.6, 1e-9);
}

/// A device that is moved along a path and feels nothing.
class LedDevice final : public Device {
public:
    explicit LedDevice(std::function<DeviceState(std::uint64_t)> path) : path_(std::move(path))
    {
        info_.limits = *find_device("omni");
        info_.stillness = Stillness::usual;
    }
    [[nodiscard]] const DeviceInfo& info() const noexcept override { return info_; }
    [[nodiscard]] DeviceReading read() noexcept override { return {path_(tick_), tick_ + 1}; }
    void write(const DeviceCommand& command) noexcept override
    {
        last_ = command;
        ++tick_;
    }
    [[nodiscard]] const DeviceCommand& last() const { return last_; }

private:
    std::function<DeviceState(std::uint64_t)> path_;
    DeviceInfo info_;
    DeviceCommand last_;
    std::uint64_t tick_ = 0;
};

TEST(DeviceInput, ClutchMovesTheHandWithoutTheTool)
{
    // Down onto the cube, clutch and up by 30 mm, clutch closed and down by 30 mm again: twice.
    const CubeScene scene;
    LedDevice device([&](std::uint64_t tick) {
        DeviceState state;
        const double part = static_cast<double>(tick % 600) / 600;
        const bool open = part >= 0.5;
        const double height = open ? part - 0.75 : 0.25 - part; // in [-0.25, 0.25]
        state.pose.translation = Vec3(0.01, 0, scene.half + 0.06 + 0.12 * height);
        state.buttons = open ? 2 : 0;
        return state;
    });
    std::vector<double> heights;
    const SessionResult session = run_session(
        scene, device, 1200, {.clutch_buttons = 2}, [&](std::uint64_t, DeviceInput& input) {
            heights.push_back(input.state().pose.translation.z());
        });
    EXPECT_EQ(session.input.clutched_ticks, 600U);
    EXPECT_EQ(session.input.faulty_ticks, 0U);
    EXPECT_EQ(session.quality.faulty_ticks, 0U);
    for (std::size_t tick = 1; tick < heights.size(); ++tick)
        EXPECT_LT(std::abs(heights[tick] - heights[tick - 1]), 0.0005) << tick;
    for (std::size_t tick = 300; tick < 600; ++tick) EXPECT_EQ(heights[tick], heights[300]);
    EXPECT_NEAR(heights[599], scene.half + 0.03, 0.0005);
    EXPECT_NEAR(heights[1199], scene.half - 0.03, 0.001); // 60 mm down with 60 mm of hand
}

TEST(DeviceInput, TurnsAxesInBothDirections)
{
    // Our z is the device's y: pressing along -y of the device touches the upper face.
    Mat3 rotation;
    rotation << 1, 0, 0, 0, 0, -1, 0, 1, 0;
    const CubeScene scene;
    LedDevice device([&](std::uint64_t tick) {
        DeviceState state;
        const double height = std::max(0.01 - 1e-5 * static_cast<double>(tick), -0.003);
        state.pose.translation = Vec3(0.004, scene.half + height, -0.002);
        state.velocity = Vec3(0, height > -0.003 ? -0.01 : 0, 0);
        return state;
    });
    const SessionResult session = run_session(scene, device, 3000, {.rotation = rotation});
    const RecordedTick& last = session.recording.ticks.back();
    EXPECT_NEAR(last.position[0], 0.004, 1e-12);
    EXPECT_NEAR(last.position[1], 0.002, 1e-12);
    EXPECT_NEAR(last.position[2], scene.half - 0.003, 1e-12);
    EXPECT_NEAR(last.force[2], 1.5, 1e-6);
    const DeviceCommand& command = device.last();
    EXPECT_NEAR(command.force.y(), 1.5, 1e-6);
    EXPECT_LT(std::hypot(command.force.x(), command.force.z()), 1e-6);
    ASSERT_EQ(command.plane_count, 1U);
    EXPECT_NEAR(command.planes[0].normal.y(), 1, 1e-9);
    EXPECT_NEAR(command.planes[0].offset, scene.half, 1e-6);
    EXPECT_EQ(command.stiffness, 500);
    EXPECT_EQ(command.force_scale, 1);
}

TEST(DeviceInput, ReleaseFadesTheForceForGood)
{
    const CubeScene scene;
    PressingDevice device(scene);
    const SessionResult session =
        run_session(scene, device, ticks, {}, [](std::uint64_t tick, DeviceInput& input) {
            if (tick == fault_begin) input.release();
        });
    EXPECT_GT(session.forces[fault_begin], 1.0);
    for (std::uint64_t tick = fault_begin + 55; tick < ticks; ++tick)
        EXPECT_EQ(session.forces[tick], 0);
    EXPECT_EQ(session.input.faulty_ticks, 0U);
}

TEST(DeviceInput, ADeviceThatEndsTheSessionIsNoFault)
{
    const CubeScene scene;
    PressingDevice device(scene, [](std::uint64_t tick, DeviceReading& reading) {
        if (tick < fault_begin) return;
        reading.state.condition = InputCondition::released; // and nothing new after that
        reading.sample = fault_begin;
    });
    const SessionResult session = run_session(scene, device, ticks);
    EXPECT_GT(session.forces[fault_begin - 1], 1.0);
    for (std::uint64_t tick = faded; tick < ticks; ++tick) EXPECT_EQ(session.forces[tick], 0);
    EXPECT_EQ(session.input.faulty_ticks, 0U);
    EXPECT_EQ(session.input.losses + session.input.silences, 0U);
    EXPECT_EQ(session.quality.faulty_ticks, 0U);
}

TEST(DeviceInput, HandsOverButtonEventsInOrder)
{
    const CubeScene scene;
    LedDevice device([](std::uint64_t tick) {
        DeviceState state;
        state.pose.translation = Vec3(0, 0, 0.2);
        state.buttons = tick >= 10 && tick < 20 ? 1U : 0U;
        state.buttons |= tick >= 15 ? 0x80000000U : 0U;
        return state;
    });
    std::vector<ButtonEvent> events;
    run_session(scene, device, 30, {}, [&](std::uint64_t, DeviceInput& input) {
        while (const auto event = input.next_button_event()) events.push_back(*event);
    });
    const std::vector<ButtonEvent> wanted = {{10, 0, true}, {15, 31, true}, {20, 0, false}};
    EXPECT_EQ(events, wanted);
}

TEST(ButtonQueue, DropsTheNewestEventsWhenNobodyReads)
{
    ButtonQueue queue;
    for (std::uint64_t i = 0; i < ButtonQueue::capacity + 7; ++i)
        EXPECT_EQ(queue.push({i, 0, true}), i < ButtonQueue::capacity);
    EXPECT_EQ(queue.dropped(), 7U);
    for (std::uint64_t i = 0; i < ButtonQueue::capacity; ++i) {
        const auto event = queue.pop();
        ASSERT_TRUE(event);
        EXPECT_EQ(event->tick, i);
    }
    EXPECT_FALSE(queue.pop());
}

TEST(ButtonQueue, LosesNoEventBetweenThreads)
{
    ButtonQueue queue;
    constexpr std::uint64_t count = 100000;
    std::thread pusher([&] {
        for (std::uint64_t i = 0; i < count;) {
            if (queue.push({i, static_cast<int>(i % 32), i % 2 == 0})) {
                ++i;
            } else {
                std::this_thread::yield();
            }
        }
    });
    for (std::uint64_t i = 0; i < count;) {
        const auto event = queue.pop();
        if (!event) {
            std::this_thread::yield();
            continue;
        }
        const ButtonEvent wanted{i, static_cast<int>(i % 32), i % 2 == 0};
        ASSERT_EQ(*event, wanted);
        ++i;
    }
    pusher.join();
}

/// The next sample of a device that moves as fast as it says.
void go_on(DeviceReading& reading)
{
    ++reading.sample;
    reading.state.pose.translation += 1e-3 * reading.state.velocity;
}

/// Moves on for some ticks.
void lead(DeviceInput& input, DeviceReading& reading)
{
    for (int tick = 0; tick < 20; ++tick) {
        go_on(reading);
        (void)input.accept(reading);
    }
}

TEST(DeviceInput, TurnsVelocitiesAndRotations)
{
    // Our y is the device's -z, and our z its y.
    Mat3 turn;
    turn << 1, 0, 0, 0, 0, -1, 0, 1, 0;
    DeviceInput input = make_device_input({}, {.rotation = turn}).value();
    DeviceReading reading;
    reading.state.pose.rotation = Eigen::AngleAxisd(0.5, Vec3::UnitZ()).toRotationMatrix();
    reading.state.velocity = Vec3(0.3, 0.1, -0.2);
    lead(input, reading);
    EXPECT_LT((input.state().velocity - Vec3(0.3, 0.2, 0.1)).norm(), 1e-12);
    const Mat3& rotation = input.state().pose.rotation;
    const Vec3 tip_x(std::cos(0.5), 0, std::sin(0.5));
    EXPECT_LT((rotation * Vec3::UnitX() - tip_x).norm(), 1e-12);
    EXPECT_LT((rotation * Vec3::UnitZ() + Vec3::UnitY()).norm(), 1e-12);
}

TEST(DeviceInput, FaultsAndClutchesEndTheVelocity)
{
    struct End {
        InputCondition condition;
        std::function<void(DeviceReading&)> change;
    };
    const std::vector<End> ends = {
        {InputCondition::gone,
         [](DeviceReading& reading) { reading.state.condition = InputCondition::gone; }},
        {InputCondition::unsure,
         [](DeviceReading& reading) { reading.state.pose.translation.x() = nan; }},
        {InputCondition::unsure,
         [](DeviceReading& reading) { reading.state.pose.translation.x() += 1; }},
        {InputCondition::silent, [](DeviceReading& reading) { --reading.sample; }},
        {InputCondition::clutched, [](DeviceReading& reading) { reading.state.buttons = 2; }}};
    for (const End& end : ends) {
        DeviceInput input = make_device_input({}, {.clutch_buttons = 2}).value();
        DeviceReading reading;
        reading.state.velocity = Vec3(0, 0.1, 0);
        lead(input, reading);
        EXPECT_EQ(input.state().velocity, Vec3(0, 0.1, 0));
        for (int tick = 0; tick < 30; ++tick) { // longer than its patience
            go_on(reading);
            end.change(reading);
            (void)input.accept(reading);
        }
        EXPECT_EQ(input.state().condition, end.condition);
        EXPECT_EQ(input.state().velocity, Vec3::Zero()) << static_cast<int>(end.condition);
    }
}

TEST(DeviceInput, CommandsHaveWhatTheGuardAdds)
{
    // A wall that swings until it is damped, or so fast that it is softened.
    for (const bool is_fast : {false, true}) {
        const CubeScene scene;
        HapticRenderer renderer =
            make_surface_renderer(scene.surface, scene.map, *find_device("omni"));
        DeviceInput input = make_device_input({}).value();
        DeviceReading reading;
        DeviceCommand command;
        for (int tick = 0; tick < 1500; ++tick) {
            const double swing =
                is_fast ? 1e-3 * std::sin(0.9 * tick) : 5e-4 * std::sin(0.2 * tick);
            const double z = tick < 300 ? 0.002 : swing - 0.001;
            ++reading.sample;
            reading.state.pose.translation = Vec3(0, 0, scene.half + z);
            renderer.tick(input.accept(reading), 1e-3);
            command = input.command(renderer);
        }
        const PassivityGuard& guard = parts_of(renderer).passivity();
        EXPECT_GT(guard.added_damping(), 0.1);
        EXPECT_EQ(guard.softness() < 1, is_fast);
        EXPECT_NEAR(command.stiffness, guard.softness() * 500, 1e-9);
        EXPECT_NEAR(command.damping, guard.softness() * 1 + guard.added_damping(), 1e-12);
    }
}

} // namespace
} // namespace proxima::device_input_test
