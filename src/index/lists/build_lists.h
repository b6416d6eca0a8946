// Adds closest-feature lists to the index of any triangle mesh: closed or open, convex or not,
// manifold or not.
//
//     auto index = with_lists(build_mesh_index(mesh).value());
//     if (!index) { std::cerr << describe(index.error()); return 1; }
//     const auto closest = closest_feature(*index, point);
#pragma once

#include "base/parallel.h"
#include "base/progress.h"
#include "base/result.h"
#include "index/lists/grow_cells.h"
#include "index/lists/proximity_lists.h"
#include "index/mesh_index.h"

#include <cstdint>

namespace proxima {

/// Of the lists where no other budget is named.
inline constexpr std::uint64_t default_list_bytes_per_triangle = 520;

/// The budget where none is named: what so many triangles get, and what a small mesh needs.
[[nodiscard]] constexpr std::uint64_t default_list_budget(std::uint64_t triangles) noexcept
{
    constexpr std::uint64_t least = 65536;       // cells
    constexpr std::uint64_t each_of_a_few = 440; // triangles themselves, at most
    const std::uint64_t small = least + each_of_a_few * triangles;
    const std::uint64_t usual = default_list_bytes_per_triangle * triangles;
    return usual < small ? small : usual;
}

/// The largest margin.
inline constexpr double max_list_margin = 1e3;

/// Past this, numbers of the builder no longer fit 32 bits.
inline constexpr std::size_t max_listed_triangles = std::size_t{1} << 25U;

struct ListOptions {
    std::uint64_t budget_bytes = 0; ///< of the lists; 0 = default_list_budget()
    double margin = 0.5; ///< root edge = (1 + margin) times the mesh's longest extent; 0 to
                         ///< max_list_margin
    int max_depth = max_proximity_depth;
    Threads threads = {};
    Progress* progress = nullptr;
};

/// The index with lists, instead of those that it may have; shares everything else with `index`.
/// Within the budget, the lists whose queries are expected to be cheapest (cost_model.h). Exact:
/// every point's closest feature is in its leaf. The same bits for any number of threads. Errors:
/// invalid_mesh (an empty index, less than 1e-140 large), invalid_argument (options out of range),
/// limit_exceeded, budget_exceeded (which budget would do), cancelled. About 50 us per triangle; at
/// most 3 times the budget of memory beside the index.
[[nodiscard]] Result<MeshIndex> with_lists(const MeshIndex& index, const ListOptions& options = {});

} // namespace proxima
