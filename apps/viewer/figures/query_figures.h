// Figures of thesis chapter 5 that show queries: the closest feature, two meshes that intersect,
// and culling by a view volume.
#pragma once

#include "proxima/closest_feature.h"
#include "proxima/execution.h"
#include "proxima/geometry.h"
#include "proxima/octree.h"
#include "proxima/triangle_mesh.h"
#include "proxima/view_volume.h"
#include "thesis/object_intersections/intersect_octrees.h"
#include "viewer/figures/thesis_figure.h"

#include <vector>

namespace proxima {

/// Figure 5.2: what a haptic cursor touches.
struct TouchedFeature {
    TriangleMesh mesh;
    Vec3 cursor;
    ClosestFeature closest;
    std::vector<TriangleId> around; ///< that share a vertex with the closest feature, without it
    Box leaf;                       ///< of the proximity octree, that holds the cursor
};
[[nodiscard]] Result<TouchedFeature> touched_feature(const Execution& context);

/// Figure 5.4: two spheres that reach into each other.
struct MeetingSpheres {
    TriangleMesh a;
    TriangleMesh b; ///< where the pose takes it
    RigidTransform pose_b;
    Octree octree_a;
    Octree octree_b; ///< before the pose
    std::vector<LeafPair> leaves;
    CandidateTriangles candidates;
};
[[nodiscard]] Result<MeetingSpheres> meeting_spheres(const Execution& context);

/// Figures 5.7 and 5.8: a mesh, a camera's volume, and the leaves that it sees.
struct CulledShip {
    TriangleMesh mesh;
    Octree octree;
    PerspectiveCamera camera;
    ViewVolume volume;
    std::vector<Cell> cells;           ///< visible and holding triangles
    std::vector<TriangleId> triangles; ///< that these hold, ascending
};
[[nodiscard]] Result<CulledShip> culled_ship(const Execution& context);

[[nodiscard]] Result<FigureContent> figure_5_2(const Execution& context);
[[nodiscard]] Result<FigureContent> figure_5_4(const Execution& context);
[[nodiscard]] Result<FigureContent> figure_5_7(const Execution& context);
[[nodiscard]] Result<FigureContent> figure_5_8(const Execution& context);

} // namespace proxima
