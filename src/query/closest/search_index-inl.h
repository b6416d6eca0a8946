// The closest feature by the tree of a mesh index alone. Included once per target.
//
//     node   squared distances of eight boxes at once, nearest child next, the others put aside
//            from far to near
//     leaf   squared distances of eight triangles at once, in floats: the least one shrinks the
//            ball that is searched, those that may be the closest become candidates
//     end    the candidates that are left are looked at in doubles (row_distance-inl.h)
//
// Floats leave out only what is surely farther, so that the answer is that of asking every row.

#if defined(PROXIMA_QUERY_CLOSEST_SEARCH_INDEX_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef PROXIMA_QUERY_CLOSEST_SEARCH_INDEX_INL_H
#undef PROXIMA_QUERY_CLOSEST_SEARCH_INDEX_INL_H
#else
#define PROXIMA_QUERY_CLOSEST_SEARCH_INDEX_INL_H
#endif

#include "index/index_parts.h"
#include "index/visit_near.h"
#include "proxima/mesh_index.h"
#include "query/closest/describe_closest.h"
#include "query/closest/index_query.h"
#include "query/closest/row_distance-inl.h"
#include "query/contact/eight_points-inl.h"

#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <hwy/cache_control.h>
#include <hwy/highway.h>
#include <limits>

HWY_BEFORE_NAMESPACE();
namespace proxima::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

PROXIMA_LANE_OP Eight quotient(const Eight& a, const Eight& b)
{
    return make_eight([&](std::size_t i) { return hn::Div(a.part[i], b.part[i]); });
}
PROXIMA_LANE_OP Eight choose(const EightMask& mask, const Eight& yes, const Eight& no)
{
    return make_eight(
        [&](std::size_t i) { return hn::IfThenElse(mask.part[i], yes.part[i], no.part[i]); });
}
PROXIMA_LANE_OP EightMask operator<=(const Eight& a, const Eight& b)
{
    return make_mask([&](std::size_t i) { return hn::Le(a.part[i], b.part[i]); });
}

/// The query point in all lanes.
PROXIMA_LANE_OP Eight3 lanes_of(const IndexQuery& query)
{
    return {eight(query.p[0]), eight(query.p[1]), eight(query.p[2])};
}

/// Squared distances of a node's boxes; infinite where there is none.
PROXIMA_LANE_OP Eight box_distances(const IndexNode& node, const Eight3& p)
{
    const auto gap = [&](std::size_t axis, const Eight& at, Eight& lower, Eight& upper) HWY_ATTR {
        const Eight step = eight(node.step[axis]);
        const Eight base = multiply_add(eight(32768.0F), step, eight(node.origin[axis]) - at);
        lower = eight_of_bytes(node.planes[axis].data());
        upper = eight_of_bytes(node.planes[axis].data() + 8);
        const Eight before = multiply_add(lower, step, base);
        const Eight behind = subtract_product(upper, step, -base);
        return maximum(maximum(before, behind), eight(0.0F));
    };
    Eight lower;
    Eight upper;
    const Eight x = gap(0, p.x, lower, upper);
    const EightMask is_box = lower <= upper;
    const Eight y = gap(1, p.y, lower, upper);
    const Eight z = gap(2, p.z, lower, upper);
    const Eight squared = multiply_add(x, x, multiply_add(y, y, z * z));
    return choose(is_box, squared, eight(std::numeric_limits<float>::infinity()));
}

#if HWY_TARGET != HWY_SCALAR

/// Whole numbers not below zero, from high to low.
template <class Tag>
HWY_INLINE hn::Vec<Tag> sorted_down(Tag tag, hn::Vec<Tag> keys)
{
    const hn::Repartition<std::int64_t, Tag> pairs;
    const auto by_pairs = [&](auto odd, auto even) HWY_ATTR {
        return hn::BitCast(tag, hn::OddEven(hn::BitCast(pairs, odd), hn::BitCast(pairs, even)));
    };
    const auto in_twos = [&](auto all) HWY_ATTR {
        const auto other = hn::Shuffle2301(all);
        return hn::OddEven(hn::Min(all, other), hn::Max(all, other));
    };
    keys = in_twos(keys);
    auto other = hn::Shuffle0123(keys);
    keys = in_twos(by_pairs(hn::Min(keys, other), hn::Max(keys, other)));
    other = hn::Reverse(tag, keys);
    keys = hn::ConcatUpperLower(tag, hn::Min(keys, other), hn::Max(keys, other));
    other = hn::Shuffle1032(keys);
    return in_twos(by_pairs(hn::Min(keys, other), hn::Max(keys, other)));
}

#endif

HWY_INLINE void prefetch_block_of(const IndexBlock* blocks, std::uint32_t reference)
{
    const IndexBlock& block = blocks[reference & ~index_leaf_bit];
    hwy::Prefetch(&block);
    hwy::Prefetch(reinterpret_cast<const std::byte*>(&block) + 64);
}

/// Takes the last of the blocks put aside that are near enough.
HWY_INLINE void leave(IndexQuery& query)
{
    do {
        --query.pending;
    } while (query.nearness[query.pending] > query.most);
    query.next = query.references[query.pending];
}

/// Goes on to the nearest child that may hold something within the ball and puts the others of
/// these aside, from far to near.
PROXIMA_STEP void enter_node(const IndexBlock* blocks, const IndexNode& node, const Eight& squared,
                             IndexQuery& query)
{
    const std::uint32_t first = query.pending;
#if HWY_TARGET != HWY_SCALAR
    if constexpr (eight_parts == 1) {
        // Whole numbers in the order of the distances, which they are but for the lane in the
        // lowest bits; zero where a child is too far.
        const hn::RebindToSigned<EightTag> whole;
        const auto within = hn::Le(squared.part[0], hn::Set(EightTag(), query.most));
        const auto count = static_cast<std::uint32_t>(hn::CountTrue(EightTag(), within));
        if (count == 0) return leave(query);
        const auto bits = hn::BitCast(whole, squared.part[0]);
        const auto keys = hn::Or(hn::AndNot(hn::Set(whole, 7), bits), hn::Iota(whole, 0));
        const auto nearest = hn::GetLane(hn::MinOfLanes(whole, keys));
        query.next = node.children[static_cast<std::uint32_t>(nearest) & 7U];
        prefetch_block_of(blocks, query.next);
        const auto sorted =
            sorted_down(whole, hn::IfThenElseZero(hn::RebindMask(whole, within), keys));
        const auto lanes = hn::And(sorted, hn::Set(whole, 7));
        const auto children = hn::TableLookupLanes(
            hn::LoadU(whole, reinterpret_cast<const std::int32_t*>(node.children.data())),
            hn::IndicesFromVec(whole, lanes));
        hn::StoreU(children, whole,
                   reinterpret_cast<std::int32_t*>(query.references.data() + query.pending));
        hn::StoreU(hn::BitCast(EightTag(), sorted), EightTag(),
                   query.nearness.data() + query.pending);
        query.pending += count - 1;
        for (std::uint32_t i = first; i < query.pending; ++i)
            prefetch_block_of(blocks, query.references[i]);
        return;
    }
#endif
    float distances[8];
    store_eight(squared, distances);
    for (std::size_t lane = 0; lane < 8; ++lane) {
        if (!(distances[lane] <= query.most)) continue;
        std::uint32_t position = query.pending++;
        for (; position > first && query.nearness[position - 1] < distances[lane]; --position) {
            query.nearness[position] = query.nearness[position - 1];
            query.references[position] = query.references[position - 1];
        }
        query.nearness[position] = distances[lane];
        query.references[position] = node.children[lane];
        prefetch_block_of(blocks, node.children[lane]);
    }
    leave(query);
}

/// What floats say of triangles.
struct TriangleDistances {
    Eight squared;   ///< of slivers: of their sides
    EightMask sound; ///< is no sliver
};

// Bounds of the distance d of a triangle within a leaf of diagonal L, u = 2^-24, a the vector from p
// to a corner, |a| <= d + L. Floats are taken as they are here; what rounding p and the vertices to
// floats does is in IndexQuery::error.
// Sides: r = a + t w is off by u (|a| + 2 L + |r|) for a, w and its own rounding, |r| by 1.5 u more.
// t is in [0, 1], so that r never is nearer than the side; its own error, 5 u |a| / |w| + 6 u, moves
// r along the side by at most 5 u d + 11 u L. Together less than u (9 d + 15 L).
// Plane: n = w x w' is off by 8 u |w| |w'|, for sines of at least 1/25 that tilts it by 203 u, which
// moves the plane at the foot by 203 u L; n a and its square over n n are off by 8 u (d + L). Less
// than u (9 d + 212 L).
// Inside: weights are sums of two products of dots, off by 23 u |a| |w|^2 |w'|; that moves the side
// as the foot sees it by 23 u |a| / sine < 600 u (d + L). What is taken for inside or outside by
// mistake has a distance whose square is off by at most the square of that.
// Slivers: what is inside is not farther from a side than the radius of the circle in it, which is
// at most half the least height: L / 50. Triangles with sides so short that the squares of their
// areas are lost, below 1e-30, are taken for slivers: the circle in them is below u.
inline constexpr float sliver_sine_squared = 1.0F / 625;
inline constexpr float sliver_area = 1e-30F;

/// Eight triangles by their corners.
struct EightTriangles {
    Eight3 v[3];
};

PROXIMA_LANE_OP EightTriangles triangles_of(const IndexLeaf& leaf)
{
    const Eight3 points{load_eight(leaf.coordinates[0].data()),
                        load_eight(leaf.coordinates[1].data()),
                        load_eight(leaf.coordinates[2].data())};
    EightTriangles triangles;
    for (std::size_t i = 0; i < 3; ++i)
        triangles.v[i] = look_up(points, indices_of_bytes(leaf.corners[i].data()));
    return triangles;
}

/// Eight triangles with all that does not depend on the point.
struct PreparedTriangles {
    Eight3 v[3];
    Eight3 w[3]; ///< side i goes from corner i
    Eight length[3];
    Eight3 normal;
    Eight area;
    Eight turn;   ///< w0 w2
    Eight turn_1; ///< w0 w1
    EightMask sound;
};

PROXIMA_STEP PreparedTriangles prepare(const EightTriangles& triangles)
{
    const Eight3(&v)[3] = triangles.v;
    PreparedTriangles result;
    Eight3(&w)[3] = result.w;
    Eight(&length)[3] = result.length;
    for (std::size_t i = 0; i < 3; ++i) {
        result.v[i] = v[i];
        w[i] = v[i == 2 ? 0 : i + 1] - v[i];
        length[i] = dot(w[i], w[i]);
    }
    result.normal = cross(w[2], w[0]);
    result.area = dot(result.normal, result.normal);
    result.turn = dot(w[0], w[2]);
    result.turn_1 = dot(w[0], w[1]);
    const Eight longest =
        maximum(maximum(length[0] * length[1], length[1] * length[2]), length[2] * length[0]);
    result.sound = maximum(longest * eight(sliver_sine_squared), eight(sliver_area)) <= result.area;
    return result;
}

/// How far they are from eight points, lane by lane.
PROXIMA_STEP TriangleDistances distances_of(const PreparedTriangles& triangles, const Eight3& p)
{
    const Eight zero = eight(0.0F);
    const Eight one = eight(1.0F);
    const Eight tiny = eight(1e-37F);
    const Eight3(&v)[3] = triangles.v;
    const Eight3(&w)[3] = triangles.w;
    const Eight(&length)[3] = triangles.length;
    const Eight3 a[3] = {v[0] - p, v[1] - p, v[2] - p};
    Eight ahead[3]; // of the corner from p, along the side
    Eight sides = zero;
    for (std::size_t i = 0; i < 3; ++i) {
        ahead[i] = dot(a[i], w[i]);
        const Eight t = minimum(maximum(quotient(-ahead[i], maximum(length[i], tiny)), zero), one);
        const Eight3 r{multiply_add(t, w[i].x, a[i].x), multiply_add(t, w[i].y, a[i].y),
                       multiply_add(t, w[i].z, a[i].z)};
        const Eight squared = dot(r, r);
        sides = i == 0 ? squared : minimum(sides, squared);
    }
    const Eight height = dot(triangles.normal, a[0]);
    const Eight plane = quotient(height * height, maximum(triangles.area, tiny));
    // Weights of the corners across sides 0, 2 and 1, as seen from corners 0, 0 and 1.
    const Eight from_last = ahead[2] + length[2]; // a0 w2
    const Eight weight_2 = multiply_subtract(length[0], from_last, ahead[0] * triangles.turn);
    const Eight weight_1 = subtract_product(length[2], ahead[0], from_last * triangles.turn);
    const Eight from_next = ahead[0] + length[0]; // a1 w0
    const Eight weight_0 = multiply_subtract(length[1], from_next, ahead[1] * triangles.turn_1);
    const EightMask inside = minimum(minimum(weight_0, weight_1), weight_2) > zero;
    return {choose(inside & triangles.sound, plane, sides), triangles.sound};
}
PROXIMA_STEP TriangleDistances distances_of(const EightTriangles& triangles, const Eight3& p)
{
    return distances_of(prepare(triangles), p);
}

/// Looks at the candidates that are near enough in doubles, and forgets all.
template <class Scalar>
PROXIMA_STEP void settle(const IndexParts& index, std::span<const TriangleRow<Scalar>> rows,
                         const Vec3& p, IndexQuery& query)
{
    const RowScale scale = row_scale_of(index);
    const float limit = query.limit(query.extent);
    for (std::uint32_t i = 0; i < query.candidate_count; ++i) {
        if (!(query.candidates[i].squared <= limit)) continue;
        const std::uint32_t row = query.candidates[i].row;
        const RowDistance found = closest_of_row(rows[row], row, p, scale);
        if (found.before(query.best)) query.best = found;
    }
    query.candidate_count = 0;
}

template <class Scalar>
HWY_INLINE void prefetch_row_of(const TriangleRow<Scalar>& row)
{
    hwy::Prefetch(&row);
    if (sizeof(row) > 64) hwy::Prefetch(reinterpret_cast<const std::byte*>(&row) + 64);
}

/// Shrinks the ball and takes candidates. The first `count` of the triangles are asked for, the
/// others have corners of these; row_of(lane) is where one is. prefetch(row) fetches it, settle()
/// looks at the candidates that there are and forgets them.
template <class RowOf, class Prefetch, class Settle>
PROXIMA_STEP void take_triangles(const TriangleDistances& distances, std::uint32_t count,
                                 float extent, const RowOf& row_of, const Prefetch& prefetch,
                                 const Settle& settle_candidates, IndexQuery& query)
{
    query.shrink(least_of(distances.squared), extent);
    const float limit = query.limit(extent);
    const Eight limits = choose(distances.sound, eight(limit), eight(query.sliver_limit(extent)));
    const std::uint32_t bits = (distances.squared <= limits).bits() & ((1U << count) - 1);
    if (bits == 0) return;
    const std::uint32_t sound = distances.sound.bits();
    HWY_ALIGN float squared[8];
    store_eight(distances.squared, squared);
    if (query.candidate_count + 8 > query.candidates.size()) [[unlikely]] {
        settle_candidates();
        query.shrink_to_best();
    }
    query.extent = HWY_MAX(query.extent, extent);
    for (std::uint32_t left = bits; left != 0; left &= left - 1) {
        const auto lane = static_cast<std::uint32_t>(std::countr_zero(left));
        const std::uint32_t row = row_of(lane);
        prefetch(row);
        query.candidates[query.candidate_count++] = {
            (sound >> lane & 1U) != 0 ? squared[lane] : 0.0F, row};
    }
}

HWY_INLINE float extent_of(const IndexLeaf& leaf)
{
    return std::bit_cast<float>(static_cast<std::uint32_t>(leaf.extent_bits) << 16U);
}

/// The triangles of a leaf. Lanes beyond the last one have its first vertex.
template <class Scalar>
PROXIMA_STEP void visit_leaf(const IndexParts& index, std::span<const TriangleRow<Scalar>> rows,
                             const IndexLeaf& leaf, const Eight3& lanes, const Vec3& p,
                             IndexQuery& query)
{
    take_triangles(
        distances_of(triangles_of(leaf), lanes), leaf.count, extent_of(leaf),
        [&](std::uint32_t lane) { return leaf.first_row + lane; },
        [&](std::uint32_t row) { prefetch_row_of(rows[row]); },
        [&] { settle(index, rows, p, query); }, query);
}

/// One block. False where the search has ended.
template <class Scalar>
HWY_INLINE bool search_step(const IndexParts& index, std::span<const TriangleRow<Scalar>> rows,
                            const IndexBlock* blocks, const Eight3& lanes, const Vec3& p,
                            IndexQuery& query)
{
    const IndexBlock& block = blocks[query.next & ~index_leaf_bit];
    if ((query.next & index_leaf_bit) != 0) {
        visit_leaf(index, rows, block.leaf, lanes, p, query);
        leave(query);
    } else {
        enter_node(blocks, block.node, box_distances(block.node, lanes), query);
    }
    return query.next != IndexQuery::end;
}

/// What a search found. The boxes of a forged index may contradict its triangles so that nothing is;
/// then any vertex is as good an answer.
template <class Scalar>
HWY_INLINE RowDistance found_or_any(const RowDistance& found,
                                    std::span<const TriangleRow<Scalar>> rows, double known)
{
    const bool is_wanted = !(known < std::numeric_limits<double>::infinity());
    if (!found.found() && is_wanted) [[unlikely]]
        return first_vertex(rows);
    return found;
}

/// As search_index, where floats have nothing to say: boxes and rows in doubles.
template <class Scalar>
HWY_NOINLINE inline RowDistance search_from_afar(const IndexParts& index,
                                                 std::span<const TriangleRow<Scalar>> rows,
                                                 const Vec3& p, double known)
{
    const RowScale scale = row_scale_of(index);
    RowDistance best;
    const double wanted = known * index.scale();
    NearWalk walk(index, {p, p}, wanted * wanted);
    while (const IndexLeaf* const leaf = walk.next_leaf()) {
        for (std::uint32_t i = 0; i < leaf->count; ++i) {
            const std::uint32_t row = leaf->first_row + i;
            const RowDistance found = closest_of_row(rows[row], row, p, scale);
            if (found.before(best)) best = found;
        }
        walk.shrink(best.squared);
    }
    return found_or_any(best, rows, known);
}

/// The closest feature of the index's rows by the order of answers. `known`: in the mesh's unit,
/// some point of the mesh is no farther, up to rounding of coordinates, or nothing farther is
/// wanted; infinite where there is no such bound. What is beyond it may or may not be found.
/// Finds nothing where p is not finite. Called, not copied: it is long, and a call is nothing beside it.
template <class Scalar>
HWY_NOINLINE inline RowDistance search_index(const IndexParts& index,
                                             std::span<const TriangleRow<Scalar>> rows,
                                             const Vec3& p, double known)
{
    IndexQuery query;
    switch (query.begin(index, p, known)) {
    case QueryStart::near:
        break;
    case QueryStart::far:
        return search_from_afar(index, rows, p, known);
    case QueryStart::endless:
        return first_vertex(rows);
    case QueryStart::nothing:
        return {};
    }
    const Eight3 lanes = lanes_of(query);
    const IndexBlock* const blocks = index.blocks().data();
    while (search_step(index, rows, blocks, lanes, p, query)) {
    }
    settle(index, rows, p, query);
    return found_or_any(query.best, rows, known);
}

} // namespace proxima::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
