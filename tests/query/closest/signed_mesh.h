// Meshes with their signs, for tests of signed distances.
#pragma once

#include "index/index_parts.h"
#include "index/signs/sign_parts.h"
#include "index/test_meshes.h"
#include "proxima/mesh_index.h"
#include "proxima/signed_distance.h"

#include <cmath>
#include <utility>

namespace proxima::testing {

/// A mesh with its index with signs.
struct Signed {
    explicit Signed(TriangleMesh m)
        : mesh(std::move(m)), index(with_signs(build_mesh_index(mesh).value()).value())
    {}

    /// \pre p is finite
    [[nodiscard]] SignedDistance at(const Vec3& p) const
    {
        return signed_distance(index, p).value();
    }

    [[nodiscard]] bool is_local() const { return has_local_signs(index); }

    /// What the triangle tells about its sides.
    [[nodiscard]] SurfaceSides sides(TriangleId id) const
    {
        const SignArrays& signs = arrays();
        return signs.sides.empty() ? SurfaceSides::doubtful : signs.sides[signs.rows[to_index(id)]];
    }

    [[nodiscard]] const SignArrays& arrays() const { return index.parts().signs()->arrays(); }

    TriangleMesh mesh;
    MeshIndex index;
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
