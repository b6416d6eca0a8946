#include "base/progress.h"
#include "octree/leaf_boxes.h"
#include "octree/vtk_cells.h"
#include "proxima/octree_io.h"

#include <array>

namespace proxima {

Status export_htg(const Octree& octree, const std::filesystem::path& path,
                  const ExportOptions& options)
{
    StageSteps steps(options.execution.progress, "collecting cells", octree.nodes().size());
    SplitCells cells;
    std::vector<std::uint8_t> classes;
    std::vector<std::uint8_t> depths;
    std::vector<std::uint32_t> triangles;
    std::vector<Cell> level = {octree.root()};
    while (!level.empty()) {
        std::vector<Cell> below;
        std::vector<bool> split;
        for (const Cell& cell : level) {
            if (!steps.done(1)) return cancelled("the export");
            split.push_back(!octree.is_leaf(cell));
            classes.push_back(static_cast<std::uint8_t>(cell.type));
            depths.push_back(static_cast<std::uint8_t>(cells.cells_at_depth().size()));
            triangles.push_back(
                split.back() ? 0U : static_cast<std::uint32_t>(octree.triangles(cell).size()));
            if (!split.back()) continue;
            for (int octant = 0; octant < 8; ++octant) below.push_back(octree.child(cell, octant));
        }
        cells.add_level(split);
        level = std::move(below);
    }
    const std::array<CellData, 3> data = {cell_data("class", classes), cell_data("depth", depths),
                                          cell_data("triangles", triangles)};
    return write_hyper_tree(octree.box(octree.root()), cells, data, path,
                            options.execution.progress);
}

} // namespace proxima
