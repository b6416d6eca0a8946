// A plate comes down on a hand that rests: prints how the force rises, tick by tick.
#include <cstdio>
#include <proxima/proxima.h>

int main()
{
    using namespace proxima;
    // Metres. The cube from -1 to 1 is 20 cm over the hand, and comes down 21 cm in 0.1 s.
    TouchScene scene({Vec3(-5, -5, -5), Vec3(5, 5, 5)});
    auto body =
        build_touch_body(*sample_mesh("cube"), {.material = SurfaceMaterial{.stiffness = 300}});
    if (!body) return 1;
    const auto object = scene.add(*body, {Mat3::Identity(), Vec3(0, 0, 1.2)});
    if (!object) return 1;
    HapticRenderer renderer =
        make_haptic_renderer(scene, WorkspaceMap{}, *find_device("omni")).value();
    if (!scene.move(*object, {.pose = {Mat3::Identity(), Vec3(0, 0, 0.99)}, .seconds = 0.1}))
        return 1;

    DeviceState hand; // at the origin, at rest
    for (int tick = 0; tick <= 300; ++tick) {
        const RenderTick& felt = renderer.tick(hand, 1e-3);
        if (tick % 50 == 0) std::printf("%3d ms %6.3f N\n", tick, felt.force.z());
    }
}
