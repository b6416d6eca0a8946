// A device of one's own: it goes down onto a cube by a script, at 1 kHz, and prints its force.
#include <cstdio>
#include <proxima/proxima.h>
using namespace proxima;
struct Plunger final : Device {
    DeviceInfo about = {.name = "plunger", .limits = *find_device("omni")};
    DeviceReading now = {{.pose = {Mat3::Identity(), Vec3(0, 0, 0.052)}}, 1}; // metres, sample 1
    const DeviceInfo& info() const noexcept override { return about; }
    DeviceReading read() noexcept override { return now; }
    void write(const DeviceCommand& command) noexcept override
    {
        if (now.sample++ % 100 == 1) std::printf("%.3f N\n", command.force.z());
        now.state.pose.translation.z() -= 2e-5; // 2 cm a second
    }
};
int main()
{
    auto cube = build_mesh_index(*sample_mesh("cube")).value();
    Plunger device;
    auto renderer = make_haptic_renderer(cube, {20}, device.about.limits).value(); // 20 units/m
    auto input = make_device_input(device.about).value(); // for devices that jump or fall silent
    (void)device.run({.rate = 1000, .ticks = 401}, [&](std::uint64_t) {
        renderer.tick(input.accept(device.read()), 1e-3);
        device.write(input.command(renderer));
        return Flow::proceed;
    });
}
