// Visits the runs of rows of a mesh index that are near a point or a box, the nearest first as far
// as depth first allows.
//
//     visit_near(index, {p, p}, radius * radius, [&](RowRange rows) noexcept {
//         ...                        // index.triangle(rows.first) and so on, index.ids()
//         return radius * radius;    // or less, to end sooner
//     });
//
// In doubles: right for points however far, and for meshes of any size.
#pragma once

#include "base/fixed_stack.h"
#include "index/index_parts.h"
#include "proxima/geometry.h"
#include "proxima/mesh_index.h"

#include <cstddef>
#include <cstdint>

namespace proxima {

/// Consecutive rows: those of a leaf.
struct RowRange {
    std::uint32_t first = 0;
    std::uint32_t count = 0;
};

/// The leaves near a box, one after the other. Allocates nothing.
class PROXIMA_HIDDEN NearWalk {
public:
    /// The leaves whose boxes are within the squared distance, in the index's units: none where
    /// that is negative or NaN. \pre the box, in the mesh's coordinates, is finite and not empty
    NearWalk(const IndexParts& index, const Box& query, double most_squared) noexcept;

    /// The next leaf within reach; none at the end.
    [[nodiscard]] const IndexLeaf* next_leaf() noexcept;

    /// Takes a squared distance, in the index's units, for a new end where it is less.
    void shrink(double most_squared) noexcept;

private:
    struct PendingBlock {
        double squared;
        std::uint32_t reference;
    };
    void enter(const IndexNode& node) noexcept;

    const IndexParts& index_;
    Box query_; ///< in the frame
    double most_ = 0;
    // Entering a node replaces it by eight at most.
    FixedStack<PendingBlock, 7 * IndexParts::max_levels + 1> pending_;
};

/// Visits all runs with a triangle whose squared distance from the box is at most `bound_squared`,
/// and perhaps others. `visitor(RowRange)` returns the bound from then on, negative to end.
/// Distances are in the mesh's unit. noexcept, as the visitor must be; no allocation.
/// \pre the box is finite and not empty
template <class Visitor>
void visit_near(const IndexParts& index, const Box& query, double bound_squared,
                Visitor&& visitor) noexcept
{
    const auto scaled = [&](double squared) { return squared * index.scale() * index.scale(); };
    NearWalk walk(index, query, scaled(bound_squared));
    while (const IndexLeaf* const leaf = walk.next_leaf())
        walk.shrink(scaled(visitor(RowRange{leaf->first_row, leaf->count})));
}

} // namespace proxima
