// How the proper triangles of a mesh hang together: edge uses, fans, loops, components. Internal.
//
// A proper triangle has three different vertex ids; the others are neighbours of nothing.
#pragma once

#include "proxima/geometry.h"
#include "proxima/topology.h"
#include "proxima/triangle_mesh.h"

#include <cmath>
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
[[nodiscard]] std::vector<std::uint32_t> first_duplicates(const TriangleMesh& mesh);

/// A power of two that brings coordinates up to `reach` to at most 1, or as near as doubles allow.
[[nodiscard]] double unit_scale(double reach) noexcept;

/// Sums up the volume of a closed surface from its triangles.
struct VolumeSum {
    double scale = 1;     ///< a power of two that brings the surface's extent to about 1
    double volume = 0;    ///< signed, six times that of the scaled surface
    double magnitude = 0; ///< what the terms would sum up to, were all triangles seen straight on

    /// `origin` is a vertex of the surface: from farther away, rounding would hide small surfaces.
    /// `turned` negates the term exactly.
    void add(const Triangle& triangle, const Vec3& origin, bool turned = false) noexcept;

    /// 1 or -1, 0 where the volume may be mere rounding.
    [[nodiscard]] int sign() const noexcept
    {
        constexpr double smallest_ratio = 1e-12;
        if (!(std::abs(volume) > smallest_ratio * magnitude)) return 0;
        return volume > 0 ? 1 : -1;
    }
};

/// Of no surface, where surfaces of triangles are listed.
inline constexpr std::uint32_t no_surface_sum = ~std::uint32_t{0};

/// Sums of so many surfaces, without a triangle yet, each with the scale of its own extent: beside a
/// large surface a small one would vanish. `surface_of`: by triangle
[[nodiscard]] std::vector<VolumeSum>
scaled_sums(const TriangleMesh& mesh, std::span<const std::uint32_t> surface_of, std::size_t count);

/// A set of proper triangles that edges connect.
struct SurfaceComponent {
    std::uint32_t first_triangle = 0; ///< the lowest
    bool sealed = true;               ///< closed, consistently oriented, and all positions finite
    VolumeSum volume{};               ///< of its finite triangles
};

/// All components, by first triangle.
[[nodiscard]] std::vector<SurfaceComponent> surface_components(const TriangleMesh& mesh,
                                                               const Topology& topology,
                                                               std::span<const EdgeUse> uses);

} // namespace proxima::detail
