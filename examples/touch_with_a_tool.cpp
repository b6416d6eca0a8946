// A box is pressed onto a table and tilted: prints force and torque.
#include <algorithm>
#include <cstdio>
#include <proxima/proxima.h>
#include <vector>

int main()
{
    using namespace proxima;
    // Metres. The table is a cube from -1 to 1, the tool one of 2 cm, its origin the device's tip.
    auto table = build_mesh_index(*sample_mesh("cube"));
    const TriangleMesh cube = *sample_mesh("cube");
    std::vector<Vec3> corners(cube.positions().begin(), cube.positions().end());
    for (Vec3& corner : corners) corner *= 0.01;
    auto small = make_triangle_mesh(corners, {cube.triangles().begin(), cube.triangles().end()});
    auto tool = build_mesh_index(*small);
    if (!table || !tool) return 1;

    DeviceLimits device = *find_device("omega");
    device.max_torque = 0.1; // a device that gives torques
    const ToolObject object = {*table, {}};
    auto renderer = make_tool_renderer(*tool, {&object, 1}, WorkspaceMap{}, device,
                                       {.torsional_stiffness = 0.5});
    if (!renderer) return 1;

    DeviceState hand;
    for (int tick = 0; tick <= 1000; ++tick) {
        const double tilt = 0.02 * std::min(tick / 500.0, 1.0);
        hand.pose.rotation = Eigen::AngleAxisd(tilt, Vec3::UnitY()).toRotationMatrix();
        hand.pose.translation = Vec3(0, 0, 1.02 - 0.014 * std::min(tick / 500.0, 1.0));
        const ToolTick& felt = renderer->tick(hand, 1e-3);
        if (tick % 250 == 0)
            std::printf("%4d ms %6.3f N %7.4f N m\n", tick, felt.force.z(), felt.torque.y());
    }
}
