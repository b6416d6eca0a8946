#include "haptics/surface/triangle_groups.h"

#include "base/check.h"

#include <algorithm>
#include <cmath>

#ifndef PROXIMA_HAPTICS_TRIANGLE_GROUPS_ONCE
#define PROXIMA_HAPTICS_TRIANGLE_GROUPS_ONCE

namespace proxima {

/// What is asked for, in units.
struct LaneQuery {
    float way[3];
    float distance;
};

} // namespace proxima

#endif

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "haptics/surface/triangle_groups.cpp"
#include <hwy/cache_control.h>
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace proxima::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using NearTag = hn::CappedTag<float, TriangleGroup::width>;
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

HWY_INLINE NearVectors set_vector(const float* v)
{
    const NearTag d;
    return {hn::Set(d, v[0]), hn::Set(d, v[1]), hn::Set(d, v[2])};
}

/// Whether two numbers, along an axis of this squared length, are beyond a limit on the same side.
HWY_INLINE auto are_beyond(NearFloats a, NearFloats b, NearFloats squared_length, NearFloats limit)
{
    const auto least = hn::Min(hn::Mul(a, a), hn::Mul(b, b));
    return hn::And(hn::Gt(hn::Mul(a, b), hn::Zero(NearTag())),
                   hn::Gt(least, hn::Mul(hn::Mul(limit, limit), squared_length)));
}

/// Corners of a group's triangles from `lane` on, as a place sees them.
struct LaneTriangles {
    NearVectors a, b, c;
};

HWY_INLINE LaneTriangles load_triangles(const TriangleGroup& group, std::size_t lane,
                                        const NearVectors& place)
{
    const NearTag d;
    const auto corner = [&](std::size_t k) {
        const auto& at = group.corners[k];
        return NearVectors{hn::Sub(hn::LoadU(d, at[0].data() + lane), place.x),
                           hn::Sub(hn::LoadU(d, at[1].data() + lane), place.y),
                           hn::Sub(hn::LoadU(d, at[2].data() + lane), place.z)};
    };
    return {corner(0), corner(1), corner(2)};
}

HWY_INLINE auto near_ball(const LaneTriangles& t, NearFloats limit)
{
    return hn::Le(triangle_distance(t.a, t.b, t.c), hn::Mul(limit, limit));
}

/// Whether the boxes of a way from the origin and of triangles are.
HWY_INLINE auto near_boxes(const LaneTriangles& t, const NearVectors& way, NearFloats limit)
{
    const auto zero = hn::Zero(NearTag());
    const auto near = [&](NearFloats a, NearFloats b, NearFloats c, NearFloats end) {
        const auto low = hn::Sub(hn::Min(end, zero), limit);
        const auto high = hn::Add(hn::Max(end, zero), limit);
        return hn::And(hn::Le(hn::Min(hn::Min(a, b), c), high),
                       hn::Ge(hn::Max(hn::Max(a, b), c), low));
    };
    return hn::And(hn::And(near(t.a.x, t.b.x, t.c.x, way.x), near(t.a.y, t.b.y, t.c.y, way.y)),
                   near(t.a.z, t.b.z, t.c.z, way.z));
}

/// Neither the triangle's normal nor the products of its sides with the way separate them.
HWY_INLINE auto near_way(const LaneTriangles& t, const NearVectors& way, NearFloats limit)
{
    const NearTag d;
    const auto blunt = hn::Set(d, 0x1p-10F); // angles whose products say enough
    const NearVectors u = difference(t.b, t.a);
    const NearVectors w = difference(t.c, t.a);
    const NearVectors n = cross(u, w);
    const auto nn = dot(n, n);
    const auto start = dot(n, t.a);
    auto apart = hn::And(are_beyond(start, hn::Sub(start, dot(n, way)), nn, limit),
                         hn::Gt(nn, hn::Mul(hn::Mul(dot(u, u), dot(w, w)), blunt)));
    const auto way_squared = dot(way, way);
    const auto separate = [&](const NearVectors& side, const NearVectors& on,
                              const NearVectors& opposite) {
        const NearVectors axis = cross(way, side);
        const auto squared = dot(axis, axis);
        const auto enough = hn::Mul(hn::Mul(way_squared, dot(side, side)), blunt);
        apart =
            hn::Or(apart, hn::And(are_beyond(dot(axis, on), dot(axis, opposite), squared, limit),
                                  hn::Gt(squared, enough)));
    };
    separate(u, t.a, t.c);
    separate(w, t.a, t.b);
    separate(difference(t.c, t.b), t.b, t.a);
    return hn::Not(apart);
}

/// Before which part of the way nothing of a triangle is within the limit, as far as a plane
/// across an axis tells: 0 where it does not.
HWY_INLINE NearFloats time_along(const NearVectors& axis, const LaneTriangles& t,
                                 const NearVectors& way, NearFloats limit)
{
    const NearTag d;
    const auto nearest = hn::Min(hn::Min(dot(axis, t.a), dot(axis, t.b)), dot(axis, t.c));
    const auto squared = dot(axis, axis);
    const auto left = hn::Sub(nearest, hn::Mul(limit, hn::Sqrt(squared)));
    const auto swept = hn::Max(dot(axis, way), hn::Mul(left, hn::Set(d, 0.5F)));
    const auto time = hn::Mul(hn::Div(left, swept), hn::Set(d, 1 - 0x1p-18F));
    // Of an axis too short its length is not known.
    const auto tells = hn::And(hn::Gt(left, hn::Zero(d)), hn::Gt(squared, hn::Set(d, 1e-30F)));
    return hn::IfThenElseZero(tells, time);
}

/// The latest of what planes across the triangle's normal, the way and the middle tell.
HWY_INLINE NearFloats least_time(const LaneTriangles& t, const NearVectors& way, NearFloats limit)
{
    const NearVectors n = cross(difference(t.b, t.a), difference(t.c, t.a));
    const auto side = hn::And(dot(n, t.a), hn::SignBit(NearTag()));
    const NearVectors towards = {hn::Xor(n.x, side), hn::Xor(n.y, side), hn::Xor(n.z, side)};
    const NearVectors middle = {hn::Add(hn::Add(t.a.x, t.b.x), t.c.x),
                                hn::Add(hn::Add(t.a.y, t.b.y), t.c.y),
                                hn::Add(hn::Add(t.a.z, t.b.z), t.c.z)};
    return hn::Max(time_along(towards, t, way, limit),
                   hn::Max(time_along(middle, t, way, limit), time_along(way, t, way, limit)));
}

/// Writes the ranks of a group's near triangles, by whole vectors. Returns how many.
template <class Near>
HWY_INLINE std::size_t near_triangles(const TriangleGroup& group, std::uint32_t id,
                                      const float* place, const Near& near, std::uint32_t* ranks)
{
    constexpr std::size_t width = TriangleGroup::width;
    const NearTag d;
    const hn::Rebind<std::uint32_t, NearTag> di;
    const NearVectors p = set_vector(place);
    std::size_t count = 0;
    for (std::size_t lane = 0; lane < width; lane += hn::Lanes(d)) {
        const std::size_t left = group.count - HWY_MIN(group.count, lane);
        const auto found = hn::And(near(load_triangles(group, lane, p)),
                                   hn::FirstN(d, HWY_MIN(hn::Lanes(d), left)));
        const auto rank = static_cast<std::uint32_t>(width * id + lane);
        hn::StoreU(hn::Compress(hn::Iota(di, rank), hn::RebindMask(di, found)), di, ranks + count);
        count += hn::CountTrue(d, found);
    }
    return count;
}

/// The same of those on a way, and when each can be met.
HWY_INLINE std::size_t triangles_on_way(const TriangleGroup& group, std::uint32_t id,
                                        const float* place, const NearVectors& way,
                                        NearFloats limit, std::uint32_t* ranks, float* times)
{
    constexpr std::size_t width = TriangleGroup::width;
    const NearTag d;
    const hn::Rebind<std::uint32_t, NearTag> di;
    const NearVectors p = set_vector(place);
    std::size_t count = 0;
    for (std::size_t lane = 0; lane < width; lane += hn::Lanes(d)) {
        const std::size_t left = group.count - HWY_MIN(group.count, lane);
        const LaneTriangles t = load_triangles(group, lane, p);
        auto found = hn::And(near_boxes(t, way, limit), hn::FirstN(d, HWY_MIN(hn::Lanes(d), left)));
        if (hn::AllFalse(d, found)) continue;
        const auto time = least_time(t, way, limit);
        found = hn::And(hn::And(found, near_way(t, way, limit)), hn::Le(time, hn::Set(d, 1.0F)));
        const auto rank = static_cast<std::uint32_t>(width * id + lane);
        hn::StoreU(hn::Compress(hn::Iota(di, rank), hn::RebindMask(di, found)), di, ranks + count);
        hn::StoreU(hn::Compress(time, found), d, times + count);
        count += hn::CountTrue(d, found);
    }
    return count;
}

std::size_t scan_groups(const TriangleGroup* groups, std::span<const std::uint32_t> ids,
                        const GroupQuery& asked, const LaneQuery& query, std::uint32_t* ranks,
                        float* times)
{
    const NearTag d;
    const NearVectors way = set_vector(query.way);
    const float way_size = std::abs(query.way[0]) + std::abs(query.way[1]) + std::abs(query.way[2]);
    const auto rounding = static_cast<float>(asked.rounding * asked.scale);
    for (const std::uint32_t id : ids) {
        const auto* const line = reinterpret_cast<const std::byte*>(&groups[id]);
        for (std::size_t at = 0; at < sizeof(TriangleGroup); at += 64) hwy::Prefetch(line + at);
    }
    std::size_t written = 0;
    for (const std::uint32_t id : ids) {
        const TriangleGroup& group = groups[id];
        float place[3];
        for (int axis = 0; axis < 3; ++axis) {
            place[axis] = static_cast<float>(
                (asked.place[axis] - group.center[static_cast<std::size_t>(axis)]) * asked.scale);
        }
        // Sides are off by less than 16 roundings of the sizes, heights of corners that are not
        // sharp by less than 2^8.
        const float size = group.size + query.distance + way_size;
        const auto limit = hn::Set(d, query.distance + 0x1p-14F * size + rounding);
        std::uint32_t* const to = ranks + written;
        if (way_size > 0) {
            written += triangles_on_way(group, id, place, way, limit, to, times + written);
        } else {
            written += near_triangles(
                group, id, place, [&](const LaneTriangles& t) { return near_ball(t, limit); }, to);
        }
    }
    return written;
}

} // namespace proxima::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace proxima {

HWY_EXPORT(scan_groups);

TriangleGroup make_group(std::span<const Triangle> triangles, double scale) noexcept
{
    Box box;
    for (const Triangle& triangle : triangles)
        for (const Vec3& corner : triangle.vertices) box.extend(corner);
    const Vec3 center = box.center();
    TriangleGroup group;
    group.center = {center[0], center[1], center[2]};
    group.size = static_cast<float>(box.extent().maxCoeff() * scale);
    group.count = static_cast<std::uint32_t>(triangles.size());
    for (std::size_t lane = 0; lane < TriangleGroup::width; ++lane) {
        const Triangle& triangle = triangles[std::min(lane, triangles.size() - 1)];
        for (int k = 0; k < 3; ++k) {
            const Vec3 corner = (triangle[k] - center) * scale;
            for (int axis = 0; axis < 3; ++axis) {
                group.corners[k][static_cast<std::size_t>(axis)][lane] =
                    static_cast<float>(corner[axis]);
            }
        }
    }
    return group;
}

std::size_t scan_groups(std::span<const TriangleGroup> groups, std::span<const std::uint32_t> ids,
                        const GroupQuery& query, std::span<std::uint32_t> ranks,
                        std::span<float> times) noexcept
{
    PROXIMA_CHECK_LE(ids.size() * TriangleGroup::width, ranks.size());
    PROXIMA_CHECK_LE(ranks.size(), times.size());
    LaneQuery lanes{};
    for (int axis = 0; axis < 3; ++axis)
        lanes.way[axis] = static_cast<float>(query.way[axis] * query.scale);
    lanes.distance = static_cast<float>(query.distance * query.scale);
    return HWY_DYNAMIC_DISPATCH(scan_groups)(groups.data(), ids, query, lanes, ranks.data(),
                                             times.data());
}

} // namespace proxima

#endif
