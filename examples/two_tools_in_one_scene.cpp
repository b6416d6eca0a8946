// Two hands touch a cube, each in a servo loop of its own, while the application turns it.
#include <array>
#include <cstdio>
#include <proxima/proxima.h>
#include <thread>

int main()
{
    using namespace proxima;
    const WorkspaceMap map = {.units_per_metre = 20}; // the cube is 10 cm wide
    TouchScene scene({Vec3(-5, -5, -5), Vec3(5, 5, 5)});
    const auto body =
        build_touch_body(*sample_mesh("cube"), {.material = SurfaceMaterial{.stiffness = 300}});
    if (!body) return 1;
    const auto cube = scene.add(*body, {});
    if (!cube || !scene.move(*cube, {.spin = Vec3(0, 0, 1), .coast_seconds = 0.5})) return 1;

    std::array<double, 2> felt{};
    const auto touch = [&](std::size_t hand, double side) {
        // Tools come and go while others run.
        auto renderer = make_haptic_renderer(scene, map, *find_device("omni"));
        if (!renderer) return;
        DeviceState state;
        (void)run_servo_loop({.rate = 1000, .ticks = 800}, [&](std::uint64_t tick) {
            // From 5 mm above the face to 5 mm below it, in half a second.
            const double height = std::max(0.045, 0.055 - 2e-5 * static_cast<double>(tick));
            state.pose.translation = Vec3(0, 0, side * height);
            renderer->tick(state, 1e-3);
            return Flow::proceed;
        });
        felt[hand] = renderer->last().force.z();
    };
    std::thread first(touch, 0, 1.0);
    std::thread second(touch, 1, -1.0);
    first.join();
    second.join();
    std::printf("%.1f N and %.1f N\n", felt[0], felt[1]);
}
