// Quickhull with exact decisions, over points and points at infinity [barber-1996].
//
//     four corners -> a tetrahedron; every other vertex waits with a face that sees it;
//     the farthest that waits with a face joins: the faces that see it give way to a cone from
//     their outline, and what waited with them waits with the cone's faces
//
// A ray is a corner at infinity. With w = 1 for points and 0 for rays, all orientations are signs
// of 4 x 4 determinants of (x, y, z, w), of which one point's subtraction leaves 3 x 3; seen so, an
// unbounded polyhedron is a bounded one, perhaps with a face at infinity (three rays).
#pragma once

#include "proxima/execution.h"
#include "proxima/geometry.h"
#include "proxima/result.h"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace proxima::detail {

/// Points first, then rays.
struct HullVertices {
    std::span<const Vec3> coordinates;
    std::uint32_t point_count = 0;

    [[nodiscard]] bool is_ray(std::uint32_t vertex) const noexcept { return vertex >= point_count; }
};

/// A triangle of the hull, counter-clockwise seen from outside; neighbours[i] lies across the edge
/// from vertex i to vertex i + 1. Coplanar triangles are possible, degenerate ones are not.
struct HullTriangle {
    std::array<std::uint32_t, 3> vertices{};
    std::array<std::uint32_t, 3> neighbours{};
};

/// What a set of vertices spans: dimension + 1 of them that already do.
struct AffineSpan {
    int dimension = 0;
    std::array<std::uint32_t, 4> vertices{};
};

/// Exact. The first vertex is a point. O(vertices). \pre at least one point; all finite; no zero
/// ray
[[nodiscard]] AffineSpan affine_span(const HullVertices& vertices);

/// The triangles of the hull. O(n log n) for vertices in random order; the worst case is quadratic.
/// `trials`, where given, becomes how often a vertex was held against a face: most of the work.
/// Errors: cancelled. \pre span.dimension == 3; the rays are in an open half-space
[[nodiscard]] Result<std::vector<HullTriangle>> quickhull(const HullVertices& vertices,
                                                          const AffineSpan& span,
                                                          Progress* progress,
                                                          std::uint64_t* trials = nullptr);

/// Bounds the error of (u x v) . d, all rounded, per unit of |d.x| + |d.y| + |d.z|.
[[nodiscard]] double normal_tolerance(const Vec3& u, const Vec3& v) noexcept;

/// Whether the triangle lies with vertex v in one plane, sees it (+1), or has it behind (-1).
/// Exact.
[[nodiscard]] int hull_side(const HullVertices& vertices,
                            const std::array<std::uint32_t, 3>& corners, std::uint32_t v) noexcept;

} // namespace proxima::detail
