// Descends a triangle tree depth first, nearest child first, eight boxes at a time.
#include "base/fixed_stack.h"
#include "haptics/surface/triangle_tree.h"

#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "haptics/surface/triangle_tree_search.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace proxima::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

/// A box in the tree's units.
struct TreeQuery {
    double lower[3];
    double upper[3];
};

/// A block of the tree yet to be entered, and its squared distance. Not initialised: stacks of them
/// are made for every query.
struct PendingBlock {
    double squared;
    std::uint32_t block; // of its level
    std::uint32_t level;
};

/// An entry of a block.
struct NearEntry {
    double squared;
    std::uint32_t entry; // of its level
};

/// Squared distances of the eight boxes from the query.
HWY_INLINE void box_distances(const TriangleTreeBlock& block, const TreeQuery& query,
                              double (&squared)[TriangleTree::width])
{
    const hn::CappedTag<double, TriangleTree::width> d;
    const hn::Rebind<float, decltype(d)> df;
    const auto zero = hn::Zero(d);
    for (std::size_t i = 0; i < TriangleTree::width; i += hn::Lanes(d)) {
        auto sum = zero;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const auto lower = hn::PromoteTo(d, hn::Load(df, block.lower[axis].data() + i));
            const auto upper = hn::PromoteTo(d, hn::Load(df, block.upper[axis].data() + i));
            const auto before = hn::Sub(lower, hn::Set(d, query.upper[axis]));
            const auto behind = hn::Sub(hn::Set(d, query.lower[axis]), upper);
            const auto gap = hn::Max(hn::Max(before, behind), zero);
            sum = hn::Add(sum, hn::Mul(gap, gap));
        }
        hn::StoreU(sum, d, squared + i);
    }
}

/// The squared bound in the tree's units: greater by more than distances to boxes are rounded.
HWY_INLINE double limit_of(double bound_squared, double scale)
{
    if (bound_squared < 0) return -1;
    return bound_squared * scale * scale * (1 + 0x1p-45) + std::numeric_limits<double>::min();
}

void visit_nearest(const TriangleTree& tree, const Box& box, double bound_squared,
                   detail::VisitRanks visit, void* context)
{
    constexpr std::uint32_t width = TriangleTree::width;
    const std::span<const TriangleTree::Level> levels = tree.levels();
    if (levels.empty()) return;
    const double scale = tree.scale();
    TreeQuery query;
    for (int axis = 0; axis < 3; ++axis) {
        query.lower[axis] = (box.lower[axis] - tree.origin()[axis]) * scale;
        query.upper[axis] = (box.upper[axis] - tree.origin()[axis]) * scale;
    }
    double limit = limit_of(bound_squared, scale);
    // Entering a block replaces it by eight at most.
    FixedStack<PendingBlock, (width - 1) * TriangleTree::max_levels + 1> pending;
    pending.push({0.0, 0, static_cast<std::uint32_t>(levels.size() - 1)});
    while (!pending.empty()) {
        const PendingBlock at = pending.pop();
        if (at.squared > limit) continue;
        const TriangleTree::Level& level = levels[at.level];
        double squared[width];
        box_distances(tree.blocks()[level.first_block + at.block], query, squared);

        NearEntry near[width];
        std::size_t count = 0;
        const std::uint32_t first = at.block * width;
        const std::uint32_t entries = HWY_MIN(width, level.entries - first);
        for (std::uint32_t i = 0; i < entries; ++i) {
            if (squared[i] > limit) continue;
            std::size_t position = count++;
            for (; position > 0 && near[position - 1].squared > squared[i]; --position) {
                near[position] = near[position - 1];
            }
            near[position] = {squared[i], first + i};
        }
        if (at.level > 0) {
            for (std::size_t i = count; i-- > 0;) {
                pending.push({near[i].squared, near[i].entry, at.level - 1});
            }
            continue;
        }
        for (std::size_t i = 0; i < count && near[i].squared <= limit; ++i) {
            const std::uint32_t rank = near[i].entry * width;
            const std::uint32_t ranks = HWY_MIN(width, tree.triangle_count() - rank);
            limit = limit_of(visit(context, {rank, ranks}), scale);
        }
    }
}

} // namespace proxima::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace proxima {

HWY_EXPORT(visit_nearest);

void detail::visit_nearest(const TriangleTree& tree, const Box& query, double bound_squared,
                           VisitRanks visit, void* context) noexcept
{
    HWY_DYNAMIC_DISPATCH(visit_nearest)(tree, query, bound_squared, visit, context);
}

} // namespace proxima

#endif
