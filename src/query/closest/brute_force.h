// The slow search that the fast ones are held to: every feature is asked.
#pragma once

#include "proxima/closest_feature.h"
#include "proxima/topology.h"
#include "proxima/triangle_mesh.h"

namespace proxima {

/// The closest feature by the distances of all vertices, edges and faces (feature_distance.h).
/// O(features), no allocation, thread safe. \pre the mesh has a triangle, all its positions in use
/// are finite, topology is the mesh's
[[nodiscard]] ClosestFeature closest_feature_by_brute_force(const TriangleMesh& mesh,
                                                            const Topology& topology,
                                                            const Vec3& p) noexcept;

} // namespace proxima
