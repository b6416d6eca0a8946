#include "octree/leaf_boxes.h"
#include "octree/vtk_cells.h"
#include "proxima/octree_io.h"

#include <array>

namespace proxima {

Status export_vtu(const Octree& octree, const std::filesystem::path& path,
                  const ExportOptions& options)
{
    const auto leaves = leaf_boxes(octree, LeafChoice::all, options.execution.progress);
    if (!leaves) return tl::unexpected(leaves.error());
    std::vector<std::uint8_t> classes;
    std::vector<std::uint8_t> depths;
    std::vector<std::uint32_t> triangles;
    for (const LeafBox& leaf : *leaves) {
        classes.push_back(static_cast<std::uint8_t>(leaf.type));
        depths.push_back(leaf.depth);
        triangles.push_back(leaf.triangles);
    }
    const std::array<CellData, 3> data = {cell_data("class", classes), cell_data("depth", depths),
                                          cell_data("triangles", triangles)};
    return write_leaf_voxels(octree.frame(), octree.parameters().max_depth, *leaves, data, path,
                             options.execution.progress);
}

} // namespace proxima
