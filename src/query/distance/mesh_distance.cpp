#include "proxima/mesh_distance.h"

#include "base/fixed_stack.h"
#include "index/index_parts.h"
#include "query/distance/distance_search.h"
#include "query/distance/near_rows.h"

#include <algorithm>
#include <bit>
#include <cstddef>
#include <hwy/cache_control.h>
#include <span>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "query/distance/mesh_distance.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
// After them: it is read once for every instruction set.
#include "query/distance/leaf_distance-inl.h"

HWY_BEFORE_NAMESPACE();
namespace proxima::HWY_NAMESPACE {

/// Branch and bound over pairs of blocks, the nearest of a node's children first.
template <class T>
class PairWalk {
public:
    explicit PairWalk(DistanceSearch& search) : search_(search), pose_(search) {}

    /// Leaves noted pairs to be settled, but for where two touch or it is cancelled: then it returns
    /// true.
    bool run()
    {
        constexpr BlockBox root = {{0, 0, 0}, {1.01F, 1.01F, 1.01F}};
        pending_.push({0, search_.a.root(), search_.b.root(), scaled(root, search_.a_scale),
                       scaled(root, search_.b_scale)});
        while (!pending_.empty()) {
            const PendingPair at = pending_.pop();
            if (at.bound > squared_limit()) continue;
            if (search_.is_cancelled()) return true;
            const bool leaf_a = (at.reference_a & index_leaf_bit) != 0;
            const bool leaf_b = (at.reference_b & index_leaf_bit) != 0;
            if (leaf_a && leaf_b) {
                if (look_at_leaves(at)) return true;
            } else if (leaf_b || (!leaf_a && size_of(at.box_a) >= size_of(at.box_b))) {
                open_a(at);
            } else {
                open_b(at);
            }
        }
        return false;
    }

private:
    static BlockBox scaled(BlockBox box, float scale)
    {
        for (float& half : box.half) half *= scale;
        return box;
    }
    static float size_of(const BlockBox& box)
    {
        return std::max({box.half[0], box.half[1], box.half[2]});
    }
    /// Above every squared bound, as rounded, of what is within the limit.
    [[nodiscard]] T squared_limit() const
    {
        const double limit = search_.limit();
        return static_cast<T>(limit * limit * (1 + 16 * double{std::numeric_limits<T>::epsilon()}));
    }

    void open_a(const PendingPair& at)
    {
        const IndexNode& node = search_.a.blocks()[at.reference_a].node;
        const ChildBoxes boxes(node, search_.a_scale);
        T squared[8];
        const ChildSlabs slabs(search_.a, node);
        const OneSlab one(search_.b, at.reference_b);
        const std::uint32_t within = bound_pairs(
            pose_, LaneBoxes<T>{boxes, slabs}, OneBox<T>{at.box_b, one}, squared_limit(), squared);
        push_nearest(within, squared, [&](std::size_t slot) {
            prefetch(search_.a, node.children[slot]);
            return PendingPair{squared[slot], node.children[slot], at.reference_b, boxes[slot],
                               at.box_b};
        });
    }
    void open_b(const PendingPair& at)
    {
        const IndexNode& node = search_.b.blocks()[at.reference_b].node;
        const ChildBoxes boxes(node, search_.b_scale);
        T squared[8];
        const ChildSlabs slabs(search_.b, node);
        const OneSlab one(search_.a, at.reference_a);
        const std::uint32_t within = bound_pairs(
            pose_, OneBox<T>{at.box_a, one}, LaneBoxes<T>{boxes, slabs}, squared_limit(), squared);
        push_nearest(within, squared, [&](std::size_t slot) {
            prefetch(search_.b, node.children[slot]);
            return PendingPair{squared[slot], at.reference_a, node.children[slot], at.box_a,
                               boxes[slot]};
        });
    }

    template <class PairOf>
    void push_nearest(std::uint32_t within, const T (&squared)[8], const PairOf& pair_of)
    {
        std::uint8_t order[8]; // farthest first
        std::size_t count = 0;
        for (; within != 0; within &= within - 1) {
            const auto slot = static_cast<std::uint8_t>(std::countr_zero(within));
            std::size_t position = count++;
            for (; position > 0 && squared[order[position - 1]] < squared[slot]; --position)
                order[position] = order[position - 1];
            order[position] = slot;
        }
        for (std::size_t i = 0; i < count; ++i) pending_.push(pair_of(order[i]));
    }

    static void prefetch(const IndexParts& index, std::uint32_t reference)
    {
        const IndexBlock& block = index.blocks()[reference & ~index_leaf_bit];
        hwy::Prefetch(&block);
        hwy::Prefetch(reinterpret_cast<const std::byte*>(&block) + 64);
    }

    bool look_at_leaves(const PendingPair& at)
    {
        const IndexLeaf& leaf_a = search_.a.blocks()[at.reference_a & ~index_leaf_bit].leaf;
        const IndexLeaf& leaf_b = search_.b.blocks()[at.reference_b & ~index_leaf_bit].leaf;
        const auto center = [](const BlockBox& box) {
            return Vec3(double{box.center[0]}, double{box.center[1]}, double{box.center[2]});
        };
        return ask_leaves(
            search_, pose_, leaf_a, leaf_b,
            Vec3(search_.rotation * center(at.box_b) + search_.offset - center(at.box_a)));
    }

    DistanceSearch& search_;
    PoseLanes<T> pose_;
    // Opening a block replaces a pair by eight at most, and each mesh has max_levels of them.
    FixedStack<PendingPair, 7 * 2 * IndexParts::max_levels + 1> pending_;
};

bool walk_pairs(DistanceSearch& search)
{
    return search.needs_doubles() ? PairWalk<double>(search).run() : PairWalk<float>(search).run();
}

} // namespace proxima::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace proxima {

HWY_EXPORT(walk_pairs);

std::optional<MeshDistance> mesh_distance(const MeshIndex& a, const MeshIndex& b,
                                          const RigidTransform& pose_b,
                                          const MeshDistanceOptions& options) noexcept
{
    if (a.triangle_count() == 0 || b.triangle_count() == 0 || !(options.farthest >= 0))
        return std::nullopt;
    DistanceSearch search(a.parts(), b.parts(), pose_b, options.farthest);
    search.watch(options.progress);
    const MeshDistance* const start = options.start_from;
    const bool touch = start != nullptr && search.ask(start->row_a, start->row_b);
    if (search.needs_no_walk()) {
        (void)search.ask(0, 0);
    } else if (!touch && !HWY_DYNAMIC_DISPATCH(walk_pairs)(search)) {
        (void)search.settle();
    }
    if (!search.found() || search.is_cancelled()) return std::nullopt;
    return search.best();
}

NearRowsAnswer near_rows(const MeshIndex& a, const MeshIndex& b, const RigidTransform& pose_b,
                         double distance, std::span<NearRows> rows) noexcept
{
    if (a.triangle_count() == 0 || b.triangle_count() == 0) return {};
    DistanceSearch search(a.parts(), b.parts(), pose_b, distance);
    if (search.needs_no_walk()) return {};
    NearRowsList list = {rows, {}};
    search.keep_all(list);
    (void)HWY_DYNAMIC_DISPATCH(walk_pairs)(search);
    return list.answer;
}

} // namespace proxima

#endif
