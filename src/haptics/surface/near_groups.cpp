#include "haptics/surface/near_groups.h"

#include "base/fixed_stack.h"
#include "haptics/surface/ball_query.h"

#include <algorithm>
#include <bit>

#ifndef PROXIMA_HAPTICS_NEAR_GROUPS_ONCE
#define PROXIMA_HAPTICS_NEAR_GROUPS_ONCE

namespace proxima {

/// Counts squared distances by their first bits: the exponent and five more, so that a reach is at
/// most 3 % shorter than what would fit.
struct DistanceCounts {
    static constexpr int dropped_bits = 18;
    static constexpr std::size_t size = std::size_t{1} << (31 - dropped_bits);

    static std::size_t bin_of(float squared) noexcept
    {
        return std::bit_cast<std::uint32_t>(squared) >> dropped_bits;
    }
    /// Less than every distance counted in this bin or a later one; negative for the first bin.
    static float below(std::size_t bin) noexcept
    {
        if (bin == 0) return -1;
        return std::bit_cast<float>((static_cast<std::uint32_t>(bin) << dropped_bits) - 1);
    }
};

/// The arrays into which blocks are copied.
struct NearBlocks {
    std::span<std::uint32_t> ids; ///< its size says how many to take
    TriangleTreeBlock* blocks;
    TriangleTreeBlock* parents;
};

} // namespace proxima

#endif

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "haptics/surface/near_groups.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
// After foreach_target, for it is included once per target.
#include "haptics/surface/ball_gaps-inl.h"

HWY_BEFORE_NAMESPACE();
namespace proxima::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

/// A block of groups that the ball meets, and the lane that has its box.
struct MetBlock {
    std::uint32_t number;
    float squared;
    const TriangleTreeBlock* boxes; ///< null in a tree of one block
    std::size_t lane;
};

struct LevelBlock {
    std::uint32_t level;
    std::uint32_t block; ///< of its level
};

/// The boxes of a block that the ball meets, as bits; writes the distances of all.
HWY_INLINE std::uint32_t met_boxes(const TriangleTreeBlock& block, const BallQuery& query,
                                   std::size_t count, float* squared)
{
    const BallTag d;
    std::uint32_t met = 0;
    for (std::size_t lane = 0; lane < TriangleTree::width; lane += hn::Lanes(d)) {
        const auto gaps = squared_gaps(block, lane, query);
        hn::StoreU(gaps, d, squared + lane);
        std::uint8_t bits[8] = {};
        hn::StoreMaskBits(d, meets_ball(gaps, query, count - HWY_MIN(count, lane)), bits);
        met |= std::uint32_t{bits[0]} << lane;
    }
    return met;
}

/// Calls meet(MetBlock) for all blocks that the ball meets, in their order, until it returns false.
template <class Meet>
HWY_INLINE void visit_blocks(const TriangleTree& tree, const BallQuery& query, const Meet& meet)
{
    constexpr std::uint32_t width = TriangleTree::width;
    const std::span<const TriangleTree::Level> levels = tree.levels();
    if (levels.empty()) return;
    if (levels.size() == 1) { // the one block has no parent with its box
        float squared[width];
        if (met_boxes(tree.blocks()[0], query, levels[0].entries, squared) != 0)
            meet(MetBlock{0, *std::ranges::min_element(squared), nullptr, 0});
        return;
    }
    FixedStack<LevelBlock, (width - 1) * TriangleTree::max_levels + 1> pending;
    pending.push({static_cast<std::uint32_t>(levels.size() - 1), 0});
    while (!pending.empty()) {
        const LevelBlock at = pending.pop();
        const TriangleTree::Level& level = levels[at.level];
        const TriangleTreeBlock& boxes = tree.blocks()[level.first_block + at.block];
        const std::uint32_t first = at.block * width;
        float squared[width];
        std::uint32_t met = met_boxes(boxes, query, level.entries - first, squared);
        if (at.level == 1) {
            for (; met != 0; met &= met - 1) {
                const auto lane = static_cast<std::uint32_t>(std::countr_zero(met));
                if (!meet(MetBlock{first + lane, squared[lane], &boxes, lane})) return;
            }
            continue;
        }
        while (met != 0) {
            const auto lane = static_cast<std::uint32_t>(std::bit_width(met)) - 1;
            met &= ~(1U << lane);
            pending.push({at.level - 1, first + lane});
        }
    }
}

std::size_t count_blocks(const TriangleTree& tree, const BallQuery& query, std::uint32_t* counts)
{
    std::size_t count = 0;
    visit_blocks(tree, query, [&](const MetBlock& met) {
        ++counts[DistanceCounts::bin_of(met.squared)];
        ++count;
        return true;
    });
    return count;
}

void take_blocks(const TriangleTree& tree, const BallQuery& query, const NearBlocks& to)
{
    constexpr std::size_t width = TriangleTree::width;
    std::size_t taken = 0;
    visit_blocks(tree, query, [&](const MetBlock& met) {
        if (taken == to.ids.size()) return false;
        to.ids[taken] = met.number;
        to.blocks[taken] = tree.blocks()[met.number];
        if (met.boxes != nullptr) {
            TriangleTreeBlock& parent = to.parents[taken / width];
            for (std::size_t axis = 0; axis < 3; ++axis) {
                parent.lower[axis][taken % width] = met.boxes->lower[axis][met.lane];
                parent.upper[axis][taken % width] = met.boxes->upper[axis][met.lane];
            }
        }
        ++taken;
        return true;
    });
}

} // namespace proxima::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace proxima {

HWY_EXPORT(count_blocks);
HWY_EXPORT(take_blocks);

namespace {
constexpr std::size_t triangles_per_block = std::size_t{TriangleTree::width} * TriangleTree::width;
} // namespace

NearGroups::NearGroups(std::size_t triangles)
    : ids_(std::max<std::size_t>(1, (triangles + triangles_per_block - 1) / triangles_per_block)),
      // One block more than a tree of one block has: take_blocks may write a parent.
      blocks_(
          TriangleTree::block_count(static_cast<std::uint32_t>(ids_.size() * triangles_per_block)) +
          1),
      counts_(DistanceCounts::size)
{}

/// A squared distance within which all blocks that were counted fit the capacity.
float NearGroups::distance_that_fits() const noexcept
{
    std::size_t bin = 0;
    std::size_t blocks = 0;
    while (bin < counts_.size() && blocks + counts_[bin] <= ids_.size()) blocks += counts_[bin++];
    return DistanceCounts::below(bin);
}

NearGroups::Found NearGroups::find(const TriangleTree& tree, const Vec3& p,
                                   double distance) noexcept
{
    const auto count = [&](const BallQuery& query) {
        std::ranges::fill(counts_, 0U);
        return HWY_DYNAMIC_DISPATCH(count_blocks)(tree, query, counts_.data());
    };
    Found found{.reach = distance};
    BallQuery query = ball_query(tree, p, distance);
    std::size_t blocks = count(query);
    if (blocks > ids_.size()) {
        found = {.reach = ball_reach(tree, p, distance_that_fits()), .complete = false};
        query = ball_query(tree, p, found.reach);
        blocks = count(query);
        if (blocks > ids_.size()) found.reach = 0;
    }
    blocks = std::min(blocks, ids_.size());
    origin_ = tree.origin();
    scale_ = tree.scale();
    reach_ = tree.reach();
    triangle_count_ = 0;
    if (blocks == 0) return found;
    const std::size_t parents = (blocks + TriangleTree::width - 1) / TriangleTree::width;
    std::fill_n(blocks_.begin() + static_cast<std::ptrdiff_t>(blocks), parents,
                detail::empty_block());
    HWY_DYNAMIC_DISPATCH(take_blocks)
    (tree, query, {std::span(ids_).first(blocks), blocks_.data(), blocks_.data() + blocks});
    const std::size_t last = std::size_t{ids_[blocks - 1]} * triangles_per_block;
    triangle_count_ = static_cast<std::uint32_t>(
        (blocks - 1) * triangles_per_block +
        std::min<std::size_t>(triangles_per_block, tree.triangle_count() - last));
    const TriangleTree near = this->tree();
    const std::span<const TriangleTree::Level> levels = near.levels();
    if (levels.size() > 2) {
        const std::size_t above = levels[2].first_block;
        std::fill(blocks_.begin() + static_cast<std::ptrdiff_t>(above),
                  blocks_.begin() + static_cast<std::ptrdiff_t>(near.blocks().size()),
                  detail::empty_block());
        detail::fill_parents(levels, 2, blocks_);
    }
    return found;
}

TriangleTree NearGroups::tree() const noexcept
{
    const std::size_t count = TriangleTree::block_count(triangle_count_);
    return TriangleTree::adopt(origin_, scale_, reach_, triangle_count_,
                               std::span(blocks_).first(count), nullptr);
}

} // namespace proxima

#endif
