// The features of any mesh with their local regions: what the builder tests against cells.
//
//     face     3 side planes                                            of the prism over it
//     edge     2 end planes, and for every incident face t the plane    (x - p).m_t >= 0
//     vertex   one plane per neighbour w                                (x - v).(w - v) <= 0
//
// If a feature holds the point of the mesh closest to x, then x lies in its local region, whatever
// the mesh: closed or open, convex or not, manifold or not. (Moving along the mesh from the closest
// point must not lead nearer to x.) On convex meshes these are the thesis's exterior Voronoi
// regions (4.3.2) without the restriction to the outside.
//
// Everything is in the root's frame, coordinates within about [-1, 1], as floats whose errors are
// covered: planes lie outside of the true ones by at least `float_margin`.
#pragma once

#include "index/lists/root_frame.h"
#include "proxima/execution.h"
#include "proxima/topology.h"
#include "proxima/triangle_mesh.h"

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace proxima {

/// What a sum of up to 14 products of floats within [-1, 1], rounded once each and compared with
/// another such sum, can be wrong by: 14 * 2 * 2^-24 < 2^-19, in units of the root frame.
inline constexpr float float_margin = 0x1p-19F;

/// Planes kept per vertex and faces per edge: to leave some out only makes a region larger.
inline constexpr std::uint32_t max_vertex_planes = 16;
inline constexpr std::uint32_t max_edge_faces = 6;

/// Where a feature's numbers are, see LocalFeatures.
struct LocalFeature {
    std::uint32_t numbers = 0;        ///< first of its floats
    std::uint32_t incident = 0;       ///< first of its incident triangles
    std::uint32_t incident_count = 0; ///< 1 for a face
    std::uint16_t planes = 0;
    FeatureKind kind = FeatureKind::vertex;
    bool flat = true; ///< faces: false for slivers, whose normal says too little
};

/// What follows the planes (four floats each: n with n . x <= offset, of length 1 but for rounding;
/// offset, the margin included) among a feature's numbers.
inline constexpr std::uint32_t plane_floats = 4;
inline constexpr std::uint32_t face_floats =
    14; ///< normal 3 | least, greatest normal . corner | corners 9
inline constexpr std::uint32_t edge_floats = 6;   ///< ends 6
inline constexpr std::uint32_t vertex_floats = 3; ///< position 3

/// All features, in the Morton order of the triangles where they come first. Incident triangles are
/// ranks in that order, ascending.
struct LocalFeatures {
    std::vector<LocalFeature> features;
    std::vector<float> numbers;
    std::vector<std::uint32_t> incident;

    [[nodiscard]] const float* planes(const LocalFeature& feature) const noexcept
    {
        return numbers.data() + feature.numbers;
    }
    [[nodiscard]] const float* shape(const LocalFeature& feature) const noexcept
    {
        return planes(feature) + std::size_t{plane_floats} * feature.planes;
    }
    [[nodiscard]] std::span<const std::uint32_t>
    triangles(const LocalFeature& feature) const noexcept
    {
        return std::span(incident).subspan(feature.incident, feature.incident_count);
    }
    [[nodiscard]] std::uint64_t bytes() const noexcept;
};

/// The features that can be closest to a point and are not degenerate: triangles that are segments
/// or points count by their edges and vertices, and slivers without a normal as their longest side.
/// `order` are the triangles by rank. Null where cancelled. About 300 bytes per triangle of a closed
/// mesh. O(features).
[[nodiscard]] std::optional<LocalFeatures> collect_local_features(const TriangleMesh& mesh,
                                                                  const Topology& topology,
                                                                  std::span<const TriangleId> order,
                                                                  const RootFrame& frame,
                                                                  Progress* progress);

} // namespace proxima
