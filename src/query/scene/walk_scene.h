// The leaves of a scene's tree that a ray comes through or a box meets, found eight boxes at a time in floats.
#pragma once

#include "index/index_parts.h"
#include "proxima/function_ref.h"
#include "proxima/geometry.h"
#include "query/rays/prepare_ray.h"

#include <array>

namespace proxima {

/// Takes a leaf; it may lower the ray's `most`.
using SceneLeafVisitor = FunctionRef<Flow(const IndexLeaf&, RayTraversal&)>;

/// Visits the leaves whose boxes the ray meets, and perhaps others, the nearest first as far as depth first allows,
/// until the visitor says Flow::stop. Where it returns RayStart::too_far or invalid, none was visited. No
/// allocation.
[[nodiscard]] RayStart visit_scene_leaves(const IndexParts& tree, const Ray& ray,
                                          const SceneLeafVisitor& visitor) noexcept;

/// A box in the units of a tree, drawn outward.
struct FloatQueryBox {
    std::array<float, 3> lower;
    std::array<float, 3> upper;

    /// \pre the box, in the scene's coordinates, is finite and not empty
    FloatQueryBox(const IndexParts& tree, const Box& box) noexcept;
};

/// Visits the leaves whose boxes meet the box, and perhaps others. No allocation.
void visit_scene_leaves(const IndexParts& tree, const FloatQueryBox& box,
                        FunctionRef<void(const IndexLeaf&)> visitor) noexcept;

} // namespace proxima
