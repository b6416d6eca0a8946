// Random scenes that hurt: instances in and on each other, exactly touching, of very uneven sizes, far from
// the origin, of any scale, turned by rotations that are only nearly rigid, on few layers.
#pragma once

#include "index/index_parts.h"
#include "index/test_meshes.h"
#include "mesh/random_soups.h"
#include "proxima/scene.h"

#include <Eigen/Geometry>
#include <cmath>
#include <random>
#include <vector>

namespace proxima::testing {

struct RandomScene {
    std::vector<MeshIndex> shapes;
    std::vector<Instance> instances;
    double size = 1; ///< of the box that instances' origins are in
    Vec3 center = Vec3::Zero();
};

class SceneGenerator {
public:
    explicit SceneGenerator(std::uint64_t seed) : random_(seed) {}

    [[nodiscard]] std::uint64_t below(std::uint64_t limit) { return random_() % limit; }
    [[nodiscard]] double unit() { return std::uniform_real_distribution<double>(-1, 1)(random_); }
    [[nodiscard]] Vec3 vector()
    {
        const double x = unit();
        const double y = unit();
        return {x, y, unit()};
    }

    [[nodiscard]] Mat3 rotation()
    {
        switch (below(4)) {
        case 0:
            return Mat3::Identity();
        case 1: { // axes to axes
            Mat3 turn = Mat3::Zero();
            const auto first = static_cast<int>(below(3));
            turn(0, first) = turn(1, (first + 1) % 3) = turn(2, (first + 2) % 3) = 1;
            return turn;
        }
        default: {
            const Eigen::Quaterniond q(unit(), unit(), unit(), unit() + 1e-3);
            Mat3 turn = q.normalized().toRotationMatrix();
            // As far from rigid as is allowed.
            if (below(2) == 0)
                for (int i = 0; i < 9; ++i) turn.data()[i] *= 1 + 1.5e-10 * unit();
            return turn;
        }
        }
    }

    [[nodiscard]] RandomScene operator()(std::size_t most_instances)
    {
        constexpr std::array<double, 6> scales = {1, 1, 1, 1e-200, 1e140, 1e-3};
        const double scale = scales[below(scales.size())];
        RandomScene scene;
        const std::uint64_t shapes = 1 + below(5);
        for (std::uint64_t i = 0; i < shapes; ++i) scene.shapes.push_back(index_of(shape(), scale));
        if (below(4) == 0) scene.shapes.emplace_back(); // of no triangles
        const std::uint64_t count = 1 + below(most_instances);
        const std::uint64_t layout = below(5);
        scene.size = scale * (layout == 0 ? 0
                                          : std::cbrt(static_cast<double>(count)) *
                                                (1 + static_cast<double>(below(3))));
        if (below(3) == 0)
            scene.center = (scale * std::pow(10.0, static_cast<double>(below(7)))) * vector();
        for (std::uint64_t i = 0; i < count; ++i) {
            Instance instance;
            instance.shape = static_cast<std::uint32_t>(below(scene.shapes.size()));
            instance.pose.rotation = layout == 1 ? Mat3(Mat3::Identity()) : rotation();
            Vec3 at = scene.size * vector();
            if (layout == 1) at = (scale * (4 * vector()).array().round()).matrix(); // in a grid
            if (layout == 2 && below(2) == 0) at *= 1e-3;
            instance.pose.translation = scene.center + at;
            instance.layers = below(3) == 0 ? 1U << below(3) : all_layers;
            scene.instances.push_back(instance);
            if (below(8) == 0) scene.instances.push_back(instance); // twice
        }
        return scene;
    }

private:
    [[nodiscard]] TriangleMesh shape()
    {
        const auto seed = static_cast<std::uint32_t>(random_());
        switch (below(7)) {
        case 0:
            return cube_mesh(Vec3::Zero(), 0.5);
        case 1:
            return sphere_mesh(0.3 * vector(), 0.4, 6, 8);
        case 2:
            return grid_mesh(seed);
        case 3:
            return torus_mesh(0.8, 0.3, 9, 7);
        case 4:
            return sliver_strip();
        case 5: // far from its own origin, large beside the others
            return moved(cube_mesh(Vec3::Zero(), 3),
                         [&](const Vec3& p) { return Vec3(p + Vec3(30, 20, -10)); });
        default:
            return mesh_of({Vec3(0, 0, 0), Vec3(0.7, 0, 0), Vec3(0, 0.7, 0)}, {{0, 1, 2}});
        }
    }
    static MeshIndex index_of(const TriangleMesh& mesh, double scale)
    {
        return build_mesh_index(moved(mesh, [&](const Vec3& p) { return Vec3(scale * p); }))
            .value();
    }

    std::mt19937_64 random_;
};

/// So many instances of some shapes, a tenth of their boxes overlapping others.
inline RandomScene many_instances(std::size_t count, std::uint64_t seed)
{
    SceneGenerator random(seed);
    RandomScene of;
    of.shapes = {build_mesh_index(sphere_mesh(Vec3::Zero(), 0.5, 8, 12)).value(),
                 build_mesh_index(torus_mesh(0.4, 0.15, 12, 8)).value(),
                 build_mesh_index(cube_mesh(Vec3::Zero(), 0.3)).value()};
    of.size = std::cbrt(static_cast<double>(count));
    for (std::size_t i = 0; i < count; ++i) {
        Instance instance;
        instance.shape = static_cast<std::uint32_t>(random.below(3));
        instance.pose.rotation = random.rotation();
        instance.pose.translation = of.size * random.vector();
        instance.layers = 1U << (i % 4);
        of.instances.push_back(instance);
    }
    return of;
}

} // namespace proxima::testing
