#include "proxima/mesh_repair.h"

#include <algorithm>
#include <utility>
#include <vector>

namespace proxima {

TriangleMesh sub_mesh(const TriangleMesh& mesh, std::span<const TriangleId> triangles)
{
    std::vector<std::uint32_t> used;
    used.reserve(3 * triangles.size());
    for (const TriangleId id : triangles) {
        const TriangleCorners& corners = mesh.triangles()[to_index(id)];
        used.insert(used.end(), corners.begin(), corners.end());
    }
    std::ranges::sort(used);
    used.erase(std::unique(used.begin(), used.end()), used.end());

    std::vector<Vec3> positions;
    positions.reserve(used.size());
    for (const std::uint32_t vertex : used) positions.push_back(mesh.position(VertexId{vertex}));
    std::vector<TriangleCorners> renamed;
    renamed.reserve(triangles.size());
    for (const TriangleId id : triangles) {
        TriangleCorners corners = mesh.triangles()[to_index(id)];
        for (std::uint32_t& corner : corners) {
            const auto rank = std::ranges::lower_bound(used, corner) - used.begin();
            corner = static_cast<std::uint32_t>(rank);
        }
        renamed.push_back(corners);
    }
    // Cannot fail: indices are in range, and neither vertices nor triangles are more than before.
    return std::move(*make_triangle_mesh(std::move(positions), std::move(renamed)));
}

} // namespace proxima
