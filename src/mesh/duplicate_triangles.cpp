#include "mesh/duplicate_triangles.h"

#include "base/disjoint_sets.h"
#include "mesh/surface_parts.h"
#include "proxima/topology.h"

#include <algorithm>

namespace proxima::detail {

namespace {

/// The first triangles of a set that face one way and the other.
struct TwoSides {
    std::uint32_t kept = 0;
    std::uint32_t opposite = 0;
};

/// Of those of `pairs` of which both sides are to stay, the opposite ones are no longer redundant.
Status keep_walls(std::span<const Vec3> positions, std::span<const TriangleCorners> triangles,
                  std::span<const TwoSides> pairs, std::vector<std::uint8_t>& redundant,
                  const Execution& execution)
{
    const auto mesh = make_triangle_mesh({positions.begin(), positions.end()},
                                         {triangles.begin(), triangles.end()});
    if (!mesh) return tl::unexpected(mesh.error());
    const auto topology = build_topology(*mesh, {.execution = execution});
    if (!topology) return tl::unexpected(topology.error());
    std::vector<std::uint8_t> has_two_sides(triangles.size(), 0);
    for (const TwoSides& pair : pairs) has_two_sides[pair.kept] = 1;

    /// At an edge, of the triangles that are not redundant.
    struct Uses {
        std::uint32_t by_walls = 0; ///< one for both sides
        std::uint32_t by_others = 0;
        std::uint32_t wall = 0; ///< one of them
    };
    DisjointSets walls(triangles.size());
    const auto uses_of = [&](std::uint32_t edge) {
        Uses uses;
        for (const TriangleId id : topology->triangles(EdgeId{edge})) {
            const std::uint32_t triangle = to_index(id);
            if (redundant[triangle] != 0 || !is_proper(triangles[triangle])) continue;
            if (has_two_sides[triangle] == 0) {
                ++uses.by_others;
                continue;
            }
            if (uses.by_walls++ > 0) walls.unite(uses.wall, triangle);
            uses.wall = triangle;
        }
        return uses;
    };
    std::vector<Uses> borders; // edges where walls meet the rest
    for (std::uint32_t edge = 0; edge < topology->edge_count(); ++edge) {
        const Uses uses = uses_of(edge);
        if (uses.by_walls > 0 && uses.by_others > 0) borders.push_back(uses);
    }

    struct Wall {
        bool has_border = false;
        std::int64_t closes = 0; ///< edges that are open with both sides and not with one, less
                                 ///< those that are open with one and not with both
    };
    std::vector<Wall> found(triangles.size()); // at the lowest triangle of each
    for (const Uses& uses : borders) {
        Wall& wall = found[walls.find(uses.wall)];
        wall.has_border = true;
        if (uses.by_walls % 2 != 0) wall.closes += uses.by_others % 2 != 0 ? 1 : -1;
    }
    for (const TwoSides& pair : pairs) {
        const Wall& wall = found[walls.find(pair.kept)];
        if (wall.has_border && wall.closes <= 0) redundant[pair.opposite] = 0;
    }
    return {};
}

} // namespace

bool face_the_same_way(const TriangleCorners& a, const TriangleCorners& b) noexcept
{
    const auto place = static_cast<std::size_t>(std::ranges::find(b, a[0]) - b.begin());
    return b[(place + 1) % 3] == a[1];
}

Result<std::vector<std::uint8_t>> redundant_triangles(std::span<const Vec3> positions,
                                                      std::span<const TriangleCorners> triangles,
                                                      std::span<const std::uint32_t> first,
                                                      const Execution& execution)
{
    struct Set {
        std::int32_t surplus = 0;   ///< triangles that face as the first does, less the others
        std::uint32_t opposite = 0; ///< the first of the others, 0 without any
    };
    const auto count = static_cast<std::uint32_t>(first.size());
    std::vector<Set> sets(count); // at the first triangle of each
    std::vector<std::uint8_t> redundant(count, 0);
    for (std::uint32_t i = 0; i < count; ++i) {
        Set& set = sets[first[i]];
        const bool same_way = first[i] == i || face_the_same_way(triangles[first[i]], triangles[i]);
        set.surplus += same_way ? 1 : -1;
        if (!same_way && set.opposite == 0) set.opposite = i;
        redundant[i] = first[i] == i ? 0 : 1;
    }
    std::vector<TwoSides> pairs;
    for (std::uint32_t i = 0; i < count; ++i) {
        const Set& set = sets[i];
        if (set.opposite == 0) continue;
        if (set.surplus == 0) pairs.push_back({i, set.opposite});
        if (set.surplus < 0) std::swap(redundant[i], redundant[set.opposite]);
    }
    if (!pairs.empty()) {
        const Status kept = keep_walls(positions, triangles, pairs, redundant, execution);
        if (!kept) return tl::unexpected(kept.error());
    }
    return redundant;
}

} // namespace proxima::detail
