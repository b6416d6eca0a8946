#include "proxima/proximity/list_statistics.h"

#include "proxima/base/check.h"
#include "proxima/proximity/proximity_cells.h"
#include "proxima/proximity/proximity_octree.h"
#include "proxima/proximity/thesis_labels.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace proxima {

namespace {

/// Walks the cells of a proximity octree, those above its table by joining what is one leaf there.
class LeafWalk {
public:
    explicit LeafWalk(const ProximityOctree& octree) : octree_(octree) {}

    LeafLists walk()
    {
        visit_above(0, {0, 0, 0});
        return std::move(lists_);
    }

private:
    /// A cell at the table's level or above it, by its place on its own level's grid.
    void visit_above(int depth, const std::array<std::uint32_t, 3>& at)
    {
        const int levels = octree_.table_depth() - depth;
        const std::uint64_t word = word_at(at, levels);
        if (levels == 0) {
            visit(word, depth);
        } else if (proximity_word::is_leaf(word) && is_one_leaf(word, at, levels)) {
            add_leaf(word, depth);
        } else {
            for (std::uint32_t octant = 0; octant < 8; ++octant)
                visit_above(depth + 1, {2 * at[0] + (octant & 1U), 2 * at[1] + (octant >> 1U & 1U),
                                        2 * at[2] + (octant >> 2U)});
        }
    }

    void visit(std::uint64_t word, int depth)
    {
        if (proximity_word::is_leaf(word)) {
            add_leaf(word, depth);
            return;
        }
        for (std::uint64_t octant = 0; octant < 8; ++octant)
            visit(octree_.arrays().nodes[word + octant], depth + 1);
    }

    /// The table's word of the first of the cells `levels` below `at`.
    [[nodiscard]] std::uint64_t word_at(const std::array<std::uint32_t, 3>& at, int levels) const
    {
        return table_word({at[0] << levels, at[1] << levels, at[2] << levels});
    }

    [[nodiscard]] std::uint64_t table_word(const std::array<std::uint32_t, 3>& at) const
    {
        const int depth = octree_.table_depth();
        return octree_.arrays().table[(std::size_t{at[2]} << depth | at[1]) << depth | at[0]];
    }

    [[nodiscard]] bool is_one_leaf(std::uint64_t word, const std::array<std::uint32_t, 3>& at,
                                   int levels) const
    {
        const std::uint32_t edge = 1U << levels;
        for (std::uint32_t z = 0; z < edge; ++z)
            for (std::uint32_t y = 0; y < edge; ++y)
                for (std::uint32_t x = 0; x < edge; ++x)
                    if (table_word({(at[0] << levels) + x, (at[1] << levels) + y,
                                    (at[2] << levels) + z}) != word)
                        return false;
        return true;
    }

    void add_leaf(std::uint64_t word, int depth)
    {
        lists_.lengths.push_back(list_length(octree_.arrays(), word));
        lists_.volumes.push_back(std::ldexp(1.0, -3 * depth));
    }

    const ProximityOctree& octree_;
    LeafLists lists_;
};

} // namespace

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

LeafLists list_lengths(const ProximityOctree& octree)
{
    return LeafWalk(octree).walk();
}

} // namespace proxima
