// The candidate list of the leaf that holds a point: what a query by lists looks at.
//
//     std::vector<TriangleId> buffer(index->lists()->statistics().max_list);    // once
//     if (const auto leaf = leaf_candidates(*index, p, buffer))
//         for (const TriangleId id : std::span(buffer).first(leaf->count)) { ... }
//
// For every point of the leaf's box the list has a triangle of its closest feature: whatever asks
// the surface near a point over and over, for contacts say, need look no further while it stays in
// the box.
#pragma once

#include "index/index_parts.h"
#include "proxima/geometry.h"
#include "proxima/mesh_index.h"
#include "proxima/triangle_mesh.h"

#include <cstddef>
#include <optional>
#include <span>

namespace proxima {

/// The leaf that holds a point.
struct LeafCandidates {
    Box box; ///< in the mesh's coordinates, up to rounding; of all leaves round p with that list
    int depth = 0;
    std::size_t count = 0; ///< triangles listed
    bool has_list = true;  ///< else queries search the tree, and count is 0
};

/// The leaf that holds p, and the triangles that it lists, ascending, into the caller's buffer;
/// where they do not fit, some of them. statistics().max_list items always suffice. Nothing where p
/// is outside of the root or not finite, and where the index has no lists. Real-time safe: noexcept,
/// no allocation, no lock; any number of threads. 0.1 us for usual lists; as many loads as the table
/// has cells where the leaf is the root (thesis 4.3).
[[nodiscard]] std::optional<LeafCandidates>
leaf_candidates(const IndexParts& index, const Vec3& p, std::span<TriangleId> triangles) noexcept;

} // namespace proxima
