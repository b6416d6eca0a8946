// Small random meshes with everything wrong at once: repeated ids, shared and equal positions on a
// small integer grid, duplicates, branching edges, unused vertices.
#pragma once

#include "proxima/triangle_mesh.h"

#include <random>

namespace proxima {

/// A number in [0, limit).
inline std::uint32_t below(std::mt19937& random, std::uint32_t limit)
{
    return static_cast<std::uint32_t>(random() % limit);
}

inline TriangleMesh random_soup(std::uint32_t seed)
{
    std::mt19937 random(seed);
    const std::uint32_t vertices = 1 + below(random, 14);
    const std::uint32_t grid = 2 + below(random, 4);
    std::vector<Vec3> positions;
    for (std::uint32_t vertex = 0; vertex < vertices; ++vertex) {
        positions.emplace_back(below(random, grid), below(random, grid), below(random, grid));
    }
    std::vector<TriangleCorners> triangles(below(random, 30));
    for (TriangleCorners& corners : triangles) {
        for (std::uint32_t& corner : corners) corner = below(random, vertices);
    }
    return *make_triangle_mesh(std::move(positions), std::move(triangles));
}

} // namespace proxima
