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

} // namespace proxima::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace proxima {

HWY_EXPORT(visit_leaves);

RayStart visit_scene_leaves(const IndexParts& tree, const Ray& ray,
                            const SceneLeafVisitor& visitor) noexcept
{
    return HWY_DYNAMIC_DISPATCH(visit_leaves)(tree, ray, visitor);
}

} // namespace proxima

#endif
