// One step of a ray through a mesh index: eight boxes, or up to eight triangles, at once. Included
// once per target, after <hwy/highway.h>.
//
//     lane     7 6 5 4 3 2 1 0        children from far to near: lane = octant ^ slot, so that the
//     nearest                ^        lowest bit of the mask is the next one to enter
//
// Floats leave out what surely is not hit; a triangle that surely is hit, with t surely less than
// all before, is only noted; everything else is asked in doubles at once (ray_triangle.h).

#if defined(PROXIMA_QUERY_WALK_RAY_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef PROXIMA_QUERY_WALK_RAY_INL_H
#undef PROXIMA_QUERY_WALK_RAY_INL_H
#else
#define PROXIMA_QUERY_WALK_RAY_INL_H
#endif

#include "base/inline_steps-inl.h"
#include "index/index_parts.h"
#include "query/rays/intersect_exact-inl.h"
#include "query/rays/prepare_ray.h"

#include <bit>
#include <cstddef>
#include <cstdint>
#include <hwy/cache_control.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace proxima::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using RayTag = hn::CappedTag<float, 8>;
using RayIndexTag = hn::RebindToUnsigned<RayTag>;
#if HWY_TARGET != HWY_SCALAR
using RayByteTag = hn::Repartition<std::uint8_t, RayTag>;
#endif
using RayFloats = hn::Vec<RayTag>;
inline constexpr std::size_t ray_lanes = HWY_MIN(8, HWY_LANES(float));
inline constexpr std::uint32_t all_ray_lanes = (1U << ray_lanes) - 1;

/// For every octant and axis, where lanes find the byte of the plane among a node's 16 by which the
/// ray enters, then of that by which it leaves. It becomes the second byte of 32 bits, the others
/// zero.
struct PlaneShuffles {
    alignas(64) std::uint8_t bytes[8][3][2][32]{};

    constexpr PlaneShuffles()
    {
        for (std::uint32_t octant = 0; octant < 8; ++octant) {
            for (std::uint32_t axis = 0; axis < 3; ++axis) {
                for (std::uint32_t far = 0; far < 2; ++far) {
                    for (std::size_t lane = 0; lane < 8; ++lane) {
                        const std::size_t upper = (octant >> axis & 1U) ^ far;
                        std::uint8_t* const own = bytes[octant][axis][far] + 4 * lane;
                        own[0] = own[2] = own[3] = 0x80;
                        own[1] = static_cast<std::uint8_t>(8 * upper + (lane ^ octant));
                    }
                }
            }
        }
    }
};
inline constexpr PlaneShuffles plane_shuffles;

/// By mask: the lanes it names from the highest down, as four bits per lane.
struct DescendingLanes {
    std::uint32_t lanes[256]{};

    constexpr DescendingLanes()
    {
        for (std::uint32_t mask = 0; mask < 256; ++mask) {
            std::uint32_t count = 0;
            for (std::uint32_t lane = 8; lane-- > 0;)
                if ((mask >> lane & 1U) != 0) lanes[mask] |= lane << (4 * count++);
        }
    }
};
inline constexpr DescendingLanes descending_lanes;

HWY_INLINE std::uint32_t mask_bits(hn::Mask<RayTag> mask)
{
    std::uint8_t bits[8] = {};
    (void)hn::StoreMaskBits(RayTag(), mask, bits);
    return bits[0];
}

HWY_INLINE void prefetch_block(const IndexBlock& block)
{
    hwy::Prefetch(&block);
    hwy::Prefetch(reinterpret_cast<const std::byte*>(&block) + 64);
}

/// 32768 + byte, for each lane's plane.
HWY_INLINE RayFloats plane_numbers(const std::array<std::uint8_t, 16>& planes,
                                   const std::uint8_t* shuffle)
{
    const RayIndexTag words;
    constexpr std::uint32_t float_32768 = 0x47000000;
#if HWY_TARGET == HWY_SCALAR
    const auto chosen = hn::Set(words, static_cast<std::uint32_t>(planes[shuffle[1]]) << 8U);
#else
    const RayByteTag bytes;
    const auto all = hn::LoadDup128(bytes, planes.data());
    const auto chosen = hn::BitCast(words, hn::TableLookupBytesOr0(all, hn::Load(bytes, shuffle)));
#endif
    return hn::BitCast(RayTag(), hn::Or(chosen, hn::Set(words, float_32768)));
}

/// A number in all lanes.
HWY_INLINE RayFloats load_all(const RayLanes& lanes)
{
    return hn::Load(RayTag(), lanes.lanes);
}

/// Takes the last of the blocks put aside that are near enough.
HWY_INLINE void leave(const RayTraversal& ray, WalkState& at)
{
    do {
        --at.pending;
    } while (ray.nearness[at.pending] > ray.most);
    at.next = ray.references[at.pending];
}

/// The children of a node that a ray meets, and where it enters them.
struct MetChildren {
    std::uint32_t bits = 0; ///< by lanes
    RayFloats entered[8 / ray_lanes];
};

PROXIMA_STEP MetChildren meet_children(const IndexNode& node, const RayTraversal& ray)
{
    const RayTag d;
    const std::uint8_t(&shuffles)[3][2][32] = plane_shuffles.bytes[ray.octant];
    MetChildren met;
    for (std::size_t part = 0; part < 8 / ray_lanes; ++part) {
        RayFloats enters[3];
        RayFloats leaves[3];
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const auto inverse = load_all(ray.inverse[axis]);
            const auto step = hn::Mul(hn::Set(d, node.step[axis]), inverse);
            const auto start =
                hn::MulAdd(hn::Set(d, node.origin[axis]), inverse, load_all(ray.start[axis]));
            const std::size_t own = 4 * ray_lanes * part;
            const auto front = plane_numbers(node.planes[axis], shuffles[axis][0] + own);
            const auto back = plane_numbers(node.planes[axis], shuffles[axis][1] + own);
            enters[axis] = hn::MulAdd(front, step, start);
            leaves[axis] = hn::MulAdd(back, step, start);
        }
        // As integers, four times as soon: a negative number is less than 0 and `most` whichever of
        // them it is.
        const hn::RebindToSigned<RayTag> bits;
        const auto number = [&](RayFloats t) { return hn::BitCast(bits, t); };
        const auto near = hn::Max(hn::Max(number(enters[0]), number(enters[1])),
                                  hn::Max(number(enters[2]), hn::Zero(bits)));
        const auto far = hn::Min(hn::Min(number(leaves[0]), number(leaves[1])),
                                 hn::Min(number(leaves[2]), number(hn::Set(d, ray.most))));
        met.entered[part] = hn::BitCast(d, near);
        met.bits |= (mask_bits(hn::RebindMask(d, hn::Gt(near, far))) ^ all_ray_lanes)
                    << (ray_lanes * part);
    }
    return met;
}

/// Goes on to the nearest child met and puts the others aside. Where none was met, only `at.next`
/// is changed, to any child.
PROXIMA_STEP void enter_nearest(const IndexNode& node, const MetChildren& met, RayTraversal& ray,
                                WalkState& at)
{
    const RayTag d;
    const auto nearest = static_cast<std::uint32_t>(std::countr_zero(met.bits));
    at.next = node.children[(nearest ^ ray.octant) & 7U];
    const std::uint32_t rest = met.bits & (met.bits - 1);
    const std::uint32_t descending = descending_lanes.lanes[rest];
    const auto count = static_cast<std::uint32_t>(std::popcount(rest));
#if HWY_MAX_BYTES >= 32
    if constexpr (ray_lanes == 8) {
        // The nearest last. Looking up reads three bits of each index.
        const RayIndexTag words;
        alignas(32) static constexpr std::uint32_t shifts[8] = {0, 4, 8, 12, 16, 20, 24, 28};
        const auto lanes = hn::Shr(hn::Set(words, descending), hn::Load(words, shifts));
        const auto slots = hn::Xor(lanes, hn::Set(words, ray.octant));
        const auto children = hn::TableLookupLanes(hn::LoadU(words, node.children.data()),
                                                   hn::Indices256<std::uint32_t>{slots.raw});
        const auto near = hn::TableLookupLanes(met.entered[0], hn::Indices256<float>{lanes.raw});
        hn::StoreU(children, words, ray.references.data() + at.pending);
        hn::StoreU(near, d, ray.nearness.data() + at.pending);
        at.pending += count;
        return;
    }
#endif
    float near[8];
    for (std::size_t part = 0; part < 8 / ray_lanes; ++part)
        hn::StoreU(met.entered[part], d, near + ray_lanes * part);
    for (std::uint32_t i = 0; i < count; ++i) {
        const std::uint32_t lane = descending >> 4 * i & 7U;
        ray.references[at.pending] = node.children[lane ^ ray.octant];
        ray.nearness[at.pending++] = near[lane];
    }
}

/// Eight floats, looked up by lanes.
class EightFloats {
public:
    HWY_INLINE void set(std::size_t part, RayFloats values)
    {
        if constexpr (ray_lanes == 8) {
            values_ = values;
        } else {
            hn::Store(values, RayTag(), memory_ + ray_lanes * part);
        }
    }
    HWY_INLINE RayFloats at(hn::Vec<RayIndexTag> indices) const
    {
        if constexpr (ray_lanes == 8) {
            return hn::TableLookupLanes(values_, hn::IndicesFromVec(RayTag(), indices));
        } else {
            const hn::RebindToSigned<RayTag> d;
            return hn::GatherIndex(RayTag(), memory_, hn::BitCast(d, indices));
        }
    }

private:
    RayFloats values_;
    HWY_ALIGN float memory_[8];
};

/// Whether to stop at a leaf's triangles when all are missed: half of the time, which is hard to
/// predict; in a batch it is better not to ask.
enum class LeafWork : std::uint8_t { until_missed, whole };

/// What floats say of a leaf's triangles: by lanes, or bits of lanes.
struct LeafCandidates {
    HWY_ALIGN float least[8]; ///< t is between these, where sure
    HWY_ALIGN float most[8];
    std::uint32_t lanes = 0; ///< not surely missed
    std::uint32_t sure = 0;  ///< surely hit, if in range
};

// Bounds of the test, u = 2^-24. About the ray's origin (|o| <= 1.01) a vertex is off by 4.03 u
// (its own rounding and the origin's, u each, and that of a difference of at most 2.02), x = A_x -
// S A_z by 4.03 u more for A_z, 4.04 u for S and its product, and 4.04 u for the difference: X = 17
// u, times the ray's factor where its origin was moved. A weight x_1 y_2 - y_1 x_2 with x, y up to
// R <= 4 is off by 4 R X + 2 X^2 + 4 u R^2 <= 84 u R + 578 u^2 < 86 u (R + 32 u) =: E. As the ray
// comes through the leaf's box, of edges up to Z, and |S| <= 1, R <= 2 Z.
// Where all three are beyond E and their sum S beyond 8 E, the true sum is at least 5/8 S, and t,
// the mean of the corners' by weights, is off by 3 E Z / (5/8 S) < 5 E Z / S for the weights, Z the
// extent along the ray, and for the corners' own t and roundings by less than 40 u.
HWY_INLINE float leaf_extent(const IndexLeaf& leaf)
{
    return std::bit_cast<float>(static_cast<std::uint32_t>(leaf.extent_bits) << 16U);
}

HWY_INLINE float leaf_error(float extent, float factor)
{
    return (2 * extent + 32 * float_roundoff) * (86 * float_roundoff * factor);
}

template <LeafWork Work>
PROXIMA_STEP void look_at_leaf(const IndexLeaf& leaf, const RayTraversal& ray,
                               LeafCandidates& candidates)
{
    const RayTag d;
    const float extent = leaf_extent(leaf);
    const float error_size = leaf_error(extent, ray.error);
    const auto error = hn::Set(d, error_size);
    const auto minus_error = hn::Set(d, -error_size);
    EightFloats x;
    EightFloats y;
    EightFloats z;
    for (std::size_t part = 0; part < 8 / ray_lanes; ++part) {
        const std::size_t at = ray_lanes * part;
        const auto load = [&](std::size_t k) {
            return hn::Sub(hn::Load(d, leaf.coordinates[ray.axes[k]].data() + at),
                           hn::Set(d, ray.origin[k]));
        };
        const auto along = load(2);
        const auto across_x = hn::NegMulAdd(along, hn::Set(d, ray.slope_x), load(0));
        const auto across_y = hn::NegMulAdd(along, hn::Set(d, ray.slope_y), load(1));
        x.set(part, across_x);
        y.set(part, across_y);
        z.set(part, along);
    }
    for (std::size_t part = 0; part < 8 / ray_lanes; ++part) {
        const std::size_t first = ray_lanes * part;
        const hn::Rebind<std::uint8_t, RayTag> narrow;
        const RayIndexTag words;
        hn::Vec<RayIndexTag> corner[3];
        RayFloats xs[3];
        RayFloats ys[3];
        for (std::size_t i = 0; i < 3; ++i) {
            corner[i] = hn::PromoteTo(words, hn::LoadU(narrow, leaf.corners[i].data() + first));
            xs[i] = x.at(corner[i]);
            ys[i] = y.at(corner[i]);
        }
        RayFloats weights[3];
        for (std::size_t i = 0; i < 3; ++i) {
            const std::size_t b = (i + 1) % 3;
            const std::size_t c = (i + 2) % 3;
            weights[i] = hn::NegMulAdd(ys[b], xs[c], hn::Mul(xs[b], ys[c]));
        }
        const auto lower = hn::Min(hn::Min(weights[0], weights[1]), weights[2]);
        const auto upper = hn::Max(hn::Max(weights[0], weights[1]), weights[2]);
        const auto some_positive = hn::Gt(upper, error);
        const auto some_negative = hn::Lt(lower, minus_error);
        const auto positive = hn::Gt(lower, error);
        const auto negative = hn::Lt(upper, minus_error);
        std::uint32_t lanes = mask_bits(hn::Not(hn::And(some_positive, some_negative)));
        if (ray.refuses_positive) lanes &= ~mask_bits(positive);
        if (ray.refuses_negative) lanes &= ~mask_bits(negative);
        lanes &= all_ray_lanes;
        if (leaf.count < first + ray_lanes)
            lanes &= leaf.count > first ? (1U << (leaf.count - first)) - 1 : 0U;
        if constexpr (Work == LeafWork::until_missed) {
            if (lanes == 0) continue;
        }
        const auto sum = hn::Add(hn::Add(weights[0], weights[1]), weights[2]);
        const auto size = hn::Abs(sum);
        const auto inverse = hn::Div(hn::Set(d, 1.0F), sum);
        const auto mean = hn::MulAdd(
            weights[0], z.at(corner[0]),
            hn::MulAdd(weights[1], z.at(corner[1]), hn::Mul(weights[2], z.at(corner[2]))));
        const auto t = hn::Mul(hn::Mul(mean, inverse), hn::Set(d, ray.inverse_z));
        const auto off = hn::MulAdd(hn::Abs(inverse), hn::Set(d, 5 * extent * error_size),
                                    hn::Set(d, ray.t_error));
        const auto least = hn::Sub(t, off);
        const auto most = hn::Add(t, off);
        const auto sure =
            hn::And(hn::Or(positive, negative), hn::Gt(size, hn::Set(d, 8 * error_size)));
        const auto out =
            hn::And(sure, hn::Or(hn::Gt(least, hn::Set(d, ray.most)), hn::Lt(most, hn::Zero(d))));
        const auto in = hn::And(sure, hn::And(hn::Ge(least, hn::Set(d, ray.sure_least)),
                                              hn::Le(most, hn::Set(d, ray.sure_most))));
        lanes &= ~mask_bits(out);
        candidates.lanes |= lanes << first;
        candidates.sure |= (mask_bits(in) & lanes) << first;
        hn::Store(least, d, candidates.least + first);
        hn::Store(most, d, candidates.most + first);
    }
}

/// Whether a closest hit that floats are sure of is computed in doubles at once, while the walk goes
/// on, or noted: then many rays' hits can be computed side by side.
enum class SureHits : std::uint8_t { computed, noted };

/// The closest hit so far.
template <SureHits Sure>
struct ClosestSearch {
    static constexpr bool has_packets = true;
    static constexpr bool notes_hits = Sure == SureHits::noted;
    const IndexParts& index;

    HWY_INLINE void keep(SearchedRay& ray) const
    {
        ray.found = true;
        ray.best_noted.leaf = RayTriangle::no_leaf;
        const auto t = static_cast<float>(ray.best.t * ray.rate - ray.shift);
        ray.best_least = t - ray.t_error;
        ray.most = HWY_MIN(ray.most, t + ray.t_error);
    }
    HWY_INLINE void settle(SearchedRay& ray) const
    {
        if (!notes_hits || ray.best_noted.leaf == RayTriangle::no_leaf) return;
        if (ask_any_triangle(index, ray.best_noted, ray, ray.best)) keep(ray);
    }
    /// False to end the search.
    HWY_INLINE bool take(std::uint32_t leaf, const LeafCandidates& candidates,
                         SearchedRay& ray) const
    {
        for (std::uint32_t left = candidates.lanes; left != 0; left &= left - 1) {
            const auto lane = static_cast<std::uint32_t>(std::countr_zero(left));
            if ((candidates.sure >> lane & 1U) != 0) {
                if (candidates.least[lane] > ray.most) continue;
                if (candidates.most[lane] < ray.best_least) {
                    ray.best_least = candidates.least[lane];
                    ray.most = candidates.most[lane];
                    if constexpr (notes_hits) {
                        ray.best_noted = {leaf, lane};
                        const std::uint32_t first = index.blocks()[leaf].leaf.first_row;
                        hwy::Prefetch(row_address(index, first + lane));
                    } else {
                        const bool is_hit = ask_any_triangle(index, {leaf, lane}, ray, ray.best);
                        ray.found = is_hit || ray.found;
                    }
                    continue;
                }
            }
            settle(ray);
            RayHit hit;
            if (!ask_any_triangle(index, {leaf, lane}, ray, hit)) continue;
            if (ray.found && !hit.before(ray.best)) continue;
            ray.best = hit;
            keep(ray);
        }
        return true;
    }
};

/// Whether there is a hit.
struct AnySearch {
    static constexpr bool has_packets = true;
    static constexpr bool notes_hits = false;
    const IndexParts& index;

    HWY_INLINE bool take(std::uint32_t leaf, const LeafCandidates& candidates,
                         SearchedRay& ray) const
    {
        ray.found = candidates.sure != 0;
        for (std::uint32_t left = candidates.lanes; left != 0 && !ray.found; left &= left - 1) {
            const auto lane = static_cast<std::uint32_t>(std::countr_zero(left));
            ray.found = ask_any_triangle(index, {leaf, lane}, ray, ray.best);
        }
        return !ray.found;
    }
    HWY_INLINE void settle(SearchedRay& /*ray*/) const {}
};

/// One block. False where the walk has ended.
template <class Search>
HWY_INLINE bool step(const IndexBlock* blocks, const Search& search, RayTraversal& ray,
                     WalkState& at)
{
    const std::uint32_t block = at.next & ~index_leaf_bit;
    if ((at.next & index_leaf_bit) == 0) {
        const IndexNode& node = blocks[block].node;
        const MetChildren met = meet_children(node, ray);
        if (met.bits != 0) {
            enter_nearest(node, met, ray, at);
        } else {
            leave(ray, at);
        }
    } else {
        LeafCandidates candidates;
        look_at_leaf<LeafWork::until_missed>(blocks[block].leaf, ray, candidates);
        if (candidates.lanes != 0 && !search.take(block, candidates, ray)) return false;
        leave(ray, at);
    }
    return at.next != RayTraversal::end;
}

} // namespace proxima::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
