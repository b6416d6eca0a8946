// Small meshes by hand for the octree's tests: cubes, spheres, tori, and ways to combine them.
#pragma once

#include "proxima/triangle_mesh.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <utility>
#include <vector>

namespace proxima::testing {

/// Makes the mesh; the arrays are known to be right.
inline TriangleMesh mesh_of(std::vector<Vec3> positions, std::vector<TriangleCorners> triangles)
{
    return make_triangle_mesh(std::move(positions), std::move(triangles)).value();
}

/// Twelve triangles, outward.
inline TriangleMesh cube_mesh(const Vec3& center, double half)
{
    std::vector<Vec3> positions(8);
    for (int corner = 0; corner < 8; ++corner) {
        positions[corner] =
            center + half * Vec3((corner & 1) != 0 ? 1 : -1, (corner & 2) != 0 ? 1 : -1,
                                 (corner & 4) != 0 ? 1 : -1);
    }
    return mesh_of(positions, {{0, 4, 6},
                               {0, 6, 2},
                               {1, 3, 7},
                               {1, 7, 5},
                               {0, 1, 5},
                               {0, 5, 4},
                               {2, 6, 7},
                               {2, 7, 3},
                               {0, 2, 3},
                               {0, 3, 1},
                               {4, 5, 7},
                               {4, 7, 6}});
}

/// The radius of the largest ball about the origin that a convex mesh around it holds: no point of
/// its surface is nearer.
inline double inner_radius(const TriangleMesh& mesh)
{
    double least = std::numeric_limits<double>::infinity();
    for (std::uint32_t id = 0; id < mesh.triangle_count(); ++id) {
        const Triangle triangle = mesh.triangle(TriangleId{id});
        least = std::min(least, scaled_normal(triangle).stableNormalized().dot(triangle[0]));
    }
    return least;
}

/// A closed grid of stacks x slices points on a sphere-like or torus-like surface.
inline TriangleMesh torus_mesh(double major, double minor, int slices, int stacks)
{
    std::vector<Vec3> positions;
    std::vector<TriangleCorners> triangles;
    const auto at = [&](int i, int j) {
        return static_cast<std::uint32_t>((i % slices) * stacks + j % stacks);
    };
    for (int i = 0; i < slices; ++i) {
        for (int j = 0; j < stacks; ++j) {
            const double u = 2 * std::numbers::pi * i / slices;
            const double v = 2 * std::numbers::pi * j / stacks;
            const double r = major + minor * std::cos(v);
            positions.emplace_back(r * std::cos(u), r * std::sin(u), minor * std::sin(v));
            triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
            triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
        }
    }
    return mesh_of(std::move(positions), std::move(triangles));
}

/// A sphere of stacks x slices quads with one vertex at each pole, outward.
inline TriangleMesh sphere_mesh(const Vec3& center, double radius, int stacks, int slices)
{
    std::vector<Vec3> positions{center + Vec3(0, 0, radius)};
    for (int i = 1; i < stacks; ++i) {
        for (int j = 0; j < slices; ++j) {
            const double polar = std::numbers::pi * i / stacks;
            const double angle = 2 * std::numbers::pi * j / slices;
            positions.emplace_back(center + radius * Vec3(std::sin(polar) * std::cos(angle),
                                                          std::sin(polar) * std::sin(angle),
                                                          std::cos(polar)));
        }
    }
    positions.emplace_back(center - Vec3(0, 0, radius));
    const auto ring = [&](int i, int j) {
        return static_cast<std::uint32_t>(1 + (i - 1) * slices + j % slices);
    };
    const auto south = static_cast<std::uint32_t>(positions.size() - 1);
    std::vector<TriangleCorners> triangles;
    for (int j = 0; j < slices; ++j) {
        triangles.push_back({0, ring(1, j), ring(1, j + 1)});
        for (int i = 1; i + 1 < stacks; ++i) {
            triangles.push_back({ring(i, j), ring(i + 1, j), ring(i + 1, j + 1)});
            triangles.push_back({ring(i, j), ring(i + 1, j + 1), ring(i, j + 1)});
        }
        triangles.push_back({ring(stacks - 1, j), south, ring(stacks - 1, j + 1)});
    }
    return mesh_of(std::move(positions), std::move(triangles));
}

/// Both meshes as one.
inline TriangleMesh joined(const TriangleMesh& a, const TriangleMesh& b)
{
    std::vector<Vec3> positions(a.positions().begin(), a.positions().end());
    positions.insert(positions.end(), b.positions().begin(), b.positions().end());
    std::vector<TriangleCorners> triangles(a.triangles().begin(), a.triangles().end());
    const auto shift = static_cast<std::uint32_t>(a.vertex_count());
    for (const auto& t : b.triangles()) {
        triangles.push_back({t[0] + shift, t[1] + shift, t[2] + shift});
    }
    return mesh_of(std::move(positions), std::move(triangles));
}

/// Every triangle turned round.
inline TriangleMesh inverted(const TriangleMesh& mesh)
{
    std::vector<TriangleCorners> triangles;
    for (const auto& t : mesh.triangles()) triangles.push_back({t[0], t[2], t[1]});
    return mesh_of({mesh.positions().begin(), mesh.positions().end()}, std::move(triangles));
}

/// Every vertex moved by `move`.
inline TriangleMesh moved(const TriangleMesh& mesh, const std::function<Vec3(const Vec3&)>& move)
{
    std::vector<Vec3> positions;
    for (const Vec3& p : mesh.positions()) positions.push_back(move(p));
    return mesh_of(std::move(positions), {mesh.triangles().begin(), mesh.triangles().end()});
}

/// Without the triangles for which `drop(index)` holds.
inline TriangleMesh without(const TriangleMesh& mesh, const std::function<bool(std::size_t)>& drop)
{
    std::vector<TriangleCorners> triangles;
    for (std::size_t i = 0; i < mesh.triangle_count(); ++i) {
        if (!drop(i)) triangles.push_back(mesh.triangles()[i]);
    }
    return mesh_of({mesh.positions().begin(), mesh.positions().end()}, std::move(triangles));
}

} // namespace proxima::testing
