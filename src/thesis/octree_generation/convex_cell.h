// Convex polygons and polyhedra being cut by planes: the cells of a partition of space, and the
// pieces of facets in them.
#pragma once

#include "proxima/convex_polyhedron.h"
#include "proxima/geometry.h"

#include <vector>

namespace proxima::detail {

using PolygonCorners = std::vector<Vec3>;

/// Signed distance beyond a plane; its normal is of length 1.
[[nodiscard]] inline double distance_beyond(const HalfSpace& plane, const Vec3& point) noexcept
{
    return plane.normal.dot(point) - plane.offset;
}

[[nodiscard]] inline HalfSpace opposite(const HalfSpace& plane) noexcept
{
    return {-plane.normal, -plane.offset};
}

/// The part of a convex polygon in the half-space; no corners if none of it is.
[[nodiscard]] PolygonCorners clipped(const PolygonCorners& polygon, const HalfSpace& half_space);

[[nodiscard]] double area(const PolygonCorners& polygon) noexcept;

/// A bounded convex polyhedron as the polygons around it.
class ConvexCell {
public:
    explicit ConvexCell(const Box& box);

    [[nodiscard]] double volume() const;
    /// The volume of the part in the half-space.
    [[nodiscard]] double volume_within(const HalfSpace& half_space) const;
    /// The part in the half-space; it may be empty.
    [[nodiscard]] ConvexCell within(const HalfSpace& half_space) const;
    /// A point inside. \pre not empty
    [[nodiscard]] Vec3 middle() const;
    [[nodiscard]] Box bounds() const;
    [[nodiscard]] bool is_empty() const noexcept { return faces_.empty(); }

private:
    ConvexCell() = default;

    std::vector<PolygonCorners> faces_;
};

} // namespace proxima::detail
