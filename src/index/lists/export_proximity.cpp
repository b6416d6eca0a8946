#include "index/lists/export_proximity.h"

#include "base/file_extension.h"
#include "base/fixed_stack.h"
#include "base/progress.h"
#include "base/text.h"
#include "index/lists/grow_cells.h"
#include "index/lists/proximity_cells.h"
#include "octree/vtk_cells.h"
#include "proxima/mesh_index.h"

#include <array>
#include <string>
#include <utility>

namespace proxima {

namespace {

/// Numbers of cells, in the order of the file.
class CellNumbers {
public:
    void add(const ProximityArrays& arrays, const ProximityCell& cell)
    {
        const std::uint64_t word = cell.word;
        const bool is_leaf = proximity_word::is_leaf(word);
        lengths_.push_back(is_leaf ? list_length(arrays, word) : 0);
        std::uint32_t blocks = is_leaf && proximity_word::is_block(word) ? 1 : 0;
        if (is_leaf && proximity_word::is_run(word))
            blocks = arrays.runs[proximity_word::position(word)].position;
        blocks_.push_back(blocks);
        depths_.push_back(static_cast<std::uint8_t>(cell.depth));
    }

    [[nodiscard]] std::array<CellData, 3> data() const
    {
        return {cell_data("list_length", lengths_), cell_data("blocks", blocks_),
                cell_data("depth", depths_)};
    }

private:
    std::vector<std::uint32_t> lengths_;
    std::vector<std::uint32_t> blocks_;
    std::vector<std::uint8_t> depths_;
};

OctreeFrame frame_of(const RootFrame& frame)
{
    return {frame.center - Vec3::Constant(frame.half), Vec3::Constant(2 * frame.half)};
}

Status export_leaves(const ProximityLists& lists, std::uint64_t root,
                     const std::filesystem::path& path, Progress* progress)
{
    const auto lattice_depth = static_cast<int>(lists.statistics().max_depth);
    StageSteps steps(progress, "collecting leaves", lists.statistics().nodes);
    std::vector<LeafBox> leaves;
    CellNumbers numbers;
    FixedStack<ProximityCell, 7 * max_list_depth + 1> pending;
    pending.push({root, 0, {}});
    while (!pending.empty()) {
        const ProximityCell cell = pending.pop();
        if (!steps.done(1)) return cancelled("the export");
        if (!proximity_word::is_leaf(cell.word)) {
            for (std::uint32_t i = 8; i-- > 0;) pending.push(child(lists.arrays(), cell, i));
            continue;
        }
        LeafBox leaf;
        leaf.size = 1U << (lattice_depth - cell.depth);
        for (std::size_t axis = 0; axis < 3; ++axis) leaf.lower[axis] = leaf.size * cell.at[axis];
        leaves.push_back(leaf);
        numbers.add(lists.arrays(), cell);
    }
    return write_leaf_voxels(frame_of(lists.frame()), lattice_depth, leaves, numbers.data(), path,
                             progress);
}

Status export_tree(const ProximityLists& lists, std::uint64_t root,
                   const std::filesystem::path& path, Progress* progress)
{
    StageSteps steps(progress, "collecting cells", lists.statistics().nodes);
    SplitCells cells;
    CellNumbers numbers;
    std::vector<ProximityCell> level = {{root, 0, {}}};
    while (!level.empty()) {
        std::vector<ProximityCell> below;
        std::vector<bool> split;
        for (const ProximityCell& cell : level) {
            if (!steps.done(1)) return cancelled("the export");
            numbers.add(lists.arrays(), cell);
            split.push_back(!proximity_word::is_leaf(cell.word));
            for (std::uint32_t i = 0; i < 8 && split.back(); ++i)
                below.push_back(child(lists.arrays(), cell, i));
        }
        cells.add_level(split);
        level = std::move(below);
    }
    return write_hyper_tree(cell_box(frame_of(lists.frame()), CellKey{}), cells, numbers.data(),
                            path, progress);
}

} // namespace

Status export_proximity(const ProximityLists& lists, const std::filesystem::path& path,
                        const ExportOptions& options)
{
    const std::string extension = lower_case_extension(path);
    if (extension != ".vtu" && extension != ".htg") {
        return fail(ErrorCode::unsupported_format,
                    concat("closest-feature lists are exported as .vtu or .htg, not as \"",
                           extension, "\""),
                    path.string());
    }
    const auto root = root_word(lists.arrays());
    if (!root) return tl::unexpected(root.error());
    return extension == ".vtu" ? export_leaves(lists, *root, path, options.execution.progress)
                               : export_tree(lists, *root, path, options.execution.progress);
}

} // namespace proxima
