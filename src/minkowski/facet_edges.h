// The edges of a surface from the loops of its facets.
#pragma once

#include "proxima/convex_polyhedron.h"

#include <cstdint>
#include <span>
#include <vector>

namespace proxima::detail {

/// The loops of all facets in one array: that of facet f is vertices[first[f]] up to
/// vertices[first[f + 1]]. Vertices below point_count are points, the others rays.
struct FacetLoops {
    std::span<const std::uint32_t> first;
    std::span<const std::uint32_t> vertices;
    std::size_t point_count = 0;
    std::size_t vertex_count = 0;
};

/// Every edge once, from its lower to its higher vertex, ordered by the lower one; edges between
/// two rays are at infinity and left out. Linear time for bounded numbers of edges at a vertex.
/// \pre every edge is in two loops, in opposite directions
[[nodiscard]] std::vector<PolyhedronEdge> edges_of_loops(const FacetLoops& loops);

} // namespace proxima::detail
