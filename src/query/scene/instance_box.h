// Boxes about placed instances of an index (scene_parts.h says by how much they are drawn out).
#pragma once

#include "proxima/execution.h"
#include "proxima/geometry.h"
#include "proxima/mesh_index.h"
#include "query/scene/scene_parts.h"

namespace proxima {

/// The boxes of a shape's parts, most_shape_boxes at most: the largest nodes of its tree are opened first.
/// O(triangles), 5 ns each. Where it is stopped on request, what it returns means nothing.
[[nodiscard]] InstancedShape make_instanced_shape(const MeshIndex& index, Progress* progress);

inline constexpr std::size_t most_shape_boxes = 48;

/// The box of the shape in that pose. \pre the shape has boxes
[[nodiscard]] Box instance_box(const InstancedShape& shape, const RigidTransform& pose) noexcept;

} // namespace proxima
