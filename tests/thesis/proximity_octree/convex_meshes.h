// Convex meshes for the tests: round, flat, thin, random, with coplanar faces and parallel edges.
#pragma once

#include "minkowski/drawn_surface.h"
#include "proxima/convex_polyhedron.h"
#include "proxima/sample_meshes.h"
#include "proxima/triangle_mesh.h"

#include <cmath>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

namespace proxima::test {

/// The hull of the points, its facets cut into triangles.
inline TriangleMesh hull_mesh(const std::vector<Vec3>& points)
{
    const auto hull = convex_hull(points);
    if (!hull) throw std::runtime_error(describe(hull.error()));
    const auto surface = draw(*hull);
    if (!surface) throw std::runtime_error(describe(surface.error()));
    return *triangulate(*surface);
}

/// The mesh with other positions, in the same order.
template <class Map>
TriangleMesh mapped(const TriangleMesh& mesh, Map map)
{
    std::vector<Vec3> positions;
    for (const Vec3& position : mesh.positions()) positions.emplace_back(map(position));
    return *make_triangle_mesh(std::move(positions),
                               {mesh.triangles().begin(), mesh.triangles().end()});
}

struct NamedMesh {
    std::string name;
    TriangleMesh mesh;
};

/// Of whole coordinates, so that coplanar faces are exactly so.
inline TriangleMesh random_hull(std::mt19937& random)
{
    std::uniform_int_distribution<int> pick(0, 2);
    const int reach = std::array{2, 12, 1000}[static_cast<std::size_t>(pick(random))];
    std::uniform_int_distribution<int> coordinate(-reach, reach);
    while (true) {
        std::vector<Vec3> points(static_cast<std::size_t>(5 + 12 * pick(random)));
        for (Vec3& point : points) {
            point = Eigen::Vector3i{coordinate(random), coordinate(random), coordinate(random)}
                        .cast<double>();
        }
        const auto hull = convex_hull(points);
        if (hull && hull->dimension() == 3) return hull_mesh(points);
    }
}

/// A box of n x n quads on every side: vertices inside edges and inside faces.
inline TriangleMesh gridded_box(int n)
{
    const TriangleMesh cube = make_cube();
    std::vector<Vec3> positions;
    std::vector<TriangleCorners> triangles;
    const auto vertex = [&](const Vec3& p) {
        for (std::uint32_t i = 0; i < positions.size(); ++i)
            if (positions[i] == p) return i;
        positions.push_back(p);
        return static_cast<std::uint32_t>(positions.size() - 1);
    };
    for (int axis = 0; axis < 3; ++axis) {
        for (const int side : {-1, 1}) {
            for (int i = 0; i < n; ++i) {
                for (int j = 0; j < n; ++j) {
                    const auto at = [&](int u, int v) {
                        Vec3 p;
                        p[axis] = side * n;
                        p[(axis + 1) % 3] = 2 * u - n;
                        p[(axis + 2) % 3] = 2 * v - n;
                        return vertex(p);
                    };
                    std::array corners = {at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)};
                    if (side < 0) std::swap(corners[1], corners[3]);
                    triangles.push_back({corners[0], corners[1], corners[2]});
                    triangles.push_back({corners[0], corners[2], corners[3]});
                }
            }
        }
    }
    return *make_triangle_mesh(std::move(positions), std::move(triangles));
}

/// A fixed collection of shapes of every kind.
inline std::vector<NamedMesh> convex_meshes()
{
    std::mt19937 random(20240501);
    std::vector<NamedMesh> meshes;
    const auto add = [&](const std::string& name, TriangleMesh mesh) {
        meshes.push_back({name, std::move(mesh)});
    };
    add("cube", make_cube());
    add("octahedron", make_octahedron());
    add("icosphere", make_icosphere(2));
    add("sphere", make_sphere(12, 16));
    add("gridded box", gridded_box(3));
    add("plate",
        mapped(gridded_box(2), [](const Vec3& p) { return Vec3(p.x(), p.y(), 1e-5 * p.z()); }));
    add("needle", mapped(make_octahedron(),
                         [](const Vec3& p) { return Vec3(1e-5 * p.x(), 1e-4 * p.y(), p.z()); }));
    const Eigen::Quaterniond turn = Eigen::Quaterniond(0.3, 0.7, -0.2, 0.5).normalized();
    add("turned sphere far away", mapped(make_sphere(8, 10), [&](const Vec3& p) {
            return Vec3(turn * p + Vec3(1e3, -2e3, 5e2));
        }));
    add("tiny turned icosphere",
        mapped(make_icosphere(1), [&](const Vec3& p) { return Vec3(1e-7 * (turn * p)); }));
    add("huge sphere", mapped(make_sphere(6, 7), [](const Vec3& p) { return Vec3(1e9 * p); }));
    for (int i = 0; i < 12; ++i) add("random hull " + std::to_string(i), random_hull(random));
    return meshes;
}

} // namespace proxima::test
