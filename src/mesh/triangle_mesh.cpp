#include "proxima/triangle_mesh.h"

#include "base/hash.h"
#include "base/text.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <string_view>
#include <utility>

namespace proxima {

namespace {

/// Refuses more than 2^31 - 1 things; `things` is their name in the plural.
Status check_count(std::size_t count, std::string_view things)
{
    if (count <= std::numeric_limits<std::int32_t>::max()) return {};
    return fail(ErrorCode::limit_exceeded,
                concat("a mesh has at most 2^31 - 1 ", things, ", this one ", count));
}

/// Refuses too many things, and indices beyond the positions. The names are for the message.
template <std::size_t N>
Status check_indices(std::span<const std::array<std::uint32_t, N>> things, std::size_t positions,
                     std::string_view thing, std::string_view position, std::string_view plural)
{
    if (Status status = check_count(things.size(), concat(thing, "s")); !status) return status;
    for (std::size_t i = 0; i < things.size(); ++i) {
        for (const std::uint32_t index : things[i]) {
            if (index < positions) continue;
            return fail(ErrorCode::invalid_mesh,
                        concat(thing, " ", i, " uses ", position, " ", index, ": there are only ",
                               positions, " ", plural));
        }
    }
    return {};
}

} // namespace

Result<TriangleMesh> make_triangle_mesh(std::vector<Vec3> positions,
                                        std::vector<TriangleCorners> triangles)
{
    if (positions.size() >= std::numeric_limits<std::uint32_t>::max()) {
        return fail(ErrorCode::limit_exceeded,
                    concat("a mesh has at most 2^32 - 2 vertices, this one ", positions.size()));
    }
    const std::span<const TriangleCorners> corners = triangles;
    if (Status status = check_indices(corners, positions.size(), "triangle", "vertex", "vertices");
        !status)
        return tl::unexpected(status.error());
    TriangleMesh mesh;
    mesh.positions_ = std::move(positions);
    mesh.triangles_ = std::move(triangles);
    return mesh;
}

Result<TriangleMesh> mesh_of_points(std::vector<Vec3> positions)
{
    if (Status status = check_count(positions.size(), "points"); !status)
        return tl::unexpected(status.error());
    std::vector<TriangleCorners> triangles(positions.size());
    for (std::size_t i = 0; i < triangles.size(); ++i)
        triangles[i].fill(static_cast<std::uint32_t>(i));
    return make_triangle_mesh(std::move(positions), std::move(triangles));
}

Result<TriangleMesh> mesh_of_segments(std::vector<Vec3> positions,
                                      std::span<const std::array<std::uint32_t, 2>> segments)
{
    if (Status status = check_indices(segments, positions.size(), "segment", "point", "points");
        !status)
        return tl::unexpected(status.error());
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
