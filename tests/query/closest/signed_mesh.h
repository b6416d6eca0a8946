// Meshes with all that signed distances need, for tests of them.
#pragma once

#include "index/test_meshes.h"
#include "proxima/mesh_index.h"
#include "proxima/signed_distance.h"
#include "query/closest/sign_parts.h"

#include <cmath>
#include <utility>

namespace proxima::testing {

/// A mesh with all that signed distances need.
struct Signed {
    explicit Signed(TriangleMesh m)
        : mesh(std::move(m)), topology(build_topology(mesh).value()),
          to_index(build_mesh_index(mesh).value()),
          sign(build_surface_sign(mesh, topology, index).value())
    {}
    Signed(const Signed&) = delete;
    Signed& operator=(const Signed&) = delete;

    [[nodiscard]] SignedDistance at(const Vec3& p) const { return sign_of(sign, closest(p), p); }

    /// no_closest_feature() where there is none.
    [[nodiscard]] ClosestFeature closest(const Vec3& p) const
    {
        return closest_feature(index, p).value_or(no_closest_feature());
    }

    TriangleMesh mesh;
    Topology topology;
    MeshIndex index;
    SurfaceSign sign;
};

inline TriangleMesh ball(const Vec3& center, double radius)
{
    return sphere_mesh(center, radius, 9, 11);
}

/// A closed prism over a polygon that is a knife: the angle at its edge is `angle`.
inline TriangleMesh knife(double angle)
{
    const Vec3 a(0, 0, 0);
    const Vec3 b(1, 0, 0);
    const Vec3 c(std::cos(angle), std::sin(angle), 0);
    const Vec3 up(0, 0, 1);
    return mesh_of(
        {a, b, c, a + up, b + up, c + up},
        {{0, 2, 1}, {3, 4, 5}, {0, 1, 4}, {0, 4, 3}, {1, 2, 5}, {1, 5, 4}, {2, 0, 3}, {2, 3, 5}});
}

} // namespace proxima::testing
