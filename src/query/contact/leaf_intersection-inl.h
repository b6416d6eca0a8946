// Which triangles of two leaves meet: planes against vertices, then edges against edges, eight
// pairs at once (thesis section 5.2). Included once per target, after <hwy/highway.h>.
//
//     own slab, its vertices       beside it: none meets
//     own planes, its vertices     8 bytes: above, 8 bytes: below, a bit per vertex
//     its planes, own vertices     the same
//     pairs left                   64 bits, bit 8 i + j: own triangle i, its triangle j
//     edges against edges          9 signs a pair, with those of the vertices: met, apart or unsure
//
// Coordinates count from the first vertex of the own leaf, along the axes of the own mesh's frame.

#if defined(PROXIMA_QUERY_LEAF_PAIRS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef PROXIMA_QUERY_LEAF_PAIRS_INL_H
#undef PROXIMA_QUERY_LEAF_PAIRS_INL_H
#else
#define PROXIMA_QUERY_LEAF_PAIRS_INL_H
#endif

#include "index/index_parts.h"
#include "query/contact/box_pairs-inl.h"
#include "query/contact/contact_search.h"
#include "query/contact/eight_points-inl.h"

#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace proxima::HWY_NAMESPACE {

// Bounds of the tests, u = 2^-24, sizes in units of the frames. Vertices are off by X at most:
//     u / 2 times the own unit and u sqrt(3) / 2 times the other's for having been stored;
//     u E for the difference to the first vertex of the own leaf, E its extent;
//     u (sqrt(3) (3 roundings of 3 sums, R, difference and product: 6) F + 4 G) for the other's,
//     F its extent, G the displacement of the first vertices, which is taken in doubles;
//     1e-9 times 2 where the way back is by R^T; and the pose's own error.
// With S >= E + G + sqrt(3) F, a bound of all coordinates: X = u (own unit / 2 + 0.95 other's + 11
// S) + pose error. Own edges are at most E, the other's at most F' = sqrt(3) F, both off by 2 X + u
// E < 2.1 X.
//
// Height of a vertex q over the plane of p_0 with normal n = e x f: n is off by 4 E * 2.1 X + 2
// (2.1 X)^2 + 3 u E^2 < 8.7 E X + 9 X^2, |q - p_0| <= 2 S in each number. The height is off by
//     3 ((8.7 E X + 9 X^2) (2 S + 2 X) + 2 E^2 2 X)
// and for rounding, computed as n.q - n.p_0, by 60 u E^2 S < 5.5 E^2 X more. That is below
//     72 X (E + X) (S + X),  as S >= E.
//
// For a pair by itself, from p_0: P bounds |p_1 - p_0| and |p_2 - p_0|, F |q_1 - q_0| and |q_2 -
// q_0|, Q every |q - p_0|, in each number. Differences are off by 2.4 X (2 X and a rounding, 11 u
// of each of these sizes being below 2 X), n = e_0 x (p_2 - p_0) by 10 P X + 12 X^2 as above.
//     height n . q of q       3 ((10 P X + 12 X^2) (Q + 2.4 X) + 2 P^2 2.4 X), for rounding
//                             18 u P^2 Q < 3.3 P^2 X:
//                             below 44 X (P + 2 X) (P + Q + 2 X)
//     height m . p - m . q_0  m the normal of q, p at most P + Q =: W away:
//                             3 ((10 F X + 12 X^2) (W + 4.8 X) + 2 F^2 4.8 X), for rounding
//                             24 u F^2 W < 6.6 F^2 X:
//                             below 44 X (F + 2 X) (W + F + 2 X)
//     side of two edges       e_i . M_j + f_j . (p_i x e_i), M_j = q_j x f_j off by
//                             4.8 Q X + 10.7 F X + 11.6 X^2; p_i x e_i is 0, n, 0, and f_j . n a
//                             difference of heights. The worst is i = 1, |e_1| <= 2 P:
//                             X (28.8 P Q + 137 P F + 28.8 Q F + 37.6 P^2)
//                             + X^2 (142 P + 35 Q + 149 F) + 171 X^3,
//                             roundings of at most 90 u P Q F and 48 u P^2 Q among them:
//                             below 72 X (P + F + 2 X) (P + Q + F + 2 X)
struct LeafBounds {
    float off = 0;          ///< X
    float own_height = 0;   ///< over own planes
    float other_height = 0; ///< over the other's
};

/// A leaf's triangles among its vertices. Not all is filled in at once.
struct LeafShape {
    const IndexLeaf* leaf = nullptr;
    float extent = 0;
    std::uint64_t corner_bits = 0; ///< byte i: those of triangle i
    Eight3 vertices;
    EightIndices indices[3]; ///< of corners among vertices
    Eight3 corners[3];       ///< by triangle
    Eight3 normals;
    Eight heights;                ///< normal . corner
    HWY_ALIGN float planes[4][8]; ///< normals, heights
};

/// The first leaf of a pair, which others are held against. All of it lies in a slab, p_0 its first
/// vertex:  lower <= normal . (p - p_0) <= upper.
struct OwnLeaf : LeafShape {
    std::size_t side = 0; ///< whose leaf it is: both meshes may have the same index
    float normal[3];      ///< of length 1, or 0
    float lower;
    float upper;
    float other_normal[4]; ///< the normal in the other mesh's frame, 0
    float other_first[4];  ///< p_0 there, 0
    double offset[4];      ///< the other frame's origin from p_0, 0
};

/// Byte i: 1 << corner for each of triangle i's.
HWY_INLINE std::uint64_t find_corner_bits(const IndexLeaf& leaf)
{
#if HWY_TARGET == HWY_SCALAR
    std::uint64_t bits = 0;
    for (std::size_t i = 0; i < 8; ++i) {
        for (std::size_t k = 0; k < 3; ++k)
            bits |= std::uint64_t{1} << (8 * i + leaf.corners[k][i]);
    }
    return bits;
#else
    const hn::FixedTag<std::uint8_t, 8> d;
    const hn::FixedTag<std::uint8_t, 16> full;
    HWY_ALIGN constexpr std::uint8_t table[16] = {1, 2, 4, 8, 16, 32, 64, 128};
    const auto powers = hn::Load(full, table);
    const auto look = [&](std::size_t k) {
        return hn::TableLookupBytes(powers, hn::LoadU(d, leaf.corners[k].data()));
    };
    const auto all = hn::Or(hn::Or(look(0), look(1)), look(2));
    std::uint64_t bits = 0;
    hn::StoreU(all, d, reinterpret_cast<std::uint8_t*>(&bits));
    return bits;
#endif
}

/// normal . p for eight points.
HWY_INLINE Eight heights_along(const float (&normal)[3], const Eight3& p)
{
    return multiply_add(eight(normal[0]), p.x,
                        multiply_add(eight(normal[1]), p.y, eight(normal[2]) * p.z));
}

HWY_INLINE void take_leaf(const IndexLeaf& leaf, float unit, LeafShape& shape)
{
    shape.leaf = &leaf;
    shape.extent = unit * std::bit_cast<float>(static_cast<std::uint32_t>(leaf.extent_bits) << 16U);
    shape.corner_bits = find_corner_bits(leaf);
    // From the first vertex.
    const Eight scale = eight(unit);
    const auto load = [&](std::size_t axis) {
        const float* const from = leaf.coordinates[axis].data();
        return (load_eight(from) - eight(from[0])) * scale;
    };
    shape.vertices = {load(0), load(1), load(2)};
}

PROXIMA_STEP void find_planes(LeafShape& shape)
{
    for (std::size_t k = 0; k < 3; ++k) {
        shape.indices[k] = indices_of_bytes(shape.leaf->corners[k].data());
        shape.corners[k] = look_up(shape.vertices, shape.indices[k]);
    }
    shape.normals = cross(shape.corners[1] - shape.corners[0], shape.corners[2] - shape.corners[0]);
    shape.heights = dot(shape.normals, shape.corners[0]);
    store_eight(shape.normals.x, shape.planes[0]);
    store_eight(shape.normals.y, shape.planes[1]);
    store_eight(shape.normals.z, shape.planes[2]);
    store_eight(shape.heights, shape.planes[3]);
}

/// Across the sum of the triangles' normals.
HWY_INLINE void find_slab(OwnLeaf& own)
{
    const float sum[3] = {sum_of(own.normals.x), sum_of(own.normals.y), sum_of(own.normals.z)};
    const float squared = sum[0] * sum[0] + (sum[1] * sum[1] + sum[2] * sum[2]);
    // A normal of 0 parts nothing.
    constexpr float least_squared = 1e-30F;
    const float scale = squared > least_squared ? 1 / std::sqrt(squared) : 0.0F;
    for (std::size_t k = 0; k < 3; ++k) own.normal[k] = sum[k] * scale;
    const Eight heights = heights_along(own.normal, own.vertices);
    own.lower = least_of(heights);
    own.upper = most_of(heights);
}

/// Fills in all of it.
HWY_INLINE void take_own_leaf(const ContactSearch& open, std::size_t side, const IndexLeaf& leaf,
                              OwnLeaf& own)
{
    const float unit = open.sides[side].unit;
    take_leaf(leaf, unit, own);
    own.side = side;
    find_planes(own);
    find_slab(own);
    const PairFrame& there = open.frames[1 - side];
    const hn::CappedTag<float, 4> d;
    for (std::size_t i = 0; i < 4; i += hn::Lanes(d)) {
        auto normal = hn::Zero(d);
        auto first = hn::LoadU(d, there.offset.data() + i);
        for (std::size_t j = 0; j < 3; ++j) {
            const auto column = hn::LoadU(d, there.columns[j].data() + i);
            normal = hn::MulAdd(column, hn::Set(d, own.normal[j]), normal);
            first = hn::MulAdd(column, hn::Set(d, leaf.coordinates[j][0] * unit), first);
        }
        hn::StoreU(normal, d, own.other_normal + i);
        hn::StoreU(first, d, own.other_first + i);
    }
    for (std::size_t i = 0; i < 3; ++i) {
        own.offset[i] = open.frames[side].exact_offset[i] -
                        static_cast<double>(leaf.coordinates[i][0]) * static_cast<double>(unit);
    }
    own.offset[3] = 0;
}

/// Bit i: the box of child i, of the other mesh, is not surely beside the leaf's slab.
HWY_INLINE std::uint32_t meet_slab(const OwnLeaf& own, const MetBoxes& boxes, float slack)
{
    Eight along = eight(0);
    Eight radius = eight(slack);
    for (std::size_t axis = 0; axis < 3; ++axis) {
        along = multiply_add(eight(own.other_first[axis]) - boxes.center[axis],
                             eight(own.other_normal[axis]), along);
        radius = multiply_add(boxes.half[axis], eight(std::abs(own.other_normal[axis])), radius);
    }
    const EightMask above = along + eight(own.lower) > radius;
    const EightMask below = along + eight(own.upper) < -radius;
    return ~(above | below).bits() & 0xFFU;
}

/// Whether all vertices of a leaf, of the other mesh, are surely beside the slab.
HWY_INLINE bool is_beside_slab(const OwnLeaf& own, const IndexLeaf& leaf, float unit, float slack)
{
    Eight along = eight(0);
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const Eight at = load_eight(leaf.coordinates[axis].data()) * eight(unit);
        along =
            multiply_add(eight(own.other_first[axis]) - at, eight(own.other_normal[axis]), along);
    }
    return (along + eight(own.lower) > eight(slack)).bits() == 0xFFU ||
           (along + eight(own.upper) < eight(-slack)).bits() == 0xFFU;
}

HWY_INLINE Eight3 moved(const PairFrame& frame, const Eight3& p, const float* by)
{
    const auto row = [&](std::size_t i) {
        return multiply_add(
            eight(frame.columns[0][i]), p.x,
            multiply_add(eight(frame.columns[1][i]), p.y,
                         multiply_add(eight(frame.columns[2][i]), p.z, eight(by[i]))));
    };
    return {row(0), row(1), row(2)};
}

/// The second leaf, of the other mesh, put where it is seen from the first.
PROXIMA_STEP LeafBounds take_other_leaf(const ContactSearch& open, std::size_t side,
                                        const OwnLeaf& own, const IndexLeaf& leaf, LeafShape& shape)
{
    const PairFrame& frame = open.frames[side];
    const PairSide& own_side = open.sides[side];
    const PairSide& other_side = open.sides[1 - side];
    take_leaf(leaf, other_side.unit, shape);
    const hn::CappedTag<double, 4> d;
    float by[4];
    for (std::size_t i = 0; i < 4; i += hn::Lanes(d)) {
        auto sum = hn::LoadU(d, own.offset + i);
        for (std::size_t j = 0; j < 3; ++j) {
            const double first =
                static_cast<double>(leaf.coordinates[j][0]) * static_cast<double>(other_side.unit);
            sum =
                hn::MulAdd(hn::LoadU(d, frame.exact_columns[j].data() + i), hn::Set(d, first), sum);
        }
        hn::StoreU(hn::DemoteTo(hn::Rebind<float, decltype(d)>(), sum),
                   hn::Rebind<float, decltype(d)>(), by + i);
    }
    const float distance = HWY_MAX(HWY_MAX(std::abs(by[0]), std::abs(by[1])), std::abs(by[2]));
    shape.vertices = moved(frame, shape.vertices, by);

    constexpr float u = 0x1p-24F;
    const float own_edge = own.extent;
    const float other_edge = 1.7321F * shape.extent;
    const float reach = (own_edge + distance) + other_edge;
    const float off =
        u * ((0.5F * own_side.unit + 0.95F * other_side.unit) + 11 * reach) + open.pose_error;
    const float height = 72 * off * (reach + off);
    return {off, height * (own_edge + off), height * (other_edge + off)};
}

/// By byte, which vertices are surely above and below a plane.
struct VertexSides {
    std::uint64_t above = 0;
    std::uint64_t below = 0;

    /// At least the first `count` planes.
    HWY_INLINE void look(const LeafShape& planes, std::uint32_t count, const Eight3& vertices,
                         const Eight& bound)
    {
        // Most leaves have four or less: no branch that is hard to foresee.
        for (std::size_t i = 0; i < 4; ++i) look_at(planes, i, vertices, bound);
        if (count <= 4) return;
        for (std::size_t i = 4; i < 8; ++i) look_at(planes, i, vertices, bound);
    }

    /// Bit 8 i + j: the corners of triangle j are all above plane i, or all below.
    HWY_INLINE std::uint64_t parted(std::uint64_t corner_bits) const
    {
        std::uint64_t result = 0;
#if HWY_TARGET == HWY_SCALAR
        for (std::size_t bit = 0; bit < 64; ++bit) {
            const auto corners = corner_bits >> (8 * (bit % 8)) & 0xFFU;
            const auto row = 8 * (bit / 8);
            const bool apart =
                (above >> row & corners) == corners || (below >> row & corners) == corners;
            result |= std::uint64_t{apart} << bit;
        }
#else
        const hn::CappedTag<std::uint8_t, 64> d;
        const hn::Repartition<std::uint64_t, decltype(d)> wide;
        constexpr std::size_t lanes = HWY_MIN(64, HWY_LANES(std::uint8_t));
        const auto corners = hn::BitCast(d, hn::Set(wide, corner_bits));
        const auto upper = hn::BitCast(d, hn::Set(wide, above));
        const auto lower = hn::BitCast(d, hn::Set(wide, below));
        HWY_ALIGN constexpr std::uint8_t rows[64] = {
            0, 0, 0, 0, 0, 0, 0, 0, 1, 1, 1, 1, 1, 1, 1, 1, 2, 2, 2, 2, 2, 2,
            2, 2, 3, 3, 3, 3, 3, 3, 3, 3, 4, 4, 4, 4, 4, 4, 4, 4, 5, 5, 5, 5,
            5, 5, 5, 5, 6, 6, 6, 6, 6, 6, 6, 6, 7, 7, 7, 7, 7, 7, 7, 7};
        for (std::size_t first = 0; first < 64; first += lanes) {
            const auto row = hn::Load(d, rows + first);
            const auto in = [&](hn::Vec<decltype(d)> side) {
                return hn::Eq(hn::And(hn::TableLookupBytes(side, row), corners), corners);
            };
            std::uint64_t bits = 0;
            (void)hn::StoreMaskBits(d, hn::Or(in(upper), in(lower)),
                                    reinterpret_cast<std::uint8_t*>(&bits));
            result |= bits << first;
        }
#endif
        return result;
    }

private:
    HWY_INLINE void look_at(const LeafShape& planes, std::size_t i, const Eight3& vertices,
                            const Eight& bound)
    {
        const Eight height =
            multiply_add(eight(planes.planes[0][i]), vertices.x,
                         multiply_add(eight(planes.planes[1][i]), vertices.y,
                                      multiply_subtract(eight(planes.planes[2][i]), vertices.z,
                                                        eight(planes.planes[3][i]))));
        above |= std::uint64_t{(height > bound).bits()} << (8 * i);
        below |= std::uint64_t{(height < -bound).bits()} << (8 * i);
    }
};

/// Bit 8 j + i of bit 8 i + j.
HWY_INLINE std::uint64_t with_rows_as_columns(std::uint64_t x)
{
    std::uint64_t t = (x ^ (x >> 7U)) & 0x00AA00AA00AA00AAU;
    x ^= t ^ (t << 7U);
    t = (x ^ (x >> 14U)) & 0x0000CCCC0000CCCCU;
    x ^= t ^ (t << 14U);
    t = (x ^ (x >> 28U)) & 0x00000000F0F0F0F0U;
    return x ^ t ^ (t << 28U);
}

/// The first n of 8.
HWY_INLINE std::uint64_t first_bits(std::uint32_t n)
{
    return (std::uint64_t{1} << n) - 1;
}

/// Pairs that no plane parts.
PROXIMA_STEP std::uint64_t unparted(const OwnLeaf& own, LeafShape& other, const LeafBounds& bounds)
{
    const std::uint32_t own_count = own.leaf->count;
    const std::uint32_t other_count = other.leaf->count;
    VertexSides sides;
    const Eight own_bound = eight(bounds.own_height);
    sides.look(own, own_count, other.vertices, own_bound);
    const std::uint64_t columns = first_bits(other_count) * 0x0101010101010101U;
    const std::uint64_t rows =
        own_count == 8 ? ~std::uint64_t{0} : (std::uint64_t{1} << (8 * own_count)) - 1;
    std::uint64_t left = ~sides.parted(other.corner_bits) & rows & columns;
    if (left == 0) return 0;
    find_planes(other);
    VertexSides back;
    back.look(other, other_count, own.vertices, eight(bounds.other_height));
    return left & ~with_rows_as_columns(back.parted(own.corner_bits));
}

/// What floats say of eight pairs.
struct PairVerdict {
    std::uint32_t met = 0;
    std::uint32_t apart = 0;
};

/// Edges of one triangle against the other: whether one surely pierces it, or surely none meets it.
struct EdgeVerdict {
    EightMask pierces;
    EightMask misses;

    /// An edge whose ends have these heights over the other's plane, and these sides of its edges.
    /// Its line passes within the other where all sides are the same. So it pierces the other if
    /// its ends are on both sides of the plane besides, and misses it if they are on one, or if
    /// sides differ: also where the other has no area.
    HWY_INLINE static EdgeVerdict of(const Eight& start, const Eight& end, const Eight& height,
                                     const Eight& a, const Eight& b, const Eight& c,
                                     const Eight& side)
    {
        const Eight low = minimum(start, end);
        const Eight high = maximum(start, end);
        const Eight least = minimum(minimum(a, b), c);
        const Eight most = maximum(maximum(a, b), c);
        const EightMask across = minimum(-low, high) > height;
        const EightMask beside = maximum(low, -high) > height;
        const EightMask within = maximum(least, -most) > side;
        const EightMask without = minimum(-least, most) > side;
        return {across & within, beside | without};
    }
    HWY_INLINE void add(const EdgeVerdict& other)
    {
        pierces = pierces | other.pierces;
        misses = misses & other.misses;
    }
};

/// The largest size of any number of two vectors.
HWY_INLINE Eight largest(const Eight3& a, const Eight3& b)
{
    return maximum(
        maximum(maximum(size_of(a.x), size_of(a.y)), maximum(size_of(a.z), size_of(b.x))),
        maximum(size_of(b.y), size_of(b.z)));
}

PROXIMA_STEP PairVerdict look_at_pairs(const LeafShape& own, const EightIndices& own_indices,
                                       const LeafShape& other, const EightIndices& other_indices,
                                       float off)
{
    const Eight3 origin = look_up(own.corners[0], own_indices);
    const Eight3 p1 = look_up(own.corners[1], own_indices) - origin;
    const Eight3 p2 = look_up(own.corners[2], own_indices) - origin;
    const Eight3 p_edge = p2 - p1;
    const Eight3 normal = look_up(own.normals, own_indices);
    const Eight3 other_normal = look_up(other.normals, other_indices);
    Eight3 q[3];
    Eight3 f[3];
    Eight3 moments[3];
    Eight q_heights[3];
    for (std::size_t k = 0; k < 3; ++k) q[k] = look_up(other.corners[k], other_indices) - origin;
    for (std::size_t k = 0; k < 3; ++k) {
        f[k] = q[(k + 1) % 3] - q[k];
        moments[k] = cross(q[k], f[k]);
        q_heights[k] = dot(normal, q[k]);
    }
    Eight p_heights[3];
    p_heights[0] = -dot(other_normal, q[0]);
    p_heights[1] = dot(other_normal, p1) + p_heights[0];
    p_heights[2] = dot(other_normal, p2) + p_heights[0];
    Eight sides[3][3];
    for (std::size_t j = 0; j < 3; ++j) {
        sides[0][j] = dot(p1, moments[j]);
        sides[1][j] = dot(p_edge, moments[j]) + (q_heights[(j + 1) % 3] - q_heights[j]);
        sides[2][j] = -dot(p2, moments[j]);
    }

    const Eight p_size = largest(p1, p2);
    const Eight f_size = largest(f[0], f[2]);
    const Eight q_size = maximum(largest(q[0], q[1]), largest(q[2], q[2]));
    const Eight slack = eight(2 * off);
    const Eight reach = (p_size + q_size) + slack;
    const Eight factor = eight(44 * off);
    const Eight over_own = (p_size + slack) * (reach * factor);
    const Eight over_other = (f_size + slack) * ((reach + f_size) * factor);
    const Eight side = ((p_size + f_size) + slack) * ((reach + f_size) * eight(72 * off));
    const auto own_edge = [&](std::size_t i) {
        return EdgeVerdict::of(p_heights[i], p_heights[(i + 1) % 3], over_other, sides[i][0],
                               sides[i][1], sides[i][2], side);
    };
    const auto other_edge = [&](std::size_t j) {
        return EdgeVerdict::of(q_heights[j], q_heights[(j + 1) % 3], over_own, sides[0][j],
                               sides[1][j], sides[2][j], side);
    };
    EdgeVerdict verdict = own_edge(0);
    verdict.add(other_edge(0));
    for (std::size_t k = 1; k < 3; ++k) {
        verdict.add(own_edge(k));
        verdict.add(other_edge(k));
    }
    return {verdict.pierces.bits(), verdict.misses.bits()};
}

/// Calls take(i, j, sure) for pairs that meet (sure) or may, own triangle i and its triangle j,
/// until it returns false; then false.
template <class Take>
HWY_INLINE bool meet_leaves(const ContactSearch& open, std::size_t own_side, const OwnLeaf& own,
                            const IndexLeaf& leaf, const Take& take)
{
    const std::size_t side = 1 - own_side;
    if (is_beside_slab(own, leaf, open.sides[side].unit, 2 * open.frames[side].slack)) return true;
    LeafShape other;
    const LeafBounds bounds = take_other_leaf(open, own_side, own, leaf, other);
    std::uint64_t left = unparted(own, other, bounds);
    while (left != 0) {
        // Eight of them, their bits' indices as bytes.
        std::uint64_t own_bytes = 0;
        std::uint64_t other_bytes = 0;
        std::uint32_t count = 0;
        for (; left != 0 && count < 8; left &= left - 1, ++count) {
            const auto bit = static_cast<std::uint64_t>(std::countr_zero(left));
            own_bytes |= (bit >> 3U) << (8 * count);
            other_bytes |= (bit & 7U) << (8 * count);
        }
        std::uint8_t own_indices[8];
        std::uint8_t other_indices[8];
        std::memcpy(own_indices, &own_bytes, 8);
        std::memcpy(other_indices, &other_bytes, 8);
        const PairVerdict verdict = look_at_pairs(own, indices_of_bytes(own_indices), other,
                                                  indices_of_bytes(other_indices), bounds.off);
        const auto used = static_cast<std::uint32_t>(first_bits(count));
        for (auto met = verdict.met & used; met != 0; met &= met - 1) {
            const auto lane = static_cast<std::size_t>(std::countr_zero(met));
            if (!take(own_indices[lane], other_indices[lane], true)) return false;
        }
        for (auto unsure = ~(verdict.met | verdict.apart) & used; unsure != 0;
             unsure &= unsure - 1) {
            const auto lane = static_cast<std::size_t>(std::countr_zero(unsure));
            if (!take(own_indices[lane], other_indices[lane], false)) return false;
        }
    }
    return true;
}

} // namespace proxima::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
