// Triangles in the order of their positions in space, so that neighbours have near ranks.
#pragma once

#include "base/radix_sort.h"
#include "proxima/execution.h"
#include "proxima/triangle_mesh.h"

#include <cstdint>
#include <optional>
#include <vector>

namespace proxima {

/// Bits per axis of the grid that centroids are sorted on.
inline constexpr int triangle_order_bits = 19;

/// How the cells of the grid are numbered.
enum class SpaceCurve : std::uint8_t {
    morton, ///< codes tell cells: their bits are the octants
    hilbert ///< more compact: groups of 8 have boxes a quarter to a half less often in the way
};

/// The triangles by the codes of their centroids on a grid over the cube at the lower corner of
/// `bounds`, ascending; those in one cell by id. An item is a code and a triangle id. Nothing
/// where `progress`, which may be null, asks to stop. O(triangles), 32 bytes each.
/// \pre bounds holds all triangles, its extent is finite
[[nodiscard]] std::optional<std::vector<KeyedIndex>>
triangle_order(const TriangleMesh& mesh, const Box& bounds, SpaceCurve curve, Progress* progress);

} // namespace proxima
