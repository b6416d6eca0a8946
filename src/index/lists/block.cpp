#include "index/lists/block.h"

#include "base/check.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>

namespace proxima {

namespace {

constexpr double grid_end = 65535;

/// A block's triangle on the grid.
using GridTriangle = std::array<Vec3, 3>;

/// How far the distance to a triangle as computed may exceed the true one because the foot of the
/// perpendicular was computed badly: at most `size` + `reach` * (the distance to the triangle's
/// first corner).
struct Slack {
    double size = 0;
    double reach = 0;
};

/// The foot comes from the triangle's Gram matrix in floats: its weights are off by some
/// roundings times the square of the condition, longest side by height. Where the computed foot
/// leaves the triangle, a side stands in, and no inside point is farther from all sides than the
/// height. So thin triangles count by their height, others by their condition.
Slack slack_of(const GridTriangle& triangle)
{
    const Vec3 ab = triangle[1] - triangle[0];
    const Vec3 ac = triangle[2] - triangle[0];
    const Vec3 bc = triangle[2] - triangle[1];
    const double longest = std::max({ab.norm(), ac.norm(), bc.norm()});
    if (!(longest > 0)) return {};
    const double height = ab.cross(ac).norm() / longest;
    const double condition = longest / std::max(height, 1e-300);
    constexpr double roundings = 24 * 0x1p-24;
    const double reach = roundings * condition * condition;
    // As far as the block is wide: there the two are weighed.
    return height < reach * grid_end ? Slack{height, 0} : Slack{0, reach};
}

template <class T>
void append(std::vector<std::byte>& arena, const T* values, std::size_t count)
{
    const auto* const bytes = reinterpret_cast<const std::byte*>(values);
    arena.insert(arena.end(), bytes, bytes + count * sizeof(T));
}

/// The vertices of a block, each once, in order of first use.
struct BlockVertices {
    std::array<std::uint32_t, block_vertices> ids{};
    std::size_t count = 0;

    std::size_t index_of(std::uint32_t id)
    {
        auto* const end = ids.data() + count;
        auto* const found = std::find(ids.data(), end, id);
        if (found == end) {
            PROXIMA_CHECK_LT(count, block_vertices);
            ids[count++] = id;
        }
        return static_cast<std::size_t>(found - ids.data());
    }
};

} // namespace

std::uint16_t upper_half(float value) noexcept
{
    const auto bits = std::bit_cast<std::uint32_t>(value);
    return static_cast<std::uint16_t>((bits + 0xFFFFU) >> 16U);
}

std::size_t append_block(std::span<const BlockTriangle> triangles, std::span<const Vec3> positions,
                         std::vector<std::byte>& arena)
{
    BlockVertices vertices;
    std::array<std::array<std::size_t, 3>, block_triangles> indices{};
    Box box;
    std::uint32_t base = std::numeric_limits<std::uint32_t>::max();
    std::uint32_t last = 0;
    for (std::size_t k = 0; k < triangles.size(); ++k) {
        for (std::size_t i = 0; i < 3; ++i) {
            indices[k][i] = vertices.index_of(triangles[k].vertices[i]);
            box.extend(positions[triangles[k].vertices[i]]);
        }
        base = std::min(base, triangles[k].rank);
        last = std::max(last, triangles[k].rank);
    }

    BlockHeader header;
    for (int axis = 0; axis < 3; ++axis) {
        // Surely not above the vertices, however the number is rounded.
        const float low = std::nextafter(static_cast<float>(box.lower[axis]),
                                         -std::numeric_limits<float>::infinity());
        header.origin[axis] = low;
    }
    double extent = 0;
    for (int axis = 0; axis < 3; ++axis)
        extent = std::max(extent, box.upper[axis] - static_cast<double>(header.origin[axis]));
    // A point has no extent, and floats of the frame no finer grid than this one.
    extent = std::max(extent, 0x1p-20);
    header.inverse_unit = static_cast<float>(grid_end * (1 - 0x1p-22) / extent);

    std::array<std::array<std::uint16_t, block_vertices>, 3> grid{};
    std::array<Vec3, block_vertices> points;
    for (std::size_t i = 0; i < vertices.count; ++i) {
        for (int axis = 0; axis < 3; ++axis) {
            const double units = std::nearbyint(
                (positions[vertices.ids[i]][axis] - static_cast<double>(header.origin[axis])) *
                static_cast<double>(header.inverse_unit));
            const auto k = static_cast<std::size_t>(axis);
            grid[k][i] = static_cast<std::uint16_t>(std::clamp(units, 0.0, grid_end));
            points[i][axis] = grid[k][i];
        }
    }
    Slack slack;
    for (std::size_t k = 0; k < triangles.size(); ++k) {
        const Slack one =
            slack_of({points[indices[k][0]], points[indices[k][1]], points[indices[k][2]]});
        slack.size = std::max(slack.size, one.size);
        slack.reach = std::max(slack.reach, one.reach);
    }
    header.slack_size = upper_half(static_cast<float>(slack.size));
    header.slack_reach = upper_half(static_cast<float>(slack.reach));
    header.base = base;
    header.vertices = static_cast<std::uint8_t>(vertices.count);
    header.triangles = static_cast<std::uint8_t>(triangles.size());
    header.wide = last - base > 0xFFFFU ? 1 : 0;

    arena.resize((arena.size() + block_alignment - 1) / block_alignment * block_alignment);
    const std::size_t begin = arena.size();
    append(arena, &header, 1);
    for (const auto& coordinates : grid) append(arena, coordinates.data(), vertices.count);
    for (std::size_t k = 0; k < triangles.size(); ++k) {
        const auto corners =
            static_cast<std::uint16_t>(indices[k][0] | indices[k][1] << 5U | indices[k][2] << 10U);
        append(arena, &corners, 1);
    }
    for (const BlockTriangle& triangle : triangles) {
        const std::uint32_t difference = triangle.rank - base;
        const auto narrow = static_cast<std::uint16_t>(difference);
        if (header.wide != 0) {
            append(arena, &difference, 1);
        } else {
            append(arena, &narrow, 1);
        }
    }
    return begin;
}

} // namespace proxima
