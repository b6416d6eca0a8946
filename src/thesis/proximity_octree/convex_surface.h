// A closed convex mesh, checked: what the thesis's proximity octree stands on (thesis 4.3.2).
//
//     triangle   its outward normal
//     edge       ridge  the faces at its sides are folded: it has a Voronoi region with a volume
//                flat   they are one plane: the region is the border of two faces'
//
// Coordinates of round shapes are rounded, so that quads of a sphere are neither quite flat nor
// quite convex: both are decided up to a tolerance, 0 for none.
#pragma once

#include "proxima/execution.h"
#include "proxima/result.h"
#include "proxima/topology.h"
#include "proxima/triangle_mesh.h"

#include <vector>

namespace proxima {

/// How the two faces of an edge stand to each other.
enum class EdgeFold : std::uint8_t { ridge, flat };

struct ConvexSurfaceOptions {
    /// How far a vertex may stand beyond a face's plane, per diagonal of the bounding box.
    double convexity_tolerance = 1e-9;
    /// The largest sine of the angle between faces that count as one plane. Faces that are exactly
    /// coplanar always do.
    double flat_sine = 1e-8;
    Execution execution = {};
};

struct ConvexSurface {
    std::vector<Vec3> normals;       ///< by triangle; outward, of length 1
    std::vector<EdgeFold> folds;     ///< by edge; what bends inward within the tolerance is flat
    Vec3 inner_point = Vec3::Zero(); ///< strictly behind the plane of every triangle
};

/// The sine of the angle between two directions of length 1, to a few roundings of 1.
[[nodiscard]] double sine_between(const Vec3& one, const Vec3& other) noexcept;

/// Errors: invalid_mesh for a mesh that is empty, has NaN or infinite coordinates, a triangle of no
/// area, is open, branches, falls apart, is not convex, has no volume, or whose triangles are not
/// all counter-clockwise seen from outside; the message says where. limit_exceeded as
/// polyhedron_of_mesh; cancelled. O(n log n). \pre topology is the mesh's
[[nodiscard]] Result<ConvexSurface> check_convex_surface(const TriangleMesh& mesh,
                                                         const Topology& topology,
                                                         const ConvexSurfaceOptions& options = {});

} // namespace proxima
