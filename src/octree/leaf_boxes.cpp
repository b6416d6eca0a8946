#include "octree/leaf_boxes.h"

#include "base/progress.h"
#include "base/radix_sort.h"
#include "proxima/octree.h"

#include <algorithm>

namespace proxima {

namespace {

constexpr unsigned axis_bits = max_octree_depth + 1; // coordinates up to 2^19, both included
constexpr std::uint64_t axis_mask = (std::uint64_t{1} << axis_bits) - 1;

std::uint32_t coordinate(const LeafBox& leaf, int corner, unsigned axis) noexcept
{
    const bool upper = (static_cast<unsigned>(corner) >> axis & 1U) != 0;
    return leaf.lower[axis] + (upper ? leaf.size : 0);
}

/// z, y, x from the highest bits down.
std::uint64_t code(const LeafBox& leaf, int corner) noexcept
{
    return std::uint64_t{coordinate(leaf, corner, 2)} << 2 * axis_bits |
           std::uint64_t{coordinate(leaf, corner, 1)} << axis_bits | coordinate(leaf, corner, 0);
}

struct Collector {
    const Octree& octree;
    LeafChoice choice;
    std::vector<LeafBox>& leaves;
    StageSteps& steps;
    bool stopped = false;

    [[nodiscard]] bool should_enter(const Cell& cell) const noexcept
    {
        return choice == LeafChoice::all || cell.type == CellClass::boundary;
    }

    [[nodiscard]] Flow visit_leaf(const Cell& cell, std::span<const TriangleId> triangles)
    {
        const int level = depth(cell.key);
        const auto up = static_cast<unsigned>(octree.parameters().max_depth - level);
        LeafBox leaf;
        leaf.lower = cell_coordinates(cell.key);
        for (std::uint32_t& at : leaf.lower) at <<= up;
        leaf.size = 1U << up;
        leaf.triangles = static_cast<std::uint32_t>(triangles.size());
        leaf.type = cell.type;
        leaf.depth = static_cast<std::uint8_t>(level);
        leaves.push_back(leaf);
        stopped = !steps.done(1);
        return stopped ? Flow::stop : Flow::proceed;
    }
};

} // namespace

Result<std::vector<LeafBox>> leaf_boxes(const Octree& octree, LeafChoice choice, Progress* progress)
{
    const Cell root = octree.root();
    return leaf_boxes_below(octree, {&root, 1}, choice, progress);
}

Result<std::vector<LeafBox>> leaf_boxes_below(const Octree& octree, std::span<const Cell> cells,
                                              LeafChoice choice, Progress* progress)
{
    std::vector<LeafBox> leaves;
    StageSteps steps(progress, "collecting leaves", octree.nodes().size());
    Collector collector{octree, choice, leaves, steps};
    for (const Cell& cell : cells) {
        traverse_below(octree, cell, collector);
        if (collector.stopped) return cancelled("the export");
    }
    return leaves;
}

Result<LeafCorners> LeafCorners::find(const std::vector<LeafBox>& leaves, Progress* progress)
{
    constexpr unsigned sort_passes = radix_passes(3 * axis_bits);
    StageSteps steps(progress, "numbering corners", (2 + 8 * sort_passes) * leaves.size());
    LeafCorners corners;
    std::vector<std::uint64_t>& codes = corners.codes_;
    codes.reserve(8 * leaves.size());
    for (const LeafBox& leaf : leaves) {
        for (int corner = 0; corner < 8; ++corner) codes.push_back(code(leaf, corner));
        if (!steps.done(1)) return cancelled("the export");
    }
    const auto key_of = [](std::uint64_t code) { return code; };
    if (!radix_sort(codes, 3 * axis_bits, key_of, steps)) return cancelled("the export");
    codes.erase(std::unique(codes.begin(), codes.end()), codes.end());
    return corners;
}

std::uint64_t LeafCorners::number(const LeafBox& leaf, int corner) const noexcept
{
    return static_cast<std::uint64_t>(
        std::lower_bound(codes_.begin(), codes_.end(), code(leaf, corner)) - codes_.begin());
}

Vec3 LeafCorners::position(const OctreeFrame& frame, int lattice_depth,
                           std::size_t number) const noexcept
{
    Vec3 point;
    for (int axis = 0; axis < 3; ++axis) {
        const auto at = static_cast<std::uint32_t>(
            codes_[number] >> static_cast<unsigned>(axis) * axis_bits & axis_mask);
        point[axis] = frame.plane(axis, at, lattice_depth);
    }
    return point;
}

Vec3 corner_position(const Octree& octree, const LeafBox& leaf, int corner) noexcept
{
    Vec3 point;
    for (int axis = 0; axis < 3; ++axis) {
        point[axis] =
            octree.frame().plane(axis, coordinate(leaf, corner, static_cast<unsigned>(axis)),
                                 octree.parameters().max_depth);
    }
    return point;
}

} // namespace proxima
