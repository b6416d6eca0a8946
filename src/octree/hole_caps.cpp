#include "octree/hole_caps.h"

#include "base/disjoint_sets.h"
#include "base/grow_buffer.h"
#include "base/progress.h"
#include "base/radix_sort.h"

#include <algorithm>
#include <array>
#include <bit>
#include <map>
#include <optional>
#include <span>
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

/// The bits of a position, with one zero: equal positions have equal bits.
std::array<std::uint64_t, 3> bits_of(const Vec3& position) noexcept
{
    return {std::bit_cast<std::uint64_t>(position[0] + 0.0),
            std::bit_cast<std::uint64_t>(position[1] + 0.0),
            std::bit_cast<std::uint64_t>(position[2] + 0.0)};
}

std::uint64_t hash(const Vec3& position) noexcept
{
    std::uint64_t hash = 0;
    for (const std::uint64_t bits : bits_of(position)) {
        hash = mixed(hash + 0x9E3779B97F4A7C15U + bits);
    }
    return hash;
}

std::uint64_t packed(std::uint32_t from, std::uint32_t to) noexcept
{
    return std::uint64_t{from} << 32U | to;
}

/// A list of edges, from << 32 | to, without pairs of opposite ones of which the second comes soon
/// after the first. A table has the edges that wait for their opposite; a newer one replaces an
/// older one. Where neighbours are near each other in the list, most pairs go while the table stays
/// in the cache, without a branch that depends on them. `visit_edges(keep)` calls keep(from, to)
/// for at most `count` edges and returns false where it was stopped; `seed` tells which edges
/// replace which.
template <class VisitEdges>
std::optional<GrowBuffer<std::uint64_t>>
without_near_opposites(std::size_t count, std::uint64_t seed, const VisitEdges& visit_edges)
{
    constexpr std::uint64_t nothing = 0; // no edge: it has two vertices
    const int slot_bits = std::clamp(static_cast<int>(std::bit_width(count)), 4, 15);
    const int shift = 64 - slot_bits;
    const std::uint64_t factor = mixed(seed) | 1U;
    std::vector<std::uint64_t> waiting(std::size_t{1} << slot_bits, nothing);
    GrowBuffer<std::uint64_t> left;
    left.resize(count + waiting.size() + 1);
    std::uint64_t* end = left.data();
    const bool all = visit_edges([&](std::uint32_t from, std::uint32_t to) {
        const std::uint64_t edge = packed(from, to);
        const std::uint64_t opposite = packed(to, from);
        std::uint64_t& slot = waiting[std::min(edge, opposite) * factor >> shift];
        const std::uint64_t before = slot;
        slot = before == opposite ? nothing : edge;
        *end = before;
        end += static_cast<std::ptrdiff_t>(before != nothing) &
               static_cast<std::ptrdiff_t>(before != opposite);
    });
    if (!all) return std::nullopt;
    end = std::copy_if(waiting.begin(), waiting.end(), end,
                       [](std::uint64_t edge) { return edge != nothing; });
    left.resize(static_cast<std::size_t>(end - left.data()));
    return left;
}

/// The edges that are not balanced, by their lower vertices, then by their higher ones: sums up the
/// edges, which may repeat and be opposite to each other. False where stopped.
bool sum_up(std::vector<DirectedEdge>& edges, std::size_t vertex_count, StageSteps& steps)
{
    const auto vertex_bits = static_cast<unsigned>(std::bit_width(vertex_count));
    const auto key_of = [vertex_bits](const DirectedEdge& edge) {
        return std::uint64_t{std::min(edge.from, edge.to)} << vertex_bits |
               std::max(edge.from, edge.to);
    };
    if (!radix_sort(edges, 2 * vertex_bits, key_of, steps)) return false;
    std::size_t count = 0;
    for (std::size_t begin = 0, end = 0; begin < edges.size(); begin = end) {
        const std::uint32_t lower = std::min(edges[begin].from, edges[begin].to);
        const std::uint32_t upper = std::max(edges[begin].from, edges[begin].to);
        std::int32_t excess = 0;
        for (; end < edges.size() && key_of(edges[end]) == key_of(edges[begin]); ++end) {
            excess += edges[end].from == lower ? edges[end].excess : -edges[end].excess;
        }
        if (excess > 0) edges[count++] = {lower, upper, excess};
        if (excess < 0) edges[count++] = {upper, lower, -excess};
    }
    edges.resize(count);
    return true;
}

/// The unbalanced edges between vertices told by their ids; nothing where stopped.
std::optional<std::vector<DirectedEdge>> edges_unbalanced_by_id(const TriangleMesh& mesh,
                                                                StageSteps& steps)
{
    auto left = without_near_opposites(3 * mesh.triangle_count(), 1, [&](const auto& keep) {
        for (const TriangleCorners& corners : mesh.triangles()) {
            if (!steps.done(1)) return false;
            for (std::size_t k = 0; k < 3; ++k) {
                const std::uint32_t from = corners[k];
                const std::uint32_t to = corners[(k + 1) % 3];
                if (from != to) keep(from, to);
            }
        }
        return true;
    });
    // Edges that were replaced before their opposites came meet them as long as there are fewer.
    std::size_t before = 3 * mesh.triangle_count();
    for (std::uint64_t seed = 2; left && left->size() < before / 2; ++seed) {
        before = left->size();
        left = without_near_opposites(before, seed, [&](const auto& keep) {
            for (const std::uint64_t edge : *left) {
                keep(static_cast<std::uint32_t>(edge >> 32U), static_cast<std::uint32_t>(edge));
            }
            return steps.done(before);
        });
    }
    if (!left) return std::nullopt;
    std::vector<DirectedEdge> edges(left->size());
    std::ranges::transform(*left, edges.begin(), [](std::uint64_t edge) {
        return DirectedEdge{static_cast<std::uint32_t>(edge >> 32U),
                            static_cast<std::uint32_t>(edge), 1};
    });
    left.reset();
    if (!sum_up(edges, mesh.vertex_count(), steps)) return std::nullopt;
    return edges;
}

/// For each vertex of the edges the first one of them at the same position, for others any number;
/// nothing where `steps` asks to stop.
std::optional<std::vector<std::uint32_t>>
first_at_same_position(std::span<const Vec3> positions, std::span<const DirectedEdge> edges,
                       StageSteps& steps)
{
    constexpr unsigned hash_bits = 44;
    std::vector<bool> is_end(positions.size());
    for (const DirectedEdge& edge : edges) {
        is_end[edge.from] = true;
        is_end[edge.to] = true;
    }
    std::vector<KeyedIndex> items;
    for (std::uint32_t i = 0; i < positions.size(); ++i) {
        if (is_end[i]) items.push_back({hash(positions[i]) >> (64 - hash_bits), i});
        if (!steps.done(1)) return std::nullopt;
    }
    if (!radix_sort(items, hash_bits, steps)) return std::nullopt;
    std::vector<std::uint32_t> first(positions.size());
    for (std::size_t begin = 0, end = 0; begin < items.size(); begin = end) {
        while (end < items.size() && items[end].key == items[begin].key) ++end;
        const auto run = std::span(items).subspan(begin, end - begin);
        const auto place = [&](const KeyedIndex& item) {
            return std::pair(bits_of(positions[item.index]), item.index);
        };
        std::sort(run.begin(), run.end(),
                  [&](const KeyedIndex& a, const KeyedIndex& b) { return place(a) < place(b); });
        for (std::size_t i = 0; i < run.size(); ++i) {
            const bool repeats = i > 0 && positions[run[i].index] == positions[run[i - 1].index];
            first[run[i].index] = repeats ? first[run[i - 1].index] : run[i].index;
        }
        if (!steps.done(run.size())) return std::nullopt;
    }
    return first;
}

/// Takes vertices at equal positions as one and sums the edges up again. False where stopped.
bool join_equal_positions(std::span<const Vec3> positions, std::vector<DirectedEdge>& edges,
                          Progress* progress)
{
    StageSteps steps(progress, "looking for holes", positions.size());
    const auto first = first_at_same_position(positions, edges, steps);
    if (!first) return false;
    for (DirectedEdge& edge : edges) {
        edge.from = (*first)[edge.from];
        edge.to = (*first)[edge.to];
    }
    std::erase_if(edges, [](const DirectedEdge& edge) { return edge.from == edge.to; });
    return sum_up(edges, positions.size(), steps);
}

} // namespace

Result<std::vector<DirectedEdge>> unbalanced_edges(const TriangleMesh& mesh, Progress* progress)
{
    StageSteps steps(progress, "looking for holes", mesh.triangle_count());
    auto edges = edges_unbalanced_by_id(mesh, steps);
    if (!edges) return cancelled("looking for holes");
    return std::move(*edges);
}

Result<TriangleMesh> hole_caps(const TriangleMesh& mesh, Progress* progress)
{
    // Edges that cancel by vertex id cancel by position too. Only for the rest are vertices at the
    // same position looked for.
    auto edges = unbalanced_edges(mesh, progress);
    if (!edges) return tl::unexpected(edges.error());
    return cap_rims(std::move(*edges), mesh.positions(), progress);
}

Result<TriangleMesh> cap_rims(std::vector<DirectedEdge> edges, std::span<const Vec3> mesh_positions,
                              Progress* progress)
{
    if (!edges.empty() && !join_equal_positions(mesh_positions, edges, progress)) {
        return cancelled("looking for holes");
    }
    std::map<std::uint32_t, std::uint32_t> renumbered; // vertices of the mesh to those of the caps
    std::vector<Vec3> positions;
    for (const DirectedEdge& edge : edges) {
        for (const std::uint32_t vertex : {edge.from, edge.to}) {
            if (renumbered.try_emplace(vertex, static_cast<std::uint32_t>(positions.size()))
                    .second) {
                positions.push_back(mesh_positions[vertex]);
            }
        }
    }
    DisjointSets rims(positions.size());
    for (const DirectedEdge& edge : edges) {
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
    for (const DirectedEdge& edge : edges) {
        const std::uint32_t from = renumbered.at(edge.from);
        const std::uint32_t to = renumbered.at(edge.to);
        triangles.insert(triangles.end(), static_cast<std::size_t>(edge.excess),
                         TriangleCorners{to, from, apex[rims.find(from)]});
    }
    return make_triangle_mesh(std::move(positions), std::move(triangles)).value_or(TriangleMesh{});
}

} // namespace proxima
