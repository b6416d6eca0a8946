// Figures of thesis chapter 5 that show queries: the closest feature, two meshes that intersect,
// and culling by a view volume.
#pragma once

#include "geometry/rigid_transform.h"
#include "geometry/view_volume.h"
#include "mesh/triangle_mesh.h"
#include "octree/octree.h"
#include "query/closest/closest_feature.h"
#include "thesis/object_intersections/intersect_octrees.h"
#include "viewer/figures/thesis_figure.h"

#include <vector>

namespace proxima {

/// Figure 5.2: what a haptic cursor touches.
struct TouchedPlace {
    TriangleMesh mesh;
    Vec3 cursor;
    ClosestFeature closest;
    std::vector<TriangleId> around; ///< that share a vertex with the closest feature, without it
    Box leaf;                       ///< of the proximity octree, that holds the cursor
};
[[nodiscard]] Result<TouchedPlace> touched_place(const FigureContext& context);

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
[[nodiscard]] Result<MeetingSpheres> meeting_spheres(const FigureContext& context);

/// Figures 5.7 and 5.8: a mesh, a camera's volume, and the leaves that it sees.
struct CulledShip {
    TriangleMesh mesh;
    Octree octree;
    PerspectiveCamera camera;
    ViewVolume volume;
    std::vector<Cell> cells;           ///< visible and holding triangles
    std::vector<TriangleId> triangles; ///< that these hold, ascending
};
[[nodiscard]] Result<CulledShip> culled_ship(const FigureContext& context);

[[nodiscard]] Result<FigureContent> figure_5_2(const FigureContext& context);
[[nodiscard]] Result<FigureContent> figure_5_4(const FigureContext& context);
[[nodiscard]] Result<FigureContent> figure_5_7(const FigureContext& context);
[[nodiscard]] Result<FigureContent> figure_5_8(const FigureContext& context);

} // namespace proxima
