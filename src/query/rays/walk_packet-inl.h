// Rays that go much the same way, through a mesh index together. Included once per target.
//
//     nodes    once for all: where the first of them could enter a box, and the last leave it, by
//              intervals of origins and directions; lanes are children
//     leaves   a triangle at a time; lanes are rays
//
// An interval's ends are those of rays. (p - o) r is least at one of its corners, and at the two
// that are asked. Rounding is that of a single ray with the largest r, up to r (0.008 step + 16 u)
// (block_boxes.cpp); a packet adds the second part itself, and boxes have twice the first.

#if defined(PROXIMA_QUERY_WALK_PACKET_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef PROXIMA_QUERY_WALK_PACKET_INL_H
#undef PROXIMA_QUERY_WALK_PACKET_INL_H
#else
#define PROXIMA_QUERY_WALK_PACKET_INL_H
#endif

#include "index/index_parts.h"
#include "query/rays/intersect_lanes-inl.h"
#include "query/rays/prepare_packet-inl.h"
#include "query/rays/walk_ray-inl.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

HWY_BEFORE_NAMESPACE();
namespace proxima::HWY_NAMESPACE {

template <class Search>
class PacketWalk {
public:
    HWY_INLINE PacketWalk(const IndexParts& index, const Search& search, const RaySource& source)
        : hits_(index, source), index_(index), blocks_(index.blocks().data()), search_(search),
          source_(source)
    {
        std::fill_n(stack_.references.begin(), RayTraversal::bottom, RayTraversal::end);
        std::fill_n(stack_.nearness.begin(), RayTraversal::bottom, -infinity);
    }

    /// Takes on packet_size rays of the source, from this number on. False where they are no packet,
    /// or where each does better on its own: then none of them is answered.
    HWY_INLINE bool run(std::size_t first)
    {
        if (waiting_ > 0) {
            --waiting_;
            return false;
        }
        if (!rays_.open(index_, source_.rays.subspan(first, packet_size))) return false;
        first_ = static_cast<std::uint32_t>(first);
        if (rays_.ready != 0) {
            if (!bound()) return false;
            searched_now_ = 0;
            for (std::size_t part = 0; part < packet_parts; ++part) {
                hn::Store(hn::Set(RayTag(), infinity), RayTag(),
                          best_least_.values + ray_lanes * part);
            }
            noted_.fill({RayTriangle::no_leaf, 0});
            if (!walk()) {
                waiting_ = pause_;
                pause_ = HWY_MIN(2 * pause_, longest_pause);
                return false;
            }
            pause_ = 1;
        }
        for (std::uint32_t i = 0; i < packet_size; ++i) answer(i);
        return true;
    }

    /// Answers those that still wait.
    HWY_INLINE void end() { hits_.answer(); }

private:
    static constexpr float infinity = std::numeric_limits<float>::infinity();
    /// With as many, sixteen rays took as long together as each on its own: meshes of 69,000 and
    /// 871,000 triangles, cameras of 150 to 2000 pixels across, AVX2 and AVX-512.
    static constexpr std::uint32_t most_leaves = 14;
    static constexpr std::uint32_t longest_pause = 32; ///< of packets, after several in vain

    /// The least and the most of the rays' numbers.
    struct Interval {
        float least;
        float most;

        HWY_INLINE explicit Interval(const PacketFloats& numbers)
        {
            const RayTag d;
            auto lower = numbers.part(0);
            auto upper = lower;
            for (std::size_t part = 1; part < packet_parts; ++part) {
                lower = hn::Min(lower, numbers.part(part));
                upper = hn::Max(upper, numbers.part(part));
            }
            least = hn::GetLane(hn::MinOfLanes(d, lower));
            most = hn::GetLane(hn::MaxOfLanes(d, upper));
        }
    };

    /// One end of an interval of directions: their inverse, and - o r for the origins that enter
    /// first and leave last.
    struct End {
        RayLanes inverse;
        RayLanes enter;
        RayLanes leave;
    };

    /// Intervals. False where rays are too different.
    PROXIMA_STEP bool bound()
    {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const Interval inverse(rays_.inverse[axis]);
            const Interval origin(rays_.origin[axis]);
            const bool rises = inverse.least > 0;
            const float small = std::abs(rises ? inverse.least : inverse.most);
            const float large = std::abs(rises ? inverse.most : inverse.least);
            constexpr float most_apart = 0.25F; // of origins: a guess
            constexpr float most_unlike = 1.9F; // of 2: margin of boxes
            if (!(large <= most_unlike * small && origin.most - origin.least <= most_apart))
                return false;
            const float enters = rises ? origin.most : origin.least;
            const float leaves = rises ? origin.least : origin.most;
            const float rounding = 20 * float_roundoff * large;
            for (std::size_t i = 0; i < 2; ++i) {
                const float r = i == 0 ? inverse.least : inverse.most;
                ends_[axis][i].inverse.fill(r);
                ends_[axis][i].enter.fill(-enters * r - rounding);
                ends_[axis][i].leave.fill(-leaves * r + rounding);
            }
        }
        // Weights are positive where direction . normal has the sign of the direction's z.
        const bool forward = (rays_.octant >> rays_.axes[2] & 1U) == 0;
        refuses_positive_ = source_.faces == (forward ? Faces::front : Faces::back);
        refuses_negative_ = source_.faces == (forward ? Faces::back : Faces::front);
        packet_least_ = Interval(rays_.least).least;
        find_most();
        return true;
    }

    HWY_INLINE void find_most() { packet_most_ = Interval(rays_.most).most; }

    /// Children that some ray may meet.
    PROXIMA_STEP MetChildren meet(const IndexNode& node, std::uint32_t octant) const
    {
        const RayTag d;
        const std::uint8_t(&shuffles)[3][2][32] = plane_shuffles.bytes[octant];
        MetChildren met;
        for (std::size_t part = 0; part < 8 / ray_lanes; ++part) {
            auto near = hn::Set(d, packet_least_);
            auto far = hn::Set(d, packet_most_);
            auto used = hn::Le(near, near);
            for (std::size_t axis = 0; axis < 3; ++axis) {
                const std::size_t own = 4 * ray_lanes * part;
                const auto front = plane_numbers(node.planes[axis], shuffles[axis][0] + own);
                const auto back = plane_numbers(node.planes[axis], shuffles[axis][1] + own);
                // No ray meets the box of a slot without a child, but intervals of rays do.
                if (axis == 0)
                    used = (octant & 1U) == 0 ? hn::Le(front, back) : hn::Le(back, front);
                RayFloats in[2];
                RayFloats out[2];
                for (std::size_t i = 0; i < 2; ++i) {
                    const End& end = ends_[axis][i];
                    const auto inverse = load_all(end.inverse);
                    const auto step = hn::Mul(hn::Set(d, node.step[axis]), inverse);
                    const auto origin = hn::Set(d, node.origin[axis]);
                    in[i] =
                        hn::MulAdd(front, step, hn::MulAdd(origin, inverse, load_all(end.enter)));
                    out[i] =
                        hn::MulAdd(back, step, hn::MulAdd(origin, inverse, load_all(end.leave)));
                }
                near = hn::Max(near, hn::Min(in[0], in[1]));
                far = hn::Min(far, hn::Max(out[0], out[1]));
            }
            met.entered[part] = near;
            met.bits |= mask_bits(hn::And(used, hn::Le(near, far))) << (ray_lanes * part);
        }
        return met;
    }

    /// False, given up, where it comes to so many leaves that most are met by few of the rays.
    HWY_INLINE bool walk()
    {
        std::uint32_t leaves = 0;
        RayTraversal& like = stack_;
        like.octant = rays_.octant;
        WalkState at = {index_.root(), RayTraversal::bottom};
        while (at.next != RayTraversal::end) {
            const std::uint32_t block = at.next & ~index_leaf_bit;
            if ((at.next & index_leaf_bit) == 0) {
                const IndexNode& node = blocks_[block].node;
                const MetChildren met = meet(node, like.octant);
                if (met.bits != 0) {
                    enter_nearest(node, met, like, at);
                    prefetch_block(blocks_[like.references[at.pending - 1] & ~index_leaf_bit]);
                    continue;
                }
            } else {
                if (++leaves > most_leaves) return false;
                look_at_leaf_together(block);
            }
            do {
                --at.pending;
            } while (like.nearness[at.pending] > packet_most_);
            at.next = like.references[at.pending];
        }
        return true;
    }

    /// As look_at_leaf, but that rays may pass by far from the leaf's box.
    HWY_INLINE void look_at_leaf_together(std::uint32_t block)
    {
        const RayTag d;
        const IndexLeaf& leaf = blocks_[block].leaf;
        bool changes = false;
        for (std::size_t part = 0; part < packet_parts; ++part) {
            Corners corners;
            const auto infinite = hn::Set(d, infinity);
            auto left = infinite;
            auto low = infinite;
            auto right = hn::Neg(infinite);
            auto high = hn::Neg(infinite);
            for (std::size_t i = 0; i < 8; ++i) {
                const auto about = [&](std::size_t k) {
                    return hn::Sub(hn::Set(d, leaf.coordinates[rays_.axes[k]][i]),
                                   rays_.origin[rays_.axes[k]].part(part));
                };
                const auto along = about(2);
                const auto x = hn::NegMulAdd(along, rays_.slope_x.part(part), about(0));
                const auto y = hn::NegMulAdd(along, rays_.slope_y.part(part), about(1));
                left = hn::Min(left, x);
                right = hn::Max(right, x);
                low = hn::Min(low, y);
                high = hn::Max(high, y);
                hn::Store(x, d, corners.x[i]);
                hn::Store(y, d, corners.y[i]);
                hn::Store(along, d, corners.z[i]);
            }
            // Rays that have all corners on one side, by more than x and y are off
            // (walk_ray-inl.h).
            const auto aside = hn::Max(hn::Max(left, low), hn::Max(hn::Neg(right), hn::Neg(high)));
            const auto near = hn::Le(aside, hn::Set(d, 18 * float_roundoff * rays_.error));
            if (hn::AllFalse(d, near)) continue;
            const auto reach = hn::Max(hn::Max(right, high), hn::Max(hn::Neg(left), hn::Neg(low)));
            const auto error = hn::Mul(hn::Add(reach, hn::Set(d, 32 * float_roundoff)),
                                       hn::Set(d, 86 * float_roundoff * rays_.error));
            hn::Store(error, d, corners.error);
            for (std::uint32_t lane = 0; lane < leaf.count; ++lane)
                changes = look_at_triangle({block, lane}, part, corners) || changes;
        }
        if (changes) find_most();
    }

    /// A leaf's corners as rays see them, and the errors of weights.
    struct Corners {
        HWY_ALIGN float x[8][ray_lanes];
        HWY_ALIGN float y[8][ray_lanes];
        HWY_ALIGN float z[8][ray_lanes];
        HWY_ALIGN float error[ray_lanes];
    };

    /// Whether it is a candidate of any ray. As look_at_leaf, whose bounds hold here.
    PROXIMA_STEP bool look_at_triangle(RayTriangle triangle, std::size_t part,
                                       const Corners& corners)
    {
        const RayTag d;
        const IndexLeaf& leaf = blocks_[triangle.leaf].leaf;
        RayFloats xs[3];
        RayFloats ys[3];
        for (std::size_t i = 0; i < 3; ++i) {
            const std::size_t vertex = leaf.corners[i][triangle.lane];
            xs[i] = hn::Load(d, corners.x[vertex]);
            ys[i] = hn::Load(d, corners.y[vertex]);
        }
        RayFloats weights[3];
        for (std::size_t i = 0; i < 3; ++i) {
            const std::size_t b = (i + 1) % 3;
            const std::size_t c = (i + 2) % 3;
            weights[i] = hn::NegMulAdd(ys[b], xs[c], hn::Mul(xs[b], ys[c]));
        }
        const auto error = hn::Load(d, corners.error);
        const auto minus_error = hn::Neg(error);
        const auto lower = hn::Min(hn::Min(weights[0], weights[1]), weights[2]);
        const auto upper = hn::Max(hn::Max(weights[0], weights[1]), weights[2]);
        const auto positive = hn::Gt(lower, error);
        const auto negative = hn::Lt(upper, minus_error);
        const auto most = rays_.most.part(part);
        const auto missed = hn::And(hn::Gt(upper, error), hn::Lt(lower, minus_error));
        std::uint32_t rays = mask_bits(hn::Not(missed)) & ((1U << ray_lanes) - 1);
        if (refuses_positive_) rays &= ~mask_bits(positive);
        if (refuses_negative_) rays &= ~mask_bits(negative);
        if (rays == 0) return false;
        const auto wanted = refuses_positive_   ? negative
                            : refuses_negative_ ? positive
                                                : hn::Or(positive, negative);

        const auto sum = hn::Add(hn::Add(weights[0], weights[1]), weights[2]);
        const auto inverse = hn::Div(hn::Set(d, 1.0F), sum);
        const auto depth = [&](std::size_t i) {
            return hn::Load(d, corners.z[leaf.corners[i][triangle.lane]]);
        };
        const auto mean = hn::MulAdd(
            weights[0], depth(0), hn::MulAdd(weights[1], depth(1), hn::Mul(weights[2], depth(2))));
        const auto t = hn::Mul(hn::Mul(mean, inverse), rays_.inverse_z.part(part));
        const auto off = hn::MulAdd(hn::Mul(error, hn::Abs(inverse)),
                                    hn::Set(d, 5 * leaf_extent(leaf)), hn::Set(d, rays_.t_error));
        const auto first = hn::Sub(t, off);
        const auto last = hn::Add(t, off);
        const auto sure = hn::And(wanted, hn::Gt(hn::Abs(sum), hn::Mul(error, hn::Set(d, 8.0F))));
        const auto out =
            hn::And(sure, hn::Or(hn::Gt(first, most), hn::Lt(last, rays_.least.part(part))));
        const auto in = hn::And(sure, hn::And(hn::Ge(first, rays_.sure_least.part(part)),
                                              hn::Le(last, rays_.sure_most.part(part))));
        // Rays that no longer look for hits have a `most` below everything.
        const auto looks = hn::Gt(most, hn::Set(d, -infinity));
        rays &= mask_bits(hn::And(hn::Not(out), looks));
        std::uint32_t noted = 0;
        if constexpr (Search::notes_hits) {
            const auto best_least = best_least_.part(part);
            const auto better =
                hn::And(hn::And(in, looks), hn::And(hn::Le(first, most), hn::Lt(last, best_least)));
            noted = mask_bits(better) & rays;
            hn::Store(hn::IfThenElse(better, last, most), d, rays_.most.values + ray_lanes * part);
            hn::Store(hn::IfThenElse(better, first, best_least), d,
                      best_least_.values + ray_lanes * part);
            for (std::uint32_t left = noted; left != 0; left &= left - 1) {
                const auto lane = static_cast<std::size_t>(std::countr_zero(left));
                noted_[ray_lanes * part + lane] = triangle;
            }
        }
        LeafCandidates candidates;
        hn::Store(first, d, candidates.least);
        hn::Store(last, d, candidates.most);
        const std::uint32_t sure_bits = mask_bits(in);
        for (std::uint32_t left = rays & ~noted; left != 0; left &= left - 1) {
            const auto lane = static_cast<std::size_t>(std::countr_zero(left));
            ask(triangle, ray_lanes * part + lane, candidates.least[lane], candidates.most[lane],
                (sure_bits >> lane & 1U) != 0);
        }
        return rays != 0;
    }

    /// One ray on its own.
    PROXIMA_STEP void ask(RayTriangle triangle, std::size_t i, float first, float last, bool sure)
    {
        LeafCandidates candidates;
        candidates.lanes = 1U << triangle.lane;
        candidates.sure = sure ? candidates.lanes : 0;
        candidates.least[triangle.lane] = first;
        candidates.most[triangle.lane] = last;
        SearchedRay& ray = searched(i);
        const bool goes_on = search_.take(triangle.leaf, candidates, ray);
        rays_.most.values[i] = goes_on ? ray.most : -infinity;
        best_least_.values[i] = ray.best_least;
        noted_[i] = ray.best_noted;
    }

    /// A ray as it is by now.
    HWY_INLINE SearchedRay& searched(std::size_t i)
    {
        SearchedRay& ray = searched_[i];
        if ((searched_now_ >> i & 1U) == 0) {
            searched_now_ |= 1U << i;
            ray.t_error = rays_.t_error;
            ray.found = false;
            ray.number = first_ + static_cast<std::uint32_t>(i);
            ray.ray = &source_.rays[ray.number];
            ray.faces = source_.faces;
            ray.rate = rays_.rate.values[i];
            ray.shift = rays_.shift.values[i];
            ray.shear = shear(i);
        }
        ray.most = rays_.most.values[i];
        ray.best_least = best_least_.values[i];
        ray.best_noted = noted_[i];
        return ray;
    }
    HWY_INLINE RayShear shear(std::size_t i) const
    {
        RayShear shear;
        shear.x = rays_.axes[0];
        shear.y = rays_.axes[1];
        shear.z = rays_.axes[2];
        shear.inverse_z = rays_.inverses_z.values[i];
        shear.slope_x = rays_.slopes_x.values[i];
        shear.slope_y = rays_.slopes_y.values[i];
        return shear;
    }

    HWY_INLINE void answer(std::uint32_t i)
    {
        const std::uint32_t number = first_ + i;
        if ((rays_.ready >> i & 1U) == 0) {
            source_.refuse(source_.context, number, RayStart::misses);
        } else if ((searched_now_ >> i & 1U) != 0) {
            SearchedRay& ray = searched(i);
            search_.settle(ray);
            source_.answer(source_.context, number, ray.found ? &ray.best : nullptr);
        } else if (noted_[i].leaf != RayTriangle::no_leaf) {
            hits_.add(number, shear(i), noted_[i]);
        } else {
            source_.answer(source_.context, number, nullptr);
        }
    }

    End ends_[3][2];
    RayTraversal stack_; ///< lends its octant, and its stack of blocks put aside
    PacketFloats best_least_;
    PacketRays rays_;
    HitLanes hits_;
    const IndexParts& index_;
    const IndexBlock* blocks_;
    const Search& search_;
    const RaySource& source_;
    std::array<SearchedRay, packet_size> searched_;
    std::array<RayTriangle, packet_size> noted_;
    std::uint32_t searched_now_ = 0; ///< bits of the rays that were asked on their own
    std::uint32_t first_ = 0;        ///< number of the packet's first ray
    std::uint32_t waiting_ = 0;      ///< packets yet to be turned down
    std::uint32_t pause_ = 1;        ///< how many, after the next in vain
    float packet_least_ = 0;
    float packet_most_ = 0;
    bool refuses_positive_ = false;
    bool refuses_negative_ = false;
};

} // namespace proxima::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
