#include "ray_sets.h"

#include <cmath>
#include <random>

namespace proxima::bench {
namespace {

Vec3 to_floats(const Vec3& p)
{
    // One by one: g++ 12 drops the rounding where it makes vectors of such a way there and back.
    Vec3 rounded;
    for (int axis = 0; axis < 3; ++axis) {
        volatile auto nearest = static_cast<float>(p[axis]);
        rounded[axis] = static_cast<double>(nearest);
    }
    return rounded;
}

Ray float_ray(const Vec3& origin, const Vec3& direction)
{
    return {to_floats(origin), to_floats(direction)};
}

} // namespace

std::array<RaySet, 2> ray_sets(const TriangleMesh& mesh, std::size_t side, std::uint64_t seed)
{
    const Box box = bounding_box(mesh);
    const double radius = 0.5 * box.extent().norm();
    std::array<RaySet, 2> sets = {
        {{"coherent", Coherence::coherent, {}}, {"incoherent", Coherence::incoherent, {}}}};

    constexpr double half_angle_tangent = 0.4;
    const double sine = half_angle_tangent / std::hypot(1.0, half_angle_tangent);
    const Vec3 toward_eye = Vec3(0.3, 0.4, 1.0).normalized();
    const Vec3 eye = box.center() + 0.5 * box.extent().maxCoeff() / sine * toward_eye;
    const Vec3 right = Vec3::UnitY().cross(toward_eye).normalized();
    const Vec3 up = toward_eye.cross(right);
    for (std::size_t y = 0; y < side; ++y) {
        for (std::size_t x = 0; x < side; ++x) {
            const auto place = [&](std::size_t i) {
                return half_angle_tangent *
                       ((2 * static_cast<double>(i) + 1) / static_cast<double>(side) - 1);
            };
            sets[0].rays.push_back(float_ray(eye, place(x) * right - place(y) * up - toward_eye));
        }
    }
    std::mt19937_64 random(seed);
    std::normal_distribution<double> normal;
    const auto on_sphere = [&]() -> Vec3 {
        const double x = normal(random);
        const double y = normal(random);
        return box.center() + radius * Vec3(x, y, normal(random)).normalized();
    };
    for (std::size_t i = 0; i < side * side; ++i) {
        const Vec3 from = on_sphere();
        sets[1].rays.push_back(float_ray(from, on_sphere() - from));
    }
    return sets;
}

TriangleMesh rounded_to_floats(const TriangleMesh& mesh)
{
    std::vector<Vec3> positions;
    positions.reserve(mesh.vertex_count());
    for (const Vec3& p : mesh.positions()) positions.push_back(to_floats(p));
    return make_triangle_mesh(std::move(positions),
                              {mesh.triangles().begin(), mesh.triangles().end()})
        .value();
}

} // namespace proxima::bench
