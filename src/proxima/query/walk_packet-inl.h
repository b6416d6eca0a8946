// Rays that go much the same way, through a ray index together. Included once per target.
//
//     nodes    once for all: where the first of them could enter a box, and the last leave it, by
//              intervals of origins and directions; lanes are children
//     leaves   a triangle at a time; lanes are rays
//
// An interval's ends are those of rays. (p - o) r is least at one of its corners, and at the two
// that are asked; rounding is that of a single ray with the largest r, which boxes have margins for
// as long as no other is below 4/5 of it (build_ray_index.cpp: 15 of 20 u, half of step / 64).

#if defined(PROXIMA_QUERY_WALK_PACKET_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef PROXIMA_QUERY_WALK_PACKET_INL_H
#undef PROXIMA_QUERY_WALK_PACKET_INL_H
#else
#define PROXIMA_QUERY_WALK_PACKET_INL_H
#endif

#include "proxima/query/open_ray-inl.h"
#include "proxima/query/walk_ray-inl.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>

HWY_BEFORE_NAMESPACE();
namespace proxima::HWY_NAMESPACE {

/// Rays of a packet.
inline constexpr std::size_t packet_size = 16;
inline constexpr std::size_t packet_parts = packet_size / ray_lanes;

/// A number of every ray.
struct PacketFloats {
    HWY_ALIGN float values[packet_size];

    HWY_INLINE RayFloats part(std::size_t i) const
    {
        return hn::Load(RayTag(), values + ray_lanes * i);
    }
};

/// Whether rays look alike enough to be worth opening as a packet: a guess.
HWY_INLINE bool look_alike(std::span<const Ray> rays)
{
    const Ray& first = rays.front();
    const double reach = 0.25 * first.direction.cwiseAbs().maxCoeff();
    return std::ranges::all_of(rays.subspan(1), [&](const Ray& ray) {
        const Vec3 off = (ray.direction - first.direction).cwiseAbs();
        return std::max({off[0], off[1], off[2]}) <= reach;
    });
}

template <class Search>
class PacketWalk {
public:
    HWY_INLINE PacketWalk(const RayIndex& index, const Search& search)
        : index_(index), blocks_(index.blocks().data()), search_(search)
    {}

    /// Answers packet_size rays of the source. False where they are no packet: nothing is answered.
    HWY_INLINE bool run(const RaySource& source, std::size_t first)
    {
        std::array<RayStart, packet_size> starts;
        std::size_t leader = packet_size;
        for (std::size_t i = 0; i < packet_size; ++i) {
            starts[i] = open_any_ray(index_, source.rays[first + i], source.faces, rays_[i]);
            rays_[i].place = static_cast<std::uint32_t>(first + i);
            if (starts[i] == RayStart::ready && leader == packet_size) leader = i;
        }
        if (leader < packet_size) {
            if (!gather(starts, leader)) return false;
            walk(rays_[leader]);
        }
        for (std::size_t i = 0; i < packet_size; ++i) {
            OpenRay& ray = rays_[i];
            if (starts[i] == RayStart::ready) {
                write_back(i);
                search_.settle(ray);
                source.answer(source.context, ray);
            } else {
                source.refuse(source.context, ray.place, starts[i]);
            }
        }
        return true;
    }

private:
    static constexpr float infinity = std::numeric_limits<float>::infinity();

    /// The least and the most of the rays' numbers on an axis.
    struct Interval {
        float least = infinity;
        float most = -infinity;

        HWY_INLINE void add(float value)
        {
            least = HWY_MIN(least, value);
            most = HWY_MAX(most, value);
        }
    };

    /// One end of an interval of directions: their inverse, and - o r for the origins that enter
    /// first and leave last.
    struct End {
        RayQuad inverse;
        RayQuad enter;
        RayQuad leave;
    };

    /// Intervals, and what leaves need of each ray. False where rays are too different.
    HWY_INLINE bool gather(const std::array<RayStart, packet_size>& starts, std::size_t leader)
    {
        const OpenRay& like = rays_[leader];
        axes_ = like.axes;
        refuses_positive_ = like.refuses_positive;
        refuses_negative_ = like.refuses_negative;
        std::array<Interval, 3> inverse;
        std::array<Interval, 3> origin;
        Interval range;
        Interval error;
        Interval t_error;
        bool fits = true;
        for (std::size_t i = 0; i < packet_size; ++i) {
            const bool is_ready = starts[i] == RayStart::ready;
            const OpenRay& ray = is_ready ? rays_[i] : like;
            fits = fits && ray.octant == like.octant && ray.axes == like.axes;
            for (std::size_t k = 0; k < 3; ++k) {
                inverse[k].add(ray.inverse[k][0]);
                origin[ray.axes[k]].add(ray.origin[k]);
                origin_[k].values[i] = ray.origin[k];
            }
            range.add(ray.least);
            error.add(ray.error);
            t_error.add(ray.t_error);
            slope_x_.values[i] = ray.slope_x;
            slope_y_.values[i] = ray.slope_y;
            inverse_z_.values[i] = ray.inverse_z;
            least_.values[i] = ray.least;
            most_.values[i] = is_ready ? ray.most : -infinity;
            sure_least_.values[i] = ray.sure_least;
            sure_most_.values[i] = ray.sure_most;
            best_least_.values[i] = ray.best_least;
            noted_[i] = ray.best_noted;
        }
        packet_least_ = range.least;
        error_ = error.most;
        t_error_ = t_error.most;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const bool rises = inverse[axis].least > 0;
            const float small = std::abs(rises ? inverse[axis].least : inverse[axis].most);
            const float large = std::abs(rises ? inverse[axis].most : inverse[axis].least);
            constexpr float most_apart = 0.25F; // of origins: a guess as well
            fits = fits && large <= 1.25F * small &&
                   origin[axis].most - origin[axis].least <= most_apart;
            const float enters = rises ? origin[axis].most : origin[axis].least;
            const float leaves = rises ? origin[axis].least : origin[axis].most;
            for (std::size_t i = 0; i < 2; ++i) {
                const float r = i == 0 ? inverse[axis].least : inverse[axis].most;
                ends_[axis][i].inverse.fill(r);
                ends_[axis][i].enter.fill(-enters * r);
                ends_[axis][i].leave.fill(-leaves * r);
            }
        }
        find_most();
        return fits;
    }

    HWY_INLINE void find_most()
    {
        packet_most_ = most_.values[0];
        for (const float most : most_.values) packet_most_ = HWY_MAX(packet_most_, most);
    }

    /// Children that some ray may meet.
    HWY_INLINE MetChildren meet(const RayNode& node, std::uint32_t octant) const
    {
        const RayTag d;
        const std::uint8_t(&shuffles)[3][2][32] = plane_shuffles.bytes[octant];
        MetChildren met;
        for (std::size_t part = 0; part < 8 / ray_lanes; ++part) {
            auto near = hn::Set(d, packet_least_);
            auto far = hn::Set(d, packet_most_);
            for (std::size_t axis = 0; axis < 3; ++axis) {
                const std::size_t own = 4 * ray_lanes * part;
                const auto front = plane_numbers(node.planes[axis], shuffles[axis][0] + own);
                const auto back = plane_numbers(node.planes[axis], shuffles[axis][1] + own);
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
            met.bits |= mask_bits(hn::Le(near, far)) << (ray_lanes * part);
        }
        return met;
    }

    /// `like` lends its octant, and its room for blocks put aside.
    HWY_INLINE void walk(OpenRay& like)
    {
        RayPlace at = like.at;
        while (at.next != OpenRay::end) {
            const std::uint32_t place = at.next & ~ray_leaf_bit;
            if ((at.next & ray_leaf_bit) == 0) {
                const RayNode& node = blocks_[place].node;
                const MetChildren met = meet(node, like.octant);
                if (met.bits != 0) {
                    enter_nearest(node, met, like, at);
                    prefetch_block(blocks_[like.references[at.pending - 1] & ~ray_leaf_bit]);
                    continue;
                }
            } else {
                look_at_leaf_together(place);
            }
            do {
                --at.pending;
            } while (like.nearness[at.pending] > packet_most_);
            at.next = like.references[at.pending];
        }
    }

    /// As look_at_leaf, but that rays may pass by far from the leaf's box.
    HWY_INLINE void look_at_leaf_together(std::uint32_t place)
    {
        const RayTag d;
        const RayLeaf& leaf = blocks_[place].leaf;
        bool changes = false;
        for (std::size_t part = 0; part < packet_parts; ++part) {
            Corners corners;
            auto reach = hn::Zero(d);
            for (std::size_t i = 0; i < 8; ++i) {
                const auto about = [&](std::size_t k) {
                    return hn::Sub(hn::Set(d, leaf.coordinates[axes_[k]][i]),
                                   origin_[k].part(part));
                };
                const auto along = about(2);
                const auto x = hn::NegMulAdd(along, slope_x_.part(part), about(0));
                const auto y = hn::NegMulAdd(along, slope_y_.part(part), about(1));
                reach = hn::Max(reach, hn::Max(hn::Abs(x), hn::Abs(y)));
                hn::Store(x, d, corners.x[i]);
                hn::Store(y, d, corners.y[i]);
                hn::Store(along, d, corners.z[i]);
            }
            const auto error = hn::Mul(hn::Add(reach, hn::Set(d, 32 * float_roundoff)),
                                       hn::Set(d, 86 * float_roundoff * error_));
            hn::Store(error, d, corners.error);
            for (std::uint32_t lane = 0; lane < leaf.count; ++lane)
                changes = look_at_triangle({place, lane}, part, corners) || changes;
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
    HWY_INLINE bool look_at_triangle(RayTriangle triangle, std::size_t part, const Corners& corners)
    {
        const RayTag d;
        const RayLeaf& leaf = blocks_[triangle.leaf].leaf;
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
        const auto most = most_.part(part);
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
        const auto t = hn::Mul(hn::Mul(mean, inverse), inverse_z_.part(part));
        const auto off = hn::MulAdd(hn::Mul(error, hn::Abs(inverse)),
                                    hn::Set(d, 5 * leaf_extent(leaf)), hn::Set(d, t_error_));
        const auto first = hn::Sub(t, off);
        const auto last = hn::Add(t, off);
        const auto sure = hn::And(wanted, hn::Gt(hn::Abs(sum), hn::Mul(error, hn::Set(d, 8.0F))));
        const auto out =
            hn::And(sure, hn::Or(hn::Gt(first, most), hn::Lt(last, least_.part(part))));
        const auto in = hn::And(sure, hn::And(hn::Ge(first, sure_least_.part(part)),
                                              hn::Le(last, sure_most_.part(part))));
        // Rays that no longer look for hits have a `most` below everything.
        const auto looks = hn::Gt(most, hn::Set(d, -infinity));
        rays &= mask_bits(hn::And(hn::Not(out), looks));
        std::uint32_t noted = 0;
        if constexpr (Search::notes_hits) {
            const auto best_least = best_least_.part(part);
            const auto better =
                hn::And(hn::And(in, looks), hn::And(hn::Le(first, most), hn::Lt(last, best_least)));
            noted = mask_bits(better) & rays;
            hn::Store(hn::IfThenElse(better, last, most), d, most_.values + ray_lanes * part);
            hn::Store(hn::IfThenElse(better, first, best_least), d,
                      best_least_.values + ray_lanes * part);
            for (std::uint32_t left = noted; left != 0; left &= left - 1)
                noted_[ray_lanes * part + static_cast<std::size_t>(std::countr_zero(left))] =
                    triangle;
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
    HWY_INLINE void ask(RayTriangle triangle, std::size_t i, float first, float last, bool sure)
    {
        LeafCandidates candidates;
        candidates.lanes = 1U << triangle.lane;
        candidates.sure = sure ? candidates.lanes : 0;
        candidates.least[triangle.lane] = first;
        candidates.most[triangle.lane] = last;
        write_back(i);
        OpenRay& ray = rays_[i];
        const bool goes_on = search_.take(triangle.leaf, candidates, ray);
        most_.values[i] = goes_on ? ray.most : -infinity;
        best_least_.values[i] = ray.best_least;
        noted_[i] = ray.best_noted;
    }

    HWY_INLINE void write_back(std::size_t i)
    {
        rays_[i].most = most_.values[i];
        rays_[i].best_least = best_least_.values[i];
        rays_[i].best_noted = noted_[i];
    }

    const RayIndex& index_;
    const RayBlock* blocks_;
    const Search& search_;
    std::array<OpenRay, packet_size> rays_;
    End ends_[3][2];
    float packet_least_ = 0;
    float packet_most_ = 0;
    float error_ = 0;
    float t_error_ = 0;
    std::array<std::uint32_t, 3> axes_{};
    bool refuses_positive_ = false;
    bool refuses_negative_ = false;
    std::array<PacketFloats, 3> origin_;
    PacketFloats slope_x_;
    PacketFloats slope_y_;
    PacketFloats inverse_z_;
    PacketFloats least_;
    PacketFloats most_;
    PacketFloats sure_least_;
    PacketFloats sure_most_;
    PacketFloats best_least_;
    std::array<RayTriangle, packet_size> noted_;
};

} // namespace proxima::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
