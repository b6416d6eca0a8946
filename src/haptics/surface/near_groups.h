// Which groups of a surface are near a place: what a metric patch refers to.
//
//     surface   blocks of eight groups of eight triangles, in an order that keeps neighbours near
//     near      the blocks whose boxes are within a reach, in that order, and a tree of boxes over
//               them; the triangles stay where they are
//
// Blocks are counted by distance before any is taken: where there are more than there is room for,
// the reach that has room is known from the counts. A patch of 100,000 triangles takes 0.1 ms.
#pragma once

#include "index/triangle_tree.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace proxima {

/// A copy is whole. One thread writes.
class NearGroups {
public:
    /// Room for so many triangles, in whole blocks of 64.
    explicit NearGroups(std::size_t triangles);

    /// What find() found.
    struct Found {
        double reach = 0;     ///< every triangle that is no farther is there; 0 promises nothing
        bool complete = true; ///< the reach is the distance asked for
    };

    /// Takes all blocks with a triangle within `distance` of p, or within the reach that there is
    /// room for; boxes as far as each other are all taken or none. Where the boxes about p itself
    /// are more than that, the first of them. The same on every instruction set. O(blocks taken), a
    /// few 10 ns each; noexcept, no allocation. \pre p is finite, distance >= 0; triangles
    [[nodiscard]] Found find(const TriangleTree& tree, const Vec3& p, double distance) noexcept;

    [[nodiscard]] std::uint32_t triangle_count() const noexcept { return triangle_count_; }

    /// Over the blocks that were taken; it refers to this. \pre triangle_count() > 0
    [[nodiscard]] TriangleTree tree() const noexcept;

    /// The surface's number of a group of that tree.
    [[nodiscard]] std::uint32_t group(std::uint32_t near) const noexcept
    {
        constexpr std::uint32_t width = TriangleTree::width;
        return ids_[near / width] * width + near % width;
    }

private:
    [[nodiscard]] float distance_with_room() const noexcept;

    std::vector<std::uint32_t> ids_; ///< of the blocks that were taken, ascending
    std::vector<TriangleTreeBlock> blocks_;
    std::vector<std::uint32_t> counts_; ///< of blocks, by distance
    std::uint32_t triangle_count_ = 0;
    Vec3 origin_ = Vec3::Zero();
    double scale_ = 1;
    double reach_ = 0;
};

} // namespace proxima
