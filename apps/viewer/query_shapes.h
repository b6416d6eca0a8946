// Shapes that show what queries answer: figures and panels draw them alike.
#pragma once

#include "proxima/cells_along_ray.h"
#include "proxima/minkowski_sum.h"
#include "proxima/octree.h"
#include "proxima/view_volume.h"
#include "thesis/object_intersections/intersect_octrees.h"
#include "viewer/scene_shapes.h"

#include <array>
#include <span>
#include <vector>

namespace proxima {

/// The triangles of the mesh that are not in `named`. \pre named is ascending
[[nodiscard]] std::vector<TriangleId> all_but(const TriangleMesh& mesh,
                                              std::span<const TriangleId> named);

/// These triangles of the mesh; nothing for none.
void add_part(DrawnScene& scene, const TriangleMesh& mesh, std::span<const TriangleId> triangles,
              const ShapeStyle& style);

/// The leaves of one side of the pairs, each once.
[[nodiscard]] std::vector<Box>
boxes_of_leaves(const Octree& octree, const std::vector<LeafPair>& pairs, Cell LeafPair::*side);

/// The corners of a camera's volume, near ones first, each four in a circle. \pre far is finite
[[nodiscard]] std::array<Vec3, 8> frustum_corners(const PerspectiveCamera& camera);

/// Adds the edges of the camera's volume, and lines from the eye to it.
void add_frustum(DrawnScene& scene, const PerspectiveCamera& camera, const EdgeStyle& style);

/// From black at 0 to yellow at 1.
[[nodiscard]] Color intensity_color(double weight);

/// The chord in a cell over the cell's diagonal, 0 to 1.
[[nodiscard]] double chord_weight(const Octree& octree, const CellOnRay& cell);

/// The facets of the sum that have this origin.
[[nodiscard]] std::vector<std::uint32_t> facets_of(const MinkowskiSum& sum, FacetOrigin origin);

} // namespace proxima
