#include "minkowski/gaussian_map.h"

#include "base/check.h"
#include "geometry/exact_predicates.h"
#include "minkowski/facet_sign.h"
#include "minkowski/operation_counts.h"

#include <array>

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
        return normal_sign<Scalar>(other, other_facet, d);
    };
    // Climbs to a point that no neighbour exceeds. Up to two edges there are level.
    std::uint32_t vertex = start;
    std::array<std::uint32_t, 2> level{};
    int level_count = 0;
    for (bool higher = true; higher;) {
        higher = false;
        level_count = 0;
        for (const PolyhedronNeighbour& next : polyhedron.neighbours(vertex)) {
            const bool is_ray = polyhedron.is_ray(next.vertex);
            const int sign = sign_along({is_ray ? Vec3(Vec3::Zero()) : polyhedron.vertex(vertex),
                                         polyhedron.vertex(next.vertex)});
            if (sign > 0 && !is_ray) {
                vertex = next.vertex;
                higher = true;
                break;
            }
            if (sign == 0 && level_count < 2)
                level[static_cast<std::size_t>(level_count++)] = next.edge;
        }
    }
    if (level_count == 0) return {0, vertex, vertex};
    if (level_count == 1) return {1, vertex, level[0]};
    // The facet between both edges; for a polygon, the side that faces the direction.
    const PolyhedronEdge& first = polyhedron.edges()[level[0]];
    const PolyhedronEdge& second = polyhedron.edges()[level[1]];
    const bool left_is_shared = first.left == second.left || first.left == second.right;
    const bool right_is_shared = first.right == second.left || first.right == second.right;
    PROXIMA_CHECK(left_is_shared || right_is_shared);
    bool is_left = left_is_shared;
    if (left_is_shared && right_is_shared) {
        is_left = same_direction(polyhedron.normal_factors(first.left),
                                 other.normal_factors(other_facet));
    }
    return {2, vertex, is_left ? first.left : first.right};
}

template <class Scalar>
ArcCrossing arcs_cross(const ConvexPolyhedron& a, const PolyhedronEdge& edge_a,
                       const ConvexPolyhedron& b, const PolyhedronEdge& edge_b) noexcept
{
    const Displacement along_a = a.direction(edge_a);
    const Displacement along_b = b.direction(edge_b);
    const int left_a = normal_sign<Scalar>(a, edge_a.left, along_b);
    if (left_a == 0 || normal_sign<Scalar>(a, edge_a.right, along_b) != -left_a)
        return ArcCrossing::none;
    if (normal_sign<Scalar>(b, edge_b.left, along_a) != -left_a) return ArcCrossing::none;
    if (normal_sign<Scalar>(b, edge_b.right, along_a) != left_a) return ArcCrossing::none;
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
