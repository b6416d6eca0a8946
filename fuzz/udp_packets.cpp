// Feeds any datagrams to a UDP device and to the servo of the other side: whatever they hold,
// forces are finite and within the limit. The bytes are a datagram of each kind after the other,
// each after its length in a byte; seeds are a state and a reply of a contact.
#include "base/check.h"
#include "exact_copy.h"
#include "haptics/device/remote_servo.h"
#include "haptics/device/udp_device.h"
#include "haptics/force/surface_renderer.h"
#include "haptics/surface/contact_surface.h"
#include "proxima/device.h"
#include "proxima/haptic_renderer.h"
#include "proxima/sample_meshes.h"

#include <cstddef>
#include <cstdint>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
    using namespace proxima;
    static const TriangleMesh mesh = *sample_mesh("cube");
    static const MeshContactSurface surface(mesh);
    const auto device = UdpDevice::open({});
    if (!device) return 0;
    constexpr double limit = 3.3;
    HapticRenderer renderer = make_surface_renderer(surface, fit_workspace(bounding_box(mesh), 0.1),
                                                    *find_device("omni"));
    DeviceInput input = make_device_input((*device)->info()).value();
    RemoteServo servo(limit);
    std::int64_t now = 1;
    for (std::size_t at = 0; at < size;) {
        const std::size_t length = std::min<std::size_t>(data[at] + std::size_t{1}, size - at - 1);
        const auto datagram = testing::exact_copy(data + at + 1, length);
        const std::span<const std::byte> bytes(datagram.get(), length);
        at += 1 + length;
        now += 1'000'000;
        (*device)->take(bytes, {}, now);
        const RenderTick& felt = renderer.tick(input.accept((*device)->read()), 1e-3);
        PROXIMA_CHECK(felt.force.allFinite());
        PROXIMA_CHECK_LE(felt.force.norm(), limit);
        const DeviceCommand command = input.command(renderer);
        PROXIMA_CHECK(command.force.allFinite());
        ReplyPacket reply;
        const double seconds = 1e-9 * static_cast<double>(now);
        if (decode(bytes, reply) == PacketFault::none) servo.take(reply, seconds);
        const DeviceState& state = input.state();
        const Vec3 force = servo.force(state.pose.translation, state.velocity, seconds);
        PROXIMA_CHECK(force.allFinite());
        PROXIMA_CHECK_LE(force.norm(), limit);
    }
    return 0;
}
