#include "haptics/surface/find_groups.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "haptics/surface/find_groups.cpp"
#include <hwy/cache_control.h>
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
// After foreach_target, for it is included once per target.
#include "base/compress-inl.h"
#include "haptics/surface/ball_gaps-inl.h"

HWY_BEFORE_NAMESPACE();
namespace proxima::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

/// Stores a whole vector, the lanes of the mask first, and returns how many these are. Compressing
/// stores are slow on some processors.
template <class Lanes, class Mask, class Scalar>
HWY_INLINE std::size_t store_met(Lanes lanes, Mask mask, Scalar* to)
{
    const hn::DFromV<Lanes> d;
    hn::StoreU(compress(lanes, mask), d, to);
    return hn::CountTrue(d, mask);
}

void find_groups(const TriangleTree& tree, const BallQuery& query, GroupBoxes& boxes)
{
    constexpr std::size_t width = TriangleTree::width;
    constexpr std::size_t capacity =
        2 * GroupBoxes::capacity; // blocks of a level that the ball meets
    const BallTag d;
    const hn::Rebind<std::uint32_t, BallTag> di;
    const std::span<const TriangleTree::Level> levels = tree.levels();
    boxes.count = 0;
    if (levels.empty()) return;
    std::uint32_t met[2][capacity + width]; // blocks of this level, and of the one below
    met[0][0] = 0;
    std::size_t count = 1;
    std::size_t now = 0;
    for (std::size_t level = levels.size(); --level > 0; now = 1 - now) {
        const TriangleTreeBlock* const blocks = tree.blocks().data() + levels[level].first_block;
        const TriangleTreeBlock* const below = tree.blocks().data() + levels[level - 1].first_block;
        const std::uint32_t entries = levels[level].entries;
        std::size_t next = 0;
        for (std::size_t i = 0; i < count; ++i) {
            const std::uint32_t first = met[now][i] * width;
            for (std::size_t lane = 0; lane < width; lane += hn::Lanes(d)) {
                const auto at = static_cast<std::uint32_t>(first + lane);
                const auto near = meets_ball(squared_gaps(blocks[met[now][i]], lane, query), query,
                                             entries - HWY_MIN(entries, at));
                next += store_met(hn::Iota(di, at), hn::RebindMask(di, near), met[1 - now] + next);
            }
            if (next > capacity) {
                boxes.count = GroupBoxes::capacity + 1;
                return;
            }
        }
        count = next;
        for (std::size_t i = 0; i < count; ++i) {
            const auto* const line = reinterpret_cast<const std::byte*>(below + met[1 - now][i]);
            for (std::size_t byte = 0; byte < sizeof(TriangleTreeBlock); byte += 64)
                hwy::Prefetch(line + byte);
        }
    }
    const TriangleTreeBlock* const blocks = tree.blocks().data() + levels[0].first_block;
    const std::uint32_t entries = levels[0].entries;
    std::size_t found = 0;
    for (std::size_t i = 0; i < count; ++i) {
        const TriangleTreeBlock& block = blocks[met[now][i]];
        for (std::size_t lane = 0; lane < width; lane += hn::Lanes(d)) {
            // Stores write whole vectors.
            if (found > GroupBoxes::capacity - width) {
                boxes.count = GroupBoxes::capacity + 1;
                return;
            }
            const auto at = static_cast<std::uint32_t>(met[now][i] * width + lane);
            const auto near =
                meets_ball(squared_gaps(block, lane, query), query, entries - HWY_MIN(entries, at));
            for (std::size_t axis = 0; axis < 3; ++axis) {
                store_met(hn::Load(d, block.lower[axis].data() + lane), near,
                          boxes.lower[axis].data() + found);
                store_met(hn::Load(d, block.upper[axis].data() + lane), near,
                          boxes.upper[axis].data() + found);
            }
            found +=
                store_met(hn::Iota(di, at), hn::RebindMask(di, near), boxes.ids.data() + found);
        }
    }
    boxes.count = found;
}

} // namespace proxima::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace proxima {

HWY_EXPORT(find_groups);

void find_groups(const TriangleTree& tree, const Vec3& p, double distance,
                 GroupBoxes& boxes) noexcept
{
    const BallQuery query = ball_query(tree, p, distance);
    HWY_DYNAMIC_DISPATCH(find_groups)(tree, query, boxes);
}

} // namespace proxima

#endif
