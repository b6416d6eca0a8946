// A mesh as other libraries take it: plain arrays.
#pragma once

#include "proxima/sample_meshes.h"
#include "proxima/triangle_mesh.h"

#include <cstdint>
#include <string_view>
#include <vector>

namespace proxima::testing {

struct Arrays {
    std::vector<float> points; ///< x, y, z of each
    std::vector<std::uint32_t> corners;
};

[[nodiscard]] inline Arrays arrays_of(std::string_view sample)
{
    const TriangleMesh mesh = *sample_mesh(sample);
    Arrays arrays;
    for (const Vec3& position : mesh.positions()) {
        for (const double coordinate : {position.x(), position.y(), position.z()})
            arrays.points.push_back(static_cast<float>(coordinate));
    }
    for (const TriangleCorners& triangle : mesh.triangles())
        arrays.corners.insert(arrays.corners.end(), triangle.begin(), triangle.end());
    return arrays;
}

/// The mesh of those very floats.
[[nodiscard]] inline TriangleMesh mesh_of(const Arrays& arrays)
{
    std::vector<Vec3> positions;
    for (std::size_t i = 0; i < arrays.points.size(); i += 3)
        positions.emplace_back(arrays.points[i], arrays.points[i + 1], arrays.points[i + 2]);
    std::vector<TriangleCorners> triangles;
    for (std::size_t i = 0; i < arrays.corners.size(); i += 3)
        triangles.push_back({arrays.corners[i], arrays.corners[i + 1], arrays.corners[i + 2]});
    return *make_triangle_mesh(std::move(positions), std::move(triangles));
}

} // namespace proxima::testing
