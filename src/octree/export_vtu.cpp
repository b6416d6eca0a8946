#include "octree/leaf_boxes.h"
#include "octree/vtk_cells.h"
#include "proxima/octree_io.h"

#include <array>

namespace proxima {

Status write_classified_leaves(const OctreeFrame& frame, int lattice_depth,
                               const std::vector<LeafBox>& leaves,
                               const std::filesystem::path& path, Progress* progress)
{
    std::vector<std::uint8_t> classes;
    std::vector<std::uint8_t> depths;
    std::vector<std::uint32_t> triangles;
    for (const LeafBox& leaf : leaves) {
        classes.push_back(static_cast<std::uint8_t>(leaf.type));
        depths.push_back(leaf.depth);
        triangles.push_back(leaf.triangles);
    }
    const std::array<CellData, 3> data = {cell_data("class", classes), cell_data("depth", depths),
                                          cell_data("triangles", triangles)};
    return write_leaf_voxels(frame, lattice_depth, leaves, data, path, progress);
}

Status export_vtu(const Octree& octree, const std::filesystem::path& path,
                  const ExportOptions& options)
{
    Progress* const progress = options.execution.progress;
    const auto leaves = leaf_boxes(octree, LeafChoice::all, progress);
    if (!leaves) return tl::unexpected(leaves.error());
    return write_classified_leaves(octree.frame(), octree.parameters().max_depth, *leaves, path,
                                   progress);
}

} // namespace proxima
