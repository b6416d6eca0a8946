// Polyhedra and sums as surfaces to draw and to write: polygons over positions, rays cut off.
#pragma once

#include "proxima/convex_polyhedron.h"
#include "proxima/minkowski_sum.h"
#include "proxima/result.h"
#include "proxima/triangle_mesh.h"

#include <cstdint>
#include <span>
#include <vector>

namespace proxima {

/// Polygon f has the corners corners[first[f]] up to corners[first[f + 1]], counter-clockwise seen
/// from outside, and is facet f.
struct DrawnSurface {
    std::vector<Vec3> positions;
    std::vector<std::uint32_t> first = {0};
    std::vector<std::uint32_t> corners;

    [[nodiscard]] std::size_t polygon_count() const noexcept { return first.size() - 1; }
    [[nodiscard]] std::span<const std::uint32_t> polygon(std::size_t f) const noexcept
    {
        return std::span(corners).subspan(first[f], first[f + 1] - first[f]);
    }
};

/// Rays are drawn `ray_length` long from each point that they leave; where they were cut off the
/// surface is open. Errors: invalid_argument for a length that is not positive and finite, for
/// points, segments, and sums that hold a line: they have no polygons; limit_exceeded where a scale
/// or a length makes a coordinate infinite.
[[nodiscard]] Result<DrawnSurface> draw(const ConvexPolyhedron& polyhedron, double ray_length = 1);
[[nodiscard]] Result<DrawnSurface> draw(const MinkowskiSum& sum, double ray_length = 1);

/// The polygons as fans of triangles.
[[nodiscard]] Result<TriangleMesh> triangulate(const DrawnSurface& surface);

} // namespace proxima
