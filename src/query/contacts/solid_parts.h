// What a Solid holds.
#pragma once

#include "proxima/contacts.h"
#include "proxima/convex_polyhedron.h"
#include "proxima/intersect_meshes.h"
#include "proxima/mesh_index.h"
#include "proxima/triangle_mesh.h"

namespace proxima {

struct PROXIMA_HIDDEN SolidParts {
    TriangleMesh mesh;
    MeshIndex index; ///< with signs
    Enclosure enclosure;
    ConvexPolyhedron hull;
    bool is_convex = false;
    double hull_error = 0; ///< of a convex mesh
    double largest = 0;    ///< coordinate of its vertices
};

} // namespace proxima
