// The touch panel by devices: over UDP on this machine, and by the makers' libraries' stand-ins.
#include "base/udp_socket.h"
#include "haptics/device/udp_packets.h"
#include "viewer/named_settings.h"
#include "viewer/viewer.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <gtest/gtest.h>
#include <optional>
#include <thread>

namespace proxima::touch_devices_test {
namespace {

/// A live viewer of a sphere at the touch panel.
class Touching {
public:
    explicit Touching(const std::vector<std::string>& settings)
    {
        EXPECT_TRUE(viewer.choose_panel("touch"));
        set(settings);
        viewer.open({"icosphere:3"});
        const Status done = viewer.finish();
        EXPECT_TRUE(done) << describe(done.error());
    }

    void set(const std::vector<std::string>& settings)
    {
        const Status applied =
            apply_settings(settings, [&](Controls& controls) { viewer.offer(controls); });
        EXPECT_TRUE(applied) << describe(applied.error());
    }

    [[nodiscard]] std::string fact(std::string_view name) const
    {
        const auto found = std::ranges::find(viewer.facts(), name, &PanelFact::name);
        return found == viewer.facts().end() ? "" : found->value;
    }
    [[nodiscard]] double force() const
    {
        const std::string text = fact("force");
        return text.empty() ? 0.0 : std::stod(text);
    }

    /// The middle of the proxy's ball.
    [[nodiscard]] Vec3 proxy() const
    {
        Box box;
        for (const SceneLayer& layer : viewer.layers()) {
            for (const SceneSurface& surface : layer.scene->surfaces) {
                if (surface.name != "proxy") continue;
                for (const Vec3& position : surface.positions) box.extend(position);
            }
        }
        return box.empty() ? Vec3::Zero() : Vec3(box.center());
    }

    /// Updates until it is so, or half a minute has passed.
    template <class IsSo>
    [[nodiscard]] bool comes(const IsSo& is_so)
    {
        const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(30);
        while (std::chrono::steady_clock::now() < end) {
            viewer.update(0.01);
            if (is_so()) return true;
            std::this_thread::sleep_for(std::chrono::milliseconds(2));
        }
        return false;
    }

    Viewer viewer{{.pictures = Pictures::live}};
};

/// A device in another thread: goes down along z from above, a step for each answer, and stays a little below the
/// surface.
class OtherSide {
public:
    explicit OtherSide(std::uint16_t port) : thread_([this, port] { run({.port = port}); }) {}
    OtherSide(const OtherSide&) = delete;
    OtherSide& operator=(const OtherSide&) = delete;
    ~OtherSide()
    {
        stops_ = true;
        thread_.join();
    }

    [[nodiscard]] double largest_force() const { return largest_force_; }

private:
    void run(const UdpAddress& to)
    {
        auto socket = UdpSocket::listen({});
        if (!socket) return;
        StatePacket packet;
        packet.session = 99;
        double height = 0.05;
        const auto begin = std::chrono::steady_clock::now();
        while (!stops_) {
            const auto passed = std::chrono::steady_clock::now() - begin;
            ++packet.sequence;
            packet.nanoseconds = static_cast<std::uint64_t>(passed / std::chrono::nanoseconds(1));
            packet.position = {0, 0, height};
            (void)socket->send(encode(packet), to);
            std::array<std::byte, reply_packet_size> bytes{};
            bool is_answered = false;
            while (const auto received = socket->receive(bytes)) {
                ReplyPacket reply;
                if (decode(std::span(bytes).first(received->size), reply) == PacketFault::none)
                    largest_force_ = std::max<double>(largest_force_, reply.command.force.z());
                is_answered = true;
            }
            if (is_answered) height = std::max(0.02, height - 6e-5);
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
        }
    }

    std::atomic<bool> stops_{false};
    std::atomic<double> largest_force_{0.0};
    std::thread thread_;
};

std::uint16_t free_port()
{
    return UdpSocket::listen({})->address().port;
}

TEST(TouchDevices, AnotherProgramTouchesOverUdp)
{
    const std::uint16_t port = free_port();
    Touching touching({"device=udp", "address=" + std::to_string(port)});
    EXPECT_TRUE(touching.viewer.handles().empty()) << "the mouse drags nothing";
    ASSERT_TRUE(touching.comes([&] { return touching.fact("state") == "silent"; }));
    EXPECT_EQ(touching.force(), 0.0);
    std::optional<OtherSide> device(port);
    ASSERT_TRUE(
        touching.comes([&] { return touching.force() > 1.0 && touching.fact("state") == "well"; }));
    EXPECT_NE(touching.fact("contact"), "free");
    EXPECT_LT((touching.proxy() - Vec3::UnitZ()).norm(), 0.05) << "on the sphere's top";
    ASSERT_TRUE(touching.comes([&] { return device->largest_force() > 1.0; }));
    // Another setting begins a new session; the other side comes from outside once more.
    device.reset();
    touching.set({"stiffness=200"});
    ASSERT_TRUE(touching.comes([&] { return touching.fact("state") == "silent"; }));
    device.emplace(port);
    ASSERT_TRUE(touching.comes([&] { return touching.force() > 0.5; }));
    device.reset();
    ASSERT_TRUE(touching.comes([&] { return touching.fact("state") == "silent"; }));
    ASSERT_TRUE(touching.comes([&] { return touching.force() == 0.0; })) << "the force fades";
    EXPECT_EQ(touching.viewer.problem(), "");
}

TEST(TouchDevices, ADriverLibraryTouchesAndLetsGo)
{
    Touching touching({"device=hd", std::string("library=") + STUB_HD});
    ASSERT_TRUE(touching.comes([&] { return touching.force() > 1.0; }));
    EXPECT_NE(touching.fact("device").find("Stub Omni"), std::string::npos)
        << touching.fact("device");
    // Its hand moves along its z, towards the person: our -y where z is up.
    EXPECT_LT((touching.proxy() + Vec3::UnitY()).norm(), 0.3) << touching.proxy().transpose();
    touching.set({"device=dhd", std::string("library=") + STUB_DHD});
    // Up is z for this maker too.
    ASSERT_TRUE(touching.comes(
        [&] { return touching.force() > 1.0 && touching.fact("device").starts_with("Force"); }));
    EXPECT_LT((touching.proxy() - Vec3::UnitZ()).norm(), 0.3) << touching.proxy().transpose();
    touching.set({"axes=y,z,x"});
    ASSERT_TRUE(
        touching.comes([&] { return touching.force() > 1.0 && touching.proxy().y() > 0.7; }));
}

TEST(TouchDevices, ThatAreMissingAreReportedWithoutStoppingTheViewer)
{
    Touching touching({"device=hd", "library=/nowhere/libHD.so"});
    ASSERT_TRUE(touching.comes([&] { return !touching.viewer.problem().empty(); }));
    const std::string problem = touching.viewer.problem();
    EXPECT_NE(problem.find("/nowhere/libHD.so"), std::string::npos) << problem;
    EXPECT_NE(problem.find("install OpenHaptics"), std::string::npos) << problem;
    touching.set({"device=dhd", std::string("library=") + STUB_DHD, "number=3"});
    ASSERT_TRUE(touching.comes([&] {
        return touching.viewer.problem().find("no device dhd:3") != std::string::npos;
    })) << touching.viewer.problem();
    touching.set({"device=udp", "address=nonsense"});
    ASSERT_TRUE(touching.comes([&] {
        return touching.viewer.problem().find("udp:nonsense is not a device") != std::string::npos;
    })) << touching.viewer.problem();
    const auto taken = UdpSocket::listen({});
    touching.set({"address=" + std::to_string(taken->address().port)});
    ASSERT_TRUE(touching.comes([&] {
        return touching.viewer.problem().find("in use") != std::string::npos;
    })) << touching.viewer.problem();
    touching.set({"address=" + std::to_string(free_port()), "axes=x,x,x"});
    ASSERT_TRUE(touching.comes([&] {
        return touching.viewer.problem().find("no rotation of axes") != std::string::npos;
    })) << touching.viewer.problem();
    touching.set({"device=mouse"});
    ASSERT_TRUE(touching.comes([&] { return touching.force() > 0.1; }));
    EXPECT_EQ(touching.viewer.problem(), "");
}

TEST(TouchDevices, AreOpenedAgainOnRequest)
{
    const std::uint16_t port = free_port();
    auto taken = std::make_unique<UdpSocket>(*UdpSocket::listen({.port = port}));
    Touching touching({"device=udp", "address=" + std::to_string(port)});
    ASSERT_TRUE(touching.comes([&] { return !touching.viewer.problem().empty(); }));
    taken.reset();
    touching.set({"open it again=press"});
    ASSERT_TRUE(touching.comes([&] { return touching.fact("state") == "silent"; }));
    EXPECT_EQ(touching.viewer.problem(), "");
}

TEST(TouchDevices, AreRefusedForStillPictures)
{
    Viewer viewer;
    ASSERT_TRUE(viewer.choose_panel("touch"));
    ASSERT_TRUE(apply_settings({"device=hd"}, [&](Controls& controls) { viewer.offer(controls); }));
    viewer.open({"cube"});
    const Status status = viewer.finish();
    ASSERT_FALSE(status);
    EXPECT_NE(describe(status.error()).find("needs the window"), std::string::npos);
}

} // namespace
} // namespace proxima::touch_devices_test
