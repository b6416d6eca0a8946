// A device of one's own: it goes down onto a cube by a script, at 1 kHz, and prints its force.
#include <cstdio>
#include <proxima/proxima.h>
using namespace proxima;

struct Plunger final : Device {
    DeviceInfo about = {.name = "plunger", .limits = *find_device("omni")};
    DeviceReading now = {.state = {.pose = {Mat3::Identity(), Vec3(0, 0, 0.052)}}}; // metres
    const DeviceInfo& info() const noexcept override { return about; }
    DeviceReading read() noexcept override { return now; }
    void write(const DeviceCommand& command) noexcept override
    {
        if (now.sample++ % 100 == 0) std::printf("%.3f N\n", command.force.z());
        now.state.pose.translation.z() -= 2e-5; // 2 cm a second
    }
};
int main()
{
    TouchScene scene({Vec3(-2, -2, -2), Vec3(2, 2, 2)});
    scene.add(build_touch_body(*sample_mesh("cube")).value(), {}).value();
    Plunger device;
    HapticRenderer renderer(scene, {.units_per_metre = 20}, device.info().limits);
    (void)device.run({.rate = 1000, .ticks = 401}, [&](std::uint64_t) {
        device.write({.force = renderer.tick(device.read().state, 1e-3).force});
        return Flow::proceed;
    });
}
