#include "proxima/triangle_mesh.h"

#include "base/hash.h"
#include "base/text.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace proxima {

Result<TriangleMesh> make_triangle_mesh(std::vector<Vec3> positions,
                                        std::vector<TriangleCorners> triangles)
{
    if (positions.size() >= std::numeric_limits<std::uint32_t>::max()) {
        return fail(ErrorCode::limit_exceeded,
                    concat("a mesh has at most 2^32 - 2 vertices, this one ", positions.size()));
    }
    if (triangles.size() > std::numeric_limits<std::int32_t>::max()) {
        return fail(ErrorCode::limit_exceeded,
                    concat("a mesh has at most 2^31 - 1 triangles, this one ", triangles.size()));
    }
    for (std::size_t triangle = 0; triangle < triangles.size(); ++triangle) {
        for (const std::uint32_t corner : triangles[triangle]) {
            if (corner >= positions.size()) {
                return fail(ErrorCode::invalid_mesh,
                            concat("triangle ", triangle, " uses vertex ", corner,
                                   " but there are only ", positions.size(), " vertices"));
            }
        }
    }
    TriangleMesh mesh;
    mesh.positions_ = std::move(positions);
    mesh.triangles_ = std::move(triangles);
    return mesh;
}

Result<TriangleMesh> mesh_of_points(std::vector<Vec3> positions)
{
    const std::size_t most = std::numeric_limits<std::int32_t>::max();
    std::vector<TriangleCorners> triangles(std::min(positions.size(), most + 1));
    for (std::size_t i = 0; i < triangles.size(); ++i)
        triangles[i].fill(static_cast<std::uint32_t>(i));
    return make_triangle_mesh(std::move(positions), std::move(triangles));
}

Result<TriangleMesh> mesh_of_segments(std::vector<Vec3> positions,
                                      std::span<const std::array<std::uint32_t, 2>> segments)
{
    std::vector<TriangleCorners> triangles;
    triangles.reserve(segments.size());
    for (const auto& [first, second] : segments) triangles.push_back({first, second, second});
    return make_triangle_mesh(std::move(positions), std::move(triangles));
}

namespace {

/// One byte per vertex, 1 where a triangle uses it: a pass over vertices in order is then cheaper
/// than visiting them by triangles.
std::vector<std::uint8_t> find_used_vertices(const TriangleMesh& mesh)
{
    std::vector<std::uint8_t> is_used(mesh.vertex_count(), 0);
    for (const TriangleCorners& corners : mesh.triangles()) {
        for (const std::uint32_t corner : corners) is_used[corner] = 1;
    }
    return is_used;
}

} // namespace

Box bounding_box(const TriangleMesh& mesh)
{
    const auto is_used = find_used_vertices(mesh);
    Box box;
    for (std::size_t vertex = 0; vertex < is_used.size(); ++vertex) {
        if (is_used[vertex] != 0) box.extend(mesh.positions()[vertex]);
    }
    return box;
}

Result<Box> checked_bounding_box(const TriangleMesh& mesh)
{
    if (mesh.triangle_count() == 0) {
        return fail(ErrorCode::invalid_mesh,
                    "the mesh has no triangles: there is nothing to build");
    }
    const auto is_used = find_used_vertices(mesh);
    Box box;
    for (std::size_t vertex = 0; vertex < is_used.size(); ++vertex) {
        if (is_used[vertex] == 0) continue;
        const Vec3& position = mesh.positions()[vertex];
        box.extend(position);
        // Zero times infinity or NaN is NaN.
        if (!((position * 0.0).sum() == 0.0)) {
            return fail(ErrorCode::invalid_mesh,
                        concat("vertex ", vertex,
                               ", which triangles use, has a NaN or infinite "
                               "coordinate: repair or remove it"));
        }
    }
    return box;
}

std::uint64_t mesh_fingerprint(const TriangleMesh& mesh)
{
    const std::uint64_t positions = hash_bytes(std::as_bytes(mesh.positions()), 0);
    return hash_bytes(std::as_bytes(mesh.triangles()), positions);
}

} // namespace proxima
