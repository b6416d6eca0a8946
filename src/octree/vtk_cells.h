// Cells of any octree for VTK, with numbers of the caller's: leaves as voxels that share their
// corners (.vtu), or the tree itself, inner cells included (.htg).
#pragma once

#include "octree/leaf_boxes.h"
#include "proxima/execution.h"
#include "proxima/octree.h"
#include "proxima/result.h"

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

namespace proxima {

/// A number per cell.
struct CellData {
    const char* name = "";
    const char* type = ""; ///< as VTK calls it
    std::span<const std::byte> bytes;
};

/// `values` are not copied.
template <std::unsigned_integral T>
requires(sizeof(T) == 1 || sizeof(T) == 4) [[nodiscard]] CellData
    cell_data(const char* name, const std::vector<T>& values)
{
    return {name, sizeof(T) == 1 ? "UInt8" : "UInt32", std::as_bytes(std::span(values))};
}

/// Leaves on the planes of depth `lattice_depth` of the frame; `data` in their order, the first is
/// what programs show at first. Errors: file_not_writable, cancelled. Points cost a sort.
[[nodiscard]] Status write_leaf_voxels(const OctreeFrame& frame, int lattice_depth,
                                       const std::vector<LeafBox>& leaves,
                                       std::span<const CellData> data,
                                       const std::filesystem::path& path, Progress* progress);

/// Leaves of an octree with their classes, depths and numbers of triangles, as export_vtu writes
/// them. Errors and cost of write_leaf_voxels.
[[nodiscard]] Status write_classified_leaves(const OctreeFrame& frame, int lattice_depth,
                                             const std::vector<LeafBox>& leaves,
                                             const std::filesystem::path& path, Progress* progress);

/// Which cells of a tree are split, breadth first, children x fastest: a bit for every cell above
/// the deepest level, 1 where it is split.
class SplitCells {
public:
    /// The next level; the last one has no cell that is split.
    void add_level(const std::vector<bool>& split);

    [[nodiscard]] const std::vector<std::int64_t>& cells_at_depth() const noexcept
    {
        return cells_at_depth_;
    }

    /// Eight cells each, the first in the highest bit.
    [[nodiscard]] const std::vector<std::uint8_t>& bits() const noexcept { return bits_; }
    [[nodiscard]] std::uint64_t bit_count() const noexcept { return bit_count_; }

private:
    std::vector<std::uint8_t> bits_;
    std::uint64_t bit_count_ = 0;
    std::vector<std::int64_t> cells_at_depth_;
};

/// VTK's HyperTreeGrid, XML version 2.0, of one tree in the box; `data` breadth first.
/// Errors: file_not_writable, cancelled.
[[nodiscard]] Status write_hyper_tree(const Box& root, const SplitCells& cells,
                                      std::span<const CellData> data,
                                      const std::filesystem::path& path, Progress* progress);

} // namespace proxima
