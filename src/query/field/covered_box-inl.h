// Which leaves and triangles may be the closest of a point in a box. Included once per target.

#if defined(PROXIMA_QUERY_FIELD_COVERED_BOX_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef PROXIMA_QUERY_FIELD_COVERED_BOX_INL_H
#undef PROXIMA_QUERY_FIELD_COVERED_BOX_INL_H
#else
#define PROXIMA_QUERY_FIELD_COVERED_BOX_INL_H
#endif

#include "query/closest/search_index-inl.h"
#include "query/field/grid_candidates.h"

#include <cstddef>
#include <cstdint>

HWY_BEFORE_NAMESPACE();
namespace proxima::HWY_NAMESPACE {

/// Squared distances of a group's boxes from a box; infinite where there is none.
PROXIMA_LANE_OP Eight box_distances(const LeafBoxes::Group& group, const Eight3& lower,
                                    const Eight3& upper)
{
    const auto gap = [&](std::size_t axis, const Eight& least, const Eight& most) HWY_ATTR {
        return maximum(maximum(load_eight(group.lower[axis].data()) - most,
                               least - load_eight(group.upper[axis].data())),
                       eight(0.0F));
    };
    const Eight x = gap(0, lower.x, upper.x);
    const Eight y = gap(1, lower.y, upper.y);
    const Eight z = gap(2, lower.z, upper.z);
    return multiply_add(x, x, multiply_add(y, y, z * z));
}

PROXIMA_LANE_OP Eight square_root(const Eight& a)
{
    return make_eight([&](std::size_t i) { return hn::Sqrt(a.part[i]); });
}
PROXIMA_LANE_OP Eight3 choose(const EightMask& mask, const Eight3& yes, const Eight3& no)
{
    return {choose(mask, yes.x, no.x), choose(mask, yes.y, no.y), choose(mask, yes.z, no.z)};
}

PROXIMA_LANE_OP EightTriangles triangles_of(const TriangleLanes::Group& group)
{
    const auto corner = [&](std::size_t k) HWY_ATTR {
        return Eight3{load_eight(group.corners[k][0].data()),
                      load_eight(group.corners[k][1].data()),
                      load_eight(group.corners[k][2].data())};
    };
    return {{corner(0), corner(1), corner(2)}};
}

/// From about the triangles' closest points towards p, no longer than 1.
PROXIMA_STEP Eight3 directions_of(const EightTriangles& triangles, const Eight3& p)
{
    const Eight tiny = eight(1e-30F);
    const Eight3 a[3] = {triangles.v[0] - p, triangles.v[1] - p, triangles.v[2] - p};
    Eight least = eight(0.0F);
    Eight3 towards{least, least, least};
    for (std::size_t i = 0; i < 3; ++i) {
        const Eight3 side = a[i == 2 ? 0 : i + 1] - a[i];
        const Eight t = minimum(
            maximum(quotient(-dot(a[i], side), maximum(dot(side, side), tiny)), eight(0.0F)),
            eight(1.0F));
        const Eight3 from{-multiply_add(t, side.x, a[i].x), -multiply_add(t, side.y, a[i].y),
                          -multiply_add(t, side.z, a[i].z)};
        const Eight squared = dot(from, from);
        // NOLINTNEXTLINE(misc-redundant-expression): all lanes
        const EightMask nearer = i == 0 ? squared <= squared : squared < least;
        towards = choose(nearer, from, towards);
        least = choose(nearer, squared, least);
    }
    // Inside, seen from the corners: where p is on the inner side of all sides.
    const Eight3 normal = cross(a[1] - a[0], a[2] - a[0]);
    const Eight within =
        minimum(minimum(dot(normal, cross(a[0], a[1])), dot(normal, cross(a[1], a[2]))),
                dot(normal, cross(a[2], a[0])));
    const EightMask behind = eight(0.0F) < dot(normal, a[0]);
    const Eight3 upright = choose(behind, Eight3{-normal.x, -normal.y, -normal.z}, normal);
    towards = choose(eight(0.0F) < within, upright, towards);
    const Eight factor =
        quotient(eight(1 - 0x1p-20F), square_root(maximum(dot(towards, towards), tiny)));
    return {towards.x * factor, towards.y * factor, towards.z * factor};
}

// Which triangles can be the closest of no point of a box: with n of length 1 at most, no point x is
// nearer to triangle f than the least of n (x - v) over its corners v. Where that is more than the
// distance of x to one triangle g at all eight corners of the box, it is in all of the box, for that
// distance is convex. n is the direction to the box's middle from the closest point of f: wherever it
// points, what it says is true.

/// A box of points in the frame, and how far each of its corners is from the triangle closest to its
/// middle, rounded up.
struct CoveredBox {
    Eight3 middle;
    float half[3];
    float reach[8];
    float rounding; ///< of differences of coordinates and their products
};

/// The lanes in which something may be the closest of a point in the box: `least` are the least of
/// n (middle - v).
PROXIMA_STEP std::uint32_t may_be_closest(const Eight3& n, const Eight& least,
                                          const CoveredBox& box)
{
    const Eight3 half{n.x * eight(box.half[0]), n.y * eight(box.half[1]), n.z * eight(box.half[2])};
    const Eight sure = least - eight(box.rounding);
    std::uint32_t some = 0;
    for (std::size_t corner = 0; corner < 8; ++corner) {
        Eight at = (corner & 1U) != 0 ? sure + half.x : sure - half.x;
        at = (corner & 2U) != 0 ? at + half.y : at - half.y;
        at = (corner & 4U) != 0 ? at + half.z : at - half.z;
        some |= (at <= eight(box.reach[corner])).bits();
    }
    return some;
}

/// The triangles of eight that may be the closest of a point in the box.
PROXIMA_STEP std::uint32_t may_be_closest(const EightTriangles& triangles, const CoveredBox& box)
{
    const Eight3 n = directions_of(triangles, box.middle);
    Eight least = dot(n, box.middle - triangles.v[0]);
    for (std::size_t k = 1; k < 3; ++k) least = minimum(least, dot(n, box.middle - triangles.v[k]));
    return may_be_closest(n, least, box);
}

/// The leaves of a group of which a triangle may be, by their boxes: n from these boxes' middles.
PROXIMA_STEP std::uint32_t may_be_closest(const LeafBoxes::Group& group, const CoveredBox& box)
{
    const auto lower = [&](std::size_t axis)
                           HWY_ATTR { return load_eight(group.lower[axis].data()); };
    const auto upper = [&](std::size_t axis)
                           HWY_ATTR { return load_eight(group.upper[axis].data()); };
    const auto middle = [&](std::size_t axis)
                            HWY_ATTR { return (lower(axis) + upper(axis)) * eight(0.5F); };
    const Eight3 away = box.middle - Eight3{middle(0), middle(1), middle(2)};
    const Eight factor =
        quotient(eight(1 - 0x1p-20F), square_root(maximum(dot(away, away), eight(1e-30F))));
    const Eight3 n{away.x * factor, away.y * factor, away.z * factor};
    const auto along = [&](std::size_t axis, const Eight& part, const Eight& to) HWY_ATTR {
        return minimum(part * (to - lower(axis)), part * (to - upper(axis)));
    };
    return may_be_closest(
        n, along(0, n.x, box.middle.x) + along(1, n.y, box.middle.y) + along(2, n.z, box.middle.z),
        box);
}

} // namespace proxima::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
