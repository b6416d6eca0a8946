#include "thesis/object_intersections/cancellable_cells.h"

#include "base/progress.h"
#include "geometry/triangle_contact.h"
#include "thesis/object_intersections/intersect_octrees.h"

#include <algorithm>

namespace proxima {

namespace {

/// Sorts the list and drops what it holds twice.
void keep_distinct(std::vector<TrianglePair>& pairs)
{
    std::ranges::sort(pairs);
    pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
}

} // namespace

CellIntersection intersect_by_cells(const MeshCells& a, const MeshCells& b,
                                    const RigidTransform& pose_b)
{
    return intersect_by_cells(a, b, pose_b, nullptr);
}

CellIntersection intersect_by_cells(const MeshCells& a, const MeshCells& b,
                                    const RigidTransform& pose_b, const Progress* progress)
{
    CellIntersection result;
    std::vector<TrianglePair> candidates;
    // Neighbouring leaves list the same pairs: dropped whenever the list has doubled.
    std::size_t next_clean = std::size_t{1} << 20U;
    result.cell_tests =
        visit_intersecting_leaves(a.octree, b.octree, pose_b, [&](const LeafPair& leaves) {
            ++result.cell_pairs;
            for (const TriangleId of_a : a.octree.triangles(leaves.a)) {
                for (const TriangleId of_b : b.octree.triangles(leaves.b))
                    candidates.push_back({of_a, of_b});
            }
            if (candidates.size() > next_clean) {
                keep_distinct(candidates);
                next_clean = std::max(next_clean, 2 * candidates.size());
            }
            return is_cancelled(progress) ? Flow::stop : Flow::proceed;
        });
    keep_distinct(candidates);
    result.triangle_tests = candidates.size();
    constexpr std::size_t block = 4096;
    for (std::size_t i = 0; i < candidates.size(); ++i) {
        if (i % block == 0 && is_cancelled(progress)) break;
        const TrianglePair& pair = candidates[i];
        if (triangles_meet(a.mesh.triangle(pair.a), pose_b(b.mesh.triangle(pair.b))))
            result.pairs.push_back(pair);
    }
    return result;
}

} // namespace proxima
