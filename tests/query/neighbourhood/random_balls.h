// Balls about points near and far, of all sizes, for tests of what is within them.
#pragma once

#include "index/test_meshes.h"
#include "proxima/mesh_index.h"
#include "proxima/topology.h"

#include <cmath>
#include <gtest/gtest.h>
#include <random>

namespace proxima::testing {

/// A ball about a point, and how far distances from it may be off.
struct Ball {
    Vec3 p;
    double radius = 0;
    double rounding = 0;
};

/// Calls body(mesh, topology, index, ball) for `count` balls of all sizes about each mesh.
template <class Body>
void for_balls(int count, unsigned seed, const Body& body)
{
    std::mt19937 random(seed);
    for (const NamedMesh& named : proximity_meshes()) {
        SCOPED_TRACE(named.name);
        const TriangleMesh& mesh = named.mesh;
        const Topology topology = build_topology(mesh).value();
        const MeshIndex index = build_mesh_index(mesh).value();
        const Box bounds = bounding_box(mesh);
        const double size = bounds.extent().maxCoeff();
        for (const Vec3& p : proximity_points(mesh, count, seed + 1)) {
            const double radius = std::ldexp(size, 1 - static_cast<int>(random() % 9));
            const double reach = bounds.lower.cwiseAbs().maxCoeff() + p.cwiseAbs().maxCoeff();
            body(mesh, topology, index, Ball{p, radius, 1e-13 * (size + reach)});
        }
    }
}

} // namespace proxima::testing
