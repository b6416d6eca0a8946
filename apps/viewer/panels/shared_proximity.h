// Mesh indexes of models with lists, built once for all panels that ask them.
#pragma once

#include "index/lists/proximity_lists.h"
#include "proxima/execution.h"
#include "proxima/geometry.h"
#include "proxima/mesh_index.h"
#include "viewer/panel.h"

#include <cstdint>
#include <memory>
#include <vector>

namespace proxima {

using SharedProximity = Kept<std::shared_ptr<const ViewModel>, MeshIndex>;

/// That of the model. Errors as with_lists.
[[nodiscard]] Result<std::shared_ptr<const MeshIndex>>
proximity_of(SharedProximity& shared, const std::shared_ptr<const ViewModel>& model,
             const Execution& context);

/// A leaf of the lists, and what it lists.
struct ProximityLeaf {
    Box box;
    int depth = 0;
    std::vector<TriangleId> listed; ///< ascending; none where queries search the tree
};

/// The leaf that holds the point; nothing outside of the root.
[[nodiscard]] std::optional<ProximityLeaf> leaf_at(const MeshIndex& index, const Vec3& p);

/// The leaf as green glass.
void add_leaf(DrawnScene& scene, const ProximityLeaf& leaf);

/// Of balls that mark points of a model: they hide no triangles.
[[nodiscard]] double mark_radius(const ViewModel& model);

/// The point that is asked about, as a ball.
void add_cursor(DrawnScene& scene, const ViewModel& model, const Vec3& at);

/// "face 17".
[[nodiscard]] std::string words_for(const Feature& feature);

/// The feature in a colour, over the mesh: a triangle, a line or a ball.
void add_feature(DrawnScene& scene, const ViewModel& model, const Feature& feature,
                 double ball_radius, const Color& color);

} // namespace proxima
