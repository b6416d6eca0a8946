// Feeds any packets of an engine to a scene that is touched: whatever they hold, forces are finite and
// within the limit. The bytes are packets, each after its length in two bytes; seeds move an object and
// change its material. A length of zero is a tick without a packet.
#include "base/check.h"
#include "exact_copy.h"
#include "haptics/channel/engine_link.h"
#include "proxima/device.h"
#include "proxima/haptic_renderer.h"
#include "proxima/sample_meshes.h"
#include "proxima/touch_scene.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>

namespace {

using namespace proxima;

/// No packet comes but those that are given.
class NoTransport final : public EngineTransport {
public:
    [[nodiscard]] std::string name() const override { return "none"; }
    [[nodiscard]] std::optional<UdpSocket::Received>
    receive(std::span<std::byte> /*buffer*/) noexcept override
    {
        return std::nullopt;
    }
    bool send(std::span<const std::byte, touch_packet_size> packet,
              const UdpAddress& /*to*/) noexcept override
    {
        TouchPacket heard;
        PROXIMA_CHECK(decode(packet, heard) == PacketFault::none);
        PROXIMA_CHECK(heard.force.allFinite());
        return true;
    }
    [[nodiscard]] bool keeps_packets() const noexcept override { return true; }
};

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
    static const TouchBody body = build_touch_body(*sample_mesh("cube")).value();
    TouchScene scene({Vec3(-20, -20, -20), Vec3(20, 20, 20)});
    PROXIMA_CHECK(scene.add(body, {}).has_value());
    PROXIMA_CHECK(scene.add(body, {Mat3::Identity(), Vec3(0, 0, 5)}).has_value());
    const DeviceLimits limits = *find_device("omni");
    HapticRenderer renderer = make_haptic_renderer(scene, {20, Vec3(0, 0, 1)}, limits).value();
    EngineLink link(std::make_unique<NoTransport>());
    std::int64_t now = 1;
    std::uint64_t tick = 0;
    for (std::size_t at = 0; at + 2 <= size; ++tick) {
        const std::size_t told = data[at] | std::size_t{data[at + 1]} << 8U;
        at += 2;
        const std::size_t length = std::min(told, size - at);
        const auto packet = testing::exact_copy(data + at, length);
        at += length;
        now += 1'000'000;
        if (length > 0) link.take({packet.get(), length}, {}, now);
        (void)link.receive(scene, tick, 1e-3, now);
        DeviceState state;
        state.pose.translation = Vec3(0, 0, tick < 2 ? 0.01 : -0.004);
        const RenderTick& felt = renderer.tick(state, 1e-3);
        PROXIMA_CHECK(felt.force.allFinite());
        PROXIMA_CHECK_LE(felt.force.norm(), limits.max_force);
        link.send(renderer, state, now);
    }
    return 0;
}
