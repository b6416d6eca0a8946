#include "proxima/mesh/triangle_mesh.h"

#include "proxima/base/text.h"

#include <limits>

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

Box bounding_box(const TriangleMesh& mesh) noexcept
{
    Box box;
    for (const TriangleCorners& corners : mesh.triangles()) {
        for (const std::uint32_t corner : corners)
            box.extend(mesh.positions()[corner]);
    }
    return box;
}

Status check_positions(const TriangleMesh& mesh)
{
    if (mesh.triangle_count() == 0) {
        return fail(ErrorCode::invalid_mesh,
                    "the mesh has no triangles: there is nothing to build");
    }
    for (std::size_t triangle = 0; triangle < mesh.triangle_count(); ++triangle) {
        for (const std::uint32_t corner : mesh.triangles()[triangle]) {
            if (!mesh.positions()[corner].allFinite()) {
                return fail(ErrorCode::invalid_mesh,
                            concat("vertex ", corner, " of triangle ", triangle,
                                   " has a NaN or infinite coordinate: repair or remove it"));
            }
        }
    }
    return {};
}

} // namespace proxima
