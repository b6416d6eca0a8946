// The renderer's force against walls of which it is known: the spring's law to the last digits.
#include "haptics/force/surface_renderer.h"
#include "haptics/proxy/slide_sphere.h"
#include "haptics/spring_alone.h"
#include "haptics/surface/contact_surface.h"
#include "haptics/touch_meshes.h"
#include "proxima/device.h"
#include "proxima/haptic_renderer.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace proxima::analytic_force_test {
namespace {

constexpr double stiffness = 500;
constexpr double tick_seconds = 1e-3;

DeviceLimits strong_device()
{
    DeviceLimits limits = *find_device("delta");
    limits.max_force = 1e6;
    return limits;
}

RenderOptions spring_options()
{
    RenderOptions options = testing::spring_alone(stiffness);
    options.max_moves = max_slide_moves;
    return options;
}

DeviceState at(const Vec3& p)
{
    DeviceState state;
    state.pose.translation = p;
    return state;
}

/// The foot of q on a triangle's plane, in long doubles.
Vec3 foot(const Triangle& triangle, const Vec3& q)
{
    using Long = Eigen::Matrix<long double, 3, 1>;
    const Long a = triangle[0].cast<long double>();
    const Long n = (triangle[1].cast<long double>() - a).cross(triangle[2].cast<long double>() - a);
    const Long d = q.cast<long double>() - a;
    return (q.cast<long double>() - n * (n.dot(d) / n.squaredNorm())).cast<double>();
}

/// Of forces against random faces, K times the depth: |F - K (foot - q)| / (K d), root mean square.
double relative_force_error(const TriangleMesh& mesh, std::uint64_t seed)
{
    const MeshContactSurface surface(mesh);
    const WorkspaceMap map = fit_workspace(bounding_box(mesh), 0.1);
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> unit(0, 1);
    double squares = 0;
    double depths = 0;
    constexpr int presses = 40;
    for (int press = 0; press < presses; ++press) {
        const auto id = static_cast<std::uint32_t>(random() % mesh.triangle_count());
        const Triangle t = mesh.triangle(TriangleId{id});
        const Vec3 normal = scaled_normal(t).normalized();
        double weights[3] = {0.3 + unit(random), 0.3 + unit(random), 0.3 + unit(random)};
        const double sum = weights[0] + weights[1] + weights[2];
        const Vec3 on = (weights[0] * t[0] + weights[1] * t[1] + weights[2] * t[2]) / sum;
        const double edge = (t[1] - t[0]).norm();
        const double depth = (0.01 + 0.09 * unit(random)) * edge;
        // From above the face into it, in steps, and away again.
        const Vec3 over = map.to_device(on + 0.3 * edge * normal);
        const Vec3 within = map.to_device(on - depth * normal);
        HapticRenderer fresh =
            make_surface_renderer(surface, map, strong_device(), spring_options());
        fresh.tick(at(over), tick_seconds);
        for (int step = 1; step <= 4; ++step)
            fresh.tick(at(over + step / 4.0 * (within - over)), tick_seconds);
        const Vec3 device = map.to_model(fresh.last().position);
        const Vec3 wanted = stiffness * (foot(t, device) - device) / map.units_per_metre;
        squares += (fresh.last().force - wanted).squaredNorm();
        depths += wanted.squaredNorm();
    }
    return std::sqrt(squares / depths);
}

TEST(AnalyticForce, EqualsTheSpringForceToABillionth)
{
    const TriangleMesh plane = testing::mesh_of(
        {Vec3(-1, -1, 0), Vec3(1, -1, 0), Vec3(1, 1, 0), Vec3(-1, 1, 0)}, {{0, 1, 2}, {0, 2, 3}});
    EXPECT_LT(relative_force_error(plane, 1), 1e-9);
    EXPECT_LT(relative_force_error(*sample_mesh("cube"), 2), 1e-9);
    EXPECT_LT(relative_force_error(*sample_mesh("sphere:40x40"), 3), 1e-9);
}

} // namespace
} // namespace proxima::analytic_force_test
