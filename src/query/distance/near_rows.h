// The pairs of triangles of two meshes that are near each other, by their rows.
#pragma once

#include "proxima/geometry.h"
#include "proxima/mesh_index.h"

#include <cstddef>
#include <cstdint>
#include <span>

namespace proxima {

/// Rows of two indexes whose triangles are near.
struct NearRows {
    std::uint32_t a = 0;
    std::uint32_t b = 0;
    /// From A's triangle to B's where they are closest, in A's axes, of any length and as exact as
    /// floats are; of no meaning where they meet.
    Vec3 across = Vec3::Zero();
};

/// What near_rows() found.
struct NearRowsAnswer {
    std::size_t count = 0;
    bool complete = true; ///< false: there is no room for all
};

/// Writes every pair of triangles of A and of B moved by the pose that are at most `distance` apart,
/// each once; some pairs that are farther apart by rounding may be among them. Real-time safe:
/// noexcept, no allocation, no lock. A tree walk, and 0.1 us a pair.
/// \pre coordinates, moved ones too, are finite; distance >= 0
[[nodiscard]] NearRowsAnswer near_rows(const MeshIndex& a, const MeshIndex& b,
                                       const RigidTransform& pose_b, double distance,
                                       std::span<NearRows> rows) noexcept;

} // namespace proxima
