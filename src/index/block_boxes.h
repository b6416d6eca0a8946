// Writes the boxes of a mesh index's nodes and leaves, with their margins.
#pragma once

#include "index/binary_tree.h"
#include "index/index_parts.h"
#include "proxima/mesh_index.h"

#include <array>
#include <span>

namespace proxima {

/// Sets a node's grid and the planes of its children; null where a slot has none. `box` holds all
/// of them. Returns the largest edge of each child's box as rays meet it.
std::array<double, 8> write_boxes(IndexNode& node, const FloatBox& box,
                                  const std::array<const FloatBox*, 8>& children) noexcept;

/// The edge of the box that a root is met by: rays come from the box [-1.01, 1.01], and `box` is larger
/// where the mesh does not fit the frame.
[[nodiscard]] double root_extent(const FloatBox& box) noexcept;

/// Sets a leaf's extent from the edge of its box.
void write_extent(IndexLeaf& leaf, double extent) noexcept;

/// Sets one of a leaf's vertices. Returns whether its coordinates are exact: see
/// IndexParts::has_exact_leaves.
bool write_vertex(IndexLeaf& leaf, std::size_t vertex, const Vec3& point,
                  const IndexFrame& frame) noexcept;

} // namespace proxima
