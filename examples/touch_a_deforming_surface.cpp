// A ball is inflated under a hand that rests: prints how the force rises, frame by frame.
#include <cstdio>
#include <proxima/proxima.h>

int main()
{
    using namespace proxima;
    // A device's metre is 20 units of the scene, so that the ball has a radius of 5 cm.
    const WorkspaceMap map = {.units_per_metre = 20};
    const TriangleMesh ball = *sample_mesh("icosphere:4");
    TouchScene scene({Vec3(-2, -2, -2), Vec3(2, 2, 2)});
    auto body = build_touch_body(ball, {.material = SurfaceMaterial{.stiffness = 300}});
    if (!body) return 1;
    const auto object = scene.add(*body, {});
    if (!object) return 1;
    HapticRenderer renderer = make_haptic_renderer(scene, map, *find_device("omni")).value();

    DeviceState hand; // 2.5 mm over the ball, at rest
    hand.pose.translation = Vec3(0, 0, 0.0525);
    for (int frame = 0; frame <= 50; ++frame) {
        // The application's thread, 50 times a second: the ball's radius grows to 6.25 cm in a second.
        std::vector<Vec3> positions;
        for (const Vec3& p : ball.positions()) positions.push_back(p * (1 + 0.005 * frame));
        const auto shape = refit_touch_body(*body, positions);
        if (!shape || !scene.deform(*object, *shape, 0.02)) return 1;
        // The servo thread, 1,000 times a second.
        for (int tick = 0; tick < 20; ++tick) renderer.tick(hand, 1e-3);
        if (frame % 10 == 0) std::printf("%2d %6.3f N\n", frame, renderer.last().force.z());
    }
}
