// The immutable triangle mesh that everything is built from.
//
//     positions  v0 v1 v2 ...            doubles, in the order of the file
//     triangles  (0,1,2) (2,1,3) ...     indices into positions, counter-clockwise seen from outside
#pragma once

#include "proxima/export.h"
#include "proxima/geometry.h"
#include "proxima/result.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace PROXIMA_EXPORT proxima {

enum class VertexId : std::uint32_t {};
enum class TriangleId : std::uint32_t {};

[[nodiscard]] constexpr std::uint32_t to_index(VertexId id) noexcept
{
    return static_cast<std::uint32_t>(id);
}
[[nodiscard]] constexpr std::uint32_t to_index(TriangleId id) noexcept
{
    return static_cast<std::uint32_t>(id);
}

/// Corner indices of one triangle.
using TriangleCorners = std::array<std::uint32_t, 3>;

/// Vertices and triangles, immutable. Indices are in range; positions may be any double (NaN and
/// infinity included: builders refuse them by checked_bounding_box). Thread safe.
class TriangleMesh {
public:
    TriangleMesh() = default;

    [[nodiscard]] std::span<const Vec3> positions() const noexcept { return positions_; }
    [[nodiscard]] std::span<const TriangleCorners> triangles() const noexcept { return triangles_; }
    [[nodiscard]] std::size_t vertex_count() const noexcept { return positions_.size(); }
    [[nodiscard]] std::size_t triangle_count() const noexcept { return triangles_.size(); }

    /// \pre id is in range
    [[nodiscard]] const Vec3& position(VertexId id) const noexcept
    {
        return positions_[to_index(id)];
    }

    /// Corner positions. \pre id is in range
    [[nodiscard]] Triangle triangle(TriangleId id) const noexcept
    {
        const TriangleCorners& corners = triangles_[to_index(id)];
        return {{positions_[corners[0]], positions_[corners[1]], positions_[corners[2]]}};
    }

private:
    friend Result<TriangleMesh> make_triangle_mesh(std::vector<Vec3> positions,
                                                   std::vector<TriangleCorners> triangles);
    std::vector<Vec3> positions_;
    std::vector<TriangleCorners> triangles_;
};

/// Takes ownership of the arrays. Error invalid_mesh where an index is out of range,
/// limit_exceeded beyond 2^32 - 2 vertices or 2^31 - 1 triangles. O(triangles).
[[nodiscard]] Result<TriangleMesh> make_triangle_mesh(std::vector<Vec3> positions,
                                                      std::vector<TriangleCorners> triangles);

/// A point cloud as a mesh: triangle i is (i, i, i), without area, and its closest feature is always
/// vertex i. Every query takes such meshes. They have no inside, and a ray hits them only where it
/// meets a point exactly. Errors and cost of make_triangle_mesh.
[[nodiscard]] Result<TriangleMesh> mesh_of_points(std::vector<Vec3> positions);

/// Segments, such as those of polylines, as a mesh: triangle i is (v, w, w) of segment (v, w).
[[nodiscard]] Result<TriangleMesh>
mesh_of_segments(std::vector<Vec3> positions,
                 std::span<const std::array<std::uint32_t, 2>> segments);

/// Tight box of the vertices that triangles use; empty where there is no triangle. O(triangles).
[[nodiscard]] Box bounding_box(const TriangleMesh& mesh);

/// The same for builders: error invalid_mesh for an empty mesh, or naming the first vertex in use
/// with a NaN or infinite coordinate. O(triangles).
[[nodiscard]] Result<Box> checked_bounding_box(const TriangleMesh& mesh);

/// A hash of 64 bits of positions and triangles: different meshes share one very rarely. O(mesh).
[[nodiscard]] std::uint64_t mesh_fingerprint(const TriangleMesh& mesh);

} // namespace proxima
