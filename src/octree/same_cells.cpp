#include "octree/same_cells.h"

#include <algorithm>
#include <utility>
#include <vector>

namespace proxima {

bool same_cells(const Octree& a, const Octree& b)
{
    std::vector<std::pair<Cell, Cell>> pending = {{a.root(), b.root()}};
    while (!pending.empty()) {
        const auto [in_a, in_b] = pending.back();
        pending.pop_back();
        if (a.is_leaf(in_a) != b.is_leaf(in_b) || in_a.type != in_b.type) return false;
        if (a.is_leaf(in_a)) {
            if (!std::ranges::equal(a.triangles(in_a), b.triangles(in_b))) return false;
            continue;
        }
        for (int octant = 0; octant < 8; ++octant) {
            pending.emplace_back(a.child(in_a, octant), b.child(in_b, octant));
        }
    }
    return true;
}

} // namespace proxima
