// The curves in which two meshes intersect, from the pairs of triangles that meet (thesis section
// 5.2, "the intersection boundary").
//
//     points   p0 p1 p2 ... | q0 q1 ...      each on a vertex, an edge or a face of either mesh
//     lines    closed       | open
//
// Each pair of triangles gives a segment, and segments are joined where they end at the same
// features of both meshes, which is decided exactly (triangle_intersection.h), however close or
// equal the coordinates of different ends are. Vertices at one position are one.
#pragma once

#include "proxima/geometry.h"
#include "proxima/topology.h"
#include "proxima/triangle_mesh.h"
#include "query/contact/intersect_meshes.h"

#include <array>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace proxima {

/// A vertex (its id, twice), an edge (its vertices, ascending) or a face (its triangle, twice). Of
/// vertices at one position the lowest one that the pairs' triangles use.
struct SurfacePart {
    FeatureKind kind = FeatureKind::vertex;
    std::array<std::uint32_t, 2> ids{};
    friend constexpr bool operator==(const SurfacePart&, const SurfacePart&) = default;
    // NOLINTNEXTLINE(modernize-use-nullptr): of the defaulted comparison's own text
    friend constexpr auto operator<=>(const SurfacePart&, const SurfacePart&) = default;
};

/// A point of both surfaces, in A's coordinates: the only common point of the insides of the two
/// features (of B moved). Rounded as meeting_point says.
struct ContourPoint {
    Vec3 position = Vec3::Zero();
    SurfacePart on_a;
    SurfacePart on_b;
};

/// points[first] to points[first + count - 1]; a closed one goes on to its first point again. One
/// point alone: the meshes touch there and nowhere near.
struct ContourLine {
    std::size_t first = 0;
    std::size_t count = 0;
    bool closed = false;
};

struct IntersectionContour {
    std::vector<ContourPoint> points;
    std::vector<ContourLine> lines;

    [[nodiscard]] std::span<const ContourPoint> points_of(const ContourLine& line) const noexcept
    {
        return std::span(points).subspan(line.first, line.count);
    }
    /// Of all lines together.
    [[nodiscard]] double length() const noexcept;
};

/// The contour of A and B moved by the pose. `pairs` are those that meet, in any order; others add
/// nothing. Where surfaces pass through each other in general position, all lines end only at
/// borders: those of two closed meshes are closed. Besides:
/// - Triangles in one plane share an area. Of that the contour has the border, and edges within it
///   only where triangles of different planes meet there too.
/// - Where surfaces only touch along an edge, the line along it ends where the edge does.
/// - Where more than two segments meet in a point, lines go on along any of them, and no segment
///   comes twice.
/// - Where triangles of one mesh cover each other (a flap, there and back), the line ends with
/// them.
/// - A triangle without an area joins the segments of its neighbours; two of them add nothing.
/// O(pairs log pairs), about 3 us each; allocates. Same bits on every machine. \pre positions of
/// the pairs' triangles are finite, and so are differences of coordinates
[[nodiscard]] IntersectionContour intersection_contour(const TriangleMesh& a, const TriangleMesh& b,
                                                       const RigidTransform& pose_b,
                                                       std::span<const TrianglePair> pairs);

} // namespace proxima
