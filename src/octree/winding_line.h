// The exact winding number of a closed surface in an empty cell, counted along a line in parts.
//
//     top of the root  ---+----   The line goes up from the cell. Each leaf counts the crossings
//        | leaf |         |       between its lower plane and its upper one, which is the lower one
//        +------+     +1  /       of the next leaf: every crossing is counted in one leaf alone, so
//        | leaf |        /        that counts of parts of an octree add up to that of the whole.
//        +------+
//        | cell |   winding number = sum of all counts
//
// The line stands a little off the point that it is said to go through, by e along x and by e^2
// along y with an e smaller than any distance [edelsbrunner-1990]; so it meets no edge and no vertex.
#pragma once

#include "proxima/octree.h"
#include "proxima/triangle_mesh.h"

#include <array>
#include <cstdint>

namespace proxima {

/// A line up along z from the upper face of a cell, in the columns of an octree's deepest cells.
struct WindingLine {
    double x = 0.0;
    double y = 0.0;
    std::array<std::uint32_t, 2> column = {}; ///< of deepest cells, on x and y
    std::uint32_t first_plane = 0; ///< of the deepest cells' planes on z, where it begins
};

/// The line through the middle of a cell of octrees with this root and maximum depth.
[[nodiscard]] WindingLine winding_line(const OctreeFrame& frame, int max_depth,
                                       CellKey cell) noexcept;

/// What the leaves of an octree add to the winding number where the line begins: +1 for a triangle
/// that the line crosses outwards, -1 inwards. Leaves that a part of an octree lacks add nothing.
/// No allocation; O(leaves on the line times depth, and their lists).
/// \pre the octree was built from the mesh and is exact
[[nodiscard]] std::int64_t count_crossings(const Octree& octree, const TriangleMesh& mesh,
                                           const WindingLine& line) noexcept;

/// What all triangles of a mesh within the root add, whatever octree: O(triangles).
[[nodiscard]] std::int64_t count_crossings(const OctreeFrame& frame, int max_depth,
                                           const TriangleMesh& mesh,
                                           const WindingLine& line) noexcept;

} // namespace proxima
