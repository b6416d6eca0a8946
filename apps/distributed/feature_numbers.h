// Numbers of the edges of a mesh that is spread over the ranks, and the lowest triangle of each
// vertex and edge.
//
//     slice of rank 0      slice of rank 1
//     triangles 0..3       triangles 4..7
//     edges 0 1 2 ...      those that no triangle before had go on from there
//
// Edges are numbered as Topology numbers those of the whole: by their first side.
#pragma once

#include "distributed/mesh_slice.h"
#include "distributed/world.h"
#include "mesh/edge_numbers.h"

#include <array>
#include <cstdint>
#include <vector>

namespace proxima {

/// A vertex or an edge in the whole mesh.
struct WholeFeature {
    std::uint64_t id = 0;
    std::uint64_t triangle = 0; ///< the lowest that has it
};

/// The features of a slice.
struct SliceFeatures {
    std::vector<WholeFeature> vertices; ///< by vertex of the slice
    std::vector<WholeFeature> edges;    ///< of the slice, by first appearance in it
    std::vector<std::array<EdgeId, 3>>
        triangle_edges; ///< among `edges`; no_edge where a side joins a vertex with itself

    /// Edges of the whole mesh that do not have as many triangles each way. Triangles that repeat a
    /// vertex do not count.
    std::uint64_t unbalanced_edges = 0;
};

/// Compares edges and vertices of all slices. Collective.
[[nodiscard]] Result<SliceFeatures> number_features(const MeshSlice& slice, World& world);

} // namespace proxima
