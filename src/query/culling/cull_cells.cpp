#include "proxima/cull.h"

#include "base/fixed_stack.h"
#include "geometry/view_contact.h"
#include "geometry/view_plane.h"

#include <algorithm>
#include <cstdint>

namespace proxima {

namespace {

/// A cell, and the planes that may cut it by bits; the last bit stands for all from the 64th on.
struct CellInView {
    Cell cell;
    std::uint64_t mask;
};
constexpr std::size_t last_bit = 63;

/// False if a plane has the whole box on its outside; takes those that have it inside off the mask.
bool passes(std::span<const ViewPlane> planes, const Box& box, std::uint64_t& mask) noexcept
{
    for (std::size_t bit = 0; bit <= last_bit && mask >> bit != 0; ++bit) {
        if ((mask >> bit & 1U) == 0) continue;
        const std::size_t end = bit == last_bit ? planes.size() : bit + 1;
        bool inside = true;
        for (const ViewPlane& plane : planes.subspan(bit, end - bit)) {
            if (side_of_plane(plane, innermost_corner(plane, box)) < 0) return false;
            inside = inside && side_of_plane(plane, outermost_corner(plane, box)) >= 0;
        }
        if (inside) mask &= ~(std::uint64_t{1} << bit);
    }
    return true;
}

} // namespace

void visible_cells(const Octree& octree, const ViewVolume& volume, CullMode mode,
                   FunctionRef<Flow(const VisibleCell&)> visitor) noexcept
{
    if (octree.nodes().empty() || volume.empty()) return;
    const std::span<const ViewPlane> planes = volume.planes();
    const std::uint64_t all =
        planes.size() > last_bit ? ~std::uint64_t{0} : (std::uint64_t{1} << planes.size()) - 1;
    FixedStack<CellInView, 7 * max_octree_depth + 1> pending;
    pending.push({octree.root(), all});
    while (!pending.empty()) {
        CellInView at = pending.pop();
        if (at.mask != 0 && !passes(planes, octree.box(at.cell), at.mask)) continue;
        if (!octree.is_leaf(at.cell)) {
            for (int octant = 7; octant >= 0; --octant)
                pending.push({octree.child(at.cell, octant), at.mask});
            continue;
        }
        if (at.mask != 0 && mode == CullMode::exact && !meets_volume(volume, octree.box(at.cell)))
            continue;
        if (visitor({at.cell, at.mask == 0}) == Flow::stop) return;
    }
}

std::vector<VisibleCell> visible_cells(const Octree& octree, const ViewVolume& volume,
                                       CullMode mode)
{
    std::vector<VisibleCell> cells;
    visible_cells(octree, volume, mode, [&](const VisibleCell& cell) {
        cells.push_back(cell);
        return Flow::proceed;
    });
    return cells;
}

} // namespace proxima
