#include "proxima/mesh_index.h"

#include "base/text.h"
#include "index/index_parts.h"

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace proxima {

namespace {

bool same_bits(const Vec3& a, const Vec3& b)
{
    const auto bits = [](double value) { return std::bit_cast<std::uint64_t>(value); };
    return bits(a[0]) == bits(b[0]) && bits(a[1]) == bits(b[1]) && bits(a[2]) == bits(b[2]);
}

/// Vertices as rows have them.
class VertexPositions {
public:
    VertexPositions(std::size_t count, const Vec3& elsewhere)
        : positions_(count, elsewhere), known_(count)
    {}

    /// False where the vertex is somewhere else already, by a bit.
    [[nodiscard]] bool put(std::uint32_t vertex, const Vec3& position)
    {
        Vec3& kept = positions_[vertex];
        if (known_[vertex]) return same_bits(kept, position);
        known_[vertex] = true;
        ++known_count_;
        kept = position;
        return true;
    }

    [[nodiscard]] bool all_known() const { return known_count_ == positions_.size(); }
    [[nodiscard]] std::vector<Vec3> take() { return std::move(positions_); }

private:
    std::vector<Vec3> positions_;
    std::vector<bool> known_;
    std::size_t known_count_ = 0;
};

template <class Scalar>
Status collect(std::span<const TriangleRow<Scalar>> rows, VertexPositions& vertices,
               std::vector<TriangleCorners>& triangles)
{
    for (const TriangleRow<Scalar>& row : rows) {
        for (int i = 0; i < 3; ++i) {
            const std::uint32_t vertex = row.vertices[i];
            if (!vertices.put(vertex, row.corner(i))) {
                return fail(ErrorCode::broken_invariant, "a vertex at two positions",
                            concat("vertex ", vertex));
            }
            triangles[row.triangle_id()][static_cast<std::size_t>(i)] = vertex;
        }
    }
    return {};
}

std::string hexadecimal(std::uint64_t value)
{
    std::array<char, 16> digits{};
    const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), value, 16).ptr;
    return {digits.data(), end};
}

} // namespace

Result<TriangleMesh> mesh_of(const MeshIndex& index)
{
    VertexPositions vertices(index.vertex_count(), index.parts().center());
    std::vector<TriangleCorners> triangles(index.triangle_count());
    for (const Status& status : {collect(index.parts().float_rows(), vertices, triangles),
                                 collect(index.parts().double_rows(), vertices, triangles)}) {
        if (!status) return tl::unexpected(status.error());
    }
    const bool whole = index.triangle_count() > 0 && vertices.all_known();
    auto mesh = make_triangle_mesh(vertices.take(), std::move(triangles));
    if (mesh && whole && mesh_fingerprint(*mesh) != index.mesh_fingerprint()) {
        return fail(ErrorCode::broken_invariant,
                    "its triangles are not those of the mesh that it is said to be of", "rows");
    }
    return mesh;
}

Status check_same_mesh(const MeshIndex& index, const TriangleMesh& mesh)
{
    const std::uint64_t fingerprint = mesh_fingerprint(mesh);
    if (index.mesh_fingerprint() == fingerprint &&
        index.triangle_count() == mesh.triangle_count() &&
        index.vertex_count() == mesh.vertex_count()) {
        return {};
    }
    return fail(ErrorCode::invalid_argument,
                concat("the index is of another mesh, ", index.triangle_count(), " triangles, ",
                       index.vertex_count(), " vertices, fingerprint ",
                       hexadecimal(index.mesh_fingerprint()), "; this one has ",
                       mesh.triangle_count(), " triangles, ", mesh.vertex_count(),
                       " vertices, fingerprint ", hexadecimal(fingerprint), ": build it again"),
                "mesh");
}

} // namespace proxima
