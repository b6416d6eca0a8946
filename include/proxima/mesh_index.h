// The index of a triangle mesh: built once, it answers every query (thesis chapters 2 and 4).
//
//     auto index = build_mesh_index(mesh);
//     if (!index) { std::cerr << describe(index.error()); return 1; }
//     auto closest = closest_feature(*index, point);                            // closest_feature.h
//     auto hit = closest_hit(*index, {.origin = eye, .direction = view});       // cast_ray.h
//     auto bounded = with_lists(*index);   // the same answers, within a bounded time
//
// It holds a copy of the triangles and needs the mesh no longer. Closest-feature lists and slabs are
// optional additions: they make some queries faster or bounded, and change no answer. Signs are what
// signed distances need in addition.
#pragma once

#include "proxima/execution.h"
#include "proxima/export.h"
#include "proxima/geometry.h"
#include "proxima/result.h"
#include "proxima/topology.h"
#include "proxima/triangle_mesh.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

namespace PROXIMA_EXPORT proxima {

/// The arrays of an index, as the library's own searches use them.
class IndexParts;

/// Immutable and cheap to copy: copies share all arrays. Thread safe. Without triangles unless made
/// by build_mesh_index, load_index or from another index. Triangles have ids, those of the mesh,
/// and rows: their positions in the order of the index.
class MeshIndex {
public:
    /// The index of no triangles.
    MeshIndex();

    [[nodiscard]] std::uint32_t triangle_count() const noexcept;
    [[nodiscard]] std::size_t vertex_count() const noexcept;
    [[nodiscard]] std::size_t edge_count() const noexcept;

    /// Bytes of all arrays, including those shared with other indexes.
    [[nodiscard]] std::uint64_t bytes() const noexcept;

    /// Whether it has closest-feature lists (with_lists).
    [[nodiscard]] bool has_lists() const noexcept;
    /// Whether it has slabs (with_slabs).
    [[nodiscard]] bool has_slabs() const noexcept;
    /// Whether it has signs (with_signs).
    [[nodiscard]] bool has_signs() const noexcept;

    /// Identifies the mesh that it was built from: mesh_fingerprint(mesh).
    [[nodiscard]] std::uint64_t mesh_fingerprint() const noexcept;

    /// The ids of the triangles by row. TriangleRange names runs of them.
    [[nodiscard]] std::span<const TriangleId> ids() const noexcept;

    /// For the library's own searches.
    [[nodiscard]] const IndexParts& parts() const noexcept { return *parts_; }
    /// For the library's own builders. \pre parts is not null
    explicit MeshIndex(std::shared_ptr<const IndexParts> parts) noexcept;

    // Copies only: a moved-from index would have no parts.
    MeshIndex(const MeshIndex&) noexcept = default;
    MeshIndex& operator=(const MeshIndex&) noexcept = default;
    ~MeshIndex() = default;

private:
    std::shared_ptr<const IndexParts> parts_; ///< never null
};

/// The most triangles that an index takes.
inline constexpr std::size_t max_index_triangles = std::size_t{1} << 28U;

struct MeshIndexOptions {
    Execution execution = {}; ///< budget: index and scratch
};

/// Keeps no reference to the mesh. The same bits for any number of threads. Errors: invalid_mesh
/// (empty, NaN), limit_exceeded (more than max_index_triangles), budget_exceeded, cancelled. About
/// 0.5 us per triangle on one thread; once built, 120 bytes per triangle, 160 where positions are
/// not floats.
[[nodiscard]] Result<MeshIndex> build_mesh_index(const TriangleMesh& mesh,
                                                 const MeshIndexOptions& options = {});

/// How large closest-feature lists may become where nothing is said: 520 bytes per triangle, more for
/// small meshes.
[[nodiscard]] constexpr std::uint64_t default_list_bytes(std::uint64_t triangles) noexcept
{
    constexpr std::uint64_t least = 65536;       // cells
    constexpr std::uint64_t each_of_a_few = 440; // triangles themselves, at most
    const std::uint64_t small = least + each_of_a_few * triangles;
    const std::uint64_t usual = 520 * triangles;
    return usual < small ? small : usual;
}

/// Limits of closest-feature lists.
inline constexpr std::size_t max_listed_triangles = std::size_t{1} << 25U;
inline constexpr double max_list_margin = 1e3;
inline constexpr int max_list_depth = 14;

struct ListOptions {
    std::uint64_t list_bytes = 0; ///< the lists are no larger; 0 = default_list_bytes()
    double margin = 0.5; ///< root edge = (1 + margin) times the mesh's longest extent; 0 to
                         ///< max_list_margin
    int max_depth = max_list_depth;
    /// Budget: lists and scratch. Refused before the work if below 800 bytes per triangle and the
    /// usual list_bytes; lists beyond these have a quarter of what is left.
    Execution execution = {};
};

/// The index with closest-feature lists, in place of any that it has: closest_feature then takes
/// bounded time inside the root cube. Shares all other arrays with `index`. Of all lists of this size,
/// those whose queries are expected to be cheapest. The same bits for any number of threads. Errors:
/// invalid_mesh (an empty index, a mesh smaller than 1e-140 or larger than 1e150), invalid_argument (options out of
/// range), limit_exceeded (more than max_listed_triangles), budget_exceeded (list_bytes below 1 KB,
/// an execution.budget that cannot do), cancelled. About 70 to 130 us per triangle on one
/// thread; up to 3 ms where thousands of triangles are in the same place.
[[nodiscard]] Result<MeshIndex> with_lists(const MeshIndex& index, const ListOptions& options = {});

struct SlabOptions {
    Execution execution = {}; ///< budget: slabs and scratch
};

/// The index with slabs, which make distances between meshes faster. Shares all other arrays with
/// `index`. The same bits for any number of threads. Errors: budget_exceeded, cancelled. About
/// 0.3 us and 3 bytes per triangle.
[[nodiscard]] Result<MeshIndex> with_slabs(const MeshIndex& index, const SlabOptions& options = {});

struct SignOptions {
    Execution execution = {}; ///< budget: signs and scratch
};

/// The index with signs, which signed distances need (signed_distance.h). Shares all other arrays
/// with `index`. The same bits for any number of threads. Errors: invalid_mesh (an empty index, a
/// mesh whose extent is no number), broken_invariant (a crafted file: as mesh_of; edges of another
/// numbering), limit_exceeded (more than max_topology_triangles), budget_exceeded (below 220 bytes
/// per triangle), cancelled. On one thread 3 to 10 us per triangle of a closed mesh, 1 us of
/// others; once built, 75 and 50 bytes per triangle.
[[nodiscard]] Result<MeshIndex> with_signs(const MeshIndex& index, const SignOptions& options = {});

struct RefitOptions {
    Execution execution = {};
};

/// The index of `mesh`, which has the triangles of the index's own mesh and vertices elsewhere, with
/// lists where `index` has some, without slabs and signs; `topology` is the same for both. Boxes are drawn
/// about where vertices are now, and lists that no longer hold are given up, so answers are exact,
/// and queries slower the farther neighbours moved apart: build again when they are too slow. Keeps
/// no reference to mesh and topology; shares arrays of lists with `index`, which stays as it was.
/// Errors: invalid_argument (other triangles or topology; a vertex left the root of the lists: build
/// again), invalid_mesh (NaN), cancelled. About 1 us per triangle, with lists 2 us, and 2 to
/// 15 us per leaf that loses its list.
[[nodiscard]] Result<MeshIndex> refit_index(const MeshIndex& index, const TriangleMesh& mesh,
                                            const Topology& topology,
                                            const RefitOptions& options = {});

/// The mesh that the index was built from: positions bit for bit, triangles in their order. Vertices
/// that no triangle uses were not kept and stand at the center of the index. Error broken_invariant
/// where a crafted file puts a vertex at two positions or, all vertices being in use, holds another
/// mesh than it says. O(triangles + vertices).
[[nodiscard]] Result<TriangleMesh> mesh_of(const MeshIndex& index);

/// Whether the index was built from this mesh: same positions and triangles, in the same order, by
/// counts and mesh_fingerprint().
/// Error invalid_argument, naming both. O(mesh).
[[nodiscard]] Status check_same_mesh(const MeshIndex& index, const TriangleMesh& mesh);

/// Bytes of the parts of an index, which add up to bytes().
struct MeshIndexBytes {
    std::uint64_t blocks = 0; ///< the tree and its leaves
    std::uint64_t rows = 0;   ///< triangles in the order of the index
    std::uint64_t ids = 0;
    std::uint64_t incidences = 0; ///< the lowest triangle of each vertex and edge
    std::uint64_t lists = 0;
    std::uint64_t slabs = 0;
    std::uint64_t signs = 0;
};

[[nodiscard]] MeshIndexBytes bytes_of(const MeshIndex& index) noexcept;

} // namespace proxima
