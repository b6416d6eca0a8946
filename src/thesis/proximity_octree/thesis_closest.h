// The feature closest to a point, by the thesis's proximity octree (thesis 4.3).
#pragma once

#include "proxima/closest_feature.h"
#include "proxima/topology.h"
#include "proxima/triangle_mesh.h"
#include "thesis/proximity_octree/thesis_proximity_octree.h"

#include <optional>

namespace proxima {

/// The closest feature, by the distances to all that the leaf of the point lists; nothing for a
/// point outside the root, one inside the mesh (the thesis labels only what is outside), and NaN.
/// Points on the surface have an answer. At most depth_reached() steps and the longest list.
/// Thread safe, no allocation. \pre the octree was built from this mesh and topology
[[nodiscard]] std::optional<ClosestFeature> closest_feature(const ThesisProximityOctree& octree,
                                                            const TriangleMesh& mesh,
                                                            const Topology& topology,
                                                            const Vec3& point) noexcept;

} // namespace proxima
