// Equality of octrees as trees, whatever the order of their records.
#pragma once

#include "proxima/octree/octree.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

namespace proxima::testing {

/// Same cells, and the same triangles in every leaf.
inline ::testing::AssertionResult same_cells(const Octree& a, const Octree& b)
{
    std::vector<std::pair<Cell, Cell>> pending = {{a.root(), b.root()}};
    while (!pending.empty()) {
        const auto [in_a, in_b] = pending.back();
        pending.pop_back();
        if (a.is_leaf(in_a) != b.is_leaf(in_b)) {
            return ::testing::AssertionFailure()
                   << "cell " << in_a.key.bits << " is a leaf in one octree only ("
                   << a.is_leaf(in_a) << ", " << b.is_leaf(in_b) << ")";
        }
        if (!a.is_leaf(in_a)) {
            for (int octant = 0; octant < 8; ++octant) {
                pending.emplace_back(a.child(in_a, octant), b.child(in_b, octant));
            }
        } else if (!std::ranges::equal(a.triangles(in_a), b.triangles(in_b))) {
            return ::testing::AssertionFailure()
                   << "leaf " << in_a.key.bits << " at depth " << depth(in_a.key) << " lists "
                   << a.triangles(in_a).size() << " and " << b.triangles(in_b).size()
                   << " triangles, or different ones";
        }
    }
    return ::testing::AssertionSuccess();
}

/// The same nodes and references, bit for bit.
inline ::testing::AssertionResult same_arrays(const Octree& a, const Octree& b)
{
    if (!std::ranges::equal(a.nodes(), b.nodes())) {
        return ::testing::AssertionFailure() << "nodes differ";
    }
    if (!std::ranges::equal(a.references(), b.references())) {
        return ::testing::AssertionFailure() << "references differ";
    }
    return ::testing::AssertionSuccess();
}

} // namespace proxima::testing
