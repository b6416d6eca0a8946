#include "mesh/coincidence.h"

#include "mesh/equal_items.h"
#include "mesh/surface_parts.h"

#include <algorithm>
#include <bit>
#include <chrono>
#include <cstdint>

namespace proxima::detail {

namespace {

/// Another number in each process, so that nobody can make positions of one hash, which would be compared
/// one by one. Nothing that is found depends on it.
std::uint64_t secret() noexcept
{
    static const std::uint64_t number = [] {
        const auto time = std::chrono::steady_clock::now().time_since_epoch().count();
        const void* const place = &time; // which the system scatters
        return mix_bits(static_cast<std::uint64_t>(time), std::bit_cast<std::uintptr_t>(place));
    }();
    return number;
}

std::uint64_t hash_of(const Vec3& position) noexcept
{
    std::uint64_t hash = secret();
    for (const double coordinate : position) {
        hash = mix_bits(hash, std::bit_cast<std::uint64_t>(coordinate + 0.0)); // -0 becomes 0
    }
    return hash;
}

TriangleCorners welded(const TriangleCorners& corners,
                       std::span<const std::uint32_t> same_position) noexcept
{
    return {same_position[corners[0]], same_position[corners[1]], same_position[corners[2]]};
}

} // namespace

TriangleCorners sorted_corners(TriangleCorners corners) noexcept
{
    std::sort(corners.begin(), corners.end());
    return corners;
}

std::uint64_t hash_of(const TriangleCorners& sorted) noexcept
{
    return mix_bits(mix_bits(sorted[0], sorted[1]), sorted[2]);
}

std::vector<std::uint32_t> first_at_position(const TriangleMesh& mesh)
{
    const std::span<const Vec3> positions = mesh.positions();
    return first_equal_items(
        static_cast<std::uint32_t>(positions.size()),
        [&](std::uint32_t vertex) { return positions[vertex].allFinite(); },
        [&](std::uint32_t vertex) { return hash_of(positions[vertex]); },
        [&](std::uint32_t a, std::uint32_t b) { return positions[a] == positions[b]; });
}

std::vector<std::uint32_t> first_coincident(const TriangleMesh& mesh,
                                            std::span<const std::uint32_t> same_position)
{
    // Triangles with different ids at equal positions share a position between two vertices.
    std::vector<bool> shares_position(mesh.vertex_count(), false);
    for (std::uint32_t vertex = 0; vertex < mesh.vertex_count(); ++vertex) {
        if (same_position[vertex] == vertex) continue;
        shares_position[vertex] = shares_position[same_position[vertex]] = true;
    }
    const auto key = [&](std::uint32_t triangle) {
        return sorted_corners(welded(mesh.triangles()[triangle], same_position));
    };
    const auto takes_part = [&](std::uint32_t triangle) {
        const TriangleCorners& corners = mesh.triangles()[triangle];
        return std::any_of(corners.begin(), corners.end(),
                           [&](std::uint32_t corner) { return shares_position[corner]; }) &&
               is_proper(key(triangle));
    };
    return first_equal_items(
        static_cast<std::uint32_t>(mesh.triangle_count()), takes_part,
        [&](std::uint32_t triangle) { return hash_of(key(triangle)); },
        [&](std::uint32_t a, std::uint32_t b) { return key(a) == key(b); });
}

Result<bool> is_closed_if_welded(const TriangleMesh& mesh,
                                 std::span<const std::uint32_t> same_position,
                                 const TopologyOptions& options)
{
    std::vector<TriangleCorners> triangles;
    for (const TriangleCorners& corners : mesh.triangles()) {
        const TriangleCorners one = welded(corners, same_position);
        if (is_proper(one)) triangles.push_back(one);
    }
    const Result<TriangleMesh> one_mesh = make_triangle_mesh(
        {mesh.positions().begin(), mesh.positions().end()}, std::move(triangles));
    if (!one_mesh) return tl::unexpected(one_mesh.error());
    const Result<Topology> topology = build_topology(*one_mesh, options);
    if (!topology) return tl::unexpected(topology.error());
    bool closed = topology->edge_count() > 0;
    for (std::uint32_t id = 0; id < topology->edge_count(); ++id) {
        closed = closed && topology->triangles(EdgeId{id}).size() % 2 == 0;
    }
    return closed;
}

} // namespace proxima::detail
