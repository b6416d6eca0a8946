// Which leaves of two octrees meet, one of them moved: the double recursion of thesis section 5.2.
//
//     for (const LeafPair& pair : intersecting_leaves(*a, *b, pose)) ...a.triangles(pair.a)...
//
// Pairs of cells are descended by turns, one level of A, then one of B. Two things differ from the
// pseudocode as printed: where the cell whose turn it is is a leaf, the other one is descended
// (else pairs are lost), and pairs are always a leaf of A, then one of B. For triangles that meet,
// intersect_meshes.h is faster.
#pragma once

#include "base/fixed_stack.h"
#include "proxima/execution.h"
#include "proxima/geometry.h"
#include "proxima/octree.h"
#include "proxima/result.h"
#include "thesis/object_intersections/cell_pair_axes.h"

#include <cstdint>
#include <vector>

namespace proxima {

/// Two leaves that hold triangles and meet.
struct LeafPair {
    Cell a;
    Cell b;
};

/// Calls visitor(const LeafPair&) -> Flow for every pair of occupied leaves that meet, B's moved by
/// the pose: all that do, and none that are farther apart than CellPairAxes::meet says. Returns how
/// many pairs of cells were tested. Thread safe, no allocation. Each test about 50 ns.
template <class Visitor>
std::uint64_t visit_intersecting_leaves(const Octree& a, const Octree& b,
                                        const RigidTransform& pose_b, Visitor&& visitor)
{
    enum class Turn : std::uint8_t { of_a, of_b };
    struct Pending {
        LeafPair cells;
        CellPairAxes::Values projections;
        Turn turn;
    };
    const CellPairAxes axes(a.frame(), b.frame(), pose_b);
    // Each level of either octree leaves at most seven siblings pending.
    FixedStack<Pending, 2 * 7 * max_octree_depth + 1> pending;
    const auto is_occupied = [](const Octree& octree, const Cell& cell) {
        return cell.node < octree.nodes().size() && !octree.nodes()[cell.node].is_empty();
    };
    if (!is_occupied(a, a.root()) || !is_occupied(b, b.root())) return 0;
    pending.push({{a.root(), b.root()}, axes.root_projections(), Turn::of_a});
    std::uint64_t tests = 0;
    while (!pending.empty()) {
        const Pending pair = pending.pop();
        const Cell& cell_a = pair.cells.a;
        const Cell& cell_b = pair.cells.b;
        const int depth_a = depth(cell_a.key);
        const int depth_b = depth(cell_b.key);
        ++tests;
        if (!axes.meet(pair.projections, depth_a, depth_b)) continue;
        const bool a_is_leaf = a.is_leaf(cell_a);
        const bool b_is_leaf = b.is_leaf(cell_b);
        if (a_is_leaf && b_is_leaf) {
            if (visitor(pair.cells) == Flow::stop) break;
        } else if (b_is_leaf || (pair.turn == Turn::of_a && !a_is_leaf)) {
            for (int octant = 7; octant >= 0; --octant) {
                const Cell child = a.child(cell_a, octant);
                if (!is_occupied(a, child)) continue;
                pending.push({{child, cell_b},
                              axes.child_of_a(pair.projections, depth_a, octant),
                              Turn::of_b});
            }
        } else {
            for (int octant = 7; octant >= 0; --octant) {
                const Cell child = b.child(cell_b, octant);
                if (!is_occupied(b, child)) continue;
                pending.push({{cell_a, child},
                              axes.child_of_b(pair.projections, depth_b, octant),
                              Turn::of_a});
            }
        }
    }
    return tests;
}

/// All of them, in the order visited. Allocates the list. The same on every machine.
[[nodiscard]] std::vector<LeafPair> intersecting_leaves(const Octree& a, const Octree& b,
                                                        const RigidTransform& pose_b = {});

/// Triangles of either mesh, ascending, each once: those in the leaves of the pairs, which are all
/// that can meet. Thesis figure 5.4 draws them.
struct CandidateTriangles {
    std::vector<TriangleId> a;
    std::vector<TriangleId> b;
};
/// One thread; stage "collecting triangles". Error: cancelled.
[[nodiscard]] Result<CandidateTriangles> candidate_triangles(const Octree& a, const Octree& b,
                                                             const std::vector<LeafPair>& pairs,
                                                             Progress* progress = nullptr);

} // namespace proxima
