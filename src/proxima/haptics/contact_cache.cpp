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

/// Which of the kept triangles may be within a distance, all in units of the ball's reach.
std::size_t scan_floats(const TriangleFloats& kept, std::size_t count, const float* place,
                        float distance, std::uint16_t* found)
{
    const NearTag d;
    const NearVectors p{hn::Set(d, place[0]), hn::Set(d, place[1]), hn::Set(d, place[2])};
    const auto asked = hn::Set(d, distance);
    const auto beyond = [](NearFloats a, NearFloats b, NearFloats c) {
        // How far the origin is from the interval of three numbers.
        return hn::Max(hn::Min(a, hn::Min(b, c)), hn::Neg(hn::Max(a, hn::Max(b, c))));
    };
    std::size_t written = 0;
    for (std::size_t first = 0; first < count; first += hn::Lanes(d)) {
        const auto corner = [&](std::size_t k) {
            const auto& at = kept.corners[k];
            return NearVectors{hn::Sub(hn::LoadU(d, at[0].data() + first), p.x),
                               hn::Sub(hn::LoadU(d, at[1].data() + first), p.y),
                               hn::Sub(hn::LoadU(d, at[2].data() + first), p.z)};
        };
        const NearVectors a = corner(0);
        const NearVectors b = corner(1);
        const NearVectors c = corner(2);
        const auto limit = hn::Add(asked, hn::LoadU(d, kept.margin.data() + first));
        const auto gap = hn::Max(beyond(a.x, b.x, c.x),
                                 hn::Max(beyond(a.y, b.y, c.y), beyond(a.z, b.z, c.z)));
        auto near = hn::Le(gap, limit);
        if (hn::AllFalse(d, near)) continue;
        near = hn::And(near, hn::Le(triangle_distance(a, b, c), hn::Mul(limit, limit)));
        std::uint8_t bytes[8] = {};
        (void)hn::StoreMaskBits(d, near, bytes);
        for (std::uint32_t left = bytes[0] | static_cast<std::uint32_t>(bytes[1]) << 8U; left != 0;
             left &= left - 1)
            found[written++] = static_cast<std::uint16_t>(first + std::countr_zero(left));
    }
    return written;
}

} // namespace proxima::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace proxima {

HWY_EXPORT(scan_floats);

namespace {

constexpr std::size_t most_lanes = 16;

/// A new ball reaches so far beyond what was asked for, in mean edges, at first; then as far as
/// makes about so many triangles: fewer are asked for again too soon, more cost every scan.
constexpr double first_margin = 2.5;
constexpr std::size_t few_triangles = 64;
constexpr std::size_t many_triangles = 192;

/// Of coordinates: more than differences of them and distances between are off by.
constexpr double coordinate_rounding = 0x1p-44;

/// One triangle, in units of the ball's reach from its centre.
void write_floats(TriangleFloats& floats, std::size_t place, const Triangle& triangle,
                  const Vec3& center, double per_reach, double rounding) noexcept
{
    std::array<Vec3, 3> corners;
    double size = 1; // of the places that are asked for
    for (std::size_t k = 0; k < 3; ++k) {
        corners[k] = (triangle.vertices[k] - center) * per_reach;
        size = std::max(size, corners[k].cwiseAbs().maxCoeff());
    }
    // Sides are off by less than 16 roundings of the size, heights of corners that are not sharp
    // by less than 2^8.
    constexpr double largest = 0x1p12;
    const bool fits = size <= largest;
    for (std::size_t k = 0; k < 3; ++k) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            floats.corners[k][axis][place] =
                fits ? static_cast<float>(corners[k][static_cast<Eigen::Index>(axis)]) : 0.0F;
        }
    }
    floats.margin[place] = fits ? static_cast<float>(0x1p-14 * size + rounding)
                                : std::numeric_limits<float>::infinity();
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

ContactCache::ContactCache() : triangles_(TriangleFloats::room), floats_(1) {}

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
    reach_ = -1;
    std::size_t wanted = 0;
    double reach = 0;
    for (int attempt = 0;; ++attempt) {
        constexpr int attempts = 6;
        if (attempt == attempts) return false;
        reach = distance + margin_;
        wanted = surface.collect(p, reach, triangles_);
        ++work_.gathers;
        work_.gathered += wanted;
        if (wanted <= triangles_.size()) break;
        margin_ /= 2;
    }
    count_ = wanted;
    center_ = p;
    reach_ = reach;
    const double per_reach = 1 / reach;
    rounding_ = coordinate_rounding *
                (surface.scale().reach + p.cwiseAbs().maxCoeff() + reach);
    TriangleFloats& floats = floats_.front();
    for (std::size_t i = 0; i < count_; ++i) {
        write_floats(floats, i, triangles_[i].corners, center_, per_reach, rounding_ * per_reach);
    }
    for (std::size_t i = count_; i % most_lanes != 0; ++i) write_nothing(floats, i);
    if (wanted < few_triangles) margin_ *= 1.25;
    if (wanted > many_triangles && margin_ > 0.5 * distance) margin_ *= 0.8;
    margin_ = std::min(margin_, surface.scale().extent);
    return true;
}

std::size_t ContactCache::scan(const Vec3& p, double distance,
                               std::span<ContactTriangle> buffer) noexcept
{
    const double per_reach = 1 / reach_;
    const Vec3 at = (p - center_) * per_reach;
    const std::array<float, 3> place = {static_cast<float>(at[0]), static_cast<float>(at[1]),
                                        static_cast<float>(at[2])};
    std::array<std::uint16_t, TriangleFloats::room> found; // NOLINT: written before it is read
    const std::size_t count = HWY_DYNAMIC_DISPATCH(scan_floats)(
        floats_.front(), count_, place.data(), static_cast<float>(distance * per_reach),
        found.data());
    for (std::size_t i = 0; i < std::min(count, buffer.size()); ++i)
        buffer[i] = triangles_[found[i]];
    ++work_.scans;
    work_.scanned += count_;
    work_.passed += count;
    return count;
}

std::size_t ContactCache::collect(const ContactSurface& surface, const Vec3& p, double distance,
                                  std::span<ContactTriangle> buffer) noexcept
{
    const bool kept = keeps(surface);
    if (kept && (p - center_).norm() + distance + rounding_ <= reach_)
        return scan(p, distance, buffer);
    if (kept && fill(surface, p, distance)) return scan(p, distance, buffer);
    ++work_.gathers;
    const std::size_t count = surface.collect(p, distance, buffer);
    work_.gathered += count;
    work_.passed += count;
    return count;
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
