// A rank's part of a mesh that no rank holds as a whole: consecutive triangles, and their vertices.
//
//     rank 0           rank 1           rank 2
//     triangles 0..3   triangles 4..7   triangles 8..11      ids count through the whole mesh
#pragma once

#include "distributed/world.h"
#include "proxima/triangle_mesh.h"

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

namespace proxima {

struct MeshSlice {
    TriangleMesh mesh;                   ///< triangle i is triangle first_triangle + i of the whole
    std::vector<std::uint64_t> vertices; ///< vertex i's number in the whole, ascending
    std::uint64_t first_triangle = 0;
    std::uint64_t whole_triangles = 0;
    std::string name; ///< of the file of the vertices, for messages
};

/// Rank r's part of `count` items that n ranks share: [first, end).
struct Share {
    std::uint64_t first = 0;
    std::uint64_t end = 0;
};
[[nodiscard]] Share share_of(std::uint64_t count, int rank, int ranks) noexcept;

/// Corners by vertex numbers of the whole mesh.
using WholeCorners = std::array<std::uint64_t, 3>;

/// How far triangles of a slice may go: the corners of local meshes and bins have 32 bits.
inline constexpr std::uint64_t max_slice_triangles = std::uint64_t{1} << 29U;

/// The size of a generated surface, "torus:NxM": the one of sample_mesh, without its limit of size.
struct TorusSize {
    std::uint32_t around = 0;
    std::uint32_t across = 0;
};
[[nodiscard]] std::optional<TorusSize> torus_size(std::string_view name) noexcept;

/// This rank's part of the torus. Collective.
[[nodiscard]] Result<MeshSlice> make_torus_slice(const TorusSize& size, World& world);

/// This rank's part of a binary little-endian PLY file of triangles. Collective.
[[nodiscard]] Result<MeshSlice> read_ply_slice(const std::filesystem::path& path, World& world);

/// This rank's part of two arrays of NumPy, of N x 3 coordinates and M x 3 vertex numbers from 0.
/// Collective.
[[nodiscard]] Result<MeshSlice> read_npy_slice(const std::filesystem::path& vertices,
                                               const std::filesystem::path& triangles,
                                               World& world);

/// The distinct numbers of the corners, ascending. Throws std::bad_alloc.
[[nodiscard]] std::vector<std::uint64_t> used_vertices(const std::vector<WholeCorners>& triangles);

/// Corners as positions in slice.vertices; sets slice.mesh. Throws std::bad_alloc.
[[nodiscard]] Status assemble(const std::vector<WholeCorners>& triangles,
                              std::vector<Vec3> positions, MeshSlice& slice);

} // namespace proxima
