// An octree's leaves as boxes on the lattice of its deepest cells: what exports draw.
#pragma once

#include "proxima/execution.h"
#include "proxima/octree.h"
#include "proxima/result.h"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace proxima {

/// One leaf. Its corners have coordinates lower and lower + size in units of the deepest cells.
struct LeafBox {
    std::array<std::uint32_t, 3> lower{};
    std::uint32_t size = 0;
    std::uint32_t triangles = 0;
    CellClass type = CellClass::unclassified;
    std::uint8_t depth = 0;
};

enum class LeafChoice : std::uint8_t { all, boundary };

/// Leaves in Morton order. Error cancelled by `progress`, stage "collecting leaves".
[[nodiscard]] Result<std::vector<LeafBox>> leaf_boxes(const Octree& octree, LeafChoice choice,
                                                      Progress* progress);

/// Those below some cells, in the order of the cells.
[[nodiscard]] Result<std::vector<LeafBox>> leaf_boxes_below(const Octree& octree,
                                                            std::span<const Cell> cells,
                                                            LeafChoice choice, Progress* progress);

/// The distinct corners of boxes, each once.
class LeafCorners {
public:
    /// Sorts all corners, in linear time. Error cancelled by `progress`, stage "numbering corners".
    [[nodiscard]] static Result<LeafCorners> find(const std::vector<LeafBox>& leaves,
                                                  Progress* progress);

    [[nodiscard]] std::size_t size() const noexcept { return codes_.size(); }

    /// Number of a leaf's corner; corner bits are x, y, z as an octant's.
    [[nodiscard]] std::uint64_t number(const LeafBox& leaf, int corner) const noexcept;

    /// Where it lies: exactly on the planes of the frame, whose deepest cells have that depth.
    [[nodiscard]] Vec3 position(const OctreeFrame& frame, int lattice_depth,
                                std::size_t number) const noexcept;

private:
    std::vector<std::uint64_t> codes_;
};

/// Where a leaf's corner lies.
[[nodiscard]] Vec3 corner_position(const Octree& octree, const LeafBox& leaf, int corner) noexcept;

} // namespace proxima
