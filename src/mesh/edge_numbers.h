// The edges of a mesh by number, without the lists of who touches whom that a topology has.
//
//     side   3 t + k joins corner k and corner k + 1 of triangle t
//     edge   all sides with the same two vertices; numbered by the first of them, as Topology does
#pragma once

#include "base/grow_buffer.h"
#include "proxima/execution.h"
#include "proxima/result.h"
#include "proxima/topology.h"
#include "proxima/triangle_mesh.h"

#include <array>
#include <cstdint>
#include <vector>

namespace proxima {

struct EdgeNumbers {
    std::vector<std::array<EdgeId, 3>>
        triangle_edges;                    ///< no_edge where a side joins a vertex with itself
    GrowBuffer<std::uint32_t> first_sides; ///< by edge: the lowest side
};

/// Of number_edges, in bytes per triangle at most: the edges' numbers, and for each of three edges
/// its first side, a link of a chain and a vertex.
inline constexpr std::uint64_t edge_number_bytes = 12 + 3 * (4 + 8 + 4);

/// Numbers the edges, on the calling thread. Linear time: about 60 ns per triangle of a scan, more
/// where many edges meet at a vertex. Reports a step per triangle of the caller's stage. Error
/// cancelled. \pre at most max_topology_triangles
[[nodiscard]] Result<EdgeNumbers> number_edges(const TriangleMesh& mesh, Progress* progress);

} // namespace proxima
