// The three sets of points that closest-point searches are timed with.
//
//     a  volume    uniform in the mesh's box scaled 1.2 times about its centre
//     b  surface   uniform on the surface by area, then moved in a uniformly random direction by
//                  a uniformly random length of at most 1 % of the box's diagonal
//     c  walk      a coherent walk in steps of 1e-4 of the diagonal that keeps its direction but
//                  for a little turn a step (persistence length about 0.1 of the diagonal), and
//                  bounces inside the shell of those cells, 1 % of the diagonal wide, that the
//                  surface goes through: like the tip of a probe near a model
#pragma once

#include "proxima/triangle_mesh.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace proxima {

struct QuerySet {
    const char* name;
    std::vector<Vec3> points;
};

/// The sets a, b and c with `count` points each. The same for the same mesh, seed and standard
/// library. About 0.1 us per point, and 50 to 100 ms for the shell. \pre the mesh has a triangle,
/// its positions are finite, differences of coordinates below 1e150
[[nodiscard]] std::array<QuerySet, 3> query_sets(const TriangleMesh& mesh, std::size_t count,
                                                 std::uint64_t seed);

} // namespace proxima
