#include "octree/cells_at_caps.h"

#include "base/fixed_stack.h"
#include "base/progress.h"
#include "geometry/triangle_box.h"
#include "octree/empty_cells.h"

namespace proxima {

namespace {

/// Adds the empty cells that one cap may touch.
void descend(const Octree& octree, const Triangle& cap, std::vector<std::uint8_t>& at_caps)
{
    FixedStack<Cell, 7 * max_octree_depth + 1> pending;
    pending.push(octree.root());
    while (!pending.empty()) {
        const Cell parent = pending.pop();
        const std::uint32_t empty = empty_octants(octree, parent.node);
        for (int octant = 0; octant < 8; ++octant) {
            const Cell child = octree.child(parent, octant);
            const std::uint32_t bit = 1U << static_cast<unsigned>(octant);
            const bool is_empty = (empty & bit) != 0;
            if (!is_empty && octree.is_leaf(child)) continue;
            if (!triangle_box_filter(cap, octree.box(child)).overlaps) continue;
            if (is_empty) {
                at_caps[parent.node] |= static_cast<std::uint8_t>(bit);
            } else {
                pending.push(child);
            }
        }
    }
}

} // namespace

std::vector<std::uint8_t> octants_at_caps(const Octree& octree, const TriangleMesh& caps,
                                          const Progress* progress)
{
    if (caps.triangle_count() == 0) return {};
    std::vector<std::uint8_t> at_caps(octree.nodes().size());
    if (octree.nodes().empty() || octree.nodes()[0].is_leaf()) return at_caps;
    for (std::uint32_t i = 0; i < caps.triangle_count() && !is_cancelled(progress); ++i) {
        descend(octree, caps.triangle(TriangleId{i}), at_caps);
    }
    return at_caps;
}

} // namespace proxima
