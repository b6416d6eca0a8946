#include "distributed/whole_caps.h"

#include "distributed/whole_edges.h"
#include "octree/hole_caps.h"

#include <algorithm>

namespace proxima {

namespace {

struct PlacedVertex {
    std::uint64_t end = 0; ///< position among the ends of all edges
    std::array<double, 3> at = {};
};

std::vector<std::uint64_t> ends_of(const std::vector<WholeEdge>& edges)
{
    std::vector<std::uint64_t> ends;
    for (const WholeEdge& edge : edges) ends.insert(ends.end(), {edge.from, edge.to});
    std::ranges::sort(ends);
    ends.erase(std::unique(ends.begin(), ends.end()), ends.end());
    return ends;
}

/// The slice's vertices among the ends.
std::vector<PlacedVertex> place(const MeshSlice& slice, const std::vector<std::uint64_t>& ends)
{
    std::vector<PlacedVertex> placed;
    auto from = slice.vertices.begin();
    for (std::size_t i = 0; i < ends.size(); ++i) {
        from = std::lower_bound(from, slice.vertices.end(), ends[i]);
        if (from == slice.vertices.end()) break;
        if (*from != ends[i]) continue;
        const Vec3& at =
            slice.mesh.positions()[static_cast<std::size_t>(from - slice.vertices.begin())];
        placed.push_back({i, {at[0], at[1], at[2]}});
    }
    return placed;
}

Result<TriangleMesh> cap(const std::vector<WholeEdge>& edges,
                         const std::vector<std::uint64_t>& ends,
                         const std::vector<PlacedVertex>& placed, Progress& progress)
{
    std::vector<Vec3> positions(ends.size());
    for (const PlacedVertex& vertex : placed) {
        positions[vertex.end] = {vertex.at[0], vertex.at[1], vertex.at[2]};
    }
    const auto number = [&](std::uint64_t vertex) {
        return static_cast<std::uint32_t>(std::ranges::lower_bound(ends, vertex) - ends.begin());
    };
    std::vector<DirectedEdge> local;
    local.reserve(edges.size());
    for (const WholeEdge& edge : edges) {
        local.push_back(
            {number(edge.from), number(edge.to), static_cast<std::int32_t>(edge.excess)});
    }
    return cap_rims(std::move(local), positions, &progress);
}

} // namespace

Result<TriangleMesh> whole_caps(const MeshSlice& slice, World& world)
{
    const auto own = whole_unbalanced_edges(slice, world);
    if (!own) return tl::unexpected(own.error());
    const auto edges = world.all_gather(*own);
    if (!edges) return tl::unexpected(edges.error());
    std::vector<std::uint64_t> ends;
    std::vector<PlacedVertex> placed;
    Status status = world.agree_on([&]() -> Status {
        ends = ends_of(edges->items);
        if (ends.size() >= std::numeric_limits<std::uint32_t>::max()) {
            return fail(ErrorCode::limit_exceeded,
                        "the mesh has 2^32 vertices at holes or more: repair it");
        }
        placed = place(slice, ends);
        return {};
    });
    if (!status) return tl::unexpected(status.error());
    const auto positions = world.all_gather(placed);
    if (!positions) return tl::unexpected(positions.error());
    TriangleMesh caps;
    status = world.agree_on([&]() -> Status {
        auto made = cap(edges->items, ends, positions->items, world.progress());
        if (!made) return tl::unexpected(made.error());
        caps = std::move(*made);
        return {};
    });
    if (!status) return tl::unexpected(status.error());
    return caps;
}

} // namespace proxima
