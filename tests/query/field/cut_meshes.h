// Meshes with a hole.
#pragma once

#include "index/test_meshes.h"
#include "proxima/triangle_mesh.h"

#include <cstdint>
#include <vector>

namespace proxima::testing {

/// Without the triangles whose middle is beyond the plane z = `height`.
inline TriangleMesh cut_off(const TriangleMesh& mesh, double height)
{
    std::vector<TriangleCorners> kept;
    for (std::uint32_t id = 0; id < mesh.triangle_count(); ++id) {
        const Triangle t = mesh.triangle(TriangleId{id});
        if (t[0].z() + t[1].z() + t[2].z() < 3 * height) kept.push_back(mesh.triangles()[id]);
    }
    return mesh_of({mesh.positions().begin(), mesh.positions().end()}, kept);
}

} // namespace proxima::testing
