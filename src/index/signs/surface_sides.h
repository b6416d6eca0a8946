// What lies on the two sides of each triangle: whether the surface separates inside from outside
// there, inside being where the winding number is at least 1/2.
//
//     every edge has as many triangles one way as the other      else nothing is known
//     triangles that meet others but at vertices and edges that they share by id are doubtful
//     patch: other triangles, connected by edges of two: the winding number in front of it is the
//     same all over, for no surface passes through, and one more behind it
//
//        in front   0: separates    1 or more: inside on both sides    below 0: outside on both
//
// So a ball in a ball, both facing outward, is inside on both sides of the inner one, a ball turned
// inside out has no inside, and of two that overlap only the triangles along the seam are doubtful.
#pragma once

#include "index/signs/sign_parts.h"
#include "proxima/execution.h"
#include "proxima/mesh_index.h"
#include "proxima/result.h"
#include "proxima/topology.h"
#include "proxima/triangle_mesh.h"

#include <cstdint>
#include <vector>

namespace proxima {

struct SurfaceSidesOptions {
    Execution execution = {};
};

/// The sides of every triangle, by id; doubtful for those without an area, and for those that meet
/// others or all but do: within 2^-45 of the mesh's size, or at an edge under less than 1/1000.
/// Empty where some edge has more triangles one way than the other: then winding numbers are not
/// whole.
/// About 2 us per triangle of a closed mesh and 10 per patch. The same for any number of threads.
/// Error: cancelled. \pre index and topology are the mesh's
[[nodiscard]] Result<std::vector<SurfaceSides>>
find_surface_sides(const MeshIndex& index, const TriangleMesh& mesh, const Topology& topology,
                   const SurfaceSidesOptions& options = {});

/// For every triangle with an area whether it meets another such one otherwise than at the vertices
/// and edges that they share by id. Exact, but that one whose box meets those of more than 4096
/// others is said to meet one. Same cost and conditions.
[[nodiscard]] Result<std::vector<std::uint8_t>>
find_self_contacts(const MeshIndex& index, const TriangleMesh& mesh,
                   const SurfaceSidesOptions& options = {});

} // namespace proxima
