// The directions in which a feature of any mesh is, near itself, the closest one: thesis 4.3.2, for
// meshes that are not convex as well. It is the normal cone of the surface round the feature,
// convex however that is bent, and it lies on one side of the surface:
//
//      \  |  /
//       \ | /               ____   ____
//     ____\|/____               \ /              a saddle bends both ways: no direction is left,
//        /   \                 / | \             and the vertex is the closest one to itself alone
//     bent outward           bent inward
//     outside                behind
#pragma once

#include "proxima/result.h"
#include "proxima/topology.h"
#include "proxima/triangle_mesh.h"

#include <cstdint>
#include <vector>

namespace proxima {

/// A point of the feature and a direction; directions between two neighbours belong to the cone
/// too.
struct ConeCorner {
    Vec3 base = Vec3::Zero();
    Vec3 direction = Vec3::UnitZ(); ///< of length 1
    bool is_border = true;          ///< not merely between two others
};

enum class ConeSide : std::uint8_t {
    outside,
    behind ///< the surface, whose normals point away
};

enum class ConeShape : std::uint8_t {
    empty,
    line, ///< one corner: straight out of a flat part, as at a vertex within it
    flat, ///< corners in a row: of an edge between coplanar faces
    solid ///< corners in a circle
};

struct LocalCone {
    ConeShape shape = ConeShape::empty;
    ConeSide side = ConeSide::outside;
    std::vector<ConeCorner> corners;
    std::uint64_t comparisons = 0; ///< of directions with edges and directions: a vertex's work
};

/// The faces round the feature alone decide. The cone of a face is its outer side. Edges of one or
/// of many triangles are taken as they are; triangles of no area are overlooked. Errors:
/// invalid_argument (no such feature, a vertex that no triangle uses), invalid_mesh (a face of no
/// area, an edge of no length). About O(k^2) for k edges at a vertex.
[[nodiscard]] Result<LocalCone> local_cone(const TriangleMesh& mesh, const Topology& topology,
                                           Feature feature);

} // namespace proxima
