// Convex polyhedra from meshes and simple shapes.
#pragma once

#include "geometry/shapes.h"
#include "mesh/triangle_mesh.h"
#include "minkowski/convex_hull.h"
#include "minkowski/convex_polyhedron.h"

#include <span>

namespace proxima {

struct ConvexMeshOptions {
    /// How far a vertex may stand beyond the plane of a triangle, per diagonal of the bounding box:
    /// coordinates of round shapes are rounded, so their faces are never quite flat.
    double tolerance = 1e-9;
    Progress* progress = nullptr;
};

/// The polyhedron that a closed convex mesh bounds: the exact hull of its vertices, once every edge
/// has two triangles, all are connected, no vertex stands beyond a triangle's plane, and the area
/// is that of the hull. Which way the triangles are turned does not matter. Errors: invalid_mesh
/// (empty; NaN or infinity; an open or branching edge; several components; all vertices in one
/// plane; not convex), saying where; limit_exceeded (coordinates beyond max_polyhedron_coordinate);
/// cancelled. O(n log n).
[[nodiscard]] Result<ConvexPolyhedron> polyhedron_of_mesh(const TriangleMesh& mesh,
                                                          const ConvexMeshOptions& options = {});

/// A triangle: of dimension 2, or less if its corners are in a line. Errors as convex_hull.
[[nodiscard]] Result<ConvexPolyhedron> polyhedron_of_triangle(const Triangle& triangle);

/// A box. Errors as convex_hull; invalid_argument for an empty one.
[[nodiscard]] Result<ConvexPolyhedron> polyhedron_of_box(const Box& box);

/// -x for all x of the polyhedron.
[[nodiscard]] ConvexPolyhedron mirrored(const ConvexPolyhedron& polyhedron);

} // namespace proxima
