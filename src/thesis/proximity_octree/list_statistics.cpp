#include "thesis/proximity_octree/list_statistics.h"

#include "base/check.h"
#include "base/fixed_stack.h"
#include "index/lists/proximity_cells.h"
#include "index/lists/proximity_lists.h"
#include "proxima/octree.h"
#include "thesis/proximity_octree/thesis_proximity_octree.h"

#include <algorithm>
#include <cmath>

namespace proxima {

double ListStatistics::share_up_to(std::uint32_t length) const noexcept
{
    if (!(total_weight > 0)) return 0;
    double sum = 0;
    for (std::size_t i = 0; i < weights.size() && i <= length; ++i) sum += weights[i];
    return sum / total_weight;
}

ListStatistics list_statistics(std::span<const std::uint32_t> lengths,
                               std::span<const double> weights)
{
    PROXIMA_CHECK(weights.empty() || weights.size() == lengths.size());
    ListStatistics statistics;
    statistics.cells = lengths.size();
    if (lengths.empty()) return statistics;
    statistics.max = *std::ranges::max_element(lengths);
    statistics.weights.resize(std::size_t{statistics.max} + 1);
    double weighted_lengths = 0;
    for (std::size_t i = 0; i < lengths.size(); ++i) {
        const double weight = weights.empty() ? 1.0 : weights[i];
        statistics.weights[lengths[i]] += weight;
        statistics.total_weight += weight;
        weighted_lengths += weight * lengths[i];
    }
    if (statistics.total_weight > 0) statistics.mean = weighted_lengths / statistics.total_weight;
    return statistics;
}

MeshSphere circumscribed_sphere(const TriangleMesh& mesh)
{
    MeshSphere sphere;
    sphere.center = bounding_box(mesh).center();
    for (const TriangleCorners& corners : mesh.triangles()) {
        for (const std::uint32_t corner : corners) {
            sphere.squared_radius =
                std::max(sphere.squared_radius,
                         (mesh.position(VertexId{corner}) - sphere.center).squaredNorm());
        }
    }
    return sphere;
}

std::vector<std::uint32_t> outer_list_lengths(const ThesisProximityOctree& octree,
                                              const MeshSphere& sphere)
{
    std::vector<std::uint32_t> lengths;
    octree.for_each_leaf([&](const ThesisCell& cell) {
        if (sphere.is_outside(octree.box(cell))) lengths.push_back(octree.list_length(cell));
    });
    return lengths;
}

LeafLists list_lengths(const ProximityLists& lists)
{
    const ProximityArrays& arrays = lists.arrays();
    const auto root = root_word(arrays);
    PROXIMA_CHECK(root.has_value());
    LeafLists leaves;
    FixedStack<ProximityCell, 7 * max_octree_depth + 1> pending;
    pending.push({*root, 0, {}});
    while (!pending.empty()) {
        const ProximityCell cell = pending.pop();
        if (proximity_word::is_leaf(cell.word)) {
            leaves.lengths.push_back(list_length(arrays, cell.word));
            leaves.volumes.push_back(std::ldexp(1.0, -3 * cell.depth));
            continue;
        }
        for (std::uint32_t octant = 8; octant-- > 0;) pending.push(child(arrays, cell, octant));
    }
    return leaves;
}

} // namespace proxima
