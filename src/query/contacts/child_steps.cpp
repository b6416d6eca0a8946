#include "query/contacts/child_steps.h"

#include <algorithm>
#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "query/contacts/child_steps.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
// After them: it is read once for every instruction set.
#include "query/distance/pair_bounds-inl.h"

HWY_BEFORE_NAMESPACE();
namespace proxima::HWY_NAMESPACE {

using StepTag = PairTag<double>;
using StepLanes = hn::Vec<StepTag>;
using LaneVector = StepLanes[3];
constexpr std::size_t step_lanes = pair_lanes<double>;

HWY_INLINE StepLanes all(double value)
{
    return hn::Set(StepTag(), value);
}
HWY_INLINE void set_all(const Vec3& from, LaneVector& to)
{
    for (int k = 0; k < 3; ++k) to[k] = all(from[k]);
}
HWY_INLINE StepLanes dot(const LaneVector& u, const LaneVector& v)
{
    return hn::Add(hn::Add(hn::Mul(u[0], v[0]), hn::Mul(u[1], v[1])), hn::Mul(u[2], v[2]));
}
/// sum of |u_k| v_k
HWY_INLINE StepLanes reach_of(const LaneVector& u, const LaneVector& v)
{
    return hn::Add(hn::Add(hn::Mul(hn::Abs(u[0]), v[0]), hn::Mul(hn::Abs(u[1]), v[1])),
                   hn::Mul(hn::Abs(u[2]), v[2]));
}
HWY_INLINE StepLanes length_of(const LaneVector& v)
{
    return hn::Sqrt(dot(v, v));
}
HWY_INLINE void cross(const LaneVector& u, const Vec3& v, LaneVector& result)
{
    for (int k = 0; k < 3; ++k) {
        const int next = (k + 1) % 3;
        const int last = (k + 2) % 3;
        result[k] = hn::Sub(hn::Mul(u[next], all(v[last])), hn::Mul(u[last], all(v[next])));
    }
}
/// m v
HWY_INLINE void product(const Mat3& m, const LaneVector& v, LaneVector& result)
{
    for (int k = 0; k < 3; ++k) {
        result[k] = hn::Add(hn::Add(hn::Mul(all(m(k, 0)), v[0]), hn::Mul(all(m(k, 1)), v[1])),
                            hn::Mul(all(m(k, 2)), v[2]));
    }
}
/// Divided by its length; zero where it has hardly any, so that its square may have vanished.
HWY_INLINE void normalize(LaneVector& v)
{
    const auto length = length_of(v);
    const auto is_long = hn::Gt(length, all(0x1p-400));
    for (auto& x : v) x = hn::IfThenElseZero(is_long, hn::Div(x, length));
}

/// Some of a node's children, or one block in all lanes, as a BoundedBlock is.
struct BlockLanes {
    LaneVector center;
    LaneVector half;
    LaneVector normal;
    StepLanes lower;
    StepLanes upper;

    HWY_INLINE void set_one(const BoundedBlock& block)
    {
        set_all(block.center, center);
        set_all(block.half, half);
        set_all(block.normal, normal);
        lower = all(block.lower);
        upper = all(block.upper);
    }

    /// The centers are left about the index's own.
    HWY_INLINE void set_children(const ChildBoxes& boxes, const ChildSlabs& slabs, double unit,
                                 std::size_t first)
    {
        for (std::size_t k = 0; k < 3; ++k) {
            center[k] = hn::Mul(load_lanes<double>(boxes.center[k] + first), all(unit));
            half[k] = hn::Mul(load_lanes<double>(boxes.half[k] + first), all(unit));
            normal[k] = load_lanes<double>(slabs.normal[k] + first);
        }
        normalize(normal);
        const auto reach = reach_of(normal, half);
        lower = hn::Mul(reach, load_lanes<double>(slabs.lower + first));
        upper = hn::Mul(reach, load_lanes<double>(slabs.upper + first));
    }

    /// How far they reach from their centers along v, times |v|.
    HWY_INLINE StepLanes reach(const LaneVector& v) const
    {
        const auto by_box = reach_of(v, half);
        const auto on_normal = dot(v, normal);
        LaneVector rest;
        for (int k = 0; k < 3; ++k) rest[k] = hn::Sub(v[k], hn::Mul(on_normal, normal[k]));
        const auto by_slab = hn::Add(hn::Max(hn::Mul(on_normal, lower), hn::Mul(on_normal, upper)),
                                     reach_of(rest, half));
        return hn::Min(by_box, by_slab);
    }
};

/// Directions, one for each lane: what Along is.
struct AlongLanes {
    LaneVector direction;
    LaneVector in_b;
    LaneVector turning;
    LaneVector turning_in_b;
    StepLanes drift;
    StepLanes across;

    HWY_INLINE void set_one(const Along& along, const MovedFrame& frame)
    {
        const auto into_b = frame.pose.rotation.transpose();
        set_all(along.direction, direction);
        set_all(into_b * along.direction, in_b);
        set_all(along.turning, turning);
        set_all(into_b * along.turning, turning_in_b);
        drift = all(along.drift);
        across = all(along.across);
    }

    HWY_INLINE void set_lanes(const LaneVector& along, const MotionBounds& bounds,
                              const MovedFrame& frame)
    {
        for (int k = 0; k < 3; ++k) direction[k] = along[k];
        const Mat3 into_b = frame.pose.rotation.transpose();
        cross(direction, bounds.turn(), turning);
        product(into_b, direction, in_b);
        product(into_b, turning, turning_in_b);
        LaneVector displacement;
        set_all(bounds.displacement(), displacement);
        drift = dot(direction, displacement);
        LaneVector off_axis;
        cross(direction, bounds.axis(), off_axis);
        across = hn::Min(hn::Add(length_of(off_axis), all(MotionBounds::across_error)), all(1));
    }

    /// Has them point from A to B.
    HWY_INLINE void turn_towards(const LaneVector& between)
    {
        const auto is_back = hn::Lt(dot(direction, between), hn::Zero(StepTag()));
        const auto turned = [&](StepLanes& x)
                                HWY_ATTR { x = hn::IfThenElse(is_back, hn::Neg(x), x); };
        for (LaneVector* const v : {&direction, &in_b, &turning, &turning_in_b})
            for (auto& x : *v) turned(x);
        turned(drift);
    }
};

/// The directions that are the same for all children, made when they are first asked for.
class SharedAlongs {
public:
    SharedAlongs(const MotionBounds& bounds, const MovedFrame& frame)
        : bounds_(bounds), frame_(frame)
    {}

    static constexpr std::size_t axes = 6;
    static constexpr std::size_t hint = 6;
    static constexpr std::size_t slab = 7;
    const Along& axis(std::size_t i)
    {
        const auto k = static_cast<int>(i % 3);
        return along(i,
                     i < 3 ? Vec3(Vec3::Unit(k)) : Vec3(frame_.pose.rotation.col(k).normalized()));
    }
    const Along& along(std::size_t which, const Vec3& direction)
    {
        if ((made_ >> which & 1U) == 0) alongs_[which] = bounds_.along(direction);
        made_ |= 1U << which;
        return alongs_[which];
    }

private:
    const MotionBounds& bounds_;
    const MovedFrame& frame_;
    std::array<Along, axes + 2> alongs_;
    unsigned made_ = 0;
};

/// As many children as there are lanes.
class StepsOfLanes {
public:
    HWY_INLINE StepsOfLanes(const MotionBounds& bounds, const OpenedBlocks& opened,
                            const ChildBoxes& boxes, const ChildSlabs& slabs, std::size_t first)
        : bounds_(bounds), opened_(opened)
    {
        a_.set_one(opened.a);
        b_.set_one(opened.b);
        const MovedFrame& frame = opened.frame;
        LaneVector origin;
        if (opened.node != nullptr && opened.opens_a) {
            a_.set_children(boxes, slabs, bounds.unit_a(), first);
            set_all(bounds.center_a(), origin);
            for (int k = 0; k < 3; ++k) a_.center[k] = hn::Add(origin[k], a_.center[k]);
        } else if (opened.node != nullptr) {
            b_.set_children(boxes, slabs, bounds.unit_b(), first);
            set_all(frame.origin, origin);
            LaneVector turned;
            product(frame.pose.rotation, b_.center, turned);
            for (int k = 0; k < 3; ++k) b_.center[k] = hn::Add(origin[k], turned[k]);
        }
        for (int k = 0; k < 3; ++k) {
            between_[k] = hn::Sub(b_.center[k], a_.center[k]);
            arm_[k] = hn::Sub(b_.center[k], all(frame.turn_center[k]));
            best_direction_[k] = hn::Zero(StepTag());
        }
        LaneVector turning;
        cross(arm_, bounds.turn(), turning);
        bend_ =
            hn::Mul(all(0.5 * bounds.angle() * MotionBounds::rigid),
                    hn::Add(length_of(turning), hn::Mul(all(bounds.angle()), length_of(b_.half))));
        // Where there is no child nothing is looked for.
        best_ = hn::IfThenElse(hn::Lt(hn::Min(a_.half[0], b_.half[0]), hn::Zero(StepTag())),
                               all(MotionBounds::never), hn::Zero(StepTag()));
    }

    HWY_INLINE void find(SharedAlongs& shared)
    {
        if (!opened_.hint.isZero(0) && along(shared.along(SharedAlongs::hint, opened_.hint)))
            return;
        LaneVector direction;
        for (int k = 0; k < 3; ++k) direction[k] = between_[k];
        normalize(direction);
        if (along_lanes(direction)) return;
        const bool of_a = opened_.node != nullptr && opened_.opens_a;
        const bool of_b = opened_.node != nullptr && !opened_.opens_a;
        const Mat3& rotation = opened_.frame.pose.rotation;
        if (of_a && along_lanes(a_.normal)) return;
        if (of_b) {
            product(rotation, b_.normal, direction);
            normalize(direction);
            if (along_lanes(direction)) return;
        }
        const Vec3 normal =
            of_a ? Vec3((rotation * opened_.b.normal).stableNormalized()) : opened_.a.normal;
        if (!normal.isZero(0) && along(shared.along(SharedAlongs::slab, normal))) return;
        for (std::size_t i = 0; i < SharedAlongs::axes; ++i)
            if (along(shared.axis(i))) return;
    }

    HWY_INLINE void store(ChildSteps& steps, std::size_t first) const
    {
        const StepTag d;
        hn::StoreU(best_, d, steps.step.data() + first);
        for (std::size_t k = 0; k < 3; ++k)
            hn::StoreU(best_direction_[k], d, steps.direction[k].data() + first);
        hn::StoreU(dot(between_, between_), d, steps.apart.data() + first);
    }

private:
    HWY_INLINE bool along(const Along& one)
    {
        AlongLanes lanes;
        lanes.set_one(one, opened_.frame);
        return is_enough(lanes);
    }
    HWY_INLINE bool along_lanes(const LaneVector& direction)
    {
        AlongLanes lanes;
        lanes.set_lanes(direction, bounds_, opened_.frame);
        return is_enough(lanes);
    }

    /// Takes what is longer. Whether all are long enough.
    PROXIMA_STEP bool is_enough(AlongLanes& along)
    {
        const StepTag d;
        const auto zero = hn::Zero(d);
        along.turn_towards(between_);
        LaneVector back;
        for (int k = 0; k < 3; ++k) back[k] = hn::Neg(along.in_b[k]);
        const auto reaches = hn::Add(a_.reach(along.direction), b_.reach(back));
        const auto gap =
            hn::Sub(hn::Sub(dot(along.direction, between_), reaches), all(bounds_.margin()));
        const auto towards = hn::Sub(hn::Sub(reach_of(along.turning_in_b, b_.half), along.drift),
                                     dot(along.turning, arm_));
        const auto bend = hn::Mul(along.across, bend_);
        const auto within = all(opened_.within);
        const auto nearer = hn::Mul(within, hn::Add(towards, hn::Mul(within, bend)));
        const auto is_apart = hn::Gt(gap, zero);
        // The first time s > 0 at which towards s + bend s^2 reaches the gap.
        auto step = hn::IfThenElse(hn::Ge(gap, nearer), all(MotionBounds::never), zero);
        const auto is_open =
            hn::And(hn::And(is_apart, hn::Lt(gap, nearer)), hn::Lt(best_, all(opened_.enough)));
        if (!hn::AllFalse(d, is_open)) {
            // Some speed or bend is above 0, or the gap would not close within any time.
            const auto root =
                hn::Sqrt(hn::Add(hn::Mul(towards, towards), hn::Mul(hn::Mul(all(4), bend), gap)));
            const auto is_nearing = hn::Gt(towards, zero);
            const auto above =
                hn::IfThenElse(is_nearing, hn::Add(gap, gap), hn::Sub(root, towards));
            const auto below =
                hn::IfThenElse(is_nearing, hn::Add(towards, root), hn::Add(bend, bend));
            step = hn::IfThenElse(is_open, hn::Div(above, below), step);
        }
        step = hn::IfThenElseZero(is_apart, step);
        // A lane that has enough keeps its step, whichever lanes go on beside it: how many there are
        // differs between instruction sets.
        const auto is_longer = hn::And(hn::Gt(step, best_), hn::Lt(best_, all(opened_.enough)));
        best_ = hn::IfThenElse(is_longer, step, best_);
        for (int k = 0; k < 3; ++k)
            best_direction_[k] = hn::IfThenElse(is_longer, along.direction[k], best_direction_[k]);
        return hn::AllTrue(d, hn::Ge(best_, all(opened_.enough)));
    }

    const MotionBounds& bounds_;
    const OpenedBlocks& opened_;
    BlockLanes a_;
    BlockLanes b_;
    LaneVector between_;
    LaneVector arm_;
    StepLanes bend_;
    StepLanes best_;
    LaneVector best_direction_;
};

void child_steps(const MotionBounds& bounds, const OpenedBlocks& opened, ChildSteps& steps)
{
    SharedAlongs shared(bounds, opened.frame);
    // Where no node is opened, this empty one is read, and what comes of it is not used.
    const IndexNode none = {};
    const IndexNode& node = opened.node != nullptr ? *opened.node : none;
    const ChildBoxes boxes(node, 1);
    const ChildSlabs slabs = opened.node == nullptr
                                 ? ChildSlabs()
                                 : ChildSlabs(opened.opens_a ? bounds.a() : bounds.b(), node);
    const std::size_t end = opened.node != nullptr ? 8 : 1;
    for (std::size_t first = 0; first < end; first += step_lanes) {
        StepsOfLanes lanes(bounds, opened, boxes, slabs, first);
        lanes.find(shared);
        lanes.store(steps, first);
    }
    if (opened.node == nullptr) return;
    for (std::size_t slot = 0; slot < 8; ++slot) {
        steps.box[slot] = boxes[slot];
        if (!node.has_child(slot)) steps.step[slot] = -1;
    }
}

} // namespace proxima::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace proxima {

HWY_EXPORT(child_steps);

void find_child_steps(const MotionBounds& bounds, const OpenedBlocks& opened,
                      ChildSteps& steps) noexcept
{
    HWY_DYNAMIC_DISPATCH(child_steps)(bounds, opened, steps);
}

} // namespace proxima

#endif
