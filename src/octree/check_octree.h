// The octree's invariants: what every builder owes and every query relies on.
#pragma once

#include "proxima/execution.h"
#include "proxima/octree.h"
#include "proxima/result.h"
#include "proxima/triangle_mesh.h"

namespace proxima {

/// check_structure, and against the mesh it was built from:
/// - the root contains the mesh, and the mesh has triangle_count() triangles;
/// - a cell is split iff more triangles than the threshold are listed below it and it may be
///   deeper (uniform: iff it may be deeper);
/// - completeness: every triangle is listed in every leaf that it touches, so that no point of it
///   lies in a leaf that does not list it;
/// - minimality where parameters().exact: no leaf lists a triangle that does not touch it.
/// Touching is decided by the exact triangle_overlaps_box. Errors: broken_invariant naming the
/// cell; cancelled by `progress`, stage "checking the cells", steps are references. Slow: a few
/// exact tests per cell and triangle. For tests, tools and doubt.
[[nodiscard]] Status check_octree(const Octree& octree, const TriangleMesh& mesh,
                                  Progress* progress = nullptr);

} // namespace proxima
