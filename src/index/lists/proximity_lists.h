// Closest-feature lists of a mesh index: an octree of cells, in each leaf the triangles that can be
// closest to a point of it, inside and outside (thesis chapter 4; algorithms: local regions, corner
// certificates, cover).
//
//     table    words of all cells of one level, x fastest: where a query begins
//     nodes    words of 8 bytes, eight children contiguous
//                0 | base                     split: its children are nodes base to base + 7
//                10 | position 30 | mask 32   leaf of one block, at arena + 8 position: of its
//                                             triangles those in the mask
//                11 | position 30 | 0         leaf of several: a run, at runs[position]
//                11 | 0 | 1                   leaf without a list: queries search the index's tree
//     runs     per leaf of several blocks: an entry with their number, then one per block, the
//              nearest to the leaf's centre first
//     arena    blocks (block.h), shared between leaves; they name rows of the index
//
// A query walks from the table to its leaf, filters the leaf's blocks in lanes of floats, and looks
// at the rows of what is within the filter's error of the least: the number of steps and blocks is
// bounded when the lists are built. Points outside of the root are searched for in the index's tree.
#pragma once

#include "index/lists/root_frame.h"
#include "proxima/result.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

namespace proxima {

/// Tables are at most this fine.
inline constexpr int max_table_depth = 6;

/// Words of nodes and table.
namespace proximity_word {
inline constexpr std::uint64_t leaf_bit = std::uint64_t{1} << 63U;
inline constexpr std::uint64_t run_bit = std::uint64_t{1} << 62U;
inline constexpr std::uint32_t max_position = (1U << 30U) - 1;

[[nodiscard]] constexpr bool is_leaf(std::uint64_t word) noexcept
{
    return (word & leaf_bit) != 0;
}
/// Of leaves: whether there is one block and no more to it.
[[nodiscard]] constexpr bool is_block(std::uint64_t word) noexcept
{
    return (word & run_bit) == 0;
}
[[nodiscard]] constexpr std::uint32_t position(std::uint64_t word) noexcept
{
    return static_cast<std::uint32_t>(word >> 32U) & max_position;
}
[[nodiscard]] constexpr std::uint32_t mask(std::uint64_t word) noexcept
{
    return static_cast<std::uint32_t>(word);
}
[[nodiscard]] constexpr std::uint64_t leaf(std::uint32_t position, std::uint32_t mask) noexcept
{
    return leaf_bit | std::uint64_t{position} << 32U | mask;
}
[[nodiscard]] constexpr std::uint64_t run(std::uint32_t position) noexcept
{
    return leaf_bit | run_bit | std::uint64_t{position} << 32U;
}
/// Of leaves whose points are answered by the tree of the index.
inline constexpr std::uint64_t search = leaf_bit | run_bit | 1;

[[nodiscard]] constexpr bool is_run(std::uint64_t word) noexcept
{
    return (word & run_bit) != 0 && word != search;
}
} // namespace proximity_word

/// A block of a leaf that has several; or, before them, their number as `position` and the leaf's
/// centre as `direction`, in the frame.
struct RunEntry {
    std::uint32_t position = 0; ///< of the block in the arena, in units of 8 bytes
    std::uint32_t mask = 0;     ///< its triangles that are meant
    float direction[3] = {};    ///< unit vector, or a little shorter
    float least = 0; ///< no point of the block has direction . (point - leaf's centre) below it
};

/// Counted when the lists are built.
struct ProximityStatistics {
    std::uint64_t nodes = 0;             ///< cells, split or leaf
    std::uint64_t leaves = 0;            ///< with and without a list
    std::uint64_t searched_leaves = 0;   ///< without one: queries search the tree
    std::uint64_t stale_leaves = 0;      ///< of these, since the last build: refit
    std::uint64_t references = 0;        ///< entries of all leaves' lists
    std::uint64_t blocks = 0;            ///< in the arena
    std::uint32_t max_depth = 0;         ///< of a leaf
    std::uint32_t max_list = 0;          ///< entries of a leaf's list
    std::uint32_t worst_case_steps = 0;  ///< words read on the way to a leaf at most
    std::uint32_t worst_case_blocks = 0; ///< blocks of a leaf at most
    double mean_list = 0;                ///< over leaves with a list
    double expected_list = 0;            ///< over expected queries that meet a list
    friend bool operator==(const ProximityStatistics&, const ProximityStatistics&) = default;
};

struct ProximityArrays {
    std::span<const std::uint64_t> table;
    std::span<const std::uint64_t> nodes;
    std::span<const RunEntry> runs;
    std::span<const std::byte> arena;
};

/// The mean length of a leaf's list.
[[nodiscard]] constexpr double mean_list(const ProximityStatistics& counts) noexcept
{
    const std::uint64_t lists = counts.leaves - counts.searched_leaves;
    return lists == 0 ? 0 : static_cast<double>(counts.references) / static_cast<double>(lists);
}

/// Immutable; copies share the storage. All members are noexcept, do not allocate, and may be
/// called from any thread.
class ProximityLists {
public:
    [[nodiscard]] const RootFrame& frame() const noexcept { return frame_; }
    [[nodiscard]] int table_depth() const noexcept { return table_depth_; }
    [[nodiscard]] const ProximityArrays& arrays() const noexcept { return arrays_; }
    [[nodiscard]] const ProximityStatistics& statistics() const noexcept { return statistics_; }

    /// A point's coordinates on the finest grid of cells, as fixed-point numbers of
    /// location_bits bits. False where it is outside of the root.
    [[nodiscard]] bool locate(const Vec3& frame_point,
                              std::array<std::uint32_t, 3>& at) const noexcept
    {
        constexpr auto end = static_cast<double>(1U << location_bits);
        const double x = frame_point[0] * grid_scale_ + end / 2;
        const double y = frame_point[1] * grid_scale_ + end / 2;
        const double z = frame_point[2] * grid_scale_ + end / 2;
        if (!(x >= 0 && y >= 0 && z >= 0 && x < end && y < end && z < end)) return false;
        at = {static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(y),
              static_cast<std::uint32_t>(z)};
        return true;
    }
    static constexpr unsigned location_bits = 20;

    /// Bytes of all arrays.
    [[nodiscard]] std::uint64_t bytes() const noexcept;

    /// What keeps runs and arena alive: refitted lists share it, and nothing else, with those they are
    /// made from.
    [[nodiscard]] const std::shared_ptr<const void>& shared_storage() const noexcept
    {
        return shared_storage_;
    }

    /// Takes arrays that satisfy the layout above; `storage` keeps them alive, or table and nodes alone
    /// where `shared_storage` keeps runs and arena. For the builder, the file reader and refitting; they
    /// check, this does not.
    [[nodiscard]] static ProximityLists
    adopt(const RootFrame& frame, int table_depth, const ProximityArrays& arrays,
          const ProximityStatistics& statistics, std::shared_ptr<const void> storage,
          std::shared_ptr<const void> shared_storage = nullptr) noexcept;

private:
    RootFrame frame_;
    double grid_scale_ = 1; ///< of frame coordinates, to units of the finest grid
    int table_depth_ = 0;
    ProximityArrays arrays_;
    ProximityStatistics statistics_;
    std::shared_ptr<const void> storage_;
    std::shared_ptr<const void> shared_storage_; ///< never null
};

} // namespace proxima
