#include "proxima/octree/distribute_children.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "proxima/octree/distribute_children.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace proxima::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using Tag = hn::ScalableTag<std::uint32_t>;
using SignedTag = hn::ScalableTag<std::int32_t>;

/// Lanes of `mask` whose bit `child` is set.
HWY_INLINE hn::Mask<Tag> touches(hn::Vec<Tag> masks, int child)
{
    const Tag tag;
    const auto bit = hn::Set(tag, 1U << child);
    return hn::Ne(hn::And(masks, bit), hn::Zero(tag));
}

/// Masks of a block of pairs of one cell; lanes beyond the cell are 0.
HWY_INLINE hn::Vec<Tag> load_masks(const std::uint32_t* masks, std::size_t left)
{
    const Tag tag;
    return hn::IfThenElseZero(hn::FirstN(tag, left), hn::LoadU(tag, masks));
}

/// How many of the cell's triangles each child gets.
HWY_INLINE void count_triangles(const SplitCell& cell, const std::uint32_t* masks,
                                std::array<std::uint32_t, 8>& counts)
{
    const Tag tag;
    counts = {};
    for (std::size_t block = 0; block < cell.count; block += hn::Lanes(tag)) {
        const auto mask = load_masks(masks + block, cell.count - block);
        for (int child = 0; child < 8; ++child) {
            counts[child] += static_cast<std::uint32_t>(hn::CountTrue(tag, touches(mask, child)));
        }
    }
}

/// Writes the child's triangles to `out`, in order; up to a block of lanes behind them is spoilt.
HWY_INLINE void copy_triangles(const SplitCell& cell, const std::uint32_t* masks,
                               const std::uint32_t* triangles, int child, std::uint32_t* out)
{
    const Tag tag;
    for (std::size_t block = 0; block < cell.count; block += hn::Lanes(tag)) {
        const auto touching = touches(load_masks(masks + block, cell.count - block), child);
        hn::StoreU(hn::Compress(hn::LoadU(tag, triangles + block), touching), tag, out);
        out += hn::CountTrue(tag, touching);
    }
}

/// Replaces indices within the subtree by triangle ids.
HWY_INLINE void translate(const std::uint32_t* ids, std::uint32_t* triangles, std::size_t count)
{
    const Tag tag;
    const SignedTag signed_tag;
    for (std::size_t block = 0; block < count; block += hn::Lanes(tag)) {
        const auto is_triangle = hn::FirstN(tag, count - block);
        const auto local = hn::IfThenElseZero(is_triangle, hn::LoadU(tag, triangles + block));
        const auto global = hn::GatherIndex(tag, ids, hn::BitCast(signed_tag, local));
        hn::StoreU(global, tag, triangles + block);
    }
}

/// Opens the child as a cell of the next level and returns where its triangles go.
HWY_INLINE std::uint32_t* open_cell(const SplitCell& parent, int child, std::uint32_t count,
                                    std::uint32_t record, std::int32_t child_half,
                                    SplitLevel& next)
{
    const SignedTag tag;
    SplitCell cell;
    cell.record = record;
    cell.first = static_cast<std::uint32_t>(next.pair_count);
    cell.count = count;
    for (int axis = 0; axis < 3; ++axis) {
        const bool upper = (static_cast<unsigned>(child) >> axis & 1U) != 0;
        cell.center[axis] = parent.center[axis] + (upper ? child_half : -child_half);
        std::int32_t* const centers = next.center[axis].data() + cell.first;
        const auto center = hn::Set(tag, cell.center[axis]);
        for (std::size_t block = 0; block < count; block += hn::Lanes(tag)) {
            hn::StoreU(center, tag, centers + block);
        }
    }
    next.cells.push_back(cell);
    next.pair_count += count;
    return next.triangle.data() + cell.first;
}

void distribute_children(const SplitLevel& level, const std::uint32_t* masks,
                         const std::uint32_t* ids, const SplitRule& rule, SplitLevel& next,
                         OctreeOutput& output, OctreeNode& root)
{
    for (const SplitCell& cell : level.cells) {
        const std::uint32_t* const cell_masks = masks + cell.first;
        const std::uint32_t* const triangles = level.triangle.data() + cell.first;
        std::array<std::uint32_t, 8> counts;
        count_triangles(cell, cell_masks, counts);
        std::size_t total = 0;
        for (const std::uint32_t count : counts) total += count;

        const auto first_child = static_cast<std::uint32_t>(output.nodes.size());
        const std::size_t first_reference = output.references.size();
        output.nodes.reserve(first_child + 8);
        output.references.reserve(first_reference + total + lane_padding);
        auto* const references = reinterpret_cast<std::uint32_t*>(output.references.data());
        std::size_t end_reference = first_reference;
        std::uint32_t recorded = 0;
        for (int child = 0; child < 8; ++child) {
            const std::uint32_t count = counts[child];
            if (count == 0) continue;
            recorded |= 1U << child;
            std::uint32_t* out = nullptr;
            if (rule.children_are_deepest || count <= rule.threshold) {
                out = references + end_reference;
                output.nodes.push_back(
                    OctreeNode::leaf(static_cast<std::uint32_t>(end_reference), count));
                end_reference += count;
            } else {
                const auto record = static_cast<std::uint32_t>(output.nodes.size());
                output.nodes.push_back(OctreeNode{});
                out = open_cell(cell, child, count, record, rule.child_half, next);
            }
            copy_triangles(cell, cell_masks, triangles, child, out);
        }
        translate(ids, references + first_reference, end_reference - first_reference);
        output.references.resize(end_reference);
        (cell.record == SplitCell::no_record ? root : output.nodes[cell.record]) =
            OctreeNode::split(first_child, recorded);
    }
}

} // namespace proxima::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace proxima {

HWY_EXPORT(distribute_children);

void SplitLevel::reset(std::size_t pair_capacity)
{
    cells.clear();
    pair_count = 0;
    triangle.resize(pair_capacity + lane_padding);
    for (auto& axis : center) axis.resize(pair_capacity + lane_padding);
}

void SplitLevel::pad()
{
    for (std::size_t lane = 0; lane < lane_padding; ++lane) {
        triangle[pair_count + lane] = 0;
        for (auto& axis : center) axis[pair_count + lane] = 0;
    }
}

SnappedPairs SplitLevel::pairs() const noexcept
{
    return {triangle.data(), {center[0].data(), center[1].data(), center[2].data()}, pair_count};
}

void distribute_children(const SplitLevel& level, const std::uint32_t* masks,
                         const std::uint32_t* ids, const SplitRule& rule, SplitLevel& next,
                         OctreeOutput& output, OctreeNode& root)
{
    HWY_DYNAMIC_DISPATCH(distribute_children)(level, masks, ids, rule, next, output, root);
}

std::uint64_t count_children(const std::uint32_t* masks, std::size_t count) noexcept
{
    std::uint64_t children = 0;
    for (std::size_t pair = 0; pair < count; ++pair) {
        children += static_cast<std::uint64_t>(std::popcount(masks[pair]));
    }
    return children;
}

} // namespace proxima

#endif
