// What every search for the closest feature answers (thesis chapter 4).
//
//     feature    the lowest-dimensional feature that holds the closest point: at a corner the
//                vertex, on a side the edge, inside the face
//     triangle   the lowest id incident to that feature, by topology
//     ties       by squared distance as computed, then kind (vertex < edge < face), then id
#pragma once

#include "proxima/geometry/vec.h"
#include "proxima/mesh/feature.h"
#include "proxima/mesh/triangle_mesh.h"

#include <array>

namespace proxima {

/// The feature of a mesh closest to a point. Lengths in the mesh's unit.
struct ClosestFeature {
    Feature feature = {};
    TriangleId triangle{};
    Vec3 point = Vec3::Zero();              ///< of the feature, up to rounding
    std::array<double, 3> barycentric = {}; ///< of `point` in `triangle`: in [0, 1], sum 1
    double squared_distance = 0.0;          ///< from the query to `point`
};

} // namespace proxima
