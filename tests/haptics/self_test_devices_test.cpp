// Self-tests of devices of makers' libraries, by stubs, and of one over UDP.
#include "base/shared_library.h"
#include "base/udp_socket.h"
#include "haptics/device/dhd_device.h"
#include "haptics/device/hd_device.h"
#include "haptics/listening_device.h"
#include "haptics/self_test_session.h"
#include "stubs/stub_hand.h"

#include <gtest/gtest.h>

#include <array>
#include <memory>
#include <span>

namespace proxima::self_test_devices_test {
namespace {

using testing::listening_device;
using testing::run_self_test;
using testing::SelfTestSession;
using testing::state_packet;

constexpr long slow_ticks = 2500;
constexpr long fast_ticks = 500;

/// For a hand that goes by its own clock: it lets go after the slow and the fast motion. Friction and
/// motion are found sooner than a person is asked to wait.
SelfTestOptions timed_options()
{
    return {.wait_seconds = 5,
            .prepare_seconds = 0,
            .slow_seconds = 1e-3 * slow_ticks,
            .fast_seconds = 1e-3 * fast_ticks,
            .rest_seconds = 0.3,
            .ramp_rate = 0.2};
}

stub::State& state_of(const SharedLibrary& library)
{
    return *static_cast<stub::State*>(library.find("stub_state"));
}

SharedLibrary open_stub(const char* path)
{
    return *SharedLibrary::open({.what = "stub", .names = {}, .named = path, .advice = ""});
}

/// The stub's device: 0.1 kg, 0.2 N of friction and 0.3 N s/m along each axis, steps of 20 um. What
/// is set in a tick acts in the next one: no delay.
void expect_stub(const SelfTestSession& session, int delay)
{
    EXPECT_EQ(session.fault, SelfTestFault::none);
    EXPECT_TRUE(session.report.rested);
    for (const AxisReport& axis : session.report.axes) {
        EXPECT_EQ(axis.encoder.kind, StepKind::grid);
        EXPECT_NEAR(axis.encoder.step, 2e-5, 2e-7);
        ASSERT_TRUE(axis.static_friction);
        // (6 m D r^2)^(1/3) at this faster ramp, as self_test_test.cpp derives it.
        EXPECT_NEAR(*axis.static_friction, 0.2, 0.01);
        ASSERT_TRUE(axis.motion.found);
        EXPECT_EQ(axis.motion.delay, delay);
        EXPECT_NEAR(axis.motion.mass.value, 0.1, 0.005);
        EXPECT_NEAR(axis.motion.friction.value, 0.2, 0.01);
        EXPECT_NEAR(axis.motion.damping.value, 0.3, 0.06);
    }
    ASSERT_TRUE(session.report.settings);
    EXPECT_GT(session.report.settings->stiffness, 100);
}

TEST(SelfTestDevices, TestsAForceDimensionStub)
{
    const SharedLibrary library = open_stub(STUB_DHD);
    auto device = open_dhd_device({.library = STUB_DHD});
    ASSERT_TRUE(device);
    state_of(library).release = slow_ticks + fast_ticks;
    expect_stub(run_self_test(**device, timed_options()), 0);
    EXPECT_EQ(state_of(library).bad_forces, 0);
    EXPECT_EQ(state_of(library).last_force, 0);
    EXPECT_LE(state_of(library).largest_force, 0.3 * 12);
}

TEST(SelfTestDevices, TestsAnOpenHapticsStubInItsDriversCallback)
{
    const SharedLibrary library = open_stub(STUB_HD);
    auto device = open_hd_device({.library = STUB_HD});
    ASSERT_TRUE(device);
    state_of(library).release = slow_ticks + fast_ticks;
    state_of(library).period = 50; // its time is its ticks, as of a hand that moves with each call
    expect_stub(run_self_test(**device, timed_options()), 0);
    EXPECT_EQ(state_of(library).bad_forces, 0);
    EXPECT_EQ(state_of(library).forces_outside, 0);
    EXPECT_EQ(state_of(library).last_force, 0);
    EXPECT_LE(state_of(library).largest_force, 0.3 * 3.3 + 1e-9);
}

TEST(SelfTestDevices, ReportsFaultsOfDrivers)
{
    struct Case {
        long stub::State::*what;
        SelfTestFault fault;
    };
    for (const Case& fault : {Case{&stub::State::unplug, SelfTestFault::gone},
                              Case{&stub::State::nan, SelfTestFault::not_finite},
                              Case{&stub::State::jump, SelfTestFault::jumped}}) {
        const SharedLibrary library = open_stub(STUB_DHD);
        auto device = open_dhd_device({.library = STUB_DHD});
        ASSERT_TRUE(device);
        state_of(library).*fault.what = 1000;
        const SelfTestSession session = run_self_test(**device, timed_options());
        EXPECT_EQ(session.fault, fault.fault);
        EXPECT_EQ(session.pushed_ticks, 0U);
    }
    const SharedLibrary library = open_stub(STUB_HD);
    auto device = open_hd_device({.library = STUB_HD});
    ASSERT_TRUE(device);
    state_of(library).stall = 200;
    const SelfTestSession session = run_self_test(**device, timed_options());
    EXPECT_FALSE(session.finished); // the driver called no more
    EXPECT_NE((*device)->trouble().find("stopped calling"), std::string::npos);
}

/// A device at the other end of a socket, in step with ours: a state is sent before each tick, and the
/// force of the reply acts after it. Time goes by ticks, so no packet is late however long the machine is busy elsewhere.
class DeviceOverUdp final : public Device {
public:
    explicit DeviceOverUdp(const HandModel& model)
        : hand_("hand", model, *find_device("omni")), socket_(*UdpSocket::listen({})),
          device_(*UdpDevice::open({.address = {}, .patience = hour, .forget_seconds = hour}))
    {}
    void follow(const SelfTest& test) noexcept { hand_.follow(test); }
    [[nodiscard]] const DeviceInfo& info() const noexcept override { return device_->info(); }
    [[nodiscard]] DeviceReading read() noexcept override
    {
        StatePacket packet = state_packet(++sent_);
        const Vec3 position = hand_.read().state.pose.translation;
        for (int i = 0; i < 3; ++i) packet.position[static_cast<std::size_t>(i)] = position[i];
        socket_.send(encode(packet), device_->address());
        return device_->read();
    }
    void write(const DeviceCommand& command) noexcept override
    {
        device_->write(command);
        std::array<std::byte, reply_packet_size> buffer{};
        DeviceCommand felt;
        const auto received = socket_.receive(buffer);
        ReplyPacket reply;
        if (received &&
            decode(std::span(buffer).first(received->size), reply) == PacketFault::none) {
            felt = reply.command;
            ++replies_;
        }
        hand_.write(felt);
    }
    [[nodiscard]] std::uint64_t replies() const noexcept { return replies_; }

private:
    static constexpr double hour = 3600;

    SelfTestHand hand_;
    UdpSocket socket_;
    std::unique_ptr<UdpDevice> device_;
    std::uint64_t sent_ = 0;
    std::uint64_t replies_ = 0;
};

TEST(SelfTestDevices, TestsADeviceOverUdp)
{
    HandModel model;
    model.coulomb_friction = 0.2;
    model.device_damping = 0.3;
    model.encoder_step = 2e-5;
    for (const int delay : {0, 3}) {
        model.delay_ticks = delay;
        DeviceOverUdp device(model);
        const SelfTestSession session = run_self_test(device);
        expect_stub(session, delay);
        EXPECT_EQ(session.report.timing.samples, session.report.timing.ticks);
        EXPECT_EQ(device.replies(), session.ticks);
    }
}

TEST(SelfTestDevices, ReportsADeviceThatSaysNothingOverUdp)
{
    const auto device = listening_device();
    const SelfTestSession session = run_self_test(*device);
    EXPECT_EQ(session.fault, SelfTestFault::no_sample);
    EXPECT_NE(device->trouble().find("no packet arrived"), std::string::npos);
}

} // namespace
} // namespace proxima::self_test_devices_test
