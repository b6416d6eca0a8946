// The first hit of a ray by the octree alone: cells along the ray, each cell's listed triangles
// tested until one is hit (thesis section 5.3).
//
//     if (const auto hit = closest_hit_by_cells(*octree, mesh, ray)) use(hit->t, hit->triangle);
//
// cast_ray.h is the fast way. This one tests a triangle again in every cell that lists it.
#pragma once

#include "proxima/geometry.h"
#include "proxima/octree.h"
#include "proxima/triangle_mesh.h"
#include "query/rays/ray_hit.h"

#include <optional>

namespace proxima {

/// The answer of closest_hit, except that a line which touches the root cell in a single point hits
/// nothing. Thread safe, no allocation. \pre the octree was built from this mesh, and lists exactly
/// the triangles that touch (OctreeParameters::exact); directions are so long that t is below 2^1000
/// all over the root
[[nodiscard]] std::optional<RayHit> closest_hit_by_cells(const Octree& octree,
                                                         const TriangleMesh& mesh, const Ray& ray,
                                                         Faces faces = Faces::both) noexcept;

} // namespace proxima
