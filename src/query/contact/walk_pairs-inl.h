// The walk through two mesh indexes at once (thesis section 5.2): of every pair of blocks that may
// meet, the larger one gives way to its children. Included once per target, after <hwy/highway.h>.

#if defined(PROXIMA_QUERY_WALK_PAIRS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef PROXIMA_QUERY_WALK_PAIRS_INL_H
#undef PROXIMA_QUERY_WALK_PAIRS_INL_H
#else
#define PROXIMA_QUERY_WALK_PAIRS_INL_H
#endif

#include "index/index_parts.h"
#include "query/contact/box_pairs-inl.h"
#include "query/contact/leaf_intersection-inl.h"

#include <bit>
#include <cstddef>
#include <cstdint>
#include <hwy/cache_control.h>
#include <hwy/highway.h>
#include <utility>

HWY_BEFORE_NAMESPACE();
namespace proxima::HWY_NAMESPACE {

HWY_INLINE void fetch_ahead(const IndexBlock& block)
{
    hwy::Prefetch(&block);
    hwy::Prefetch(reinterpret_cast<const std::byte*>(&block) + 64);
}

/// Blocks of both meshes that may meet.
struct BlockPair {
    PairBox sides[2];
};

/// Bit i: child i is a leaf.
HWY_INLINE std::uint32_t leaf_slots(const IndexNode& node)
{
    static_assert(index_leaf_bit == 1U << 31U);
    const EightWordTag words;
    EightMask leaves;
    for (std::size_t i = 0; i < eight_parts; ++i) {
        const auto references = hn::LoadU(words, node.children.data() + eight_lanes * i);
        leaves.part[i] = hn::MaskFromVec(hn::BitCast(
            EightTag(),
            hn::BroadcastSignBit(hn::BitCast(hn::RebindToSigned<EightTag>(), references))));
    }
    return leaves.bits();
}

/// Tells `search` of a pair of triangles, of the leaf of one side and one of the other.
template <class Search>
class RowsOfLeaves {
public:
    HWY_INLINE RowsOfLeaves(Search& search, std::size_t own_side, const IndexLeaf& own,
                            const IndexLeaf& other)
        : search_(search), own_side_(own_side), own_(own.first_row), other_(other.first_row)
    {}
    HWY_INLINE bool operator()(std::uint32_t i, std::uint32_t j, bool sure) const
    {
        return own_side_ == 0 ? search_.take(own_ + i, other_ + j, sure)
                              : search_.take(other_ + j, own_ + i, sure);
    }

private:
    Search& search_;
    std::size_t own_side_;
    std::uint32_t own_;
    std::uint32_t other_;
};

/// Calls search.take(row_a, row_b, sure) for all pairs of triangles that meet (sure) or may, until
/// it returns false; then false. Where the search has deepest_first, it goes on with the child that
/// lies deepest in the other box.
template <class Search>
HWY_INLINE bool walk_pairs(const ContactSearch& open, Search& search)
{
    BlockPair stack[ContactSearch::stack_size];
    std::size_t pending = 0;
    OwnLeaf own;
    {
        BlockPair& root = stack[pending++];
        for (std::size_t side = 0; side < 2; ++side) {
            const float half = 1.01F * open.sides[side].unit;
            PairBox& box = root.sides[side];
            box = {{0, 0, 0}, {half, half, half}, open.sides[side].index->root(), 3 * half};
            if (is_leaf(box)) box.size = leaf_size;
        }
        if (is_leaf(root.sides[0]) && is_leaf(root.sides[1])) {
            const IndexLeaf& leaf =
                open.sides[0].blocks[root.sides[0].reference & ~index_leaf_bit].leaf;
            const IndexLeaf& other =
                open.sides[1].blocks[root.sides[1].reference & ~index_leaf_bit].leaf;
            take_own_leaf(open, 0, leaf, own);
            return meet_leaves(open, 0, own, other, RowsOfLeaves(search, 0, leaf, other));
        }
    }
    while (pending > 0) {
        const BlockPair& at = stack[--pending];
        const std::size_t side = at.sides[0].size < at.sides[1].size ? 1 : 0;
        const PairBox other = at.sides[1 - side]; // overwritten below
        const IndexBlock* const blocks = open.sides[side].blocks;
        const IndexNode& node = blocks[at.sides[side].reference].node;
        MetBoxes boxes;
        std::uint32_t met =
            meet_boxes(node, open.sides[side].unit, open.frames[side], other, boxes);
        if (met == 0) continue;
        std::uint32_t leaves = 0;
        if (is_leaf(other)) {
            const IndexLeaf& leaf =
                open.sides[1 - side].blocks[other.reference & ~index_leaf_bit].leaf;
            // The same for siblings, which follow each other.
            if (own.leaf != &leaf || own.side == side) take_own_leaf(open, 1 - side, leaf, own);
            met &= meet_slab(own, boxes, 2 * open.frames[side].slack);
            leaves = met & leaf_slots(node);
            met ^= leaves;
        }
        for (std::uint32_t left = leaves; left != 0; left &= left - 1) {
            const auto slot = static_cast<std::size_t>(std::countr_zero(left));
            fetch_ahead(blocks[node.children[slot] & ~index_leaf_bit]);
        }
        if (met != 0) {
            PairBox children[8];
            boxes.store(node, children);
            HWY_ALIGN float most[8];
            if (Search::deepest_first) store_eight(boxes.most, most);
            std::size_t deepest = pending;
            float least = 0;
            for (; met != 0; met &= met - 1) {
                const auto slot = static_cast<std::uint32_t>(std::countr_zero(met));
                fetch_ahead(blocks[node.children[slot] & ~index_leaf_bit]);
                if (Search::deepest_first && most[slot] < least) {
                    least = most[slot];
                    deepest = pending;
                }
                BlockPair& next = stack[pending++];
                next.sides[side] = children[slot];
                next.sides[1 - side] = other;
            }
            if (Search::deepest_first) std::swap(stack[deepest], stack[pending - 1]);
        }
        for (; leaves != 0; leaves &= leaves - 1) {
            const auto slot = static_cast<std::size_t>(std::countr_zero(leaves));
            const IndexLeaf& leaf = blocks[node.children[slot] & ~index_leaf_bit].leaf;
            if (!meet_leaves(open, 1 - side, own, leaf,
                             RowsOfLeaves(search, 1 - side, *own.leaf, leaf)))
                return false;
        }
    }
    return true;
}

} // namespace proxima::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
