// The rows of a mesh index below those of its boxes that a test does not leave out.
#pragma once

#include "base/fixed_stack.h"
#include "index/index_parts.h"
#include "proxima/function_ref.h"
#include "proxima/geometry.h"

#include <cstddef>
#include <cstdint>

namespace proxima {

/// Calls visit(row) -> Flow for all rows of every leaf whose box, and those above it, may_meet(lower,
/// upper) takes, in no particular order, until it returns Flow::stop. Boxes are in the index's frame;
/// the root has none. No allocation.
template <class MayMeet, class Visit>
void visit_rows(const IndexParts& index, const MayMeet& may_meet, const Visit& visit)
{
    if (index.triangle_count() == 0) return;
    FixedStack<std::uint32_t, 7 * IndexParts::max_levels + 1> pending;
    pending.push(index.root());
    while (!pending.empty()) {
        const std::uint32_t reference = pending.pop();
        const IndexBlock& block = index.blocks()[reference & ~index_leaf_bit];
        if ((reference & index_leaf_bit) != 0) {
            for (std::uint32_t i = 0; i < block.leaf.count; ++i) {
                if (visit(block.leaf.first_row + i) == Flow::stop) return;
            }
            continue;
        }
        const IndexNode& node = block.node;
        for (std::size_t slot = 0; slot < 8; ++slot) {
            if (!node.has_child(slot)) continue;
            Vec3 lower;
            Vec3 upper;
            for (std::size_t axis = 0; axis < 3; ++axis) {
                lower[static_cast<Eigen::Index>(axis)] = node.plane(axis, slot);
                upper[static_cast<Eigen::Index>(axis)] = node.plane(axis, 8 + slot);
            }
            if (may_meet(lower, upper)) pending.push(node.children[slot]);
        }
    }
}

} // namespace proxima
