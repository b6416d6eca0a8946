// The exterior Voronoi regions of a convex polyhedron's features, as unbounded polyhedra (thesis
// 4.3.2).
//
//     face    (4.2)    the triangle, along its normal: a prism without an end
//     edge    (4.6)    the edge, along all between the normals of its two faces: a wedge
//     vertex  (4.10)   the vertex, along all between the normals of its faces: a cone
//
// Errata of the thesis that are put right here:
// - (4.8): with one direction u both m_1 = u x n_1 and m_2 = u x n_2 cannot point outward.
// - (4.9), (4.11): n_1 x n_2 vanishes where the faces are coplanar; the edge itself bounds there.
// By rays instead of half-spaces neither matters: the normals are the rays.
#pragma once

#include "proxima/convex_polyhedron.h"
#include "proxima/geometry.h"
#include "proxima/result.h"

#include <span>

namespace proxima {

/// Of the triangle, on the side of its normal. Errors: invalid_argument for a degenerate triangle.
[[nodiscard]] Result<ConvexPolyhedron> voronoi_region_of_face(const Triangle& triangle);

/// Of the edge from p to q between faces with these outward normals, of any length; flat where the
/// faces are coplanar. Errors as convex_hull.
[[nodiscard]] Result<ConvexPolyhedron> voronoi_region_of_edge(const Vec3& p, const Vec3& q,
                                                              const Vec3& left_normal,
                                                              const Vec3& right_normal);

/// Of a vertex between faces with these outward normals, in any order. Errors as convex_hull.
[[nodiscard]] Result<ConvexPolyhedron> voronoi_region_of_vertex(const Vec3& vertex,
                                                                std::span<const Vec3> normals);

} // namespace proxima
