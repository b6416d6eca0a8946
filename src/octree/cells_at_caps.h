// Which empty cells of an octree the caps of a mesh's holes may touch (hole_caps.h).
#pragma once

#include "proxima/execution.h"
#include "proxima/octree.h"
#include "proxima/triangle_mesh.h"

#include <cstdint>
#include <vector>

namespace proxima {

/// Descends with each cap to the empty cells that it may touch: a mask of octants for each record;
/// no masks at all where there are no caps. Each cell is decided by itself and those above it,
/// whatever else is in the octree. Less once `progress` is cancelled.
[[nodiscard]] std::vector<std::uint8_t>
octants_at_caps(const Octree& octree, const TriangleMesh& caps, const Progress* progress);

} // namespace proxima
