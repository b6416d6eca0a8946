#include "proxima/minkowski/gaussian_map.h"

#include "proxima/base/check.h"
#include "proxima/minkowski/operation_counts.h"

namespace proxima {
namespace {

bool same_direction(const ConvexPolyhedron::NormalFactors& p,
                    const ConvexPolyhedron::NormalFactors& q) noexcept
{
    for (int axis = 0; axis < 3; ++axis) {
        const int sign = cross_component_sign(p.u, p.v, axis);
        if (sign != 0) return sign == cross_component_sign(q.u, q.v, axis);
    }
    return false;
}

} // namespace

template <class Scalar>
SupportFace support_face(const ConvexPolyhedron& polyhedron, const ConvexPolyhedron& other,
                         std::uint32_t other_facet, std::uint32_t start) noexcept
{
    const auto sign_along = [&](const Displacement& d) noexcept {
        return other.template normal_sign<Scalar>(other_facet, d);
    };
    const std::uint32_t vertex = climb(polyhedron, sign_along, start);
    SupportFace face = {0, vertex, vertex};
    for (const PolyhedronNeighbour& next : polyhedron.neighbours(vertex)) {
        const PolyhedronEdge& edge = polyhedron.edges()[next.edge];
        if (sign_along(polyhedron.direction(edge)) != 0) continue;
        if (face.dimension == 0) {
            face = {1, vertex, next.edge};
            continue;
        }
        // A second edge: the facet between both; of a polygon, that which looks the right way.
        const PolyhedronEdge& first = polyhedron.edges()[face.item];
        const bool left_is_shared = first.left == edge.left || first.left == edge.right;
        const bool right_is_shared = first.right == edge.left || first.right == edge.right;
        PROXIMA_CHECK(left_is_shared || right_is_shared);
        bool is_left = left_is_shared;
        if (left_is_shared && right_is_shared) {
            is_left = same_direction(polyhedron.normal_factors(first.left),
                                     other.normal_factors(other_facet));
        }
        return {2, vertex, is_left ? first.left : first.right};
    }
    return face;
}

template <class Scalar>
ArcCrossing arcs_cross(const ConvexPolyhedron& a, const PolyhedronEdge& edge_a,
                       const ConvexPolyhedron& b, const PolyhedronEdge& edge_b) noexcept
{
    const Displacement along_a = a.direction(edge_a);
    const Displacement along_b = b.direction(edge_b);
    const int left_a = a.template normal_sign<Scalar>(edge_a.left, along_b);
    if (left_a == 0 || a.template normal_sign<Scalar>(edge_a.right, along_b) != -left_a)
        return ArcCrossing::none;
    if (b.template normal_sign<Scalar>(edge_b.left, along_a) != -left_a) return ArcCrossing::none;
    if (b.template normal_sign<Scalar>(edge_b.right, along_a) != left_a) return ArcCrossing::none;
    return left_a > 0 ? ArcCrossing::plus : ArcCrossing::minus;
}

template SupportFace support_face<double>(const ConvexPolyhedron&, const ConvexPolyhedron&,
                                          std::uint32_t, std::uint32_t) noexcept;
template SupportFace support_face<Counted>(const ConvexPolyhedron&, const ConvexPolyhedron&,
                                           std::uint32_t, std::uint32_t) noexcept;
template ArcCrossing arcs_cross<double>(const ConvexPolyhedron&, const PolyhedronEdge&,
                                        const ConvexPolyhedron&, const PolyhedronEdge&) noexcept;
template ArcCrossing arcs_cross<Counted>(const ConvexPolyhedron&, const PolyhedronEdge&,
                                         const ConvexPolyhedron&, const PolyhedronEdge&) noexcept;

} // namespace proxima
