#include "haptics/surface/triangle_groups.h"

#include "base/check.h"

#include <algorithm>
#include <cmath>

#ifndef PROXIMA_HAPTICS_TRIANGLE_GROUPS_ONCE
#define PROXIMA_HAPTICS_TRIANGLE_GROUPS_ONCE

namespace proxima {

/// A query in units.
struct LaneQuery {
    float motion[3];
    float distance;
};

} // namespace proxima

#endif

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "haptics/surface/triangle_groups.cpp"
#include <hwy/cache_control.h>
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
// After them: it is read once for every instruction set.
#include "base/compress-inl.h"

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

/// Squared distances from the origin; 0 where a corner is too sharp for an accurate normal.
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

/// Whether two numbers along an axis of this squared length are beyond a limit on the same side.
HWY_INLINE auto are_beyond(NearFloats a, NearFloats b, NearFloats squared_length, NearFloats limit)
{
    const auto least = hn::Min(hn::Mul(a, a), hn::Mul(b, b));
    return hn::And(hn::Gt(hn::Mul(a, b), hn::Zero(NearTag())),
                   hn::Gt(least, hn::Mul(hn::Mul(limit, limit), squared_length)));
}

/// Corners of a group's triangles from `lane` on, relative to a position.
struct LaneTriangles {
    NearVectors a, b, c;
};

HWY_INLINE LaneTriangles load_triangles(const TriangleGroup& group, std::size_t lane,
                                        const NearVectors& position)
{
    const NearTag d;
    const auto corner = [&](std::size_t k) {
        const auto& at = group.corners[k];
        return NearVectors{hn::Sub(hn::LoadU(d, at[0].data() + lane), position.x),
                           hn::Sub(hn::LoadU(d, at[1].data() + lane), position.y),
                           hn::Sub(hn::LoadU(d, at[2].data() + lane), position.z)};
    };
    return {corner(0), corner(1), corner(2)};
}

HWY_INLINE auto near_ball(const LaneTriangles& t, NearFloats limit)
{
    return hn::Le(triangle_distance(t.a, t.b, t.c), hn::Mul(limit, limit));
}

/// Whether the boxes of triangles are near that of a motion from the origin.
HWY_INLINE auto near_boxes(const LaneTriangles& t, const NearVectors& motion, NearFloats limit)
{
    const auto zero = hn::Zero(NearTag());
    const auto near = [&](NearFloats a, NearFloats b, NearFloats c, NearFloats end) {
        const auto low = hn::Sub(hn::Min(end, zero), limit);
        const auto high = hn::Add(hn::Max(end, zero), limit);
        return hn::And(hn::Le(hn::Min(hn::Min(a, b), c), high),
                       hn::Ge(hn::Max(hn::Max(a, b), c), low));
    };
    return hn::And(
        hn::And(near(t.a.x, t.b.x, t.c.x, motion.x), near(t.a.y, t.b.y, t.c.y, motion.y)),
        near(t.a.z, t.b.z, t.c.z, motion.z));
}

/// Whether neither the triangle's normal nor a product of a side with the motion separates them.
HWY_INLINE auto near_motion(const LaneTriangles& t, const NearVectors& motion, NearFloats limit)
{
    const NearTag d;
    const auto blunt = hn::Set(d, 0x1p-10F); // angles whose products say enough
    const NearVectors u = difference(t.b, t.a);
    const NearVectors w = difference(t.c, t.a);
    const NearVectors n = cross(u, w);
    const auto nn = dot(n, n);
    const auto start = dot(n, t.a);
    auto apart = hn::And(are_beyond(start, hn::Sub(start, dot(n, motion)), nn, limit),
                         hn::Gt(nn, hn::Mul(hn::Mul(dot(u, u), dot(w, w)), blunt)));
    const auto motion_squared = dot(motion, motion);
    const auto separate = [&](const NearVectors& side, const NearVectors& on,
                              const NearVectors& opposite) {
        const NearVectors axis = cross(motion, side);
        const auto squared = dot(axis, axis);
        const auto enough = hn::Mul(hn::Mul(motion_squared, dot(side, side)), blunt);
        apart =
            hn::Or(apart, hn::And(are_beyond(dot(axis, on), dot(axis, opposite), squared, limit),
                                  hn::Gt(squared, enough)));
    };
    separate(u, t.a, t.c);
    separate(w, t.a, t.b);
    separate(difference(t.c, t.b), t.b, t.a);
    return hn::Not(apart);
}

/// The part of the motion before which it comes within the limit of no point of a triangle, by a
/// plane across an axis; 0 where that plane decides nothing.
HWY_INLINE NearFloats time_along(const NearVectors& axis, const LaneTriangles& t,
                                 const NearVectors& motion, NearFloats limit)
{
    const NearTag d;
    const auto nearest = hn::Min(hn::Min(dot(axis, t.a), dot(axis, t.b)), dot(axis, t.c));
    const auto squared = dot(axis, axis);
    const auto left = hn::Sub(nearest, hn::Mul(limit, hn::Sqrt(squared)));
    const auto swept = hn::Max(dot(axis, motion), hn::Mul(left, hn::Set(d, 0.5F)));
    const auto time = hn::Mul(hn::Div(left, swept), hn::Set(d, 1 - 0x1p-18F));
    // The length of an axis that is too short is not known.
    const auto tells = hn::And(hn::Gt(left, hn::Zero(d)), hn::Gt(squared, hn::Set(d, 1e-30F)));
    return hn::IfThenElseZero(tells, time);
}

/// The latest time by planes across the triangle's normal, its middle and the motion.
HWY_INLINE NearFloats least_time(const LaneTriangles& t, const NearVectors& motion,
                                 NearFloats limit)
{
    const NearVectors n = cross(difference(t.b, t.a), difference(t.c, t.a));
    const auto side = hn::And(dot(n, t.a), hn::SignBit(NearTag()));
    const NearVectors towards = {hn::Xor(n.x, side), hn::Xor(n.y, side), hn::Xor(n.z, side)};
    const NearVectors middle = {hn::Add(hn::Add(t.a.x, t.b.x), t.c.x),
                                hn::Add(hn::Add(t.a.y, t.b.y), t.c.y),
                                hn::Add(hn::Add(t.a.z, t.b.z), t.c.z)};
    return hn::Max(
        time_along(towards, t, motion, limit),
        hn::Max(time_along(middle, t, motion, limit), time_along(motion, t, motion, limit)));
}

/// Writes the ranks of a group's near triangles, by whole vectors. Returns how many.
template <class Near>
HWY_INLINE std::size_t near_triangles(const TriangleGroup& group, std::uint32_t id,
                                      const float* position, const Near& near, std::uint32_t* ranks)
{
    constexpr std::size_t width = TriangleGroup::width;
    const NearTag d;
    const hn::Rebind<std::uint32_t, NearTag> di;
    const NearVectors p = set_vector(position);
    std::size_t count = 0;
    for (std::size_t lane = 0; lane < width; lane += hn::Lanes(d)) {
        const std::size_t left = group.count - HWY_MIN(group.count, lane);
        const auto found = hn::And(near(load_triangles(group, lane, p)),
                                   hn::FirstN(d, HWY_MIN(hn::Lanes(d), left)));
        const auto rank = static_cast<std::uint32_t>(width * id + lane);
        hn::StoreU(compress(hn::Iota(di, rank), hn::RebindMask(di, found)), di, ranks + count);
        count += hn::CountTrue(d, found);
    }
    return count;
}

/// Like near_triangles, along a motion, with the time before which each cannot be met.
HWY_INLINE std::size_t triangles_along(const TriangleGroup& group, std::uint32_t id,
                                       const float* position, const NearVectors& motion,
                                       NearFloats limit, std::uint32_t* ranks, float* times)
{
    constexpr std::size_t width = TriangleGroup::width;
    const NearTag d;
    const hn::Rebind<std::uint32_t, NearTag> di;
    const NearVectors p = set_vector(position);
    std::size_t count = 0;
    for (std::size_t lane = 0; lane < width; lane += hn::Lanes(d)) {
        const std::size_t left = group.count - HWY_MIN(group.count, lane);
        const LaneTriangles t = load_triangles(group, lane, p);
        auto found =
            hn::And(near_boxes(t, motion, limit), hn::FirstN(d, HWY_MIN(hn::Lanes(d), left)));
        if (hn::AllFalse(d, found)) continue;
        const auto time = least_time(t, motion, limit);
        found =
            hn::And(hn::And(found, near_motion(t, motion, limit)), hn::Le(time, hn::Set(d, 1.0F)));
        const auto rank = static_cast<std::uint32_t>(width * id + lane);
        hn::StoreU(compress(hn::Iota(di, rank), hn::RebindMask(di, found)), di, ranks + count);
        hn::StoreU(compress(time, found), d, times + count);
        count += hn::CountTrue(d, found);
    }
    return count;
}

std::size_t scan_groups(const TriangleGroup* groups, std::span<const std::uint32_t> ids,
                        const GroupQuery& group_query, const LaneQuery& query, std::uint32_t* ranks,
                        float* times)
{
    const NearTag d;
    const NearVectors motion = set_vector(query.motion);
    const float motion_size =
        std::abs(query.motion[0]) + std::abs(query.motion[1]) + std::abs(query.motion[2]);
    const auto rounding = static_cast<float>(group_query.rounding * group_query.scale);
    for (const std::uint32_t id : ids) {
        const auto* const line = reinterpret_cast<const std::byte*>(&groups[id]);
        for (std::size_t at = 0; at < sizeof(TriangleGroup); at += 64) hwy::Prefetch(line + at);
    }
    std::size_t written = 0;
    for (const std::uint32_t id : ids) {
        const TriangleGroup& group = groups[id];
        float position[3];
        for (int axis = 0; axis < 3; ++axis) {
            position[axis] = static_cast<float>(
                (group_query.position[axis] - group.center[static_cast<std::size_t>(axis)]) *
                group_query.scale);
        }
        // Sides are wrong by less than 16 roundings of the sizes, heights of corners that are not
        // sharp by less than 2^8.
        const float size = group.size + query.distance + motion_size;
        const auto limit = hn::Set(d, query.distance + 0x1p-14F * size + rounding);
        std::uint32_t* const to = ranks + written;
        if (motion_size > 0) {
            written += triangles_along(group, id, position, motion, limit, to, times + written);
        } else {
            written += near_triangles(
                group, id, position, [&](const LaneTriangles& t) { return near_ball(t, limit); },
                to);
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
        lanes.motion[axis] = static_cast<float>(query.motion[axis] * query.scale);
    lanes.distance = static_cast<float>(query.distance * query.scale);
    return HWY_DYNAMIC_DISPATCH(scan_groups)(groups.data(), ids, query, lanes, ranks.data(),
                                             times.data());
}

} // namespace proxima

#endif
