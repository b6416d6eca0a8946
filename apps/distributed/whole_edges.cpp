#include "distributed/whole_edges.h"

#include "octree/hole_caps.h"

#include <algorithm>

namespace proxima {

namespace {

/// What the slice leaves unbalanced, to the ranks that sum up edges.
Status pack_edges(const MeshSlice& slice, World& world,
                  std::vector<std::vector<WholeEdge>>& outgoing)
{
    const auto edges = unbalanced_edges(slice.mesh, &world.progress());
    if (!edges) return tl::unexpected(edges.error());
    for (const DirectedEdge& edge : *edges) {
        const WholeEdge whole{slice.vertices[edge.from], slice.vertices[edge.to], edge.excess};
        // Any spread will do; edges of one lower vertex meet.
        outgoing[whole.ends().first % outgoing.size()].push_back(whole);
    }
    return {};
}

/// The unbalanced edges, each once and with a positive excess.
std::vector<WholeEdge> sum_up(std::vector<WholeEdge> edges)
{
    std::ranges::sort(edges, {}, &WholeEdge::ends);
    std::vector<WholeEdge> sums;
    for (const WholeEdge& edge : edges) {
        const auto [lower, upper] = edge.ends();
        if (sums.empty() || sums.back().ends() != edge.ends()) sums.push_back({lower, upper, 0});
        sums.back().excess += edge.from == lower ? edge.excess : -edge.excess;
    }
    std::erase_if(sums, [](const WholeEdge& edge) { return edge.excess == 0; });
    for (WholeEdge& edge : sums) {
        if (edge.excess < 0) edge = {edge.to, edge.from, -edge.excess};
    }
    return sums;
}

} // namespace

Result<std::vector<WholeEdge>> whole_unbalanced_edges(const MeshSlice& slice, World& world)
{
    std::vector<std::vector<WholeEdge>> outgoing(static_cast<std::size_t>(world.size()));
    Status status = world.agree_on([&] { return pack_edges(slice, world, outgoing); });
    if (!status) return tl::unexpected(status.error());
    auto received = world.exchange(std::move(outgoing));
    if (!received) return tl::unexpected(received.error());
    std::vector<WholeEdge> unbalanced;
    status = world.agree_on([&]() -> Status {
        unbalanced = sum_up(std::move(received->items));
        return {};
    });
    if (!status) return tl::unexpected(status.error());
    return unbalanced;
}

} // namespace proxima
