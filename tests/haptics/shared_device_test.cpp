// The makers' libraries, by stubs that behave like them (stubs/).
#include "base/shared_library.h"
#include "code_of.h"
#include "haptics/device/dhd_device.h"
#include "haptics/device/hd_device.h"
#include "haptics/device_session.h"
#include "stubs/stub_hand.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <vector>

namespace proxima::shared_device_test {
namespace {

using testing::CubeScene;
using testing::run_session;
using testing::SessionResult;

/// The stub's own account: the library is the one that the device has open.
struct Stub {
    explicit Stub(const char* path)
        : library(*SharedLibrary::open({.what = "stub", .names = {}, .named = path, .advice = ""})),
          state(*static_cast<stub::State*>(library.find("stub_state")))
    {}
    SharedLibrary library;
    stub::State& state;
};

constexpr std::uint64_t ticks = 900;
constexpr std::uint64_t contact = 480; ///< the hand presses through the whole middle third

SessionResult touch_hd(const Stub& stub, Device& device, std::uint64_t count = ticks)
{
    const CubeScene scene(device.info().limits.workspace_radius);
    SessionResult session = run_session(scene, device, count);
    EXPECT_EQ(stub.state.bad_forces, 0);
    EXPECT_EQ(stub.state.forces_outside, 0);
    return session;
}

TEST(HdDevice, TouchesInTheCallbackOfTheDriver)
{
    Stub stub(STUB_HD);
    auto device = open_hd_device({.library = STUB_HD});
    ASSERT_TRUE(device) << describe(device.error());
    const DeviceInfo& info = (*device)->info();
    EXPECT_EQ(info.name, "hd");
    EXPECT_EQ(info.model, "Proxima's tests Stub Omni");
    EXPECT_EQ(info.serial, "S-0042");
    EXPECT_NE(info.driver.find("stub_hd"), std::string::npos);
    EXPECT_NE(info.driver.find("HD API 3.40, driver 1.2.3"), std::string::npos) << info.driver;
    EXPECT_EQ(info.limits.max_force, 3.3);
    EXPECT_NEAR(info.limits.max_stiffness, 700, 1e-9);
    EXPECT_NEAR(info.limits.max_damping, 5, 1e-9);
    EXPECT_NEAR(info.limits.workspace_radius, 0.1, 1e-12);
    const SessionResult session = touch_hd(stub, **device);
    EXPECT_EQ(session.servo.ticks, ticks);
    EXPECT_GE(session.servo.seconds, 0.85); // its scheduler's 1,000 Hz
    EXPECT_EQ(stub.state.forces, static_cast<long>(ticks));
    EXPECT_GT(stub.state.largest_force, 1.0);
    EXPECT_EQ(session.input.faulty_ticks, 0U);
    EXPECT_EQ(session.input.velocities, 0U);
    EXPECT_EQ((*device)->trouble(), "");
    EXPECT_EQ(stub.state.forces_enabled, 1);
    device->reset();
    EXPECT_EQ(stub.state.last_force, 0);
    EXPECT_EQ(stub.state.forces_enabled, 0);
    EXPECT_EQ(stub.state.open_devices, 0);
}

/// A rotation by a right angle about z.
bool is_turned(const Mat3& rotation)
{
    return rotation * Vec3::UnitX() == Vec3::UnitY() &&
           rotation * Vec3::UnitY() == -Vec3::UnitX() && rotation * Vec3::UnitZ() == Vec3::UnitZ();
}

TEST(HdDevice, ReportsHowItIsTurned)
{
    Stub stub(STUB_HD);
    auto device = open_hd_device({.library = STUB_HD});
    ASSERT_TRUE(device);
    EXPECT_TRUE((*device)->info().rotates);
    stub.state.turn = 5; // the stub counts from 1
    std::vector<Mat3> seen;
    (void)(*device)->run({.ticks = 6}, [&](std::uint64_t) {
        seen.push_back((*device)->read().state.pose.rotation);
        (*device)->write({});
        return Flow::proceed;
    });
    ASSERT_EQ(seen.size(), 6U);
    EXPECT_EQ(seen[3], Mat3::Identity());
    EXPECT_TRUE(is_turned(seen[4])) << seen[4];
}

TEST(HdDevice, SurvivesBeingUnpluggedAndPluggedInAgain)
{
    Stub stub(STUB_HD);
    auto device = open_hd_device({.library = STUB_HD});
    ASSERT_TRUE(device);
    stub.state.unplug = static_cast<long>(contact);
    stub.state.replug = static_cast<long>(contact) + 150;
    const SessionResult session = touch_hd(stub, **device);
    EXPECT_EQ(session.input.losses, 1U);
    EXPECT_EQ(session.input.recoveries, 1U);
    EXPECT_GT(session.forces[contact - 10], 1.0);
    EXPECT_EQ(session.forces[contact + 100], 0);
    const std::string trouble = (*device)->trouble();
    EXPECT_NE(trouble.find("Communication error (error 770, internal -42)"), std::string::npos)
        << trouble;
}

TEST(HdDevice, RestsForHalfASecondAfterAForceError)
{
    Stub stub(STUB_HD);
    auto device = open_hd_device({.library = STUB_HD});
    ASSERT_TRUE(device);
    stub.state.force_error = static_cast<long>(contact);
    const SessionResult session = touch_hd(stub, **device, 1600);
    // Half a second, and the time that it takes to accept that the hand is elsewhere.
    EXPECT_GE(session.input.faulty_ticks, 500U);
    EXPECT_LE(session.input.faulty_ticks, 610U);
    EXPECT_EQ(session.forces[contact + 100], 0);
    EXPECT_GT(*std::max_element(session.forces.begin() + 1300, session.forces.end()), 1.0);
    EXPECT_NE((*device)->trouble().find("stopped the force 1 times: Exceeded max force"),
              std::string::npos);
    EXPECT_EQ(stub.state.forces_enabled, 2); // once more, after the rest
}

TEST(HdDevice, ALossWhileTheForceIsSetIsSaidByTheNextReading)
{
    Stub stub(STUB_HD);
    auto device = open_hd_device({.library = STUB_HD});
    ASSERT_TRUE(device);
    stub.state.write_fault = 10;
    stub.state.write_refusal = 20; // is no loss
    std::vector<std::uint64_t> losses;
    (void)(*device)->run({.ticks = 30}, [&](std::uint64_t number) {
        if ((*device)->read().state.condition == InputCondition::gone) losses.push_back(number);
        (*device)->write({});
        return Flow::proceed;
    });
    EXPECT_EQ(losses, std::vector<std::uint64_t>{10}); // from 0, and the stub counts from 1
    EXPECT_EQ((*device)->trouble(),
              "the driver lost the device: Device fault (error 768, internal -42); the driver "
              "refused a call: Invalid value (error 257, internal -42)");
}

TEST(HdDevice, TellsForceErrorsFromLosses)
{
    Stub stub(STUB_HD);
    auto device = open_hd_device({.library = STUB_HD});
    ASSERT_TRUE(device);
    stub.state.unplug = 10;
    stub.state.replug = 20;
    stub.state.force_error = 30;
    (void)(*device)->run({.ticks = 40}, [&](std::uint64_t) noexcept {
        (void)(*device)->read();
        (*device)->write({});
        return Flow::proceed;
    });
    EXPECT_EQ((*device)->trouble(), "the driver stopped the force 1 times: Exceeded max force; the "
                                    "driver lost the device: Communication error (error 770, "
                                    "internal -42)");
}

TEST(HdDevice, TheRestIsHalfASecondAtAnyRate)
{
    Stub stub(STUB_HD);
    auto device = open_hd_device({.library = STUB_HD});
    ASSERT_TRUE(device);
    stub.state.force_error = 10;
    int rests = 0;
    (void)(*device)->run({.rate = 500, .ticks = 600}, [&](std::uint64_t) noexcept {
        rests += (*device)->read().state.condition == InputCondition::unsure ? 1 : 0;
        (*device)->write({});
        return Flow::proceed;
    });
    EXPECT_EQ(rests, 250);
}

TEST(HdDevice, SaysThatTheDriverLacksARate)
{
    Stub stub(STUB_HD);
    auto device = open_hd_device({.library = STUB_HD});
    ASSERT_TRUE(device);
    const auto note_at = [&](double rate) {
        return (*device)
            ->run({.rate = rate, .ticks = 20},
                  [&](std::uint64_t) noexcept {
                      (void)(*device)->read();
                      (*device)->write({});
                      return Flow::proceed;
                  })
            .note;
    };
    const std::string note = note_at(3000);
    EXPECT_NE(note.find("keeps a rate of its own, for it refused 3000 Hz: Invalid value"),
              std::string::npos)
        << note;
    EXPECT_EQ((*device)->trouble(), "");
    EXPECT_EQ(note_at(1000), "ticks are called by libHD's scheduler");
}

TEST(HdDevice, EndsTheSessionWhenTheDriverHangs)
{
    Stub stub(STUB_HD);
    auto device = open_hd_device({.library = STUB_HD});
    ASSERT_TRUE(device);
    stub.state.stall = 100;
    const SessionResult session = touch_hd(stub, **device);
    EXPECT_EQ(session.recording.ticks.size(), 100U);
    EXPECT_NE((*device)->trouble().find("scheduler stopped calling"), std::string::npos);
}

TEST(HdDevice, SaysWhyTheSchedulerDoesNotRun)
{
    Stub stub(STUB_HD);
    auto device = open_hd_device({.library = STUB_HD});
    ASSERT_TRUE(device);
    stub.state.fail_start = 1;
    const ServoStatistics seen =
        (*device)->run({.ticks = 1}, [](std::uint64_t) noexcept { return Flow::proceed; });
    EXPECT_EQ(seen.ticks, 0U);
    EXPECT_EQ((*device)->trouble(),
              "the driver's scheduler does not run: Device fault (error 768, internal -42)");
}

TEST(HdDevice, DetectsBadSamples)
{
    for (const auto fault : {&stub::State::nan, &stub::State::jump}) {
        Stub stub(STUB_HD);
        auto device = open_hd_device({.library = STUB_HD});
        ASSERT_TRUE(device);
        stub.state.*fault = static_cast<long>(contact);
        const SessionResult session = touch_hd(stub, **device);
        EXPECT_GE(session.input.faulty_ticks, 10U);
        EXPECT_EQ(session.input.not_finite > 0, fault == &stub::State::nan);
        EXPECT_EQ(session.input.jumps > 0, fault == &stub::State::jump);
    }
}

TEST(HdDevice, ReportsWhatIsMissing)
{
    const auto none = open_hd_device({.library = "/nowhere/libHD.so"});
    ASSERT_FALSE(none);
    EXPECT_EQ(code_of(none), ErrorCode::file_not_found);
    for (const char* const part : {"libHD.so was not found", "tried /nowhere/libHD.so",
                                   "No such file", "install OpenHaptics", "--device-library"})
        EXPECT_NE(none.error().message.find(part), std::string::npos) << none.error().message;
    const auto old = open_hd_device({.library = STUB_HD_OLD});
    ASSERT_FALSE(old);
    EXPECT_EQ(code_of(old), ErrorCode::unsupported_format);
    EXPECT_NE(old.error().message.find("lacks hdBeginFrame, hdEndFrame"), std::string::npos)
        << old.error().message;
    const auto unknown = open_hd_device({.device = "Right", .library = STUB_HD});
    ASSERT_FALSE(unknown);
    EXPECT_NE(unknown.error().message.find("cannot open Right: Bad handle"), std::string::npos)
        << unknown.error().message;
    EXPECT_TRUE(open_hd_device({.device = "Left", .library = STUB_HD}));
    // Without a path, all the names and where they were looked for.
    if (const auto searched = open_hd_device({}); !searched) {
        for (const char* const part : {"libHD.so.3.4", "/usr/lib/libHD.so", "LD_LIBRARY_PATH"}) {
            EXPECT_NE(searched.error().message.find(part), std::string::npos)
                << searched.error().message;
        }
    }
}

TEST(DhdDevice, TouchesByPolling)
{
    Stub stub(STUB_DHD);
    auto device = open_dhd_device({.library = STUB_DHD});
    ASSERT_TRUE(device) << describe(device.error());
    const DeviceInfo& info = (*device)->info();
    EXPECT_EQ(info.model, "Force Dimension omega.3 (stub)");
    EXPECT_EQ(info.serial, "1234");
    EXPECT_NE(info.driver.find("SDK 3.17.6.1"), std::string::npos);
    EXPECT_EQ(info.limits.max_force, 12);
    EXPECT_FALSE(info.rotates);
    const CubeScene scene(info.limits.workspace_radius);
    const SessionResult session = run_session(scene, **device, ticks);
    EXPECT_GT(stub.state.largest_force, 1.0);
    EXPECT_EQ(stub.state.bad_forces, 0);
    EXPECT_EQ(session.input.faulty_ticks, 0U);
    EXPECT_EQ(session.input.velocities, 0U);
    EXPECT_EQ(stub.state.forces_enabled, 1);
    device->reset();
    EXPECT_EQ(stub.state.last_force, 0);
    EXPECT_EQ(stub.state.forces_enabled, 0);
    EXPECT_EQ(stub.state.open_devices, 0);
    EXPECT_EQ(stub.state.forces_outside, 0);
}

TEST(DhdDevice, ReportsHowItIsTurnedWhereItHasAWrist)
{
    for (const bool has_wrist : {false, true}) {
        setenv("PROXIMA_STUB", has_wrist ? "turn=2 wrist=1" : "turn=2", 1);
        auto device = open_dhd_device({.library = STUB_DHD});
        unsetenv("PROXIMA_STUB");
        ASSERT_TRUE(device) << describe(device.error());
        EXPECT_EQ((*device)->info().rotates, has_wrist);
        EXPECT_EQ((*device)->read().state.pose.rotation, Mat3::Identity());
        const Mat3 rotation = (*device)->read().state.pose.rotation;
        EXPECT_EQ(is_turned(rotation), has_wrist) << rotation;
        EXPECT_EQ(rotation == Mat3::Identity(), !has_wrist) << rotation;
    }
}

TEST(DhdDevice, SaysWhoseLimitsAnUnknownModelHas)
{
    setenv("PROXIMA_STUB", "model=1", 1);
    auto device = open_dhd_device({.library = STUB_DHD});
    unsetenv("PROXIMA_STUB");
    ASSERT_TRUE(device) << describe(device.error());
    const DeviceInfo& info = (*device)->info();
    EXPECT_EQ(info.model, "Force Dimension sigma.7 (stub) (unknown here: limits of an omega)");
    EXPECT_EQ(info.limits.name, "omega");
    EXPECT_EQ(info.limits.max_force, 12);
}

TEST(DhdDevice, SurvivesBeingUnplugged)
{
    Stub stub(STUB_DHD);
    auto device = open_dhd_device({.library = STUB_DHD});
    ASSERT_TRUE(device);
    stub.state.unplug = static_cast<long>(contact);
    const CubeScene scene(0.075);
    const SessionResult session = run_session(scene, **device, ticks);
    EXPECT_EQ(session.input.losses, 1U);
    EXPECT_EQ(session.forces.back(), 0);
    EXPECT_NE((*device)->trouble().find("communication error (stub)"), std::string::npos);
}

TEST(DhdDevice, ReportsStillnessAndButtons)
{
    Stub stub(STUB_DHD);
    auto device = open_dhd_device({.library = STUB_DHD});
    ASSERT_TRUE(device);
    stub.state.freeze = static_cast<long>(contact);
    stub.state.press = 100;
    const CubeScene scene(0.075);
    int events = 0;
    const SessionResult session =
        run_session(scene, **device, 1500, {}, [&](std::uint64_t, DeviceInput& input) {
            while (input.next_button_event()) ++events;
        });
    EXPECT_EQ(session.input.suspicions, 1U);
    EXPECT_EQ(session.input.freezes, 0U);
    EXPECT_EQ(session.input.faulty_ticks, 0U);
    EXPECT_GT(session.forces.back(), 0);
    EXPECT_EQ(events, 2);
}

TEST(DhdDevice, ReportsWhatIsMissing)
{
    const auto none = open_dhd_device({.library = "/nowhere/libdhd.so"});
    ASSERT_FALSE(none);
    EXPECT_NE(none.error().message.find("install the Force Dimension SDK"), std::string::npos);
    const auto second = open_dhd_device({.index = 1, .library = STUB_DHD});
    ASSERT_FALSE(second);
    EXPECT_NE(second.error().message.find("no device dhd:1: devices found: 1"), std::string::npos);
    const auto other = open_dhd_device({.library = STUB_HD});
    ASSERT_FALSE(other);
    EXPECT_NE(other.error().message.find("lacks dhdGetDeviceCount, dhdOpenID"), std::string::npos)
        << other.error().message;
    ::setenv("PROXIMA_STUB", "fail_open=1", 1);
    const auto failing = open_dhd_device({.library = STUB_DHD});
    ::unsetenv("PROXIMA_STUB");
    ASSERT_FALSE(failing);
    EXPECT_NE(failing.error().message.find("cannot open dhd:0: communication error"),
              std::string::npos);
}

TEST(DhdDevice, IsClosedWhereItsForcesCannotBeEnabled)
{
    Stub stub(STUB_DHD);
    ::setenv("PROXIMA_STUB", "fail_enable=1", 1);
    const auto failing = open_dhd_device({.library = STUB_DHD});
    ::unsetenv("PROXIMA_STUB");
    ASSERT_FALSE(failing);
    EXPECT_NE(failing.error().message.find("cannot open dhd:0: communication error"),
              std::string::npos)
        << failing.error().message;
    EXPECT_EQ(stub.state.open_devices, 0);
}

TEST(HdDevice, IsNotOpenedBeforeAUserCalibratesIt)
{
    Stub stub(STUB_HD);
    ::setenv("PROXIMA_STUB", "needs_hands=1", 1);
    const auto device = open_hd_device({.library = STUB_HD});
    ::unsetenv("PROXIMA_STUB");
    ASSERT_FALSE(device);
    EXPECT_EQ(code_of(device), ErrorCode::limit_exceeded);
    EXPECT_NE(device.error().message.find("not calibrated: put its stylus into the inkwell"),
              std::string::npos)
        << device.error().message;
    EXPECT_EQ(stub.state.open_devices, 0);
    EXPECT_TRUE(open_hd_device({.library = STUB_HD_LEAN})); // a driver that is not asked
}

// The row of docs/devices.md.
TEST(HdDevice, HasTheLimitsOfATouchWhereTheDriverReportsNone)
{
    ::setenv("PROXIMA_STUB", "no_limits=1", 1);
    const auto device = open_hd_device({.library = STUB_HD});
    ::unsetenv("PROXIMA_STUB");
    ASSERT_TRUE(device) << describe(device.error());
    const DeviceLimits& limits = (*device)->info().limits;
    EXPECT_EQ(limits.max_force, 3.3);
    EXPECT_NEAR(limits.max_stiffness, 400, 1e-9);
    EXPECT_NEAR(limits.max_damping, 4, 1e-12);
    EXPECT_NEAR(limits.workspace_radius, 0.075, 1e-15);
}

// The rows of docs/devices.md.
TEST(DhdDevice, HasTheLimitsOfItsModel)
{
    struct Model {
        const char* number;
        const char* name;
        DeviceLimits limits;
    };
    const Model models[] = {{"model=0", "omega.3 (stub)", {"omega", 12, 5000, 30, 0.075}},
                            {"model=2", "FALCON", {"falcon", 8, 3000, 20, 0.04}},
                            {"model=3", "delta.3", {"delta", 20, 5000, 30, 0.15}}};
    for (const Model& model : models) {
        ::setenv("PROXIMA_STUB", model.number, 1);
        const auto device = open_dhd_device({.library = STUB_DHD});
        ::unsetenv("PROXIMA_STUB");
        ASSERT_TRUE(device) << describe(device.error());
        EXPECT_EQ((*device)->info().model, std::string("Force Dimension ") + model.name);
        const DeviceLimits& limits = (*device)->info().limits;
        EXPECT_EQ(limits.name, model.limits.name);
        EXPECT_EQ(limits.max_force, model.limits.max_force);
        EXPECT_EQ(limits.max_stiffness, model.limits.max_stiffness);
        EXPECT_EQ(limits.max_damping, model.limits.max_damping);
        EXPECT_EQ(limits.workspace_radius, model.limits.workspace_radius);
    }
}

TEST(DhdDevice, DoesWithOneButtonOfOlderDrivers)
{
    Stub stub(STUB_DHD_LEAN);
    const auto device = open_dhd_device({.library = STUB_DHD_LEAN});
    ASSERT_TRUE(device) << describe(device.error());
    const DeviceInfo& info = (*device)->info();
    EXPECT_EQ(info.buttons, 1);
    EXPECT_EQ(info.serial, "");
    EXPECT_FALSE(info.rotates);
    stub.state.press = 3; // the stub counts from 1, and holds the button for 100 ticks
    for (int tick = 1; tick <= 104; ++tick) {
        const DeviceState state = (*device)->read().state;
        EXPECT_EQ(state.buttons, tick >= 3 && tick <= 102 ? 1U : 0U) << tick;
        EXPECT_EQ(state.pose.rotation, Mat3::Identity());
    }
}

} // namespace
} // namespace proxima::shared_device_test
