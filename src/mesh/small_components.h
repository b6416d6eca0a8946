// Components of a mesh that are too small to be kept.
#pragma once

#include "proxima/topology.h"
#include "proxima/triangle_mesh.h"

#include <cstdint>
#include <span>

namespace proxima::detail {

/// Sets the flags of the triangles of components (proper triangles joined at edges) to 0 that have
/// fewer triangles than that, or less than that fraction of the largest area of a component. Returns
/// how many components those are. Triangles that are not finite have no area.
std::uint64_t drop_small_components(const TriangleMesh& mesh, const Topology& topology,
                                    std::uint64_t min_triangles, double min_area,
                                    std::span<std::uint8_t> kept);

} // namespace proxima::detail
