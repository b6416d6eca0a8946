#include "distributed/routed_forest.h"

#include <algorithm>
#include <limits>
#include <p8est_bits.h>
#include <p8est_communication.h>
#include <p8est_extended.h>

namespace proxima {

struct RoutedForest::Parts {
    p8est_connectivity_t* connectivity = nullptr;
    p8est_t* forest = nullptr;
    int depth = 0; ///< whose cells are split next
    std::uint64_t threshold = 0;

    /// Calls visit(quadrant) for this rank's leaves in Morton order.
    template <class Visit>
    void each_leaf(const Visit& visit) const
    {
        if (forest->local_num_quadrants == 0) return;
        sc_array_t& quadrants = p8est_tree_array_index(forest->trees, 0)->quadrants;
        for (std::size_t i = 0; i < quadrants.elem_count; ++i) {
            visit(*p8est_quadrant_array_index(&quadrants, i));
        }
    }
};

namespace {

std::uint64_t& triangles_of(p8est_quadrant_t& quadrant) noexcept
{
    return *static_cast<std::uint64_t*>(quadrant.p.user_data);
}

void begin_empty(p8est_t*, p4est_topidx_t, p8est_quadrant_t* quadrant)
{
    triangles_of(*quadrant) = 0;
}

int weight(p8est_t*, p4est_topidx_t, p8est_quadrant_t* quadrant)
{
    constexpr std::uint64_t most = std::numeric_limits<int>::max();
    return static_cast<int>(std::min(triangles_of(*quadrant) + 1, most));
}

} // namespace

void CellCounts::add(std::uint64_t cell, const NewFrom& new_from)
{
    std::uint64_t triangles = 0;
    for (int depth = 0; depth <= deepest(); ++depth) {
        triangles += new_from[static_cast<std::size_t>(depth)];
        if (triangles == 0) continue;
        const std::uint64_t above = cell >> (3 * (deepest() - depth));
        auto& at_depth = counts_[static_cast<std::size_t>(depth)];
        if (at_depth.empty() || at_depth.back().cell != above) at_depth.push_back({above, 0});
        at_depth.back().triangles += triangles;
    }
}

RoutedForest::RoutedForest() : parts_(std::make_unique<Parts>())
{
    parts_->connectivity = p8est_connectivity_new_unitcube();
    parts_->forest = p8est_new_ext(MPI_COMM_WORLD, parts_->connectivity, 0, 0, 1,
                                   sizeof(std::uint64_t), begin_empty, parts_.get());
}

RoutedForest::~RoutedForest()
{
    p8est_destroy(parts_->forest);
    p8est_connectivity_destroy(parts_->connectivity);
}

Status RoutedForest::build(const CellCounts& counts, std::uint32_t threshold, World& world)
{
    Parts& parts = *parts_;
    parts.threshold = threshold;
    const int routing_depth = counts.deepest();
    for (parts.depth = 0; parts.depth <= routing_depth; ++parts.depth) {
        // The owner of a cell adds what touches it. Cells below a leaf have no quadrant.
        std::vector<std::vector<CellCount>> outgoing(static_cast<std::size_t>(world.size()));
        Status status = world.agree_on([&]() -> Status {
            for (const CellCount& count : counts.at(parts.depth)) {
                outgoing[static_cast<std::size_t>(owner(count.cell, parts.depth))].push_back(count);
            }
            return {};
        });
        if (!status) return status;
        const auto received = world.exchange(std::move(outgoing));
        if (!received) return tl::unexpected(received.error());
        status = world.agree_on([&]() -> Status {
            std::vector<std::pair<std::uint64_t, p8est_quadrant_t*>> here;
            parts.each_leaf([&](p8est_quadrant_t& quadrant) {
                if (quadrant.level != parts.depth) return;
                here.emplace_back(p8est_quadrant_linear_id(&quadrant, parts.depth), &quadrant);
            });
            for (const CellCount& count : received->items) {
                const auto at = std::ranges::lower_bound(
                    here, count.cell, {}, [](const auto& item) { return item.first; });
                if (at == here.end() || at->first != count.cell) continue;
                triangles_of(*at->second) += count.triangles;
            }
            return {};
        });
        if (!status) return status;
        if (parts.depth == routing_depth) break;
        const auto is_crowded = [](p8est_t* forest, p4est_topidx_t, p8est_quadrant_t* quadrant) {
            const auto& of = *static_cast<const Parts*>(forest->user_pointer);
            return quadrant->level == of.depth && triangles_of(*quadrant) > of.threshold ? 1 : 0;
        };
        p8est_refine_ext(parts.forest, 0, routing_depth, is_crowded, begin_empty, nullptr);
        p8est_partition_ext(parts.forest, 0, nullptr);
    }
    p8est_partition_ext(parts.forest, 0, weight);
    return {};
}

int RoutedForest::owner(std::uint64_t cell, int depth) const
{
    p8est_quadrant_t quadrant;
    P8EST_QUADRANT_INIT(&quadrant);
    p8est_quadrant_set_morton(&quadrant, depth, cell);
    return p8est_comm_find_owner(parts_->forest, 0, &quadrant, parts_->forest->mpirank);
}

int RoutedForest::owner(CellKey key) const
{
    const int level = depth(key);
    return owner(key.bits ^ std::uint64_t{1} << (3 * level), level);
}

std::vector<CellKey> RoutedForest::cells() const
{
    std::vector<CellKey> keys;
    parts_->each_leaf([&](const p8est_quadrant_t& quadrant) {
        const int shift = P8EST_MAXLEVEL - quadrant.level;
        keys.push_back(cell_key({static_cast<std::uint32_t>(quadrant.x >> shift),
                                 static_cast<std::uint32_t>(quadrant.y >> shift),
                                 static_cast<std::uint32_t>(quadrant.z >> shift)},
                                quadrant.level));
    });
    return keys;
}

} // namespace proxima
