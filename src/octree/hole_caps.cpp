#include "octree/hole_caps.h"

#include "base/disjoint_sets.h"
#include "base/progress.h"
#include "base/radix_sort.h"

#include <algorithm>
#include <bit>
#include <cstdlib>
#include <map>
#include <optional>
#include <utility>

namespace proxima {

namespace {

/// A bijective mix of all bits (Steele, Lea and Flood 2014).
std::uint64_t mixed(std::uint64_t bits) noexcept
{
    bits = (bits ^ bits >> 30U) * 0xBF58476D1CE4E5B9U;
    bits = (bits ^ bits >> 27U) * 0x94D049BB133111EBU;
    return bits ^ bits >> 31U;
}

std::uint64_t hash(const Vec3& position) noexcept
{
    std::uint64_t bits = 0;
    for (int axis = 0; axis < 3; ++axis) {
        const double coordinate = position[axis] + 0.0; // one zero
        bits = mixed(bits + 0x9E3779B97F4A7C15U + std::bit_cast<std::uint64_t>(coordinate));
    }
    return bits;
}

constexpr unsigned hash_bits = 44;

/// For each vertex the first one at the same position; nothing where `steps` asks to stop.
std::optional<std::vector<std::uint32_t>> first_at_same_position(const TriangleMesh& mesh,
                                                                 StageSteps& steps)
{
    const auto positions = mesh.positions();
    std::vector<KeyedIndex> items(positions.size());
    for (std::size_t i = 0; i < items.size(); ++i) {
        items[i] = {hash(positions[i]) >> (64 - hash_bits), static_cast<std::uint32_t>(i)};
    }
    if (!radix_sort(items, hash_bits, steps)) return std::nullopt;
    std::vector<std::uint32_t> first(items.size());
    for (std::size_t begin = 0; begin < items.size();) {
        std::size_t end = begin;
        while (end < items.size() && items[end].key == items[begin].key) ++end;
        const auto before = [&](const KeyedIndex& a, const KeyedIndex& b) {
            const Vec3& p = positions[a.index];
            const Vec3& q = positions[b.index];
            return std::lexicographical_compare(p.begin(), p.end(), q.begin(), q.end());
        };
        const auto run = items.begin();
        std::stable_sort(run + static_cast<std::ptrdiff_t>(begin),
                         run + static_cast<std::ptrdiff_t>(end), before);
        for (std::size_t i = begin; i < end; ++i) {
            const bool repeats =
                i > begin && positions[items[i].index] == positions[items[i - 1].index];
            first[items[i].index] = repeats ? first[items[i - 1].index] : items[i].index;
        }
        if (!steps.done(end - begin)) return std::nullopt;
        begin = end;
    }
    return first;
}

/// An edge and how many more triangles run from `from` to `to` than back; positive.
struct UnbalancedEdge {
    std::uint32_t from = 0;
    std::uint32_t to = 0;
    std::int64_t excess = 0;
};

/// Edges grouped by their lower vertex, then matched within the group; nothing where stopped.
/// Corners are numbered by vertex_of(corner).
template <class VertexOf>
std::optional<std::vector<UnbalancedEdge>>
unbalanced_edges(const TriangleMesh& mesh, const VertexOf& vertex_of, StageSteps& steps)
{
    const auto for_each_edge = [&](const auto& visit) {
        for (const TriangleCorners& corners : mesh.triangles()) {
            if (!steps.done(1)) return false;
            for (std::size_t k = 0; k < 3; ++k) {
                const std::uint32_t a = vertex_of(corners[k]);
                const std::uint32_t b = vertex_of(corners[(k + 1) % 3]);
                if (a != b) visit(a, b);
            }
        }
        return true;
    };
    struct Direction {
        std::uint32_t upper = 0;
        std::int32_t sign = 0;
    };
    std::vector<std::uint64_t> group(mesh.vertex_count() + 1);
    const bool counted =
        for_each_edge([&](std::uint32_t a, std::uint32_t b) { ++group[std::min(a, b)]; });
    if (!counted) return std::nullopt;
    std::uint64_t sum = 0;
    for (std::uint64_t& start : group) sum += std::exchange(start, sum);
    std::vector<Direction> directions(sum);
    const bool grouped = for_each_edge([&](std::uint32_t a, std::uint32_t b) {
        directions[group[std::min(a, b)]++] = {std::max(a, b), a < b ? 1 : -1};
    });
    if (!grouped) return std::nullopt;
    std::vector<UnbalancedEdge> edges;
    std::uint64_t begin = 0; // group[v] is now the end of v's group
    for (std::uint32_t lower = 0; lower < mesh.vertex_count(); ++lower) {
        const auto at = directions.begin() + static_cast<std::ptrdiff_t>(begin);
        const auto end = directions.begin() + static_cast<std::ptrdiff_t>(group[lower]);
        std::sort(at, end,
                  [](const Direction& a, const Direction& b) { return a.upper < b.upper; });
        for (auto i = at; i != end;) {
            const std::uint32_t upper = i->upper;
            std::int64_t excess = 0;
            for (; i != end && i->upper == upper; ++i) excess += i->sign;
            if (excess > 0) edges.push_back({lower, upper, excess});
            if (excess < 0) edges.push_back({upper, lower, -excess});
        }
        begin = group[lower];
        if (!steps.done(1)) return std::nullopt;
    }
    return edges;
}

/// The edges with vertices at equal positions as one; nothing where stopped.
std::optional<std::vector<UnbalancedEdge>> unbalanced_edges(const TriangleMesh& mesh,
                                                            Progress* progress)
{
    const std::uint64_t match_steps = mesh.vertex_count() + 2 * mesh.triangle_count();
    StageSteps steps(progress, "looking for holes",
                     (radix_passes(hash_bits) + 1) * mesh.vertex_count() + 2 * match_steps);
    // Edges that are balanced by vertex ids are balanced by positions too, and need no search for
    // equal positions.
    auto by_vertex = unbalanced_edges(
        mesh, [](std::uint32_t corner) { return corner; }, steps);
    if (!by_vertex || by_vertex->empty()) return by_vertex;
    const auto first = first_at_same_position(mesh, steps);
    if (!first) return std::nullopt;
    return unbalanced_edges(
        mesh, [&](std::uint32_t corner) { return (*first)[corner]; }, steps);
}

} // namespace

Result<TriangleMesh> hole_caps(const TriangleMesh& mesh, Progress* progress)
{
    const auto found = unbalanced_edges(mesh, progress);
    if (!found) {
        return cancelled("looking for holes");
    }
    const std::vector<UnbalancedEdge>& edges = *found;
    std::map<std::uint32_t, std::uint32_t> renumbered; // vertices of the mesh to those of the caps
    std::vector<Vec3> positions;
    for (const UnbalancedEdge& edge : edges) {
        for (const std::uint32_t vertex : {edge.from, edge.to}) {
            if (renumbered.try_emplace(vertex, static_cast<std::uint32_t>(positions.size()))
                    .second) {
                positions.push_back(mesh.positions()[vertex]);
            }
        }
    }
    DisjointSets rims(positions.size());
    for (const UnbalancedEdge& edge : edges) {
        rims.unite(renumbered.at(edge.from), renumbered.at(edge.to));
    }
    // The middle of each rim, kept within its box against rounding.
    const std::size_t rim_vertices = positions.size();
    std::vector<Vec3> middle(rim_vertices, Vec3::Zero());
    std::vector<Box> box(rim_vertices);
    std::vector<std::uint32_t> size(rim_vertices);
    for (std::uint32_t i = 0; i < rim_vertices; ++i) {
        const std::uint32_t rim = rims.find(i);
        box[rim].extend(positions[i]);
        middle[rim] += positions[i] - positions[rim];
        ++size[rim];
    }
    std::vector<std::uint32_t> apex(rim_vertices);
    for (std::uint32_t i = 0; i < rim_vertices; ++i) {
        if (rims.find(i) != i) continue;
        apex[i] = static_cast<std::uint32_t>(positions.size());
        const Vec3 mean = positions[i] + middle[i] / static_cast<double>(size[i]);
        positions.emplace_back(mean.cwiseMax(box[i].lower).cwiseMin(box[i].upper));
    }
    std::vector<TriangleCorners> triangles;
    for (const UnbalancedEdge& edge : edges) {
        const std::uint32_t from = renumbered.at(edge.from);
        const std::uint32_t to = renumbered.at(edge.to);
        triangles.insert(triangles.end(), static_cast<std::size_t>(edge.excess),
                         TriangleCorners{to, from, apex[rims.find(from)]});
    }
    return make_triangle_mesh(std::move(positions), std::move(triangles)).value_or(TriangleMesh{});
}

} // namespace proxima
