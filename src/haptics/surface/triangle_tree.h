// A tree of boxes over groups of eight triangles: of a whole surface, in the order of the index's
// rows, and of patches, which collision loops make anew many times a second. The leaves of the index's
// tree hold 3.4 triangles on average, so that a query would scan more than twice as many groups of
// them.
//
//     rows     0..7   8..15  16..23 ...         triangles, 8 neighbours of the order to a group
//     level 0  [box    box    box  ... x 8]     one block of 8 boxes, by coordinate
//     level 1  [box of 8 groups        ... x 8]
//     ...      until one block holds all
//
// Neither pointers nor ids: entry e of a level is block e of the level below. About 3.5 bytes per
// triangle. The boxes are floats in units of the mesh's size from its centre, rounded outward with
// more to spare than all rounding of a query and of the closest points of features
// (feature_distance.h), so a group is left out only if none of its features, as computed, is within
// the bound. Distances to boxes are doubles: right for any finite point, however far.
#pragma once

#include "index/visit_near.h"
#include "proxima/execution.h"
#include "proxima/geometry.h"
#include "proxima/octree.h"
#include "proxima/result.h"
#include "proxima/triangle_mesh.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <type_traits>

namespace proxima {

/// Boxes of eight entries. Slots without an entry are empty boxes.
struct alignas(64) TriangleTreeBlock {
    using Coordinates = std::array<float, 8>;
    std::array<Coordinates, 3> lower;
    std::array<Coordinates, 3> upper;
};

/// Immutable; copies share the blocks. Thread safe.
class TriangleTree {
public:
    static constexpr std::uint32_t width = 8;
    static constexpr std::size_t max_levels = 10; ///< for 2^31 triangles

    /// Entries of one level, in blocks from `first_block` on.
    struct Level {
        std::uint32_t first_block = 0;
        std::uint32_t entries = 0;
    };

    [[nodiscard]] std::uint32_t triangle_count() const noexcept { return triangle_count_; }
    [[nodiscard]] std::span<const TriangleTreeBlock> blocks() const noexcept { return blocks_; }

    /// From the groups of triangles up; the last one has a single block.
    [[nodiscard]] std::span<const Level> levels() const noexcept
    {
        return std::span(levels_).first(level_count_);
    }

    /// Boxes are in multiples of 1 / scale() from origin(). The scale is a power of two.
    [[nodiscard]] const Vec3& origin() const noexcept { return origin_; }
    [[nodiscard]] double scale() const noexcept { return scale_; }

    /// The largest |coordinate| of the mesh, times scale().
    [[nodiscard]] double reach() const noexcept { return reach_; }

    [[nodiscard]] std::uint64_t bytes() const noexcept { return blocks_.size_bytes(); }

    /// Blocks of a tree over so many triangles.
    [[nodiscard]] static std::size_t block_count(std::uint32_t triangles) noexcept;

    /// Takes the blocks of a tree that was built; `storage` keeps them alive. Whatever they hold,
    /// searches end and visit only ranks that exist.
    /// \pre blocks.size() == block_count(triangles), triangles > 0
    [[nodiscard]] static TriangleTree adopt(const Vec3& origin, double scale, double reach,
                                            std::uint32_t triangles,
                                            std::span<const TriangleTreeBlock> blocks,
                                            std::shared_ptr<const void> storage) noexcept;

private:
    friend class TriangleTreeBuilder;

    /// Sets the levels, returns the number of blocks.
    std::uint32_t lay_out(std::uint32_t triangles) noexcept;

    Vec3 origin_ = Vec3::Zero();
    double scale_ = 1;
    double reach_ = 0;
    std::uint32_t triangle_count_ = 0;
    std::size_t level_count_ = 0;
    std::array<Level, max_levels> levels_{};
    std::span<const TriangleTreeBlock> blocks_;
    std::shared_ptr<const void> storage_; ///< of the blocks
};

/// Builds the tree over all triangles in `order`, best one that keeps neighbours together
/// (triangle_order). Errors: invalid_mesh (empty, NaN, larger than 1e150), cancelled. O(triangles),
/// the same for any number of threads. \pre order has every triangle once
[[nodiscard]] Result<TriangleTree> build_triangle_tree(const TriangleMesh& mesh,
                                                       std::span<const TriangleId> order,
                                                       const Execution& execution = {});

/// Like build_triangle_tree(), about the triangles of two meshes, or of all between them: boxes hold
/// both. \pre the meshes have the same triangles
[[nodiscard]] Result<TriangleTree> build_triangle_tree(const TriangleMesh& from,
                                                       const TriangleMesh& to,
                                                       std::span<const TriangleId> order,
                                                       const Execution& execution = {});

namespace detail {
/// No entry anywhere.
[[nodiscard]] TriangleTreeBlock empty_block() noexcept;

/// Sets the entries' boxes of level `first` and of those above it from the level below each.
/// \pre first > 0; `blocks` are those of all levels
void fill_parents(std::span<const TriangleTree::Level> levels, std::size_t first,
                  std::span<TriangleTreeBlock> blocks) noexcept;

using VisitRanks = double (*)(void* context, RowRange ranks) noexcept;
void visit_nearest(const TriangleTree& tree, const Box& query, double bound_squared,
                   VisitRanks visit, void* context) noexcept;
} // namespace detail

/// Visits groups of up to 8 triangles whose boxes are within a bound of p, near ones first as far
/// as depth first allows. `visitor(RowRange)` returns the squared bound from then on: what it has
/// found so far, negative to end the search. Ends when no group within the bound is left. No
/// allocation; noexcept, as the visitor must be. \pre p is finite
template <class Visitor>
void visit_nearest(const TriangleTree& tree, const Vec3& p, double bound_squared,
                   Visitor&& visitor) noexcept
{
    using Callable = std::remove_reference_t<Visitor>;
    detail::visit_nearest(
        tree, {p, p}, bound_squared,
        [](void* context, RowRange ranks) noexcept -> double {
            return (*static_cast<Callable*>(context))(ranks);
        },
        const_cast<void*>(static_cast<const void*>(&visitor)));
}

/// Visits all groups whose boxes are within a distance of a box, a point for one, in the same
/// order: `visitor(RowRange)`, which may return Flow to end the search. Every feature that is, as
/// computed, no farther is in one of them. \pre the box is finite and not empty
template <class Visitor>
void visit_within(const TriangleTree& tree, const Box& box, double distance_squared,
                  Visitor&& visitor) noexcept
{
    auto all = [&](RowRange ranks) noexcept -> double {
        if constexpr (std::is_same_v<std::invoke_result_t<Visitor&, RowRange>, Flow>) {
            return visitor(ranks) == Flow::stop ? -1.0 : distance_squared;
        } else {
            visitor(ranks);
            return distance_squared;
        }
    };
    detail::visit_nearest(
        tree, box, distance_squared,
        [](void* context, RowRange ranks) noexcept -> double {
            return (*static_cast<decltype(all)*>(context))(ranks);
        },
        &all);
}

} // namespace proxima
