// Edges of a mesh that is spread over the ranks, along which triangles do not run equally often in
// both directions.
#pragma once

#include "distributed/mesh_slice.h"
#include "distributed/world.h"

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

namespace proxima {

/// An edge by vertex numbers of the whole mesh; excess as in DirectedEdge, of either sign in messages.
struct WholeEdge {
    std::uint64_t from = 0;
    std::uint64_t to = 0;
    std::int64_t excess = 0;

    [[nodiscard]] std::pair<std::uint64_t, std::uint64_t> ends() const noexcept
    {
        return std::minmax(from, to);
    }
};

/// The unbalanced edges of the whole mesh, each on one rank and with a positive excess. Triangles that
/// repeat a vertex do not count. Collective; messages are linear in what slices leave unbalanced.
[[nodiscard]] Result<std::vector<WholeEdge>> whole_unbalanced_edges(const MeshSlice& slice,
                                                                    World& world);

} // namespace proxima
