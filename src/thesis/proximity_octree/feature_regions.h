// The Voronoi regions of a convex mesh's features, and pictures of them (thesis 4.3.2, figures 4.3
// to 4.6).
//
//     const auto region = voronoi_region_of(mesh, topology, {FeatureKind::edge, 17});
//     const auto shape = voronoi_region_mesh(mesh, topology, {FeatureKind::vertex, 3}, 0.5);
#pragma once

#include "proxima/convex_polyhedron.h"
#include "proxima/result.h"
#include "proxima/topology.h"
#include "proxima/triangle_mesh.h"

#include <cstdint>

namespace proxima {

/// The exterior Voronoi region of a feature: all points outside that it is closest to. Of an edge
/// between coplanar faces it is flat; it may be thin by rounding alone. Only the feature's own
/// faces are looked at: the rest of the mesh is taken to be convex. Errors: invalid_argument (no
/// such feature, or a vertex that no triangle uses), invalid_mesh (an incident edge that has not
/// two triangles or is bent inward by more than 1e-8 radians, a triangle of no area).
/// O(k log k) for k incident faces. \pre topology is the mesh's
[[nodiscard]] Result<ConvexPolyhedron> voronoi_region_of(const TriangleMesh& mesh,
                                                         const Topology& topology, Feature feature);

/// How a region that never ends is drawn.
enum class RegionEnd : std::uint8_t {
    open,  ///< rays are drawn as long as asked, with nothing between their ends
    closed ///< cut off there: a closed surface
};

/// The region as a surface to draw, its rays `length` long, in the mesh's units. Errors: as
/// voronoi_region_of; invalid_argument for a length that is not positive and finite, and for a
/// region that is but a line: that of a vertex inside a flat part.
[[nodiscard]] Result<TriangleMesh> voronoi_region_mesh(const TriangleMesh& mesh,
                                                       const Topology& topology, Feature feature,
                                                       double length,
                                                       RegionEnd end = RegionEnd::closed);

} // namespace proxima
