// Triangles in the order of their places in space, so that neighbours have near ranks.
#pragma once

#include "proxima/base/progress.h"
#include "proxima/base/radix_sort.h"
#include "proxima/mesh/triangle_mesh.h"

#include <optional>
#include <vector>

namespace proxima {

/// Bits per axis of the grid that centroids are sorted by.
inline constexpr int morton_order_bits = 19;

/// The triangles by the Morton codes of their centroids on a grid over the cube at the lower corner
/// of `bounds`, ascending; those in one cell by id. An item is a code and a triangle id. Nothing
/// where `progress`, which may be null, asks to stop. O(triangles), 32 bytes each.
/// \pre bounds holds all triangles, its extent is finite
[[nodiscard]] std::optional<std::vector<KeyedIndex>>
morton_order(const TriangleMesh& mesh, const Box& bounds, Progress* progress);

} // namespace proxima
