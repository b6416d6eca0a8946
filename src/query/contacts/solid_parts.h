// What a Solid holds.
#pragma once

#include "proxima/contacts.h"
#include "proxima/convex_polyhedron.h"
#include "proxima/intersect_meshes.h"
#include "proxima/mesh_index.h"
#include "proxima/result.h"
#include "proxima/triangle_mesh.h"

#include <Eigen/LU>

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

/// The inverse of a pose whose matrix may be no rotation by a little, as the transpose is not.
inline RigidTransform true_inverse(const RigidTransform& pose)
{
    RigidTransform back;
    back.rotation = pose.rotation.inverse();
    back.translation = -(back.rotation * pose.translation);
    return back;
}

/// Error invalid_argument where a number is NaN or infinite, or the matrix is far from a rotation.
[[nodiscard]] Status check_pose(const RigidTransform& pose_b);

} // namespace proxima
