#include "proxima/haptics/contact_cache.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "proxima/haptics/contact_cache.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace proxima::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using NearTag = hn::CappedTag<float, 16>;
using NearFloats = hn::Vec<NearTag>;

struct NearVectors {
    NearFloats x, y, z;
};

HWY_INLINE NearFloats dot(const NearVectors& a, const NearVectors& b)
{
    return hn::MulAdd(a.z, b.z, hn::MulAdd(a.y, b.y, hn::Mul(a.x, b.x)));
}
HWY_INLINE NearVectors difference(const NearVectors& a, const NearVectors& b)
{
    return {hn::Sub(a.x, b.x), hn::Sub(a.y, b.y), hn::Sub(a.z, b.z)};
}
HWY_INLINE NearVectors cross(const NearVectors& a, const NearVectors& b)
{
    return {hn::MulSub(a.y, b.z, hn::Mul(a.z, b.y)), hn::MulSub(a.z, b.x, hn::Mul(a.x, b.z)),
            hn::MulSub(a.x, b.y, hn::Mul(a.y, b.x))};
}

/// Squared distance from the origin to the segment from a, along u. A point where u is zero.
HWY_INLINE NearFloats side_distance(const NearVectors& a, const NearVectors& u)
{
    const NearTag d;
    const auto length = hn::Max(dot(u, u), hn::Set(d, 1e-30F));
    const auto part = hn::Div(hn::Neg(dot(a, u)), length);
    const auto t = hn::Min(hn::Max(part, hn::Zero(d)), hn::Set(d, 1.0F));
    const NearVectors at = {hn::MulAdd(t, u.x, a.x), hn::MulAdd(t, u.y, a.y),
                            hn::MulAdd(t, u.z, a.z)};
    return dot(at, at);
}

/// Squared distances from the origin; 0 where a corner is so sharp that the normal says little.
HWY_INLINE NearFloats triangle_distance(const NearVectors& a, const NearVectors& b,
                                        const NearVectors& c)
{
    const NearTag d;
    const auto zero = hn::Zero(d);
    const NearVectors u = difference(b, a);
    const NearVectors w = difference(c, a);
    const NearVectors v = difference(c, b);
    const auto sides =
        hn::Min(side_distance(a, u), hn::Min(side_distance(a, w), side_distance(b, v)));
    const NearVectors n = cross(u, w);
    const auto nn = dot(n, n);
    // The foot is a + (at_b u + at_c w) / nn.
    const auto at_b = dot(cross(w, a), n);
    const auto at_c = dot(cross(a, u), n);
    const auto inside =
        hn::And(hn::And(hn::Ge(at_b, zero), hn::Ge(at_c, zero)), hn::Le(hn::Add(at_b, at_c), nn));
    const auto height = dot(n, a);
    const auto plane = hn::Div(hn::Mul(height, height), hn::Max(nn, hn::Set(d, 1e-30F)));
    const auto sharp = hn::Le(nn, hn::Mul(hn::Mul(dot(u, u), dot(w, w)), hn::Set(d, 0x1p-10F)));
    return hn::IfThenElse(sharp, zero, hn::IfThenElse(inside, plane, sides));
}

/// The kept triangles from `first` on, as a place sees them.
struct KeptLanes {
    NearVectors corner[3];
    NearFloats limit; ///< what is asked for and the margin
};

HWY_INLINE KeptLanes load_lanes(const TriangleFloats& kept, std::size_t first, const NearVectors& p,
                                NearFloats distance)
{
    const NearTag d;
    KeptLanes lanes;
    for (std::size_t k = 0; k < 3; ++k) {
        const auto& at = kept.corners[k];
        lanes.corner[k] = {hn::Sub(hn::LoadU(d, at[0].data() + first), p.x),
                           hn::Sub(hn::LoadU(d, at[1].data() + first), p.y),
                           hn::Sub(hn::LoadU(d, at[2].data() + first), p.z)};
    }
    lanes.limit = hn::Add(distance, hn::LoadU(d, kept.margin.data() + first));
    return lanes;
}

/// How far the interval of the lanes' three numbers is from the one from `low` to `high`.
HWY_INLINE NearFloats gap(NearFloats a, NearFloats b, NearFloats c, NearFloats low, NearFloats high)
{
    return hn::Max(hn::Sub(hn::Min(a, hn::Min(b, c)), high),
                   hn::Sub(low, hn::Max(a, hn::Max(b, c))));
}

HWY_INLINE NearVectors set_vector(const float* v)
{
    const NearTag d;
    return {hn::Set(d, v[0]), hn::Set(d, v[1]), hn::Set(d, v[2])};
}

/// Adds the lanes of a mask.
template <class Mask>
HWY_INLINE std::size_t write_lanes(Mask mask, std::size_t first, std::uint16_t* found)
{
    const NearTag d;
    std::uint8_t bytes[8] = {};
    (void)hn::StoreMaskBits(d, mask, bytes);
    std::size_t written = 0;
    for (std::uint32_t left = bytes[0] | static_cast<std::uint32_t>(bytes[1]) << 8U; left != 0;
         left &= left - 1)
        found[written++] =
            static_cast<std::uint16_t>(first + static_cast<std::size_t>(std::countr_zero(left)));
    return written;
}

/// Which of the kept triangles may be within a distance, all in units of the ball's reach.
std::size_t scan_ball(const TriangleFloats& kept, std::size_t count, const float* place,
                      float distance, std::uint16_t* found)
{
    const NearTag d;
    const NearVectors p = set_vector(place);
    const auto zero = hn::Zero(d);
    std::size_t written = 0;
    for (std::size_t first = 0; first < count; first += hn::Lanes(d)) {
        const KeptLanes lanes = load_lanes(kept, first, p, hn::Set(d, distance));
        const auto& [a, b, c] = lanes.corner;
        const auto apart = hn::Max(gap(a.x, b.x, c.x, zero, zero),
                                   hn::Max(gap(a.y, b.y, c.y, zero, zero),
                                           gap(a.z, b.z, c.z, zero, zero)));
        const auto near = hn::Le(apart, lanes.limit);
        if (hn::AllFalse(d, near)) continue;
        const auto within = hn::Le(triangle_distance(a, b, c), hn::Mul(lanes.limit, lanes.limit));
        written += write_lanes(hn::And(near, within), first, found + written);
    }
    return written;
}

/// Whether two numbers, along an axis of this squared length, are beyond a limit on the same side.
HWY_INLINE auto are_beyond(NearFloats a, NearFloats b, NearFloats squared_length, NearFloats limit)
{
    const auto least = hn::Min(hn::Mul(a, a), hn::Mul(b, b));
    return hn::And(hn::Gt(hn::Mul(a, b), hn::Zero(NearTag())),
                   hn::Gt(least, hn::Mul(hn::Mul(limit, limit), squared_length)));
}

/// Which of the kept triangles may come within a distance of the way from a place: none of the box's
/// axes, the triangle's normal and the products of its sides with the way separates them.
std::size_t scan_way(const TriangleFloats& kept, std::size_t count, const float* place,
                     const float* way_of, float distance, std::uint16_t* found)
{
    const NearTag d;
    const NearVectors p = set_vector(place);
    const NearVectors way = set_vector(way_of);
    const auto zero = hn::Zero(d);
    const NearVectors low{hn::Min(way.x, zero), hn::Min(way.y, zero), hn::Min(way.z, zero)};
    const NearVectors high{hn::Max(way.x, zero), hn::Max(way.y, zero), hn::Max(way.z, zero)};
    const auto way_squared = dot(way, way);
    const auto blunt = hn::Set(d, 0x1p-10F); // angles whose products say enough
    std::size_t written = 0;
    for (std::size_t first = 0; first < count; first += hn::Lanes(d)) {
        const KeptLanes lanes = load_lanes(kept, first, p, hn::Set(d, distance));
        const auto& [a, b, c] = lanes.corner;
        const auto apart = hn::Max(gap(a.x, b.x, c.x, low.x, high.x),
                                   hn::Max(gap(a.y, b.y, c.y, low.y, high.y),
                                           gap(a.z, b.z, c.z, low.z, high.z)));
        const auto near = hn::Le(apart, lanes.limit);
        if (hn::AllFalse(d, near)) continue;
        const NearVectors u = difference(b, a);
        const NearVectors w = difference(c, a);
        const NearVectors n = cross(u, w);
        const auto nn = dot(n, n);
        const auto start = dot(n, a);
        auto apart_by_axis =
            hn::And(are_beyond(start, hn::Sub(start, dot(n, way)), nn, lanes.limit),
                    hn::Gt(nn, hn::Mul(hn::Mul(dot(u, u), dot(w, w)), blunt)));
        const auto separate = [&](const NearVectors& side, const NearVectors& on,
                                  const NearVectors& opposite) {
            const NearVectors axis = cross(way, side);
            const auto squared = dot(axis, axis);
            const auto enough = hn::Mul(hn::Mul(way_squared, dot(side, side)), blunt);
            apart_by_axis = hn::Or(
                apart_by_axis,
                hn::And(are_beyond(dot(axis, on), dot(axis, opposite), squared, lanes.limit),
                        hn::Gt(squared, enough)));
        };
        separate(u, a, c);
        separate(w, a, b);
        separate(difference(c, b), b, a);
        written += write_lanes(hn::AndNot(apart_by_axis, near), first, found + written);
    }
    return written;
}

} // namespace proxima::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace proxima {

HWY_EXPORT(scan_ball);
HWY_EXPORT(scan_way);

namespace {

constexpr std::size_t most_lanes = 16;

/// A new ball reaches so far beyond what was asked for, in mean edges, at first; then as far as
/// makes about so many triangles: fewer are asked for again too soon, more cost every scan.
constexpr double first_margin = 2.5;
constexpr std::size_t few_triangles = 64;
constexpr std::size_t many_triangles = 192;

/// Of coordinates: more than differences of them and distances between are off by.
constexpr double coordinate_rounding = 0x1p-44;

/// One triangle, in units of the ball's reach from its centre. False where it is outside.
bool write_floats(TriangleFloats& floats, std::size_t place, const Triangle& triangle,
                  const Vec3& center, double per_reach, double rounding) noexcept
{
    const Eigen::Array3d a = (triangle[0] - center).array() * per_reach;
    const Eigen::Array3d b = (triangle[1] - center).array() * per_reach;
    const Eigen::Array3d c = (triangle[2] - center).array() * per_reach;
    const Eigen::Array3d low = a.min(b).min(c);
    const Eigen::Array3d high = a.max(b).max(c);
    const Eigen::Array3d apart = low.max(-high).max(0.0);
    const double most = 1 + 0x1p-20 + rounding;
    if (apart.square().sum() > most * most) return false;
    // Of the places that are asked for, and of the triangle.
    const double size = std::max(1.0, (-low).max(high).maxCoeff());
    // Sides are off by less than 16 roundings of the size, heights of corners that are not sharp
    // by less than 2^8.
    constexpr double largest = 0x1p12;
    const bool fits = size <= largest;
    const auto write = [&](std::size_t corner, const Eigen::Array3d& at) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            floats.corners[corner][axis][place] =
                fits ? static_cast<float>(at[static_cast<Eigen::Index>(axis)]) : 0.0F;
        }
    };
    write(0, a);
    write(1, b);
    write(2, c);
    floats.margin[place] = fits ? static_cast<float>(0x1p-14 * size + rounding)
                                : std::numeric_limits<float>::infinity();
    return true;
}

/// A place in lanes that nothing is near to.
void write_nothing(TriangleFloats& floats, std::size_t place) noexcept
{
    constexpr float far = 1e9F;
    for (auto& corner : floats.corners)
        for (auto& axis : corner) axis[place] = far;
    floats.margin[place] = 0;
}

} // namespace

ContactCache::ContactCache()
    : triangles_(2 * TriangleFloats::room), floats_(1), places_(TriangleFloats::room),
      found_(TriangleFloats::room)
{}

bool ContactCache::keeps(const ContactSurface& surface) noexcept
{
    const std::uint64_t edition = surface.edition();
    if (edition == 0) return false;
    if (edition == edition_) return true;
    edition_ = edition;
    reach_ = -1;
    free_ = -1;
    margin_ = first_margin * surface.scale().mean_edge;
    return true;
}

bool ContactCache::fill(const ContactSurface& surface, const Vec3& p, double distance) noexcept
{
    constexpr int attempts = 6;
    reach_ = -1;
    for (int attempt = 0; attempt < attempts; ++attempt) {
        const double reach = distance + margin_;
        const std::size_t wanted = surface.gather(p, reach, triangles_);
        ++work_.gathers;
        work_.gathered += wanted;
        if (wanted <= triangles_.size() && keep(surface, p, reach, wanted)) {
            if (count_ < few_triangles) margin_ *= 1.25;
            if (count_ > many_triangles && margin_ > 0.5 * distance) margin_ *= 0.8;
            margin_ = std::min(margin_, surface.scale().extent);
            return true;
        }
        margin_ /= 2;
    }
    return false;
}

bool ContactCache::keep(const ContactSurface& surface, const Vec3& center, double reach,
                        std::size_t given) noexcept
{
    rounding_ = coordinate_rounding *
                (surface.scale().reach + center.cwiseAbs().maxCoeff() + reach);
    const double per_reach = 1 / reach;
    TriangleFloats& floats = floats_.front();
    count_ = 0;
    for (std::size_t i = 0; i < given; ++i) {
        if (count_ == TriangleFloats::room) return false;
        if (!write_floats(floats, count_, triangles_[i].corners, center, per_reach,
                          rounding_ * per_reach))
            continue;
        places_[count_++] = static_cast<std::uint16_t>(i);
    }
    for (std::size_t i = count_; i % most_lanes != 0; ++i) write_nothing(floats, i);
    center_ = center;
    reach_ = reach;
    return true;
}

std::array<float, 3> ContactCache::in_units(const Vec3& length) const noexcept
{
    const Vec3 units = length / reach_;
    return {static_cast<float>(units[0]), static_cast<float>(units[1]),
            static_cast<float>(units[2])};
}

bool ContactCache::covers(const ContactSurface& surface, const Vec3& p, double distance) noexcept
{
    if (!keeps(surface)) return false;
    return (p - center_).norm() + distance + rounding_ <= reach_ || fill(surface, p, distance);
}

std::size_t ContactCache::give(std::size_t count, std::span<ContactTriangle> buffer) noexcept
{
    for (std::size_t i = 0; i < std::min(count, buffer.size()); ++i)
        buffer[i] = triangles_[places_[found_[i]]];
    ++work_.scans;
    work_.scanned += count_;
    work_.passed += count;
    return count;
}

std::size_t ContactCache::ask(const ContactSurface& surface, const Vec3& p, double distance,
                              std::span<ContactTriangle> buffer) noexcept
{
    const std::size_t count = surface.collect(p, distance, buffer);
    ++work_.gathers;
    work_.gathered += count;
    work_.passed += count;
    return count;
}

std::size_t ContactCache::collect(const ContactSurface& surface, const Vec3& p, double distance,
                                  std::span<ContactTriangle> buffer) noexcept
{
    if (!covers(surface, p, distance)) return ask(surface, p, distance, buffer);
    const std::array<float, 3> place = in_units(p - center_);
    return give(HWY_DYNAMIC_DISPATCH(scan_ball)(floats_.front(), count_, place.data(),
                                                static_cast<float>(distance / reach_),
                                                found_.data()),
                buffer);
}

std::size_t ContactCache::collect_along(const ContactSurface& surface, const Vec3& p,
                                        const Vec3& way, double distance,
                                        std::span<ContactTriangle> buffer) noexcept
{
    const Vec3 middle = p + 0.5 * way;
    const double around = distance + 0.5 * way.norm();
    if (!covers(surface, middle, around)) return ask(surface, middle, around, buffer);
    const std::array<float, 3> place = in_units(p - center_);
    const std::array<float, 3> whole = in_units(way);
    return give(HWY_DYNAMIC_DISPATCH(scan_way)(floats_.front(), count_, place.data(), whole.data(),
                                               static_cast<float>(distance / reach_),
                                               found_.data()),
                buffer);
}

double ContactCache::clearance(const ContactSurface& surface, const Vec3& p,
                               double wanted) noexcept
{
    const bool kept = keeps(surface);
    if (kept && free_ > 0) {
        const double rounding =
            coordinate_rounding * (surface.scale().reach + p.cwiseAbs().maxCoeff());
        const double left = free_ - (p - free_center_).norm() - rounding;
        if (left > wanted) return left;
    }
    ++work_.distances;
    const double clearance = surface.clearance(p);
    if (kept) {
        free_center_ = p;
        free_ = clearance;
    }
    return clearance;
}

} // namespace proxima

#endif
