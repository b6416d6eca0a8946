// Signs of a mesh index: what tells inside from outside. Triangles are those of the index's rows.
//
//     triangle   its row, by id                                                          4 bytes
//     row        what lies on its two sides                                                    1
//     vertex     what lies on the sides of all its triangles; pseudonormal, least height  1 + 32
//     edge       the row of its second triangle, or where the list of all begins               4
//     clusters   winding numbers (octree/winding_clusters.h), their order in rows
//
// Rows and clusters are always there. The rest is empty where every triangle is doubtful, as on open
// meshes.
#pragma once

#include "octree/winding_clusters.h"
#include "proxima/geometry.h"

#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>

namespace proxima {

/// What a triangle tells about its sides.
enum class SurfaceSides : std::uint8_t {
    doubtful,    ///< ask the winding number
    separates,   ///< outside in front of it, where its normal points, inside behind it
    inside_both, ///< inside on both sides
    outside_both ///< outside on both sides
};

/// Of the proper triangles at a vertex: those with three different vertices.
struct VertexSign {
    std::array<double, 3> normal{}; ///< of length 1 where the vertex separates: the sum of their
                                    ///< normals, weighted by their angles
    double least_height = 0;        ///< of the triangles; 0 where the vertex is doubtful
};

/// An edge's word is the row of its second triangle where it has two, both proper. Else it has this
/// bit and a position in edge_lists: a number, and so many rows, of its proper triangles, by
/// ascending id.
inline constexpr std::uint32_t edge_list_bit = 1U << 31U;

struct SignArrays {
    std::span<const std::uint32_t> rows;        ///< by triangle id
    std::span<const SurfaceSides> sides;        ///< by row
    std::span<const SurfaceSides> vertex_sides; ///< by vertex: those of all its triangles
    std::span<const VertexSign> vertices;       ///< by vertex
    std::span<const std::uint32_t> edges;       ///< by edge
    std::span<const std::uint32_t> edge_lists;
    WindingClusters winding;
    /// Of the mesh where it is known to be closed: all beyond is outside. Else endless.
    Box bounds{Vec3::Constant(-std::numeric_limits<double>::infinity()),
               Vec3::Constant(std::numeric_limits<double>::infinity())};
    /// Of the triangles whose sides are known: points near for that are told without a look at the
    /// closest one's.
    double least_height = std::numeric_limits<double>::infinity();

    /// Whether every edge is known to have as many triangles each way: winding numbers are whole.
    [[nodiscard]] bool is_closed() const noexcept { return !sides.empty(); }
};

/// Immutable; copies share the storage. Thread safe.
class SignParts {
public:
    [[nodiscard]] const SignArrays& arrays() const noexcept { return arrays_; }

    /// Whether no triangle is doubtful.
    [[nodiscard]] bool is_local() const noexcept { return is_local_; }

    /// Bytes of all arrays.
    [[nodiscard]] std::uint64_t bytes() const noexcept;

    /// Takes arrays that satisfy the layout above; `storage` keeps them alive. For the builder and
    /// the file reader; they check, this does not. O(triangles).
    [[nodiscard]] static SignParts adopt(const SignArrays& arrays,
                                         std::shared_ptr<const void> storage) noexcept;

private:
    SignArrays arrays_;
    bool is_local_ = false;
    std::shared_ptr<const void> storage_;
};

} // namespace proxima
