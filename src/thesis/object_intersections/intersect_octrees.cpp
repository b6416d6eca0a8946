#include "thesis/object_intersections/intersect_octrees.h"

#include "base/progress.h"

#include <cstdint>

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

Result<CandidateTriangles> candidate_triangles(const Octree& a, const Octree& b,
                                               const std::vector<LeafPair>& pairs,
                                               Progress* progress)
{
    StageSteps steps(progress, "collecting triangles", 2 * std::uint64_t{pairs.size()});
    // False where the work shall stop.
    const auto collect = [&](const Octree& octree, Cell LeafPair::*side,
                             std::vector<TriangleId>& triangles) {
        std::vector<bool> is_seen(octree.nodes().size());
        std::vector<bool> is_in(octree.triangle_count());
        for (const LeafPair& pair : pairs) {
            if (!steps.done(1)) return false;
            const Cell& leaf = pair.*side;
            if (is_seen[leaf.node]) continue;
            is_seen[leaf.node] = true;
            for (const TriangleId id : octree.triangles(leaf)) is_in[to_index(id)] = true;
        }
        for (std::uint32_t i = 0; i < is_in.size(); ++i)
            if (is_in[i]) triangles.push_back(TriangleId{i});
        return true;
    };
    CandidateTriangles candidates;
    if (!collect(a, &LeafPair::a, candidates.a) || !collect(b, &LeafPair::b, candidates.b))
        return cancelled("collecting triangles");
    steps.finish();
    return candidates;
}

} // namespace proxima
