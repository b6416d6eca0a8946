// A picture of two meshes that intersect, as the thesis's figure 5.4: the leaves of their octrees
// that meet as boxes, red and green, their triangles yellow, and the contour.
#pragma once

#include "cli/image.h"
#include "cli/octree_picture.h"
#include "proxima/intersect_meshes.h"
#include "thesis/object_intersections/intersect_octrees.h"

#include <vector>

namespace proxima {

/// What the picture shows; all must outlive it.
struct IntersectionScene {
    const TriangleMesh& mesh_a;
    const TriangleMesh& mesh_b;
    const Octree& octree_a;
    const Octree& octree_b;
    const RigidTransform& pose_b;
    const std::vector<LeafPair>& leaves;
    const IntersectionContour& contour;
};

/// Errors: cancelled, budget_exceeded, and those of placed_camera.
[[nodiscard]] Result<Image> draw_intersection(const IntersectionScene& scene,
                                              const PictureOptions& options = {});

} // namespace proxima
