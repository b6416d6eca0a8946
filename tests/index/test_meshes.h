// Meshes and points that closest-feature searches are tried on: closed, open, non-manifold,
// duplicated, degenerate, slivers, soups.
#pragma once

#include "minkowski/scalar_vector.h"
#include "octree/nasty_meshes.h"
#include "octree/small_meshes.h"
#include "proxima/sample_meshes.h"
#include "proxima/topology.h"

#include <random>
#include <string>
#include <vector>

namespace proxima::testing {

struct NamedMesh {
    std::string name;
    TriangleMesh mesh;
};

/// Corners in a 5^3 grid: shared, repeated, coplanar, collinear, duplicated, degenerate.
inline TriangleMesh grid_mesh(std::uint32_t seed)
{
    std::mt19937 random(seed);
    const auto below = [&](std::uint32_t n) { return static_cast<std::uint32_t>(random() % n); };
    std::vector<Vec3> positions(4 + below(8));
    for (Vec3& position : positions) {
        position = Eigen::Vector<std::uint32_t, 3>{below(5), below(5), below(5)}.cast<double>();
    }
    const auto vertices = static_cast<std::uint32_t>(positions.size());
    std::vector<TriangleCorners> triangles(1 + below(20));
    for (TriangleCorners& corners : triangles) {
        corners = {below(vertices), below(vertices), below(vertices)};
    }
    return mesh_of(std::move(positions), std::move(triangles));
}

/// A strip of triangles a million times as long as wide, along a skew line.
inline TriangleMesh sliver_strip()
{
    const Vec3 along = Vec3(1, 2, 3).normalized();
    const Vec3 across = 1e-6 * along.cross(Vec3(1, 0, 0)).normalized();
    std::vector<Vec3> positions;
    std::vector<TriangleCorners> triangles;
    for (std::uint32_t i = 0; i < 40; ++i) {
        positions.emplace_back(along * (i % 2) + across * i);
        if (i >= 2) triangles.push_back({i - 2, i - 1, i});
    }
    return mesh_of(std::move(positions), std::move(triangles));
}

/// Triangles round a common edge like the pages of a book, and round a common vertex.
inline TriangleMesh fans()
{
    std::vector<Vec3> positions = {Vec3(0, 0, 0), Vec3(0, 0, 1)};
    std::vector<TriangleCorners> triangles;
    for (std::uint32_t i = 0; i < 7; ++i) {
        positions.emplace_back(std::cos(i), std::sin(i), 0.5);
        triangles.push_back({0, 1, i + 2});
        if (i % 2 == 1) triangles.push_back({1, i + 1, i + 2});
    }
    return mesh_of(std::move(positions), std::move(triangles));
}

inline std::vector<NamedMesh> proximity_meshes()
{
    const TriangleMesh sphere = sphere_mesh(Vec3(0.1, 0.2, 0.3), 1.0, 12, 16);
    const TriangleMesh cube = cube_mesh(Vec3::Zero(), 1.0);
    std::vector<TriangleCorners> twice(cube.triangles().begin(), cube.triangles().end());
    twice.insert(twice.end(), cube.triangles().begin(), cube.triangles().end());
    std::vector<NamedMesh> meshes = {
        {"cube", cube},
        {"sphere", sphere},
        {"torus", torus_mesh(1.0, 0.3, 24, 12)},
        {"open sphere", without(sphere, [](std::size_t i) { return i % 5 == 0; })},
        {"nested spheres", joined(sphere, sphere_mesh(Vec3(0.1, 0.2, 0.3), 0.5, 8, 8))},
        {"duplicated", mesh_of({cube.positions().begin(), cube.positions().end()}, twice)},
        {"fans", fans()},
        {"slivers", sliver_strip()},
        {"long cylinder",
         moved(sphere, [](const Vec3& p) { return Vec3(p[0], p[1], 1e4 * p[2]); })},
        {"far away", moved(sphere, [](const Vec3& p) { return Vec3(p + Vec3(1e7, -1e7, 1e7)); })},
        {"one triangle", mesh_of({Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)}, {{0, 1, 2}})},
        {"a segment and a point",
         mesh_of({Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(5, 5, 5)}, {{0, 1, 1}, {2, 2, 2}})},
        {"spaceship", sample_mesh("spaceship:1300").value()}};
    for (std::uint32_t seed = 0; seed < 12; ++seed) {
        meshes.push_back({"nasty " + std::to_string(seed), nasty_mesh(seed)});
        meshes.push_back({"grid " + std::to_string(seed), grid_mesh(seed)});
    }
    return meshes;
}

/// Points in and around the box, near the surface, on it, at vertices and far away.
inline std::vector<Vec3> proximity_points(const TriangleMesh& mesh, int count, unsigned seed)
{
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> unit(0.0, 1.0);
    const Box box = bounding_box(mesh);
    const double size = box.extent().maxCoeff();
    const auto anywhere = [&](double reach) {
        return Vec3(box.center() +
                    reach * size *
                        Vec3(unit(random) - 0.5, unit(random) - 0.5, unit(random) - 0.5));
    };
    const auto on_surface = [&] {
        const Triangle triangle =
            mesh.triangle(TriangleId{static_cast<std::uint32_t>(random() % mesh.triangle_count())});
        const double u = unit(random);
        const double v = (1 - u) * unit(random);
        return Vec3(triangle[0] + u * (triangle[1] - triangle[0]) +
                    v * (triangle[2] - triangle[0]));
    };
    std::vector<Vec3> points;
    for (int i = 0; i < count; ++i) {
        const auto vertex = static_cast<std::uint32_t>(random() % mesh.vertex_count());
        switch (i % 6) {
        case 0:
            points.push_back(on_surface());
            break;
        case 1:
            points.push_back(mesh.position(VertexId{vertex}));
            break;
        case 2:
            points.emplace_back(on_surface() + 1e-3 * (anywhere(1.0) - box.center()));
            break;
        case 3:
            points.push_back(anywhere(20.0));
            break;
        default:
            points.push_back(anywhere(1.4));
            break;
        }
    }
    return points;
}

} // namespace proxima::testing
