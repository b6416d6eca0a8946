#include "octree/cells_at_caps.h"

#include "base/fixed_stack.h"
#include "base/progress.h"
#include "octree/empty_cells.h"

#include <algorithm>
#include <cmath>

namespace proxima {

namespace {

/// Whether the closed box may touch the triangle: false only if its box or plane is clear of it.
bool may_touch(const Triangle& triangle, const Box& box) noexcept
{
    const Box bounds = bounding_box(triangle);
    if ((bounds.lower.array() > box.upper.array()).any() ||
        (bounds.upper.array() < box.lower.array()).any()) {
        return false;
    }
    const Vec3 size = (box.upper - box.lower).cwiseMax(bounds.upper - bounds.lower);
    const double unit = size.maxCoeff() > 0.0 ? 1.0 / size.maxCoeff() : 1.0;
    const Vec3 normal =
        ((triangle[1] - triangle[0]) * unit).cross((triangle[2] - triangle[0]) * unit);
    const double reach = normal.cwiseAbs().dot(0.5 * unit * (box.upper - box.lower));
    const double distance = std::abs(normal.dot((box.center() - triangle[0]) * unit));
    constexpr double slack = 1e-9; // far above rounding: an extra touch only costs time
    return distance <= reach + slack * normal.norm();
}

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
            if (!may_touch(cap, octree.box(child))) continue;
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
