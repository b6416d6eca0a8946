// Which triangles of two meshes meet, by the double recursion of their octrees: every triangle of a
// leaf against every triangle of the leaves of the other octree that meet it (thesis section 5.2).
#pragma once

#include "proxima/geometry.h"
#include "proxima/octree.h"
#include "proxima/triangle_mesh.h"
#include "query/contact/intersect_meshes.h"

#include <cstdint>
#include <vector>

namespace proxima {

/// A mesh and its octree, whose leaves list all triangles that touch them.
struct MeshCells {
    const TriangleMesh& mesh;
    const Octree& octree;
};

/// The pairs and what finding them took.
struct CellIntersection {
    std::vector<TrianglePair> pairs;  ///< by a, then b, each once
    std::uint64_t cell_tests = 0;     ///< of a cell against a cell
    std::uint64_t cell_pairs = 0;     ///< leaves that meet
    std::uint64_t triangle_tests = 0; ///< pairs of triangles, each once
};

/// The pairs that intersecting_pairs finds. Thread safe, allocates lists of candidate pairs.
[[nodiscard]] CellIntersection intersect_by_cells(const MeshCells& a, const MeshCells& b,
                                                  const RigidTransform& pose_b = {});

} // namespace proxima
