// Sixteen rays that look the same way, opened side by side. Included once per target.
//
//     lanes    rays; what prepare_ray() works out for one, in the same doubles
//     packet   of rays with one octant, one largest axis and an ordinary size, not from far away

#if defined(PROXIMA_QUERY_OPEN_PACKET_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef PROXIMA_QUERY_OPEN_PACKET_INL_H
#undef PROXIMA_QUERY_OPEN_PACKET_INL_H
#else
#define PROXIMA_QUERY_OPEN_PACKET_INL_H
#endif

#include "index/index_parts.h"
#include "query/rays/prepare_ray.h"
#include "query/rays/walk_ray-inl.h"

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

using DoubleTag = hn::CappedTag<double, 8>;
using Doubles = hn::Vec<DoubleTag>;
inline constexpr std::size_t double_lanes = HWY_MIN(8, HWY_LANES(double));

/// A number of every ray.
struct PacketFloats {
    HWY_ALIGN float values[packet_size];

    HWY_INLINE RayFloats part(std::size_t i) const
    {
        return hn::Load(RayTag(), values + ray_lanes * i);
    }
};
struct PacketDoubles {
    HWY_ALIGN double values[packet_size];

    HWY_INLINE Doubles from(std::size_t first) const
    {
        return hn::Load(DoubleTag(), values + first);
    }
    HWY_INLINE void set(std::size_t first, Doubles lanes)
    {
        hn::Store(lanes, DoubleTag(), values + first);
    }
};

HWY_INLINE std::uint32_t double_mask_bits(hn::Mask<DoubleTag> mask)
{
    std::uint8_t bits[8] = {};
    (void)hn::StoreMaskBits(DoubleTag(), mask, bits);
    return bits[0] & ((1U << double_lanes) - 1);
}

/// What the walk and the leaves need of each ray; RayTraversal says what is what.
class PacketRays {
public:
    PacketDoubles slopes_x; ///< of the shear, which has these axes
    PacketDoubles slopes_y;
    PacketDoubles inverses_z;
    PacketDoubles rate;
    PacketDoubles shift;
    std::array<std::uint32_t, 3> axes{};
    std::uint32_t octant = 0;
    std::uint32_t ready = 0; ///< bits of the rays that come to the root; of others `most` is -inf
    float error = 0;         ///< the greatest of all
    float t_error = 0;
    std::array<PacketFloats, 3> inverse; ///< by axis
    std::array<PacketFloats, 3> origin;
    PacketFloats slope_x;
    PacketFloats slope_y;
    PacketFloats inverse_z;
    PacketFloats least;
    PacketFloats most;
    PacketFloats sure_least;
    PacketFloats sure_most;

    /// False where they are no packet: some invalid, for one. \pre packet_size rays
    HWY_INLINE bool open(const IndexParts& index, std::span<const Ray> rays)
    {
        if (!may_look_alike(rays)) return false;
        const RayShear shear(rays.front().direction);
        axes = {shear.x, shear.y, shear.z};
        octant = 0;
        for (std::size_t axis = 0; axis < 3; ++axis)
            octant |= (std::signbit(rays.front().direction.data()[axis]) ? 1U : 0U) << axis;
        for (std::size_t i = 0; i < packet_size; ++i) {
            for (std::size_t axis = 0; axis < 3; ++axis) {
                given_direction_[axis].values[i] = rays[i].direction.data()[axis];
                given_origin_[axis].values[i] = rays[i].origin.data()[axis];
            }
            t_min_.values[i] = rays[i].t_min;
            t_max_.values[i] = rays[i].t_max;
        }
        for (std::size_t first = 0; first < packet_size; first += double_lanes)
            if (!look_the_same_way(first)) return false;
        ready = 0;
        error = 0;
        t_error = 0;
        for (std::size_t first = 0; first < packet_size; first += double_lanes)
            if (!open_from(index, first)) return false;
        if (ready != 0 && ready != (1U << packet_size) - 1) lend_numbers();
        return true;
    }

private:
    using FloatTag = hn::Rebind<float, DoubleTag>;
    using BitTag = hn::RebindToUnsigned<DoubleTag>;

    /// By some of the rays, so that those that go anywhere are soon turned down.
    static HWY_INLINE bool may_look_alike(std::span<const Ray> rays)
    {
        const Vec3& first = rays.front().direction;
        const double reach = 0.5 * first.cwiseAbs().maxCoeff();
        const auto is_near = [&](const Ray& ray) {
            return (ray.direction - first).cwiseAbs().maxCoeff() <= reach;
        };
        return is_near(rays[packet_size / 2]) && is_near(rays.back());
    }

    HWY_INLINE bool look_the_same_way(std::size_t first) const
    {
        const DoubleTag d;
        const auto size = [&](std::size_t axis) {
            return hn::Abs(given_direction_[axis].from(first));
        };
        // As RayShear chooses.
        const auto is_third = hn::Gt(size(2), hn::Max(size(0), size(1)));
        const auto is_second = hn::AndNot(is_third, hn::Gt(size(1), size(0)));
        auto same = axes[2] == 2   ? is_third
                    : axes[2] == 1 ? is_second
                                   : hn::Not(hn::Or(is_second, is_third));
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const auto sign = hn::CopySign(hn::Set(d, 1.0), given_direction_[axis].from(first));
            same = hn::And(same, hn::Eq(sign, hn::Set(d, (octant >> axis & 1U) != 0 ? -1.0 : 1.0)));
        }
        return hn::AllTrue(d, same);
    }

    static HWY_INLINE hn::Vec<FloatTag> lowered(Doubles value) // rounded_down()
    {
        const FloatTag f;
        const auto nearest = hn::DemoteTo(f, value);
        return hn::Sub(nearest, hn::Mul(hn::Min(hn::Abs(nearest), hn::Set(f, 0x1p100F)),
                                        hn::Set(f, 0x1p-23F)));
    }
    static HWY_INLINE hn::Vec<FloatTag> raised(Doubles value)
    {
        return hn::Neg(lowered(hn::Neg(value)));
    }

    HWY_INLINE bool open_from(const IndexParts& index, std::size_t first)
    {
        const DoubleTag d;
        const FloatTag f;
        const BitTag bits;
        const auto [x, y, z] = axes;
        const auto along = given_direction_[z].from(first);
        const auto exponent =
            hn::And(hn::BitCast(bits, along), hn::Set(bits, RayUnit::exponent_bits));
        const auto unscale = hn::BitCast(d, exponent);
        const auto scale = hn::BitCast(d, hn::Sub(hn::Set(bits, RayUnit::inverting), exponent));
        const auto rates = hn::Mul(hn::Set(d, index.scale()), unscale);
        const auto is_ordinary = [&](Doubles value) {
            return hn::And(hn::Gt(value, hn::Set(d, RayUnit::least)),
                           hn::Lt(value, hn::Set(d, RayUnit::most)));
        };
        auto usual = hn::And(is_ordinary(unscale), is_ordinary(rates));
        Doubles origins[3];
        Doubles directions[3];
        Doubles inverses[3];
        auto distance = hn::Zero(d);
        auto sum = hn::Zero(d); // finite where all numbers of the ray are, but for huge ones
        const RootBox& box = index.root_box();
        // Rays are moved to a cube about the root, most of them to the same face: so origins of a
        // packet stay together better than on the root's box.
        auto nears = hn::Set(d, -std::numeric_limits<double>::infinity());
        auto enters = hn::Set(d, -std::numeric_limits<double>::infinity());
        auto leaves = hn::Set(d, std::numeric_limits<double>::infinity());
        for (std::size_t axis = 0; axis < 3; ++axis) {
            origins[axis] = hn::Mul(
                hn::Sub(given_origin_[axis].from(first), hn::Set(d, index.center().data()[axis])),
                hn::Set(d, index.scale()));
            directions[axis] = hn::Mul(given_direction_[axis].from(first), scale);
            distance = hn::Max(distance, hn::Abs(origins[axis]));
            sum = hn::Add(
                sum, hn::Add(given_origin_[axis].from(first), given_direction_[axis].from(first)));
            const auto tiny = hn::Set(d, 0x1p-500); // so that nothing is infinite
            inverses[axis] =
                hn::Div(hn::Set(d, 1.0),
                        hn::CopySign(hn::Max(hn::Abs(directions[axis]), tiny), directions[axis]));
            const auto t_at = [&](double plane) {
                return hn::Mul(hn::Sub(hn::Set(d, plane), origins[axis]), inverses[axis]);
            };
            const auto one = t_at(box.lower[axis]);
            const auto other = t_at(box.upper[axis]);
            nears = hn::Max(
                nears, hn::Min(t_at(-RayTraversal::cube_reach), t_at(RayTraversal::cube_reach)));
            enters = hn::Max(enters, hn::Min(one, other));
            leaves = hn::Min(leaves, hn::Max(one, other));
        }
        usual = hn::And(usual, hn::Eq(hn::Sub(sum, sum), hn::Zero(d)));
        usual = hn::And(usual, hn::And(hn::Le(distance, hn::Set(d, RayTraversal::far)),
                                       hn::Le(t_min_.from(first), t_max_.from(first))));
        if (!hn::AllTrue(d, usual)) return false;

        const auto outside = hn::Gt(distance, hn::Set(d, RayTraversal::cube_reach));
        const auto own_least = hn::Mul(t_min_.from(first), rates);
        const auto own_most = hn::Mul(t_max_.from(first), rates);
        const auto start = hn::Max(own_least, enters);
        const auto end = hn::Min(own_most, leaves);
        const auto comes = hn::Le(start, end);
        const auto shifts = hn::IfThenElseZero(outside, hn::Max(own_least, nears));
        const auto moved = hn::IfThenElseZero(outside, hn::Mul(hn::Set(d, 0x1p-50), distance));
        ready |= double_mask_bits(comes) << first;
        rate.set(first, rates);
        shift.set(first, shifts);
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const auto most_inverse = hn::Set(d, RayTraversal::most_inverse);
            const auto limited =
                hn::CopySign(hn::Min(hn::Abs(inverses[axis]), most_inverse), inverses[axis]);
            hn::StoreU(hn::DemoteTo(f, limited), f, inverse[axis].values + first);
            const auto moved_origin = hn::MulAdd(shifts, directions[axis], origins[axis]);
            hn::StoreU(hn::DemoteTo(f, moved_origin), f, origin[axis].values + first);
        }
        const auto backward = hn::Div(hn::Set(d, 1.0), along);
        const auto across_x = hn::Mul(given_direction_[x].from(first), backward);
        const auto across_y = hn::Mul(given_direction_[y].from(first), backward);
        inverses_z.set(first, backward);
        slopes_x.set(first, across_x);
        slopes_y.set(first, across_y);
        hn::StoreU(hn::DemoteTo(f, across_x), f, slope_x.values + first);
        hn::StoreU(hn::DemoteTo(f, across_y), f, slope_y.values + first);
        hn::StoreU(hn::DemoteTo(f, hn::Mul(backward, unscale)), f, inverse_z.values + first);

        // As RayTraversal::set_range.
        const auto float_moved = hn::DemoteTo(f, moved);
        const auto growth =
            hn::Add(hn::Set(f, 1.0F), hn::Mul(float_moved, hn::Set(f, 1 / (8 * float_roundoff))));
        const auto t_off =
            hn::Add(hn::Set(f, 40 * float_roundoff), hn::Mul(hn::Set(f, 2.0F), float_moved));
        const auto range_off = hn::Mul(hn::Set(f, 4.0F), t_off);
        const auto surely = [&](const PacketDoubles& t) {
            return hn::Sub(hn::Mul(t.from(first), rates), shifts);
        };
        hn::StoreU(hn::Sub(lowered(hn::Sub(start, shifts)), range_off), f, least.values + first);
        hn::StoreU(hn::Add(raised(hn::Sub(end, shifts)), range_off), f, most.values + first);
        hn::StoreU(hn::Add(raised(surely(t_min_)), t_off), f, sure_least.values + first);
        hn::StoreU(hn::Sub(lowered(surely(t_max_)), t_off), f, sure_most.values + first);
        error = HWY_MAX(error, hn::GetLane(hn::MaxOfLanes(f, hn::Mul(growth, growth))));
        t_error = HWY_MAX(t_error, hn::GetLane(hn::MaxOfLanes(f, t_off)));
        return true;
    }

    /// Those that miss the root are given what a ray has that does not, and look for nothing.
    void lend_numbers()
    {
        const auto leader = static_cast<std::size_t>(std::countr_zero(ready));
        for (std::size_t i = 0; i < packet_size; ++i) {
            if ((ready >> i & 1U) != 0) continue;
            for (std::size_t axis = 0; axis < 3; ++axis) {
                inverse[axis].values[i] = inverse[axis].values[leader];
                origin[axis].values[i] = origin[axis].values[leader];
            }
            least.values[i] = least.values[leader];
            most.values[i] = -std::numeric_limits<float>::infinity();
        }
    }

    std::array<PacketDoubles, 3> given_origin_;
    std::array<PacketDoubles, 3> given_direction_;
    PacketDoubles t_min_;
    PacketDoubles t_max_;
};

} // namespace proxima::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
