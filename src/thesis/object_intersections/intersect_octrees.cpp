#include "thesis/object_intersections/intersect_octrees.h"

#include <algorithm>

namespace proxima {

std::vector<LeafPair> intersecting_leaves(const Octree& a, const Octree& b,
                                          const RigidTransform& pose_b)
{
    std::vector<LeafPair> pairs;
    visit_intersecting_leaves(a, b, pose_b, [&](const LeafPair& pair) {
        pairs.push_back(pair);
        return Flow::proceed;
    });
    return pairs;
}

CandidateTriangles candidate_triangles(const Octree& a, const Octree& b,
                                       const std::vector<LeafPair>& pairs)
{
    const auto collect = [&](const Octree& octree, Cell LeafPair::*side) {
        std::vector<Cell> leaves;
        leaves.reserve(pairs.size());
        for (const LeafPair& pair : pairs) leaves.push_back(pair.*side);
        std::ranges::sort(leaves, {}, &Cell::node);
        const auto are_same = [](const Cell& one, const Cell& other) {
            return one.node == other.node;
        };
        leaves.erase(std::unique(leaves.begin(), leaves.end(), are_same), leaves.end());
        std::vector<TriangleId> triangles;
        for (const Cell& leaf : leaves) {
            const auto list = octree.triangles(leaf);
            triangles.insert(triangles.end(), list.begin(), list.end());
        }
        std::ranges::sort(triangles);
        triangles.erase(std::unique(triangles.begin(), triangles.end()), triangles.end());
        return triangles;
    };
    return {collect(a, &LeafPair::a), collect(b, &LeafPair::b)};
}

} // namespace proxima
