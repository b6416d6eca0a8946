#include "proxima/thesis.h"

#include "proxima/cull.h"

namespace proxima {

CellCulling cull_by_cells(const Octree& octree, const ViewVolume& volume)
{
    CellCulling culling;
    std::vector<bool> is_listed(octree.triangle_count(), false);
    visible_cells(octree, volume, CullMode::exact, [&](const VisibleCell& at) {
        const auto list = octree.triangles(at.cell);
        culling.cells += list.empty() ? 0U : 1U;
        for (const TriangleId id : list) is_listed[to_index(id)] = true;
        return Flow::proceed;
    });
    for (std::uint32_t id = 0; id < is_listed.size(); ++id)
        if (is_listed[id]) culling.triangles.push_back(TriangleId{id});
    return culling;
}

} // namespace proxima
