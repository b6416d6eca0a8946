// Builds proximity octrees of any triangle mesh: closed or open, convex or not, manifold or not.
//
//     auto octree = build_proximity_octree(mesh);
//     if (!octree) { std::cerr << describe(octree.error()); return 1; }
//     const ClosestFeature closest = closest_feature(*octree, point);
#pragma once

#include "index/lists/grow_cells.h"
#include "index/lists/proximity_octree.h"
#include "proxima/execution.h"
#include "proxima/result.h"
#include "proxima/topology.h"
#include "proxima/triangle_mesh.h"

#include <cstdint>

namespace proxima {

/// Of the query structure where no other budget is named.
inline constexpr std::uint64_t default_bytes_per_triangle = 600;

/// The budget where none is named: what so many triangles get, and what a small mesh needs.
[[nodiscard]] constexpr std::uint64_t default_proximity_budget(std::uint64_t triangles) noexcept
{
    constexpr std::uint64_t least = 65536;       // cells
    constexpr std::uint64_t each_of_a_few = 512; // triangles themselves, at most
    const std::uint64_t small = least + each_of_a_few * triangles;
    const std::uint64_t usual = default_bytes_per_triangle * triangles;
    return usual < small ? small : usual;
}

/// The largest margin.
inline constexpr double max_proximity_margin = 1e3;

/// Past this, numbers of the builder no longer fit 32 bits.
inline constexpr std::size_t max_proximity_triangles = std::size_t{1} << 25U;

struct ProximityOptions {
    std::uint64_t budget_bytes = 0; ///< of the result; 0 = default_proximity_budget()
    double margin = 0.5; ///< root edge = (1 + margin) times the mesh's longest extent; 0 to
                         ///< max_proximity_margin
    int max_depth = max_proximity_depth;
    Execution execution = {};
};

/// Within the budget, the octree whose queries are expected to be cheapest (cost_model.h). Exact:
/// every point's closest feature is in its leaf. The same bits for any number of threads. Keeps
/// nothing of mesh and topology. Errors: invalid_mesh (empty, NaN, less than 1e-140 large),
/// invalid_argument (options out of range, a topology of another mesh), limit_exceeded,
/// budget_exceeded (which budget would do), cancelled. About 50 us per triangle; at most 3 times
/// the budget of memory beside the mesh.
[[nodiscard]] Result<ProximityOctree> build_proximity_octree(const TriangleMesh& mesh,
                                                             const Topology& topology,
                                                             const ProximityOptions& options = {});

/// The same, with a topology of its own.
[[nodiscard]] Result<ProximityOctree> build_proximity_octree(const TriangleMesh& mesh,
                                                             const ProximityOptions& options = {});

/// A number that differs for meshes with other positions or triangles. O(mesh).
[[nodiscard]] std::uint64_t mesh_fingerprint(const TriangleMesh& mesh);

} // namespace proxima
