#include "minkowski/facet_edges.h"

#include <algorithm>

namespace proxima::detail {
namespace {

/// action(facet, from, to) for all edges of all loops, but for those at infinity.
template <class Action>
void for_each_side(const FacetLoops& loops, Action action)
{
    for (std::uint32_t f = 0; f + 1 < loops.first.size(); ++f) {
        const std::uint32_t first = loops.first[f];
        const std::uint32_t last = loops.first[f + 1];
        for (std::uint32_t i = first; i < last; ++i) {
            const std::uint32_t from = loops.vertices[i];
            const std::uint32_t to = loops.vertices[i + 1 == last ? first : i + 1];
            if (from < loops.point_count || to < loops.point_count) action(f, from, to);
        }
    }
}

} // namespace

std::vector<PolyhedronEdge> edges_of_loops(const FacetLoops& loops)
{
    // Sides from a lower to a higher vertex make the edges and are listed at the lower vertex.
    // Sides in the other direction find them there.
    std::vector<std::uint32_t> first(loops.vertex_count + 1, 0);
    for_each_side(loops, [&](std::uint32_t, std::uint32_t from, std::uint32_t to) {
        if (from < to) ++first[from + 1];
    });
    for (std::size_t v = 0; v + 1 < first.size(); ++v) first[v + 1] += first[v];
    std::vector<PolyhedronEdge> edges(first.back());
    std::vector<std::uint32_t> next(first.begin(), first.end() - 1);
    for_each_side(loops, [&](std::uint32_t f, std::uint32_t from, std::uint32_t to) {
        if (from < to) edges[next[from]++] = {from, to, f, no_facet};
    });
    constexpr std::ptrdiff_t short_list = 16;
    for (std::size_t v = 0; v + 1 < first.size(); ++v) {
        if (first[v + 1] - first[v] <= short_list) continue;
        std::ranges::sort(edges.begin() + first[v], edges.begin() + first[v + 1], {},
                          &PolyhedronEdge::to);
    }
    for_each_side(loops, [&](std::uint32_t f, std::uint32_t from, std::uint32_t to) {
        if (from < to) return;
        const auto begin = edges.begin() + first[to];
        const auto end = edges.begin() + first[to + 1];
        const auto found = end - begin > short_list
                               ? std::ranges::lower_bound(begin, end, from, {}, &PolyhedronEdge::to)
                               : std::ranges::find(begin, end, from, &PolyhedronEdge::to);
        if (found != end && found->to == from) found->right = f;
    });
    return edges;
}

} // namespace proxima::detail
