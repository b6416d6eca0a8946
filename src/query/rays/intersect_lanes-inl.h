// Rays and the triangles that they surely hit, asked in doubles side by side. Included once per
// target.
//
//     lanes   hits; each step is that of intersect() (ray_triangle-inl.h), so that bits are the
//             same; where it is not sure of itself, or finds no hit, that is called instead

#if defined(PROXIMA_QUERY_ASK_TOGETHER_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef PROXIMA_QUERY_ASK_TOGETHER_INL_H
#undef PROXIMA_QUERY_ASK_TOGETHER_INL_H
#else
#define PROXIMA_QUERY_ASK_TOGETHER_INL_H
#endif

#include "base/inline_steps-inl.h"
#include "geometry/ray_triangle-inl.h"
#include "index/index_parts.h"
#include "query/rays/prepare_packet-inl.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

HWY_BEFORE_NAMESPACE();
namespace proxima::HWY_NAMESPACE {

/// The answers to rays of a source whose only hit that counts is known.
class HitLanes {
public:
    HWY_INLINE HitLanes(const IndexParts& index, const RaySource& source)
        : index_(index), source_(source)
    {}

    /// To be answered now or later. The shear is of the ray's direction.
    HWY_INLINE void add(std::uint32_t number, const RayShear& shear, RayTriangle triangle)
    {
        const std::size_t lane = count_++;
        const Ray& ray = source_.rays[number];
        const IndexLeaf& leaf = index_.blocks()[triangle.leaf].leaf;
        const std::array<std::uint32_t, 3> axes = {shear.x, shear.y, shear.z};
        numbers_[lane] = number;
        rows_[lane] = leaf.first_row + triangle.lane;
        if (index_.has_exact_leaves()) {
            for (std::size_t k = 0; k < 3; ++k) {
                const auto& coordinates = leaf.coordinates[axes[k]];
                const double center = index_.center().data()[axes[k]];
                for (std::size_t i = 0; i < 3; ++i) {
                    const std::size_t vertex = leaf.corners[i][triangle.lane];
                    corners_[i][k].values[lane] =
                        static_cast<double>(coordinates[vertex]) * index_.unscale() + center;
                }
            }
        } else {
            const Triangle own = index_.triangle(rows_[lane]);
            for (std::size_t i = 0; i < 3; ++i) {
                for (std::size_t k = 0; k < 3; ++k)
                    corners_[i][k].values[lane] = own.vertices[i].data()[axes[k]];
            }
        }
        for (std::size_t k = 0; k < 3; ++k) origin_[k].values[lane] = ray.origin.data()[axes[k]];
        slope_x_.values[lane] = shear.slope_x;
        slope_y_.values[lane] = shear.slope_y;
        inverse_z_.values[lane] = shear.inverse_z;
        t_min_.values[lane] = ray.t_min;
        t_max_.values[lane] = ray.t_max;
        if (count_ == packet_size) answer();
    }

    /// Answers all that wait.
    PROXIMA_STEP void answer()
    {
        for (std::size_t first = 0; first < count_; first += double_lanes) {
            const std::uint32_t sure = intersect_from(first);
            const std::size_t end = HWY_MIN(count_, first + double_lanes);
            for (std::size_t lane = first; lane < end; ++lane) {
                const std::uint32_t number = numbers_[lane];
                if ((sure >> (lane - first) & 1U) == 0) {
                    const auto hit =
                        ask_row(index_, rows_[lane], source_.rays[number], source_.faces);
                    source_.answer(source_.context, number, hit ? &*hit : nullptr);
                    continue;
                }
                RayHit hit;
                hit.t = t_.values[lane];
                hit.triangle = index_.ids()[rows_[lane]];
                hit.u = u_.values[lane];
                hit.v = v_.values[lane];
                source_.answer(source_.context, number, &hit);
            }
        }
        count_ = 0;
    }

private:
    /// As std::min and std::max choose between zeros.
    static HWY_INLINE Doubles lesser(Doubles a, Doubles b)
    {
        return hn::IfThenElse(hn::Lt(b, a), b, a);
    }
    static HWY_INLINE Doubles greater(Doubles a, Doubles b)
    {
        return hn::IfThenElse(hn::Lt(a, b), b, a);
    }

    /// Bits of the lanes whose hits are found.
    HWY_INLINE std::uint32_t intersect_from(std::size_t first)
    {
        const DoubleTag d;
        const auto slope_x = slope_x_.from(first);
        const auto slope_y = slope_y_.from(first);
        const auto inverse_z = inverse_z_.from(first);
        Doubles x[3];
        Doubles y[3];
        Doubles depths[3];
        auto size = hn::Zero(d);
        auto reach = hn::Zero(d);
        for (std::size_t i = 0; i < 3; ++i) {
            const auto about = [&](std::size_t k) {
                return hn::Sub(corners_[i][k].from(first), origin_[k].from(first));
            };
            const auto about_x = about(0);
            const auto about_y = about(1);
            const auto about_z = about(2);
            x[i] = hn::Sub(about_x, hn::Mul(slope_x, about_z));
            y[i] = hn::Sub(about_y, hn::Mul(slope_y, about_z));
            depths[i] = hn::Mul(about_z, inverse_z);
            size = hn::Max(size,
                           hn::Max(hn::Max(hn::Abs(about_x), hn::Abs(about_y)), hn::Abs(about_z)));
            reach = hn::Max(reach, hn::Max(hn::Abs(x[i]), hn::Abs(y[i])));
        }
        Doubles weights[3];
        for (std::size_t i = 0; i < 3; ++i) {
            const std::size_t b = (i + 1) % 3;
            const std::size_t c = (i + 2) % 3;
            weights[i] = hn::Sub(hn::Mul(x[b], y[c]), hn::Mul(y[b], x[c]));
        }
        const auto error = hn::Mul(hn::Mul(hn::Set(d, detail::error_factor), size),
                                   hn::Add(reach, hn::Mul(hn::Set(d, detail::own_error), size)));
        const auto sum = hn::Add(hn::Add(weights[0], weights[1]), weights[2]);
        const auto least_weight = hn::Min(hn::Min(weights[0], weights[1]), weights[2]);
        const auto most_weight = hn::Max(hn::Max(weights[0], weights[1]), weights[2]);
        auto sure = hn::And(
            hn::And(hn::Ge(error, hn::Set(d, detail::safe_error)),
                    hn::Le(error, hn::Set(d, detail::greatest_error))),
            hn::And(hn::Or(hn::Gt(least_weight, error), hn::Lt(most_weight, hn::Neg(error))),
                    hn::Gt(hn::Abs(sum), hn::Mul(hn::Set(d, detail::sure_sum), error))));
        if (source_.faces != Faces::both) {
            // The sum times the sign of the direction is negative where the front is seen.
            const auto seen = hn::Mul(sum, inverse_z);
            sure = hn::And(sure, source_.faces == Faces::front ? hn::Lt(seen, hn::Zero(d))
                                                               : hn::Gt(seen, hn::Zero(d)));
        }
        Doubles shares[3];
        for (std::size_t i = 0; i < 3; ++i) shares[i] = hn::Div(weights[i], sum);
        auto t = hn::Add(hn::Add(hn::Mul(shares[0], depths[0]), hn::Mul(shares[1], depths[1])),
                         hn::Mul(shares[2], depths[2]));
        const auto least = lesser(lesser(depths[0], depths[1]), depths[2]);
        const auto most = greater(greater(depths[0], depths[1]), depths[2]);
        t = hn::IfThenElse(hn::Lt(t, least), least, hn::IfThenElse(hn::Lt(most, t), most, t));
        sure = hn::And(sure, hn::Le(hn::Abs(t), hn::Set(d, farthest_hit)));
        sure = hn::And(sure, hn::And(hn::Le(t_min_.from(first), t), hn::Le(t, t_max_.from(first))));
        // What is below t_min is not found either.
        const auto farthest = hn::Max(hn::Abs(least), hn::Abs(most));
        sure =
            hn::And(sure, hn::Gt(hn::Abs(t), hn::Mul(hn::Set(d, detail::start_doubt), farthest)));
        t_.set(first, t);
        u_.set(first, shares[1]);
        v_.set(first, shares[2]);
        return double_mask_bits(sure);
    }

    const IndexParts& index_;
    const RaySource& source_;
    std::size_t count_ = 0;
    std::array<std::uint32_t, packet_size> numbers_{};
    std::array<std::uint32_t, packet_size> rows_{};
    std::array<std::array<PacketDoubles, 3>, 3> corners_{}; ///< by corner, then by the shear's axes
    std::array<PacketDoubles, 3> origin_{};
    PacketDoubles slope_x_{};
    PacketDoubles slope_y_{};
    PacketDoubles inverse_z_{};
    PacketDoubles t_min_{};
    PacketDoubles t_max_{};
    PacketDoubles t_;
    PacketDoubles u_;
    PacketDoubles v_;
};

} // namespace proxima::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
