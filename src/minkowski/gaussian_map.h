// The Gaussian map of a convex polyhedron: outward directions, seen as a sphere (thesis 3.2.1, 6).
//
//     facet  -> a point    its normal
//     edge   -> an arc     from the normal of its left facet to that of its right one, below pi
//     vertex -> a region   all directions in which it is the farthest point
//     ray    -> a border   directions beyond which the polyhedron goes on forever
//
// Laid over each other, the maps of A and B make that of their Minkowski sum: its facets are the
// points of either map and the crossings of their arcs. All questions here are signs of
// determinants of coordinate differences, and answered exactly.
#pragma once

#include "proxima/convex_polyhedron.h"

#include <cstdint>
#include <optional>
#include <span>

namespace proxima {

/// The part of a polyhedron that reaches farthest in a direction: a vertex, an edge or a facet.
struct SupportFace {
    int dimension = 0;        ///< 0 vertex, 1 edge, 2 facet
    std::uint32_t vertex = 0; ///< a point of it
    std::uint32_t item = 0;   ///< the vertex, edge or facet
};

/// Whether the polyhedron ends somewhere in a direction. sign_along(d) is the sign of the direction
/// . d, exactly, for a Displacement d.
template <class SignAlong>
[[nodiscard]] bool ends_along(const ConvexPolyhedron& polyhedron, SignAlong sign_along) noexcept
{
    for (const Vec3& ray : polyhedron.rays()) {
        if (sign_along({Vec3::Zero(), ray}) > 0) return false;
    }
    return true;
}

/// The face farthest along the outward normal of a facet of another polyhedron, found by climbing
/// from a point. Of a polygon that faces exactly that way or the opposite: its front or its back.
/// \pre ends_along that normal. Instantiated for double and Counted.
template <class Scalar = double>
[[nodiscard]] SupportFace support_face(const ConvexPolyhedron& polyhedron,
                                       const ConvexPolyhedron& other, std::uint32_t other_facet,
                                       std::uint32_t start) noexcept;

/// How two arcs cross: not, or in a direction that is +(a x b) or -(a x b) of the edges.
enum class ArcCrossing : std::int8_t { minus = -1, none = 0, plus = 1 };

/// Whether the arcs of two edges cross inside both: their sum is then a facet of the sum. By four
/// signs and no cross product. \pre both have facets at their sides. Instantiated for double and
/// Counted.
template <class Scalar = double>
[[nodiscard]] ArcCrossing arcs_cross(const ConvexPolyhedron& a, const PolyhedronEdge& edge_a,
                                     const ConvexPolyhedron& b,
                                     const PolyhedronEdge& edge_b) noexcept;

} // namespace proxima
