// Whether a point is on its closest feature, though the closest point as computed may be beside it.
#pragma once

#include "geometry/exact_predicates.h"
#include "index/triangle_row.h"
#include "proxima/geometry.h"
#include "proxima/topology.h"

#include <algorithm>

namespace proxima {

/// What distances may be wrong by, in the largest coordinate of the point and the triangle.
inline constexpr double on_feature_rounding = 0x1p-44;

struct EdgeEnds {
    Vec3 low; ///< of the lower vertex id
    Vec3 high;
};

/// \pre the edge is one of the row's
template <class Scalar>
[[nodiscard]] EdgeEnds edge_ends(const TriangleRow<Scalar>& row, std::uint32_t edge) noexcept
{
    const std::size_t side = side_of(row, edge);
    const Vec3 from = row.corner(static_cast<int>(side));
    const Vec3 to = row.corner(side == 2 ? 0 : static_cast<int>(side) + 1);
    return row.backward(side) ? EdgeEnds{to, from} : EdgeEnds{from, to};
}

/// Whether p is on its closest feature: as computed, the distance being 0, or exactly.
/// \pre the feature is one of the row's
template <class Scalar>
[[nodiscard]] bool is_on_feature(const TriangleRow<Scalar>& row, const Feature& feature,
                                 double distance, const Vec3& p) noexcept
{
    if (distance == 0) return true;
    const Triangle triangle = row.corners();
    double size = p.cwiseAbs().maxCoeff();
    for (const Vec3& corner : triangle.vertices)
        size = std::max(size, corner.cwiseAbs().maxCoeff());
    if (distance > on_feature_rounding * size) return false;
    if (feature.kind == FeatureKind::face)
        return orient3d(triangle[0], triangle[1], triangle[2], p) == 0;
    if (feature.kind == FeatureKind::vertex) return false;
    const EdgeEnds ends = edge_ends(row, feature.id);
    return are_parallel({ends.low, p}, {ends.low, ends.high});
}

} // namespace proxima
