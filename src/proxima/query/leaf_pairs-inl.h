// Which triangles of two leaves meet: planes against vertices, then edges against edges, eight
// pairs at once (thesis section 5.2). Included once per target, after <hwy/highway.h>.
//
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

#include "proxima/query/eight_lanes-inl.h"
#include "proxima/query/open_pair.h"

#include <bit>
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
// (2.1 X)^2 + 3 u E^2 < 8.7 E X + 9 X^2, |q - p_0| <= 2 S in each number: off by 3 ((8.7 E X + 9
// X^2) (2 S
// + 2 X) + 2 E^2 2 X), and for rounding, computed as n.q - n.p_0, 60 u E^2 S < 5.5 E^2 X more. That
// is below 72 X (E + X) (S + X), as S >= E.
//
// Side of two edges, e . (q x f) + f . (p x e): |p| <= E, |q| <= S. q x f is off by X (2 F + 4.2 S)
// + 4.2 X^2 + 3 u S F, p x e by X (2 E + 4.2 E) + 4.2 X^2 + 3 u E^2: all in all 3 X (4.2 S F + 2.3
// E F
// + 4.2 E S + 4.2 E^2 + 6.5 E F), terms of X^2 beside, and for rounding 60 u E F S < 5.5 X E F.
// That is below 48 X (S + X) (E + F + 2 X).
struct LeafBounds {
    float own_height = 0;   ///< over own planes
    float other_height = 0; ///< over the other's
    float side = 0;
};

/// A leaf's triangles among its vertices. Not all is filled in at once.
struct LeafShape {
    const RayLeaf* leaf = nullptr;
    float extent = 0;
    std::uint64_t corner_bits = 0; ///< byte i: those of triangle i
    Eight3 vertices;
    EightPlaces places[3]; ///< of corners among vertices
    Eight3 corners[3];     ///< by triangle
    Eight3 normals;
    Eight heights;                ///< normal . corner
    HWY_ALIGN float planes[4][8]; ///< normals, heights
};

/// Byte i: 1 << corner for each of triangle i's.
HWY_INLINE std::uint64_t find_corner_bits(const RayLeaf& leaf)
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

HWY_INLINE void take_leaf(const RayLeaf& leaf, float unit, LeafShape& shape)
{
    shape.leaf = &leaf;
    shape.extent = unit * std::bit_cast<float>(static_cast<std::uint32_t>(leaf.extent_bits) << 16U);
    shape.corner_bits = find_corner_bits(leaf);
    // From the first vertex.
    const Eight scale = all_eight(unit);
    const auto load = [&](std::size_t axis) {
        const float* const from = leaf.coordinates[axis].data();
        return (load_eight(from) - all_eight(from[0])) * scale;
    };
    shape.vertices = {load(0), load(1), load(2)};
}

HWY_INLINE void find_planes(LeafShape& shape)
{
    for (std::size_t k = 0; k < 3; ++k) {
        shape.places[k] = places_of_bytes(shape.leaf->corners[k].data());
        shape.corners[k] = look_up(shape.vertices, shape.places[k]);
    }
    shape.normals = cross(shape.corners[1] - shape.corners[0], shape.corners[2] - shape.corners[0]);
    shape.heights = dot(shape.normals, shape.corners[0]);
    store_eight(shape.normals.x, shape.planes[0]);
    store_eight(shape.normals.y, shape.planes[1]);
    store_eight(shape.normals.z, shape.planes[2]);
    store_eight(shape.heights, shape.planes[3]);
}

/// The first leaf of a pair: the one that others are held against.
HWY_INLINE void take_own_leaf(const OpenPair& open, std::size_t own, const RayLeaf& leaf,
                              LeafShape& shape)
{
    take_leaf(leaf, open.sides[own].unit, shape);
    find_planes(shape);
}

HWY_INLINE Eight3 moved(const PairFrame& frame, const Eight3& p, const float* by)
{
    const auto row = [&](std::size_t i) {
        return multiply_add(
            all_eight(frame.columns[0][i]), p.x,
            multiply_add(all_eight(frame.columns[1][i]), p.y,
                         multiply_add(all_eight(frame.columns[2][i]), p.z, all_eight(by[i]))));
    };
    return {row(0), row(1), row(2)};
}

/// The second leaf, of the other mesh, put where it is seen from the first.
HWY_INLINE LeafBounds take_other_leaf(const OpenPair& open, std::size_t own, const LeafShape& first,
                                      const RayLeaf& leaf, LeafShape& shape)
{
    const PairFrame& frame = open.frames[own];
    const PairSide& own_side = open.sides[own];
    const PairSide& other_side = open.sides[1 - own];
    take_leaf(leaf, other_side.unit, shape);
    Vec3 from;
    Vec3 to;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto k = static_cast<Eigen::Index>(axis);
        from[k] = static_cast<double>(first.leaf->coordinates[axis][0]);
        to[k] = static_cast<double>(leaf.coordinates[axis][0]);
    }
    const auto own_unit = static_cast<double>(own_side.unit);
    const auto other_unit = static_cast<double>(other_side.unit);
    float by[3];
    float distance = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto k = static_cast<Eigen::Index>(axis);
        const Mat3& rotation = frame.exact_rotation;
        const double apart =
            (rotation(k, 0) * to[0] + (rotation(k, 1) * to[1] + rotation(k, 2) * to[2])) *
                other_unit +
            (frame.exact_offset[k] - from[k] * own_unit);
        by[axis] = static_cast<float>(apart);
        distance = HWY_MAX(distance, HWY_MAX(by[axis], -by[axis]));
    }
    shape.vertices = moved(frame, shape.vertices, by);

    constexpr float u = 0x1p-24F;
    const float own_edge = first.extent;
    const float other_edge = 1.7321F * shape.extent;
    const float reach = (own_edge + distance) + other_edge;
    const float off =
        u * ((0.5F * own_side.unit + 0.95F * other_side.unit) + 11 * reach) + open.pose_error;
    const float height = 72 * off * (reach + off);
    return {height * (own_edge + off), height * (other_edge + off),
            48 * off * (reach + off) * ((own_edge + other_edge) + 2 * off)};
}

/// By byte, which vertices are surely above and below a plane.
struct VertexSides {
    std::uint64_t above = 0;
    std::uint64_t below = 0;

    HWY_INLINE void look(const LeafShape& planes, std::size_t i, const Eight3& vertices,
                         const Eight& bound)
    {
        const Eight height =
            multiply_add(all_eight(planes.planes[0][i]), vertices.x,
                         multiply_add(all_eight(planes.planes[1][i]), vertices.y,
                                      multiply_subtract(all_eight(planes.planes[2][i]), vertices.z,
                                                        all_eight(planes.planes[3][i]))));
        above |= std::uint64_t{(height > bound).bits()} << (8 * i);
        below |= std::uint64_t{(height < -bound).bits()} << (8 * i);
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
};

/// Bit 8 j + i of bit 8 i + j.
HWY_INLINE std::uint64_t transposed(std::uint64_t x)
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
HWY_INLINE std::uint64_t unparted(const LeafShape& own, LeafShape& other, const LeafBounds& bounds)
{
    const std::uint32_t own_count = own.leaf->count;
    const std::uint32_t other_count = other.leaf->count;
    VertexSides sides;
    const Eight own_bound = all_eight(bounds.own_height);
    for (std::size_t i = 0; i < own_count; ++i) sides.look(own, i, other.vertices, own_bound);
    const std::uint64_t columns = first_bits(other_count) * 0x0101010101010101U;
    const std::uint64_t rows =
        own_count == 8 ? ~std::uint64_t{0} : (std::uint64_t{1} << (8 * own_count)) - 1;
    std::uint64_t left = ~sides.parted(other.corner_bits) & rows & columns;
    if (left == 0) return 0;
    find_planes(other);
    std::uint64_t some = left | left >> 32U;
    some |= some >> 16U;
    some |= some >> 8U;
    VertexSides back;
    const Eight other_bound = all_eight(bounds.other_height);
    for (auto j = static_cast<std::uint32_t>(some & 0xFFU); j != 0; j &= j - 1) {
        back.look(other, static_cast<std::size_t>(std::countr_zero(j)), own.vertices, other_bound);
    }
    return left & ~transposed(back.parted(own.corner_bits));
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
        const Eight low = least_of(start, end);
        const Eight high = most_of(start, end);
        const Eight least = least_of(least_of(a, b), c);
        const Eight most = most_of(most_of(a, b), c);
        const EightMask across = least_of(-low, high) > height;
        const EightMask beside = most_of(low, -high) > height;
        const EightMask within = most_of(least, -most) > side;
        const EightMask without = least_of(-least, most) > side;
        return {across & within, beside | without};
    }
    HWY_INLINE void add(const EdgeVerdict& other)
    {
        pierces = pierces | other.pierces;
        misses = misses & other.misses;
    }
};

HWY_INLINE PairVerdict look_at_pairs(const LeafShape& own, const EightPlaces& own_places,
                                     const LeafShape& other, const EightPlaces& other_places,
                                     const LeafBounds& bounds)
{
    Eight3 p[3];
    Eight3 q[3];
    for (std::size_t k = 0; k < 3; ++k) {
        p[k] = look_up(own.corners[k], own_places);
        q[k] = look_up(other.corners[k], other_places);
    }
    const Eight3 own_normal = look_up(own.normals, own_places);
    const Eight own_height = look_up(own.heights, own_places);
    const Eight3 other_normal = look_up(other.normals, other_places);
    const Eight other_height = look_up(other.heights, other_places);
    Eight3 e[3];
    Eight3 f[3];
    Eight3 p_moments[3];
    Eight3 q_moments[3];
    Eight p_heights[3];
    Eight q_heights[3];
    for (std::size_t k = 0; k < 3; ++k) {
        e[k] = p[(k + 1) % 3] - p[k];
        f[k] = q[(k + 1) % 3] - q[k];
        p_moments[k] = cross(p[k], e[k]);
        q_moments[k] = cross(q[k], f[k]);
        p_heights[k] = dot(other_normal, p[k]) - other_height;
        q_heights[k] = dot(own_normal, q[k]) - own_height;
    }
    Eight sides[3][3];
    for (std::size_t i = 0; i < 3; ++i) {
        for (std::size_t j = 0; j < 3; ++j) {
            sides[i][j] = multiply_add(
                e[i].x, q_moments[j].x,
                multiply_add(e[i].y, q_moments[j].y,
                             multiply_add(e[i].z, q_moments[j].z, dot(f[j], p_moments[i]))));
        }
    }
    const Eight over_own = all_eight(bounds.own_height);
    const Eight over_other = all_eight(bounds.other_height);
    const Eight side = all_eight(bounds.side);
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
HWY_INLINE bool meet_leaves(const OpenPair& open, std::size_t own_side, const LeafShape& own,
                            const RayLeaf& leaf, const Take& take)
{
    LeafShape other;
    const LeafBounds bounds = take_other_leaf(open, own_side, own, leaf, other);
    std::uint64_t left = unparted(own, other, bounds);
    while (left != 0) {
        // Eight of them, their bits' places as bytes.
        std::uint64_t own_bytes = 0;
        std::uint64_t other_bytes = 0;
        std::uint32_t count = 0;
        for (; left != 0 && count < 8; left &= left - 1, ++count) {
            const auto bit = static_cast<std::uint64_t>(std::countr_zero(left));
            own_bytes |= (bit >> 3U) << (8 * count);
            other_bytes |= (bit & 7U) << (8 * count);
        }
        std::uint8_t own_places[8];
        std::uint8_t other_places[8];
        std::memcpy(own_places, &own_bytes, 8);
        std::memcpy(other_places, &other_bytes, 8);
        const PairVerdict verdict = look_at_pairs(own, places_of_bytes(own_places), other,
                                                  places_of_bytes(other_places), bounds);
        const auto used = static_cast<std::uint32_t>(first_bits(count));
        for (auto met = verdict.met & used; met != 0; met &= met - 1) {
            const auto lane = static_cast<std::size_t>(std::countr_zero(met));
            if (!take(own_places[lane], other_places[lane], true)) return false;
        }
        for (auto unsure = ~(verdict.met | verdict.apart) & used; unsure != 0;
             unsure &= unsure - 1) {
            const auto lane = static_cast<std::size_t>(std::countr_zero(unsure));
            if (!take(own_places[lane], other_places[lane], false)) return false;
        }
    }
    return true;
}

} // namespace proxima::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
