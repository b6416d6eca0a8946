#include "mesh/weld_vertices.h"

#include "base/progress.h"
#include "mesh/vertex_table.h"
#include "proxima/execution.h"
#include "proxima/mesh_repair.h"

#include <algorithm>
#include <array>
#include <utility>

namespace proxima {

bool weld_vertices(std::vector<Vec3>& positions, std::vector<TriangleCorners>& triangles,
                   Progress* progress)
{
    StageSteps steps(progress, "welding vertices", positions.size() + triangles.size());
    VertexTable table(positions.size());
    std::vector<std::uint32_t> new_ids(positions.size());
    constexpr std::size_t block = 256;
    std::array<std::uint64_t, block> hashes{};
    for (std::size_t begin = 0; begin < positions.size(); begin += block) {
        const std::size_t count = std::min(block, positions.size() - begin);
        for (std::size_t i = 0; i < count; ++i) {
            hashes[i] = VertexTable::hash(positions[begin + i]);
            table.prefetch(hashes[i]);
        }
        for (std::size_t i = 0; i < count; ++i) {
            // Kept vertices move to the front, never beyond the current vertex.
            const Vec3 position = positions[begin + i];
            const std::uint32_t next = table.size();
            const std::uint32_t id = table.find_or_add(hashes[i], position, positions.data());
            if (id == next) positions[id] = position;
            new_ids[begin + i] = id;
        }
        if (!steps.done(count)) return false;
    }
    positions.resize(table.size());
    for (TriangleCorners& corners : triangles) {
        for (std::uint32_t& corner : corners) corner = new_ids[corner];
        if (!steps.done(1)) return false;
    }
    return true;
}

std::uint64_t weld_scratch_bytes(std::uint64_t vertex_count) noexcept
{
    return VertexTable::bytes_for(vertex_count) + vertex_count * sizeof(std::uint32_t);
}

Result<TriangleMesh> weld_vertices(const TriangleMesh& mesh, const Execution& execution)
{
    std::vector<Vec3> positions(mesh.positions().begin(), mesh.positions().end());
    std::vector<TriangleCorners> triangles(mesh.triangles().begin(), mesh.triangles().end());
    if (!weld_vertices(positions, triangles, execution.progress))
        return cancelled("welding vertices");
    return make_triangle_mesh(std::move(positions), std::move(triangles));
}

} // namespace proxima
