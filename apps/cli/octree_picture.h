// A picture of a mesh with the boundary leaves of its octree: lines coloured by depth.
#pragma once

#include "cli/image.h"
#include "proxima/mesh/triangle_mesh.h"
#include "proxima/octree/octree.h"

namespace proxima {

enum class UpAxis { y, z };

struct PictureOptions {
    int width = 1600;
    int height = 1200;
    UpAxis up = UpAxis::y; ///< which axis of the mesh points up in the picture
};

/// Draws the mesh, shaded, and the edges of the leaves that hold triangles, seen three-quarter from
/// above. \pre octree was built from mesh, sizes are positive
[[nodiscard]] Image draw_octree(const Octree& octree, const TriangleMesh& mesh,
                                const PictureOptions& options = {});

} // namespace proxima
