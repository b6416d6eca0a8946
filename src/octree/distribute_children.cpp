#include "octree/distribute_children.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "octree/distribute_children.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
// After them: it is read once for every instruction set.
#include "base/compress-inl.h"

#include <bit>

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

std::uint64_t count_children(const std::uint32_t* masks, std::size_t count)
{
    const Tag tag;
    std::uint64_t total = 0;
    // A lane adds at most 8 per step: it cannot overflow within one run.
    constexpr std::size_t run = std::size_t{1} << 24;
    for (std::size_t first = 0; first < count; first += run) {
        const std::size_t end = HWY_MIN(count, first + run);
        auto sums = hn::Zero(tag);
        for (std::size_t block = first; block < end; block += hn::Lanes(tag)) {
            auto bits = load_masks(masks + block, end - block);
            bits = hn::Sub(bits, hn::And(hn::ShiftRight<1>(bits), hn::Set(tag, 0x55)));
            bits = hn::Add(hn::And(bits, hn::Set(tag, 0x33)),
                           hn::And(hn::ShiftRight<2>(bits), hn::Set(tag, 0x33)));
            bits = hn::And(hn::Add(bits, hn::ShiftRight<4>(bits)), hn::Set(tag, 0x0F));
            sums = hn::Add(sums, bits);
        }
        total += hn::GetLane(hn::SumOfLanes(tag, sums));
    }
    return total;
}

/// Calls visit(block, mask of its lanes) for the blocks of a cell; lanes beyond the cell are 0.
template <class Visit>
HWY_INLINE void for_each_block(const SplitCell& cell, const std::uint32_t* masks,
                               const Visit& visit)
{
    const Tag tag;
    std::size_t block = 0;
    for (; block + hn::Lanes(tag) <= cell.count; block += hn::Lanes(tag)) {
        visit(block, hn::LoadU(tag, masks + block));
    }
    if (block < cell.count) visit(block, load_masks(masks + block, cell.count - block));
}

/// How many of the cell's triangles each child gets.
HWY_INLINE void count_triangles(const SplitCell& cell, const std::uint32_t* masks,
                                std::array<std::uint32_t, 8>& counts)
{
    counts = {};
    for_each_block(cell, masks, [&](std::size_t, hn::Vec<Tag> mask) {
        for (int child = 0; child < 8; ++child) {
            counts[child] += static_cast<std::uint32_t>(hn::CountTrue(Tag(), touches(mask, child)));
        }
    });
}

/// Writes the child's triangles to `out`, in order; up to a block of lanes behind them is spoilt.
HWY_INLINE void copy_triangles(const SplitCell& cell, const std::uint32_t* masks,
                               const std::uint32_t* triangles, int child, std::uint32_t* out)
{
    const Tag tag;
    for_each_block(cell, masks, [&](std::size_t block, hn::Vec<Tag> mask) {
        const auto touching = touches(mask, child);
        hn::StoreU(compress(hn::LoadU(tag, triangles + block), touching), tag, out);
        out += hn::CountTrue(tag, touching);
    });
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

/// Writes children of one level; all arrays can hold everything that the level can produce.
class ChildWriter {
public:
    ChildWriter(const SplitRule& rule, SplitLevel& next, OctreeOutput& output)
        : rule_(rule), next_(next), nodes_(output.nodes.data()),
          node_count_(static_cast<std::uint32_t>(output.nodes.size())),
          references_(reinterpret_cast<std::uint32_t*>(output.references.data())),
          reference_count_(static_cast<std::uint32_t>(output.references.size()))
    {}

    [[nodiscard]] std::uint32_t node_count() const { return node_count_; }
    [[nodiscard]] std::uint32_t reference_count() const { return reference_count_; }
    [[nodiscard]] OctreeNode& node(std::uint32_t record) { return nodes_[record]; }

    /// Opens a leaf or a cell of the next level and returns where its triangles go.
    HWY_INLINE std::uint32_t* open(const SplitCell& parent, int child, std::uint32_t count)
    {
        if (rule_.children_are_deepest || count <= rule_.threshold) {
            nodes_[node_count_++] = OctreeNode::leaf(reference_count_, count);
            std::uint32_t* const out = references_ + reference_count_;
            reference_count_ += count;
            return out;
        }
        const SignedTag tag;
        SplitCell cell;
        cell.record = node_count_++;
        cell.first = static_cast<std::uint32_t>(next_.pair_count);
        cell.count = count;
        for (int axis = 0; axis < 3; ++axis) {
            const bool upper = (static_cast<unsigned>(child) >> axis & 1U) != 0;
            cell.center[axis] =
                parent.center[axis] + (upper ? rule_.child_half : -rule_.child_half);
            std::int32_t* const centers = next_.center[axis].data() + cell.first;
            const auto center = hn::Set(tag, cell.center[axis]);
            for (std::size_t block = 0; block < count; block += hn::Lanes(tag)) {
                hn::StoreU(center, tag, centers + block);
            }
        }
        next_.cells.push_back(cell);
        next_.pair_count += count;
        return next_.triangle.data() + cell.first;
    }

private:
    const SplitRule& rule_;
    SplitLevel& next_;
    OctreeNode* nodes_;
    std::uint32_t node_count_;
    std::uint32_t* references_;
    std::uint32_t reference_count_;
};

/// Cells whose triangles fit so many blocks of lanes, as most do: everything stays in registers.
template <std::size_t Blocks>
HWY_INLINE std::uint32_t distribute_few(const SplitCell& cell, const std::uint32_t* masks,
                                        const std::uint32_t* triangles, ChildWriter& writer)
{
    const Tag tag;
    hn::Vec<Tag> mask[Blocks];
    hn::Vec<Tag> block[Blocks];
    for (std::size_t i = 0; i < Blocks; ++i) {
        const std::size_t first = i * hn::Lanes(tag);
        mask[i] = load_masks(masks + first, cell.count - first);
        block[i] = hn::LoadU(tag, triangles + first);
    }
    // Which children have triangles is known before the loop over them, which then has no branch
    // that depends on it.
    std::uint32_t counts[8][Blocks];
    std::uint32_t recorded = 0;
    for (int child = 0; child < 8; ++child) {
        std::uint32_t count = 0;
        for (std::size_t i = 0; i < Blocks; ++i) {
            counts[child][i] =
                static_cast<std::uint32_t>(hn::CountTrue(tag, touches(mask[i], child)));
            count += counts[child][i];
        }
        recorded |= static_cast<std::uint32_t>(count != 0) << child;
    }
    for (std::uint32_t left = recorded; left != 0; left &= left - 1) {
        const int child = std::countr_zero(left);
        std::uint32_t count = 0;
        for (std::size_t i = 0; i < Blocks; ++i) count += counts[child][i];
        std::uint32_t* out = writer.open(cell, child, count);
        for (std::size_t i = 0; i < Blocks; ++i) {
            hn::StoreU(compress(block[i], touches(mask[i], child)), tag, out);
            out += counts[child][i];
        }
    }
    return recorded;
}

HWY_INLINE std::uint32_t distribute_blocks(const SplitCell& cell, const std::uint32_t* masks,
                                           const std::uint32_t* triangles, ChildWriter& writer)
{
    std::array<std::uint32_t, 8> counts;
    count_triangles(cell, masks, counts);
    std::uint32_t recorded = 0;
    for (int child = 0; child < 8; ++child) {
        if (counts[child] == 0) continue;
        recorded |= 1U << child;
        copy_triangles(cell, masks, triangles, child, writer.open(cell, child, counts[child]));
    }
    return recorded;
}

void distribute_children(const SplitLevel& level, const std::uint32_t* masks,
                         std::uint64_t child_count, const std::uint32_t* ids, const SplitRule& rule,
                         SplitLevel& next, OctreeOutput& output, OctreeNode& root)
{
    const std::size_t first_reference = output.references.size();
    output.nodes.reserve(output.nodes.size() + HWY_MIN(8 * level.cells.size(), child_count));
    output.references.reserve(first_reference + child_count + lane_padding);
    next.reset(child_count);
    ChildWriter writer(rule, next, output);
    for (const SplitCell& cell : level.cells) {
        const std::uint32_t first_child = writer.node_count();
        const std::uint32_t* const cell_masks = masks + cell.first;
        const std::uint32_t* const triangles = level.triangle.data() + cell.first;
        const std::size_t lanes = hn::Lanes(Tag());
        const std::uint32_t recorded =
            cell.count <= lanes       ? distribute_few<1>(cell, cell_masks, triangles, writer)
            : cell.count <= 2 * lanes ? distribute_few<2>(cell, cell_masks, triangles, writer)
                                      : distribute_blocks(cell, cell_masks, triangles, writer);
        (cell.record == SplitCell::no_record ? root : writer.node(cell.record)) =
            OctreeNode::split(first_child, recorded);
    }
    output.nodes.resize(writer.node_count());
    output.references.resize(writer.reference_count());
    next.pad();
    translate(ids, reinterpret_cast<std::uint32_t*>(output.references.data()) + first_reference,
              output.references.size() - first_reference);
}

} // namespace proxima::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace proxima {

HWY_EXPORT(distribute_children);
HWY_EXPORT(count_children);

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
                         std::uint64_t child_count, const std::uint32_t* ids, const SplitRule& rule,
                         SplitLevel& next, OctreeOutput& output, OctreeNode& root)
{
    HWY_DYNAMIC_DISPATCH(distribute_children)
    (level, masks, child_count, ids, rule, next, output, root);
}

std::uint64_t count_children(const std::uint32_t* masks, std::size_t count) noexcept
{
    return HWY_DYNAMIC_DISPATCH(count_children)(masks, count);
}

} // namespace proxima

#endif
