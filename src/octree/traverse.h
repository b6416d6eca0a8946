// Depth-first visits of an octree's cells.
//
//     traverse(octree, Visitor{...});   // should_enter(cell) prunes, visit_leaf(cell, ids) sees
//     leaves
#pragma once

#include "base/fixed_stack.h"
#include "octree/octree.h"

#include <concepts>
#include <span>

namespace proxima {

/// What a visitor says after a leaf.
enum class Flow : std::uint8_t { proceed, stop };

template <class V>
concept CellVisitor = requires(V visitor, const Cell& cell, std::span<const TriangleId> triangles)
{
    {
        visitor.should_enter(cell)
        } -> std::convertible_to<bool>;
    {
        visitor.visit_leaf(cell, triangles)
        } -> std::same_as<Flow>;
};

/// Visits cells depth first in Morton order, empty leaves included. Never allocates: each level
/// leaves at most seven siblings pending. Thread safe.
template <class V>
requires CellVisitor<std::remove_reference_t<V>>
void traverse(const Octree& octree, V&& visitor)
{
    FixedStack<Cell, 7 * max_octree_depth + 1> pending;
    pending.push(octree.root());
    while (!pending.empty()) {
        const Cell cell = pending.pop();
        if (!visitor.should_enter(cell)) continue;
        if (octree.is_leaf(cell)) {
            if (visitor.visit_leaf(cell, octree.triangles(cell)) == Flow::stop) return;
        } else {
            for (int octant = 7; octant >= 0; --octant) pending.push(octree.child(cell, octant));
        }
    }
}

} // namespace proxima
