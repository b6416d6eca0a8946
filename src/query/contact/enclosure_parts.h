// What an Enclosure holds.
#pragma once

#include "octree/winding_number.h"
#include "proxima/geometry.h"
#include "proxima/intersect_meshes.h"
#include "proxima/mesh_index.h"

#include <vector>

namespace proxima {

struct PROXIMA_HIDDEN EnclosureParts {
    MeshIndex index;
    Box bounds; ///< of the mesh
    InsideMethod method = InsideMethod::crossings;
    std::vector<Vec3> vertices; ///< of every connected part the lowest one
    WindingStorage own_winding; ///< of rows; for open meshes whose index has no signs
    WindingClusters winding;    ///< of open meshes: that one, or the signs'
};

} // namespace proxima
