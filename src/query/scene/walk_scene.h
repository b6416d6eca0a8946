// The leaves of a scene's tree that a ray comes through, found eight boxes at a time in floats, as rays find
// those of a mesh.
#pragma once

#include "index/index_parts.h"
#include "proxima/function_ref.h"
#include "proxima/geometry.h"
#include "query/rays/prepare_ray.h"

namespace proxima {

/// Takes a leaf; it may lower the ray's `most`.
using SceneLeafVisitor = FunctionRef<Flow(const IndexLeaf&, RayTraversal&)>;

/// Visits the leaves whose boxes the ray meets, and perhaps others, the nearest first as far as depth first allows,
/// until the visitor says Flow::stop. Where it returns RayStart::too_far or invalid, none was visited. No
/// allocation.
[[nodiscard]] RayStart visit_scene_leaves(const IndexParts& tree, const Ray& ray,
                                          const SceneLeafVisitor& visitor) noexcept;

} // namespace proxima
