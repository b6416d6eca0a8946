// The edges of a mesh by number, without the lists of who touches whom that a topology has.
//
//     side   3 t + k joins corner k and corner k + 1 of triangle t
//     edge   all sides with the same two vertices; numbered by the first of them, as Topology does
#pragma once

#include "base/parallel.h"
#include "base/progress.h"
#include "base/result.h"
#include "mesh/topology.h"
#include "mesh/triangle_mesh.h"

#include <array>
#include <cstdint>
#include <vector>

namespace proxima {

struct EdgeNumbers {
    std::vector<std::array<EdgeId, 3>>
        triangle_edges;                     ///< no_edge where a side joins a vertex with itself
    std::vector<std::uint32_t> first_sides; ///< by edge: the lowest side
};

/// Of number_edges, in bytes per triangle: its result, of which the edges' first sides are six for a
/// closed mesh, and scratch.
inline constexpr std::uint64_t edge_number_bytes = 12 + 6 + 3 * (4 + 4 + 8);

/// Numbers the edges. The same for any number of threads. Error cancelled; stage "numbering edges".
/// Linear time, except that the sides at a vertex with many triangles are sorted: about 60 ns per
/// triangle on one thread. \pre at most max_topology_triangles
[[nodiscard]] Result<EdgeNumbers> number_edges(const TriangleMesh& mesh, Threads threads,
                                               Progress* progress);

} // namespace proxima
