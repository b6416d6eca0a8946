#include "proxima/mesh/weld_vertices.h"

#include <array>
#include <bit>
#include <limits>
#include <xxhash.h>

namespace proxima {

namespace {

constexpr std::uint32_t no_vertex = std::numeric_limits<std::uint32_t>::max();

// Coordinates as bits, with one zero.
using Key = std::array<std::uint64_t, 3>;

Key key_of(const Vec3& position) noexcept
{
    const auto bits = [](double value) {
        return std::bit_cast<std::uint64_t>(value == 0 ? 0.0 : value);
    };
    return {bits(position.x()), bits(position.y()), bits(position.z())};
}

// A power of two, at most two thirds full.
std::uint64_t table_size(std::uint64_t vertex_count) noexcept
{
    return std::bit_ceil(vertex_count + vertex_count / 2 + 1);
}

} // namespace

bool weld_vertices(std::vector<Vec3>& positions, std::vector<TriangleCorners>& triangles,
                   Progress* progress)
{
    StageSteps steps(progress, "welding vertices", positions.size() + triangles.size());
    // Open addressing by linear probing; entries are new ids.
    std::vector<std::uint32_t> table(table_size(positions.size()), no_vertex);
    std::vector<std::uint32_t> new_ids(positions.size());
    const std::uint64_t mask = table.size() - 1;
    std::uint32_t kept = 0;
    for (std::size_t vertex = 0; vertex < positions.size(); ++vertex) {
        const Key key = key_of(positions[vertex]);
        std::uint64_t slot = XXH3_64bits(key.data(), sizeof(key)) & mask;
        while (table[slot] != no_vertex && key_of(positions[table[slot]]) != key) {
            slot = (slot + 1) & mask;
        }
        if (table[slot] == no_vertex) {
            table[slot] = kept;
            positions[kept++] = positions[vertex];
        }
        new_ids[vertex] = table[slot];
        if (!steps.done(1)) return false;
    }
    positions.resize(kept);
    for (TriangleCorners& corners : triangles) {
        for (std::uint32_t& corner : corners) corner = new_ids[corner];
        if (!steps.done(1)) return false;
    }
    return true;
}

std::uint64_t weld_scratch_bytes(std::uint64_t vertex_count) noexcept
{
    return (table_size(vertex_count) + vertex_count) * sizeof(std::uint32_t);
}

} // namespace proxima
