#include "query/scene/walk_scene.h"
#include "index/index_parts.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "query/scene/walk_scene.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
// After them: they are read once for every instruction set.
#include "query/rays/prepare_ray-inl.h"
#include "query/rays/walk_ray-inl.h"

HWY_BEFORE_NAMESPACE();
namespace proxima::HWY_NAMESPACE {

RayStart visit_leaves(const IndexParts& tree, const Ray& ray, const SceneLeafVisitor& visitor)
{
    RayTraversal open;
    const RayStart start = open_any_ray(tree, ray, Faces::both, open);
    if (start != RayStart::ready) return start;
    WalkState at = open.at;
    const IndexBlock* const blocks = tree.blocks().data();
    do {
        const IndexBlock& block = blocks[at.next & ~index_leaf_bit];
        if ((at.next & index_leaf_bit) == 0) {
            const MetChildren met = meet_children(block.node, open);
            if (met.bits != 0) {
                enter_nearest(block.node, met, open, at);
            } else {
                leave(open, at);
            }
        } else {
            if (visitor(block.leaf, open) == Flow::stop) return start;
            leave(open, at);
        }
        prefetch_block(blocks[open.references[at.pending - 1] & ~index_leaf_bit]);
    } while (at.next != RayTraversal::end);
    return start;
}

/// Which children's boxes meet the box, by slots; slots without a child may be among them.
PROXIMA_STEP std::uint32_t meet_children(const IndexNode& node, const FloatQueryBox& box)
{
    const RayTag d;
    const std::uint8_t(&shuffles)[3][2][32] = plane_shuffles.bytes[0];
    std::uint32_t met = 0;
    for (std::size_t part = 0; part < 8 / ray_lanes; ++part) {
        const std::size_t own = 4 * ray_lanes * part;
        auto apart = hn::Set(d, 0.0F);
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const auto step = hn::Set(d, node.step[axis]);
            const auto origin = hn::Set(d, node.origin[axis]);
            const auto lower =
                hn::MulAdd(plane_numbers(node.planes[axis], shuffles[axis][0] + own), step, origin);
            const auto upper =
                hn::MulAdd(plane_numbers(node.planes[axis], shuffles[axis][1] + own), step, origin);
            apart = hn::Max(apart, hn::Max(hn::Sub(lower, hn::Set(d, box.upper[axis])),
                                           hn::Sub(hn::Set(d, box.lower[axis]), upper)));
        }
        met |= (mask_bits(hn::Gt(apart, hn::Set(d, 0.0F))) ^ all_ray_lanes) << (ray_lanes * part);
    }
    return met;
}

void visit_box_leaves(const IndexParts& tree, const FloatQueryBox& box,
                      FunctionRef<void(const IndexLeaf&)> visitor)
{
    std::array<std::uint32_t, 7 * IndexParts::max_levels + 1> pending;
    std::size_t count = 0;
    pending[count++] = tree.root();
    const IndexBlock* const blocks = tree.blocks().data();
    while (count > 0) {
        const std::uint32_t at = pending[--count];
        const IndexBlock& block = blocks[at & ~index_leaf_bit];
        if ((at & index_leaf_bit) != 0) {
            visitor(block.leaf);
            continue;
        }
        for (std::uint32_t met = meet_children(block.node, box); met != 0; met &= met - 1) {
            const auto slot = static_cast<std::size_t>(std::countr_zero(met));
            if (block.node.has_child(slot)) pending[count++] = block.node.children[slot];
        }
    }
}

} // namespace proxima::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace proxima {

HWY_EXPORT(visit_leaves);
HWY_EXPORT(visit_box_leaves);

FloatQueryBox::FloatQueryBox(const IndexParts& tree, const Box& box) noexcept
{
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto k = static_cast<Eigen::Index>(axis);
        lower[axis] = rounded_down((box.lower[k] - tree.center()[k]) * tree.scale());
        upper[axis] = rounded_up((box.upper[k] - tree.center()[k]) * tree.scale());
    }
}

RayStart visit_scene_leaves(const IndexParts& tree, const Ray& ray,
                            const SceneLeafVisitor& visitor) noexcept
{
    return HWY_DYNAMIC_DISPATCH(visit_leaves)(tree, ray, visitor);
}

void visit_scene_leaves(const IndexParts& tree, const FloatQueryBox& box,
                        FunctionRef<void(const IndexLeaf&)> visitor) noexcept
{
    HWY_DYNAMIC_DISPATCH(visit_box_leaves)(tree, box, visitor);
}

} // namespace proxima

#endif
