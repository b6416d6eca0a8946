// The renderer's force against walls of which it is known: the spring's law to the last digits, and
// no energy of closed paths without friction.
//
// Seen from a room (the inside of a cube, of a sphere) the places that are free are convex: the
// spring has a potential, and closed paths take nothing. Seen from outside, an edge lets go of a
// device that goes round it under the surface: such paths take energy, and must never give any.
#include "haptics/spring_alone.h"
#include "haptics/touch_meshes.h"
#include "proxima/haptics/haptic_renderer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

namespace proxima {
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
        HapticRenderer fresh(surface, map, strong_device(), spring_options());
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

TEST(AnalyticForce, is_the_springs_to_a_billionth)
{
    const TriangleMesh plane = testing::mesh_of(
        {Vec3(-1, -1, 0), Vec3(1, -1, 0), Vec3(1, 1, 0), Vec3(-1, 1, 0)}, {{0, 1, 2}, {0, 2, 3}});
    EXPECT_LT(relative_force_error(plane, 1), 1e-9);
    EXPECT_LT(relative_force_error(*sample_mesh("cube"), 2), 1e-9);
    EXPECT_LT(relative_force_error(*sample_mesh("sphere:40x40"), 3), 1e-9);
}

/// What a closed path took, J, over K times the greatest depth squared.
struct PathEnergy {
    double trapezoid = 0;
    double held = 0; ///< of forces that are held over a tick, as devices do
    double depth = 0;
};

/// A smooth closed path: sums of sines about a middle, by seed.
class Loop {
public:
    Loop(const Vec3& middle, double size, std::uint64_t seed) : middle_(middle)
    {
        std::mt19937_64 random(seed);
        std::normal_distribution<double> normal;
        for (std::size_t i = 0; i < sines_.size(); ++i) {
            const double share = size / static_cast<double>(i + 1);
            sines_[i] = share * Vec3{normal(random), normal(random), normal(random)};
            cosines_[i] = share * Vec3{normal(random), normal(random), normal(random)};
        }
    }
    [[nodiscard]] Vec3 place(double part) const
    {
        Vec3 p = middle_;
        for (std::size_t i = 0; i < sines_.size(); ++i) {
            const double angle = 2 * std::numbers::pi * static_cast<double>(i + 1) * part;
            p += std::sin(angle) * sines_[i] + std::cos(angle) * cosines_[i];
        }
        return p;
    }

private:
    Vec3 middle_;
    std::array<Vec3, 3> sines_;
    std::array<Vec3, 3> cosines_;
};

/// From a place that is free to the loop's beginning, and once round it.
PathEnergy energy_of(const ContactSurface& surface, const WorkspaceMap& map, const Vec3& from,
                     const Loop& loop, int ticks)
{
    HapticRenderer renderer(surface, map, strong_device(), spring_options());
    renderer.tick(at(from), tick_seconds);
    for (int step = 1; step <= 1000; ++step)
        renderer.tick(at(from + step / 1000.0 * (loop.place(0) - from)), tick_seconds);
    Vec3 force = renderer.last().force;
    Vec3 before = renderer.last().position;
    PathEnergy sum;
    for (int tick = 1; tick <= ticks; ++tick) {
        const Vec3 p =
            tick == ticks ? loop.place(0) : loop.place(static_cast<double>(tick) / ticks);
        const RenderTick& felt = renderer.tick(at(p), tick_seconds);
        const Vec3 way = felt.position - before;
        sum.trapezoid -= 0.5 * (felt.force + force).dot(way);
        sum.held -= force.dot(way);
        sum.depth = std::max(sum.depth, felt.force.norm() / stiffness);
        force = felt.force;
        before = felt.position;
    }
    const double unit = stiffness * sum.depth * sum.depth;
    return {sum.trapezoid / unit, sum.held / unit, sum.depth};
}

TEST(AnalyticEnergy, closed_paths_in_a_room_take_none_over_faces_edges_and_corners)
{
    const TriangleMesh room = testing::inverted(*sample_mesh("cube"));
    const MeshContactSurface surface(room);
    const WorkspaceMap map = fit_workspace(bounding_box(room), 0.1);
    const double half = 0.5 * bounding_box(room).extent().x() / map.units_per_metre;
    double held = 0;
    for (std::uint64_t seed = 1; seed <= 2; ++seed) {
        // About a corner of the room, through its walls, edges and the corner itself.
        const Loop loop(Vec3::Constant(half), 0.006, seed);
        const PathEnergy energy = energy_of(surface, map, Vec3::Zero(), loop, 300000);
        EXPECT_GT(energy.depth, 0.003);
        EXPECT_LT(std::abs(energy.trapezoid), 1e-9) << seed;
        held = std::max(held, std::abs(energy.held));
    }
    EXPECT_LT(held, 5e-3);
    RecordProperty("held_energy", std::to_string(held));
}

TEST(AnalyticEnergy, closed_paths_over_the_inside_of_a_sphere_take_next_to_none)
{
    const TriangleMesh room = testing::inverted(*sample_mesh("sphere:12x12"));
    const MeshContactSurface surface(room);
    const WorkspaceMap map = fit_workspace(bounding_box(room), 0.1);
    const double radius = 0.5 * bounding_box(room).extent().z() / map.units_per_metre;
    for (std::uint64_t seed = 1; seed <= 2; ++seed) {
        const Loop loop(Vec3(0.6, 0.5, 0.62).normalized() * radius, 0.005, seed);
        const PathEnergy energy = energy_of(surface, map, Vec3::Zero(), loop, 20000);
        EXPECT_GT(energy.depth, 0.002);
        // Many seams are crossed, each a bend of the force: not the billionth of plane walls.
        EXPECT_LT(std::abs(energy.trapezoid), 1e-5) << seed;
        EXPECT_LT(std::abs(energy.held), 5e-3) << seed;
    }
}

TEST(AnalyticEnergy, closed_paths_over_outer_edges_never_give_any)
{
    for (const char* const name : {"cube", "sphere:12x12"}) {
        const TriangleMesh mesh = *sample_mesh(name);
        const MeshContactSurface surface(mesh);
        const WorkspaceMap map = fit_workspace(bounding_box(mesh), 0.1);
        for (std::uint64_t seed = 1; seed <= 3; ++seed) {
            const Vec3 corner = map.to_device(mesh.positions()[seed % mesh.positions().size()]);
            const Loop loop(corner, 0.004, seed);
            const Vec3 from = corner + 0.05 * corner.normalized();
            const PathEnergy energy = energy_of(surface, map, from, loop, 10000);
            if (energy.depth > 0) {
                EXPECT_GT(energy.trapezoid, -1e-6) << name << seed;
            }
        }
    }
}

} // namespace
} // namespace proxima
