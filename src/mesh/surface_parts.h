// How the proper triangles of a mesh hang together: edge uses, fans, loops, components. Internal.
//
// A proper triangle has three different vertex ids; the others are neighbours of nothing.
#pragma once

#include "proxima/geometry.h"
#include "proxima/topology.h"
#include "proxima/triangle_mesh.h"

#include <cstdint>
#include <span>
#include <vector>

namespace proxima::detail {

[[nodiscard]] inline bool is_proper(const TriangleCorners& corners) noexcept
{
    const auto [a, b, c] = corners;
    return a != b && b != c && c != a;
}

[[nodiscard]] inline bool is_finite(const Triangle& triangle) noexcept
{
    return triangle[0].allFinite() && triangle[1].allFinite() && triangle[2].allFinite();
}

/// The proper triangles of an edge, by direction.
struct EdgeUse {
    std::uint32_t forward = 0; ///< from the lower vertex to the higher
    std::uint32_t backward = 0;

    [[nodiscard]] std::uint32_t total() const noexcept { return forward + backward; }
    [[nodiscard]] bool is_open() const noexcept { return total() % 2 != 0; }
    [[nodiscard]] bool is_inconsistent() const noexcept
    {
        return !is_open() && forward != backward;
    }
};

/// The uses of all edges, by edge id.
[[nodiscard]] std::vector<EdgeUse> edge_uses(const TriangleMesh& mesh, const Topology& topology);

/// Number of sets of edges with a single proper triangle that vertices connect.
[[nodiscard]] std::uint64_t boundary_loops(const Topology& topology, std::span<const EdgeUse> uses);

/// For every vertex the number of sets of its proper triangles that edges at the vertex connect;
/// 2 stands for more as well.
[[nodiscard]] std::vector<std::uint8_t> fan_counts(const TriangleMesh& mesh,
                                                   const Topology& topology);

/// For every proper triangle the first one with the same three vertex ids, itself for the others.
[[nodiscard]] std::vector<std::uint32_t> first_duplicates(const TriangleMesh& mesh,
                                                          const Topology& topology);

/// A set of proper triangles that edges connect.
struct SurfaceComponent {
    std::uint32_t first_triangle = 0; ///< the lowest
    bool sealed = true;               ///< closed, consistently oriented, and all positions finite
    double volume = 0.0;    ///< signed, in units of the cube of the longest side of the bounds
    double magnitude = 0.0; ///< sum of the absolute terms of the volume
};

/// All components, by first triangle. `bounds` are those of the finite positions in use.
[[nodiscard]] std::vector<SurfaceComponent> surface_components(const TriangleMesh& mesh,
                                                               const Topology& topology,
                                                               std::span<const EdgeUse> uses,
                                                               const Box& bounds);

} // namespace proxima::detail
