// The groups of a surface that are near a position: a metric patch refers to them.
//
//     surface   blocks of eight groups of eight triangles, in an order that keeps neighbours near
//     near      the blocks whose boxes are within a reach, in that order, and a tree of boxes over
//               them; the triangles are not copied
//
// A surface's own groups are referred to; patch_groups.h makes groups of copied triangles. Unlike
// GroupBoxes, which holds up to 512 boxes of one query, this holds a patch of many thousands.
//
// Blocks are counted by distance before any is taken, so that a reach whose blocks fit the capacity
// is known from the counts. A patch of 100,000 triangles takes 0.1 ms.
#pragma once

#include "haptics/surface/triangle_tree.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace proxima {

/// Copies are independent. One thread writes.
class NearGroups {
public:
    /// Has a capacity of so many triangles, in whole blocks of 64.
    explicit NearGroups(std::size_t triangles);

    /// The extent of what find() took.
    struct Found {
        double reach = 0;     ///< all triangles no farther than this were taken; 0: perhaps not
        bool complete = true; ///< the reach is the distance asked for
    };

    /// Takes all blocks with a triangle within `distance` of p, or within the longest reach whose
    /// blocks fit the capacity; boxes at the same distance are all taken or none. Where the boxes
    /// about p alone do not fit, takes the first of them. The same on every instruction set.
    /// O(blocks taken), a few 10 ns each; noexcept, no allocation. \pre p is finite, distance >= 0
    [[nodiscard]] Found find(const TriangleTree& tree, const Vec3& p, double distance) noexcept;

    [[nodiscard]] std::uint32_t triangle_count() const noexcept { return triangle_count_; }

    /// The tree over the blocks that were taken; it refers to this. \pre triangle_count() > 0
    [[nodiscard]] TriangleTree tree() const noexcept;

    /// The surface's id of a group of that tree.
    [[nodiscard]] std::uint32_t group(std::uint32_t near) const noexcept
    {
        constexpr std::uint32_t width = TriangleTree::width;
        return ids_[near / width] * width + near % width;
    }

private:
    [[nodiscard]] float distance_that_fits() const noexcept;

    std::vector<std::uint32_t> ids_; ///< of the blocks that were taken, ascending
    std::vector<TriangleTreeBlock> blocks_;
    std::vector<std::uint32_t> counts_; ///< of blocks, by distance
    std::uint32_t triangle_count_ = 0;
    Vec3 origin_ = Vec3::Zero();
    double scale_ = 1;
    double reach_ = 0;
};

} // namespace proxima
