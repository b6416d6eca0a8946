// Distances of the eight boxes of a block from a point, in lanes of floats. Included once per
// target.

#if defined(PROXIMA_HAPTICS_BALL_GAPS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef PROXIMA_HAPTICS_BALL_GAPS_INL_H
#undef PROXIMA_HAPTICS_BALL_GAPS_INL_H
#else
#define PROXIMA_HAPTICS_BALL_GAPS_INL_H
#endif

#include "haptics/surface/ball_query.h"
#include "haptics/surface/triangle_tree.h"

#include <cstddef>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace proxima::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using BallTag = hn::CappedTag<float, TriangleTree::width>;

/// Squared distances of a block's boxes from `lane` on.
HWY_INLINE hn::Vec<BallTag> squared_gaps(const TriangleTreeBlock& block, std::size_t lane,
                                         const BallQuery& query)
{
    const BallTag d;
    auto squared = hn::Zero(d);
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto position = hn::Set(d, query.position[axis]);
        const auto before = hn::Sub(hn::Load(d, block.lower[axis].data() + lane), position);
        const auto behind = hn::Sub(position, hn::Load(d, block.upper[axis].data() + lane));
        const auto gap = hn::Max(hn::Max(before, behind), hn::Zero(d));
        squared = hn::Add(squared, hn::Mul(gap, gap)); // the same bits on every instruction set
    }
    return squared;
}

/// Which of these boxes the ball meets. Only the first `left` of them exist.
HWY_INLINE hn::Mask<BallTag> meets_ball(hn::Vec<BallTag> squared, const BallQuery& query,
                                        std::size_t left)
{
    const BallTag d;
    const auto meets = hn::Le(squared, hn::Set(d, query.squared));
    return left >= hn::Lanes(d) ? meets : hn::And(meets, hn::FirstN(d, left));
}

} // namespace proxima::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
