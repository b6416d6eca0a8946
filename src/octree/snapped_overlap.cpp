#include "octree/snapped_overlap.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "octree/snapped_overlap.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
// After them: it is read once for every instruction set.
#include "base/compress-inl.h"
#include "octree/snapped_lanes-inl.h"

// Error bounds of stage 2, in units of the half size. u = 2^-24, P = max |p|, E = max |edge
// component|, d = level.error (snapping and rounded cell planes together).
//
//   coordinates    |dp| <= uP + d        one conversion of an exact integer difference
//   edges          |de| <= uE + 2d
//   normal         n_k = e0_a e1_b - e0_b e1_a:  |dn| <= 8uE^2 + 8Ed
//   plane          n.p and three additions of n_k: <= uE^2 (64P + 42) + Ed (24P + 24 + 6E)
//   edge planes    m_a p_a + m_b p_b, then four additions: <= uE (16P + 12) + d (4P + 2E + 4)
//
// An edge plane needs the sign of n_k. Taken wrongly, it moves a touching cell's value by at most
// |n_k| below zero (a touching point lies within |n_k| of every edge line), so |dn| is added to the
// edge bound and no touching child is ever rejected. That a child touches is only certain where the
// sign is. The constants below are rounded up to cover second-order terms and their own rounding.

HWY_BEFORE_NAMESPACE();
namespace proxima::HWY_NAMESPACE {

/// Children in the lower and upper half along each axis.
constexpr std::uint32_t lower_children[3] = {0x55, 0x33, 0x0F};
constexpr std::uint32_t upper_children[3] = {0xAA, 0xCC, 0xF0};

/// Corners of the lanes' triangles; corner[j][axis].
HWY_INLINE void load_corners(const SnappedTriangle* triangles, const std::uint32_t* indices,
                             Ints (&corner)[3][3])
{
    for (std::size_t j = 0; j < 3; ++j) {
        load_points([&](std::size_t lane) { return &triangles[indices[lane]][j]; }, corner[j]);
    }
}

/// Stage 1: box and vertex tests in exact integers. Returns the number of pairs left open.
std::size_t test_boxes(const SnappedTriangle* triangles, const SnappedLevel& level,
                       const SnappedPairs& pairs, SnappedScratch& scratch, std::uint32_t* masks)
{
    const IntTag di;
    const MaskTag dm;
    const auto margin = hn::Set(di, level.margin);
    // Integer lanes have strict comparisons only.
    const auto above_margin = hn::Set(di, level.margin + 1);
    const auto below_minus_margin = hn::Set(di, -level.margin - 1);
    const auto outside = hn::Set(di, level.half - level.margin + 1);
    const auto zero = hn::Zero(di);
    std::size_t open_count = 0;
    for (std::size_t first = 0; first < pairs.count; first += hn::Lanes(di)) {
        Ints corners[3][3];
        load_corners(triangles, pairs.triangle + first, corners);
        Words box = hn::Set(dm, 0xFF);
        Words octant[3] = {hn::Set(dm, 0xFF), hn::Set(dm, 0xFF), hn::Set(dm, 0xFF)};
        Ints nearest[3] = {hn::Set(di, INT32_MAX), hn::Set(di, INT32_MAX), hn::Set(di, INT32_MAX)};
        Ints farthest[3] = {zero, zero, zero};
        Ints centers[3];
        for (int axis = 0; axis < 3; ++axis) {
            const auto center = hn::LoadU(di, pairs.center[axis] + first);
            centers[axis] = center;
            const auto lower_bits = hn::Set(dm, lower_children[axis]);
            const auto upper_bits = hn::Set(dm, upper_children[axis]);
            Ints corner[3] = {zero, zero, zero};
            for (int j = 0; j < 3; ++j) {
                corner[j] = hn::Sub(corners[j][axis], center);
                const auto distance = hn::Abs(corner[j]);
                nearest[j] = hn::Min(nearest[j], distance);
                farthest[j] = hn::Max(farthest[j], distance);
                const auto is_upper = hn::RebindMask(dm, hn::Gt(corner[j], zero));
                octant[j] = hn::And(octant[j], hn::IfThenElse(is_upper, upper_bits, lower_bits));
            }
            const auto low = hn::Min(hn::Min(corner[0], corner[1]), corner[2]);
            const auto high = hn::Max(hn::Max(corner[0], corner[1]), corner[2]);
            const auto meets_lower = hn::RebindMask(dm, hn::Lt(low, above_margin));
            const auto meets_upper = hn::RebindMask(dm, hn::Gt(high, below_minus_margin));
            box = hn::And(box, hn::Or(hn::IfThenElseZero(meets_lower, lower_bits),
                                      hn::IfThenElseZero(meets_upper, upper_bits)));
        }
        // A triangle touches the cell, so a single child left by the boxes is touched.
        const auto single = hn::Eq(hn::And(box, hn::Sub(box, hn::Set(dm, 1))), hn::Zero(dm));
        Words contains = hn::Zero(dm);
        for (int j = 0; j < 3; ++j) {
            const auto is_contained = hn::RebindMask(
                dm, hn::And(hn::Gt(nearest[j], margin), hn::Lt(farthest[j], outside)));
            contains = hn::Or(contains, hn::IfThenElseZero(is_contained, octant[j]));
        }
        const auto touched = hn::IfThenElse(single, box, hn::And(contains, box));
        hn::StoreU(touched, dm, masks + first);
        const auto open = hn::AndNot(touched, box);
        const auto is_pair = hn::FirstN(dm, pairs.count - first);
        const auto is_open = hn::And(is_pair, hn::Ne(open, hn::Zero(dm)));
        const auto pair = hn::Iota(dm, static_cast<std::uint32_t>(first));
        const auto keep = [&](Words values, std::uint32_t* out) {
            hn::StoreU(compress(values, is_open), dm, out + open_count);
        };
        keep(pair, scratch.open_pairs.data());
        keep(open, scratch.open_children.data());
        keep(hn::LoadU(dm, pairs.triangle + first), scratch.open_triangles.data());
        for (int axis = 0; axis < 3; ++axis) {
            hn::StoreU(compress(centers[axis], hn::RebindMask(di, is_open)), di,
                       scratch.open_centers[axis].data() + open_count);
        }
        open_count += hn::CountTrue(dm, is_open);
    }
    return open_count;
}

/// What one block of lanes knows of its triangles and cells.
struct Lanes {
    Floats corner[3][3]; ///< p
    Floats edge[3][3];   ///< p_(j+1) - p_j, from exact integer differences
    Floats normal[3];
    Floats plane_error;
    Floats edge_error;
    Floats normal_error;
};

HWY_INLINE Floats largest(const Floats (&values)[3][3])
{
    Floats largest_value = hn::Abs(values[0][0]);
    for (const auto& row : values) {
        for (const Floats& value : row) largest_value = hn::Max(largest_value, hn::Abs(value));
    }
    return largest_value;
}

HWY_INLINE void find_errors(const SnappedLevel& level, Lanes& lanes)
{
    const FloatTag df;
    constexpr float u = 1.0F / (1 << 24);
    const auto reach = largest(lanes.corner);
    const auto size = largest(lanes.edge);
    const auto error = hn::Set(df, level.error);
    const auto times = [&](float factor, Floats value) {
        return hn::Mul(hn::Set(df, factor), value);
    };
    const auto unit_size = times(u, size);
    const auto error_size = hn::Mul(error, size);
    lanes.normal_error = hn::Mul(hn::Add(times(9, unit_size), times(9, error)), size);
    lanes.plane_error = hn::Add(
        hn::Mul(hn::Mul(unit_size, size), hn::Add(times(72, reach), hn::Set(df, 52))),
        hn::Mul(error_size, hn::Add(hn::Add(times(27, reach), hn::Set(df, 27)), times(8, size))));
    const auto rounding =
        hn::Mul(unit_size, hn::Add(hn::Add(times(18, reach), times(10, size)), hn::Set(df, 14)));
    const auto snapping =
        hn::Mul(error, hn::Add(hn::Add(times(5, reach), times(13, size)), hn::Set(df, 6)));
    lanes.edge_error = hn::Add(rounding, snapping);
}

/// Children within the two planes of the triangle, pushed by the child: |n.(p - sigma/2)| <=
/// |n|_1 / 2.
HWY_INLINE void test_planes(const Lanes& lanes, Words& possible, Words& certain)
{
    const FloatTag df;
    const MaskTag dm;
    const auto* n = lanes.normal;
    const auto* p = lanes.corner[0];
    const auto at_center =
        hn::Add(hn::Add(hn::Mul(n[0], p[0]), hn::Mul(n[1], p[1])), hn::Mul(n[2], p[2]));
    const auto half = hn::Set(df, 0.5F);
    const auto radius =
        hn::Mul(half, hn::Add(hn::Add(hn::Abs(n[0]), hn::Abs(n[1])), hn::Abs(n[2])));
    const auto outer = hn::Add(radius, lanes.plane_error);
    const auto inner = hn::Sub(radius, lanes.plane_error);
    Floats value[8];
    value[0] = hn::Add(at_center, hn::Mul(half, hn::Add(hn::Add(n[0], n[1]), n[2])));
    value[1] = hn::Sub(value[0], n[0]);
    value[2] = hn::Sub(value[0], n[1]);
    value[3] = hn::Sub(value[1], n[1]);
    for (int child = 0; child < 4; ++child) value[child + 4] = hn::Sub(value[child], n[2]);
    possible = hn::Zero(dm);
    certain = hn::Zero(dm);
    for (int child = 0; child < 8; ++child) {
        const auto bit = hn::Set(dm, 1U << child);
        const auto distance = hn::Abs(value[child]);
        possible =
            hn::Or(possible, hn::IfThenElseZero(hn::RebindMask(dm, hn::Le(distance, outer)), bit));
        certain =
            hn::Or(certain, hn::IfThenElseZero(hn::RebindMask(dm, hn::Le(distance, inner)), bit));
    }
}

/// Children within the nine edge planes, three for each axis: seen along `Axis`, the child's square
/// against the triangle's three edges.
template <int Axis>
HWY_INLINE void test_edges(const Lanes& lanes, Words& possible, Words& certain)
{
    const FloatTag df;
    const MaskTag dm;
    constexpr int a = (Axis + 1) % 3;
    constexpr int b = (Axis + 2) % 3;
    const auto sign = hn::And(lanes.normal[Axis], hn::SignBit(df));
    const auto zero = hn::Zero(df);
    Floats least[4];
    for (int j = 0; j < 3; ++j) {
        const auto& edge = lanes.edge[j];
        const auto& corner = lanes.corner[j];
        // Outward normal (m_a, m_b) = sign(n_axis) (e_b, -e_a); the child's corner nearest to the
        // inside adds max(m, 0) or max(-m, 0) for a lower or upper child.
        const auto m_a = hn::Xor(edge[b], sign);
        const auto m_b = hn::Neg(hn::Xor(edge[a], sign));
        const auto at_center = hn::Add(hn::Mul(m_a, corner[a]), hn::Mul(m_b, corner[b]));
        const auto lower = hn::Add(hn::Add(at_center, hn::Max(m_a, zero)), hn::Max(m_b, zero));
        const auto upper_a = hn::Sub(lower, m_a);
        const Floats value[4] = {lower, upper_a, hn::Sub(lower, m_b), hn::Sub(upper_a, m_b)};
        for (int quadrant = 0; quadrant < 4; ++quadrant) {
            least[quadrant] = j == 0 ? value[quadrant] : hn::Min(least[quadrant], value[quadrant]);
        }
    }
    const auto minus_error = hn::Neg(lanes.edge_error);
    Words axis_possible = hn::Zero(dm);
    Words axis_certain = hn::Zero(dm);
    for (int quadrant = 0; quadrant < 4; ++quadrant) {
        const std::uint32_t along_a = (quadrant & 1) != 0 ? upper_children[a] : lower_children[a];
        const std::uint32_t along_b = (quadrant & 2) != 0 ? upper_children[b] : lower_children[b];
        const auto bits = hn::Set(dm, along_a & along_b);
        const auto passes = hn::RebindMask(dm, hn::Ge(least[quadrant], minus_error));
        const auto is_certain = hn::RebindMask(dm, hn::Ge(least[quadrant], lanes.edge_error));
        axis_possible = hn::Or(axis_possible, hn::IfThenElseZero(passes, bits));
        axis_certain = hn::Or(axis_certain, hn::IfThenElseZero(is_certain, bits));
    }
    possible = hn::And(possible, axis_possible);
    certain = hn::And(certain, axis_certain);
}

/// Removes certainty where a box plane or the sign of a normal component is within its bound.
HWY_INLINE Words trust(const SnappedLevel& level, const Lanes& lanes, const Ints (&corner)[3][3],
                       Words certain)
{
    const IntTag di;
    const MaskTag dm;
    const auto margin = hn::Set(di, level.margin);
    const auto minus_margin = hn::Set(di, -level.margin);
    for (int axis = 0; axis < 3; ++axis) {
        const auto low = hn::Min(hn::Min(corner[0][axis], corner[1][axis]), corner[2][axis]);
        const auto high = hn::Max(hn::Max(corner[0][axis], corner[1][axis]), corner[2][axis]);
        const auto in_lower = hn::RebindMask(dm, hn::Lt(low, minus_margin));
        const auto in_upper = hn::RebindMask(dm, hn::Gt(high, margin));
        const auto boxes = hn::Or(hn::IfThenElseZero(in_lower, hn::Set(dm, lower_children[axis])),
                                  hn::IfThenElseZero(in_upper, hn::Set(dm, upper_children[axis])));
        const auto sign_known =
            hn::RebindMask(dm, hn::Gt(hn::Abs(lanes.normal[axis]), lanes.normal_error));
        certain = hn::IfThenElseZero(sign_known, hn::And(certain, boxes));
    }
    return certain;
}

/// Stage 2: planes and edges of the open pairs.
void test_planes_and_edges(const SnappedTriangle* triangles, const SnappedLevel& level,
                           std::size_t open_count, SnappedScratch& scratch, std::uint32_t* masks)
{
    const std::uint32_t* const open_pairs = scratch.open_pairs.data();
    const FloatTag df;
    const IntTag di;
    const MaskTag dm;
    const auto scale = hn::Set(df, 1.0F / static_cast<float>(level.half));
    for (std::size_t first = 0; first < open_count; first += hn::Lanes(df)) {
        Lanes lanes;
        Ints corner[3][3];
        load_corners(triangles, scratch.open_triangles.data() + first, corner);
        for (int axis = 0; axis < 3; ++axis) {
            const auto center = hn::LoadU(di, scratch.open_centers[axis].data() + first);
            for (auto& row : corner) row[axis] = hn::Sub(row[axis], center);
            for (int j = 0; j < 3; ++j) {
                const auto along = hn::Sub(corner[(j + 1) % 3][axis], corner[j][axis]);
                lanes.corner[j][axis] = hn::Mul(hn::ConvertTo(df, corner[j][axis]), scale);
                lanes.edge[j][axis] = hn::Mul(hn::ConvertTo(df, along), scale);
            }
        }
        for (int axis = 0; axis < 3; ++axis) {
            const int a = (axis + 1) % 3;
            const int b = (axis + 2) % 3;
            lanes.normal[axis] = hn::Sub(hn::Mul(lanes.edge[0][a], lanes.edge[1][b]),
                                         hn::Mul(lanes.edge[0][b], lanes.edge[1][a]));
        }
        find_errors(level, lanes);
        Words possible = hn::Zero(dm);
        Words certain = hn::Zero(dm);
        test_planes(lanes, possible, certain);
        test_edges<0>(lanes, possible, certain);
        test_edges<1>(lanes, possible, certain);
        test_edges<2>(lanes, possible, certain);
        certain = trust(level, lanes, corner, certain);
        const auto open = hn::LoadU(dm, scratch.open_children.data() + first);
        const auto is_open = hn::FirstN(dm, open_count - first);
        const auto touched = hn::And(open, certain);
        const auto undecided = hn::And(open, hn::AndNot(certain, possible));
        // Each pair is open once, so lanes write to different elements.
        HWY_ALIGN std::uint32_t touched_lanes[HWY_MAX_BYTES / sizeof(std::uint32_t)];
        hn::Store(touched, dm, touched_lanes);
        const std::size_t count = HWY_MIN(hn::Lanes(df), open_count - first);
        for (std::size_t lane = 0; lane < count; ++lane) {
            masks[open_pairs[first + lane]] |= touched_lanes[lane];
        }
        const auto is_unsure = hn::And(is_open, hn::Ne(undecided, hn::Zero(dm)));
        if (HWY_UNLIKELY(!hn::AllFalse(dm, is_unsure))) {
            HWY_ALIGN std::uint32_t lanes_left[HWY_MAX_BYTES / sizeof(std::uint32_t)];
            hn::Store(undecided, dm, lanes_left);
            for (std::size_t lane = 0; lane < count; ++lane) {
                if (lanes_left[lane] != 0) {
                    scratch.unsure.push_back({open_pairs[first + lane], lanes_left[lane]});
                }
            }
        }
    }
}

void find_touched_children(const SnappedTriangle* triangles, const SnappedLevel& level,
                           const SnappedPairs& pairs, SnappedScratch& scratch, std::uint32_t* masks)
{
    scratch.open_pairs.resize(pairs.count + lane_padding);
    scratch.open_children.resize(pairs.count + lane_padding);
    scratch.open_triangles.resize(pairs.count + lane_padding);
    for (auto& centers : scratch.open_centers) centers.resize(pairs.count + lane_padding);
    scratch.unsure.clear();
    const std::size_t open_count = test_boxes(triangles, level, pairs, scratch, masks);
    // Lanes beyond the last open pair look at triangle 0 and are ignored.
    for (std::size_t lane = 0; lane < lane_padding; ++lane) {
        scratch.open_triangles[open_count + lane] = 0;
    }
    test_planes_and_edges(triangles, level, open_count, scratch, masks);
}

} // namespace proxima::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace proxima {

HWY_EXPORT(find_touched_children);

void find_touched_children(const SnappedTriangle* triangles, const SnappedLevel& level,
                           const SnappedPairs& pairs, SnappedScratch& scratch, std::uint32_t* masks)
{
    HWY_DYNAMIC_DISPATCH(find_touched_children)(triangles, level, pairs, scratch, masks);
}

} // namespace proxima

#endif
