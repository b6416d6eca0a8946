#include "index/lists/domination.h"

#include <bit>
#include <cmath>
#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "index/lists/domination.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
// After them: it is read once for every instruction set.
#include "index/lists/eight_corners-inl.h"

HWY_BEFORE_NAMESPACE();
namespace proxima::HWY_NAMESPACE {

inline constexpr float infinite = std::numeric_limits<float>::infinity();

/// Upper bounds of distances and lower ones of another feature's: each may be wrong by the
/// roundings of a few products, and the inside of a face reaches beyond its sides by their margin.
inline constexpr float domination_margin = 4 * float_margin;

/// A cell's corners, by coordinate.
struct CellCorners {
    Eight at[3];
};

HWY_INLINE CellCorners corners_of(const FrameCell& cell)
{
    CellCorners corners;
    for (int axis = 0; axis < 3; ++axis) {
        corners.at[axis] =
            eight(cell.center[axis]) + eight(cell.half) * load_eight(corner_signs[axis]);
    }
    return corners;
}

HWY_INLINE Eight squared_to_vertex(const CellCorners& x, const float* v)
{
    const Eight dx = x.at[0] - eight(v[0]);
    const Eight dy = x.at[1] - eight(v[1]);
    const Eight dz = x.at[2] - eight(v[2]);
    return dx * dx + dy * dy + dz * dz;
}

/// Of the points of the segment where the parameter is as computed: on it, whatever the rounding.
HWY_INLINE Eight squared_to_segment(const CellCorners& x, const float* a, const float* b)
{
    const float ab[3] = {b[0] - a[0], b[1] - a[1], b[2] - a[2]};
    const float squared = ab[0] * ab[0] + ab[1] * ab[1] + ab[2] * ab[2];
    const float inverse = squared > 0 ? 1 / squared : 0;
    const Eight dx = x.at[0] - eight(a[0]);
    const Eight dy = x.at[1] - eight(a[1]);
    const Eight dz = x.at[2] - eight(a[2]);
    const Eight along =
        (dx * eight(ab[0]) + dy * eight(ab[1]) + dz * eight(ab[2])) * eight(inverse);
    const Eight t = minimum(maximum(along, eight(0)), eight(1));
    const Eight rx = dx - t * eight(ab[0]);
    const Eight ry = dy - t * eight(ab[1]);
    const Eight rz = dz - t * eight(ab[2]);
    return rx * rx + ry * ry + rz * rz;
}

/// To the face's plane where the corner is over or under the face, infinite elsewhere.
HWY_INLINE Eight squared_to_inside(const CellCorners& x, const float* planes, const float* face)
{
    Eight outside = eight(-infinite);
    for (std::size_t i = 0; i < 3; ++i) {
        const float* const n = planes + std::size_t{plane_floats} * i;
        outside = maximum(outside, x.at[0] * eight(n[0]) + x.at[1] * eight(n[1]) +
                                       x.at[2] * eight(n[2]) - eight(n[3]));
    }
    const Eight height =
        x.at[0] * eight(face[0]) + x.at[1] * eight(face[1]) + x.at[2] * eight(face[2]);
    const Eight above = maximum(height - eight(face[3]), eight(face[4]) - height);
    return choose(outside, eight(0), above * above, eight(infinite));
}

/// The same for one point.
HWY_INLINE float squared_to_inside(const float* x, const float* planes, const float* face)
{
    for (std::size_t i = 0; i < 3; ++i) {
        const float* const n = planes + std::size_t{plane_floats} * i;
        if (n[0] * x[0] + n[1] * x[1] + n[2] * x[2] > n[3]) return infinite;
    }
    const float height = face[0] * x[0] + face[1] * x[1] + face[2] * x[2];
    const float above = HWY_MAX(height - face[3], face[4] - height);
    return above * above;
}

/// Everything that is to know about a feature and a cell: direction and lower bound at the centre,
/// squared upper bound there.
struct SeenFeature {
    float n[3];
    float least;
    float squared;
};

HWY_INLINE SeenFeature see_points(const float* closest, const float* points, int count,
                                  const FrameCell& cell)
{
    SeenFeature seen;
    float squared = 0;
    for (int axis = 0; axis < 3; ++axis) {
        seen.n[axis] = closest[axis] - cell.center[axis];
        squared += seen.n[axis] * seen.n[axis];
    }
    seen.squared = squared;
    // A direction a little longer than 1 would bound too high.
    const float inverse = squared > 0 ? (1 - 0x1p-21F) / std::sqrt(squared) : 0;
    for (float& component : seen.n) component *= inverse;
    seen.least = infinite;
    for (int i = 0; i < count; ++i) {
        const float* const p = points + std::size_t{3} * static_cast<std::size_t>(i);
        const float height = seen.n[0] * (p[0] - cell.center[0]) +
                             seen.n[1] * (p[1] - cell.center[1]) +
                             seen.n[2] * (p[2] - cell.center[2]);
        seen.least = HWY_MIN(seen.least, height);
    }
    return seen;
}

HWY_INLINE SeenFeature see_segment(const float* ends, const FrameCell& cell)
{
    float ab[3];
    float squared = 0;
    float along = 0;
    for (int axis = 0; axis < 3; ++axis) {
        ab[axis] = ends[3 + axis] - ends[axis];
        squared += ab[axis] * ab[axis];
        along += ab[axis] * (cell.center[axis] - ends[axis]);
    }
    const float t = squared > 0 ? HWY_MIN(HWY_MAX(along / squared, 0.0F), 1.0F) : 0;
    float closest[3];
    for (int axis = 0; axis < 3; ++axis) closest[axis] = ends[axis] + t * ab[axis];
    return see_points(closest, ends, 2, cell);
}

HWY_INLINE SeenFeature see_face(const float* planes, const float* face, bool flat,
                                const FrameCell& cell)
{
    SeenFeature seen;
    const float* const c = cell.center;
    const float height = face[0] * c[0] + face[1] * c[1] + face[2] * c[2];
    const float below = face[3] - height;
    const float above = height - face[4];
    const float sign = below > above ? 1.0F : -1.0F;
    for (int axis = 0; axis < 3; ++axis) seen.n[axis] = sign * (1 - 0x1p-21F) * face[axis];
    seen.least = HWY_MAX(below, above) * (1 - 0x1p-21F);
    seen.squared = flat ? squared_to_inside(c, planes, face) : infinite;
    return seen;
}

/// Upper bounds of a feature's distances from all corners.
HWY_INLINE Eight distances(const LocalFeatures& features, const LocalFeature& feature,
                           const CellCorners& corners)
{
    const float* const shape = features.shape(feature);
    switch (feature.kind) {
    case FeatureKind::vertex:
        return square_root(squared_to_vertex(corners, shape));
    case FeatureKind::edge:
        return square_root(squared_to_segment(corners, shape, shape + 3));
    case FeatureKind::face:
        break;
    }
    const float* const points = shape + 5;
    Eight least = minimum(minimum(squared_to_segment(corners, points, points + 3),
                                  squared_to_segment(corners, points + 3, points + 6)),
                          squared_to_segment(corners, points + 6, points));
    if (feature.flat) {
        least = minimum(least, squared_to_inside(corners, features.planes(feature), shape));
    }
    return square_root(least);
}

/// The features closest to the corners and the centre, each once.
struct Closest {
    std::uint32_t entries[9];
    std::size_t count = 0;

    void add(std::uint32_t entry)
    {
        for (std::size_t i = 0; i < count; ++i)
            if (entries[i] == entry) return;
        entries[count++] = entry;
    }
};

/// Moves those to the front whose lower bounds, a direction and a height each, are not above an upper
/// bound of another feature at all corners. Eight of them at a time.
HWY_INLINE std::size_t keep_undominated(std::uint32_t* list, std::size_t count,
                                        const FrameCell& cell, const float* bounds,
                                        std::size_t upper_count, const Eight* uppers,
                                        float best_at_center)
{
    HWY_ALIGN float nearest[9][8]; // by feature, then corner
    for (std::size_t i = 0; i < upper_count; ++i) store_eight(uppers[i], nearest[i]);
    const float diameter = 2 * std::sqrt(3.0F) * cell.half;
    const float farthest = std::sqrt(best_at_center) + diameter + domination_margin;
    const Eight half = eight(cell.half);
    std::size_t kept = 0;
    for (std::size_t first = 0; first < count; first += 8) {
        const std::size_t lanes = HWY_MIN(count - first, 8);
        HWY_ALIGN float numbers[4][8];
        for (std::size_t lane = 0; lane < 8; ++lane) {
            const float* const bound = bounds + 4 * (first + HWY_MIN(lane, lanes - 1));
            for (std::size_t k = 0; k < 4; ++k) numbers[k][lane] = bound[k];
        }
        const Eight x = load_eight(numbers[0]);
        const Eight y = load_eight(numbers[1]);
        const Eight z = load_eight(numbers[2]);
        const Eight least = load_eight(numbers[3]);
        Eight heights[8]; // lower bounds at the corners
        for_corner_pairs(x, y, z, [&](std::size_t corner, std::size_t opposite, const Eight& sum) {
            heights[corner] = least - half * sum;
            heights[opposite] = least + half * sum;
        });
        Eight above = eight(-infinite); // the most, over features, of the least over corners
        for (std::size_t i = 0; i < upper_count; ++i) {
            Eight over = heights[0] - eight(nearest[i][0]);
            for (std::size_t c = 1; c < 8; ++c)
                over = minimum(over, heights[c] - eight(nearest[i][c]));
            above = maximum(above, over);
        }
        const std::uint32_t undominated =
            at_most(above, eight(0)) & at_most(least, eight(farthest)) & ((1U << lanes) - 1);
        for (std::uint32_t left = undominated; left != 0; left &= left - 1)
            list[kept++] = list[first + static_cast<std::size_t>(std::countr_zero(left))];
    }
    return kept;
}

std::size_t drop_dominated(const LocalFeatures& features, std::uint32_t* list, std::size_t count,
                           const FrameCell& cell, float* bounds)
{
    const CellCorners corners = corners_of(cell);
    Eight best = eight(infinite);
    Eight entry = eight(0); // bits of positions in the list: floats cannot count that far
    float best_at_center = infinite;
    std::uint32_t entry_at_center = 0;
    for (std::size_t k = 0; k < count; ++k) {
        const LocalFeature& feature = features.features[list[k]];
        const float* const shape = features.shape(feature);
        Eight squared;
        SeenFeature seen;
        switch (feature.kind) {
        case FeatureKind::vertex:
            squared = squared_to_vertex(corners, shape);
            seen = see_points(shape, shape, 1, cell);
            break;
        case FeatureKind::edge:
            squared = squared_to_segment(corners, shape, shape + 3);
            seen = see_segment(shape, cell);
            break;
        default: {
            const float* const planes = features.planes(feature);
            squared = feature.flat ? squared_to_inside(corners, planes, shape) : eight(infinite);
            seen = see_face(planes, shape, feature.flat, cell);
            break;
        }
        }
        entry = choose(squared, best, eight(std::bit_cast<float>(static_cast<std::uint32_t>(k))),
                       entry);
        best = minimum(best, squared);
        if (seen.squared < best_at_center) {
            best_at_center = seen.squared;
            entry_at_center = static_cast<std::uint32_t>(k);
        }
        for (int axis = 0; axis < 3; ++axis)
            bounds[4 * k + static_cast<std::size_t>(axis)] = seen.n[axis];
        bounds[4 * k + 3] = seen.least;
    }

    Closest closest;
    closest.add(entry_at_center);
    float entries[8];
    store_eight(entry, entries);
    for (const float one : entries) closest.add(std::bit_cast<std::uint32_t>(one));
    Eight nearest[9];
    for (std::size_t i = 0; i < closest.count; ++i) {
        nearest[i] = distances(features, features.features[list[closest.entries[i]]], corners) +
                     eight(domination_margin);
    }

    return keep_undominated(list, count, cell, bounds, closest.count, nearest, best_at_center);
}

} // namespace proxima::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace proxima {

HWY_EXPORT(drop_dominated);

std::size_t drop_dominated(const LocalFeatures& features, std::uint32_t* list, std::size_t count,
                           const FrameCell& cell, DominationScratch& scratch)
{
    if (count == 0) return 0;
    if (scratch.bounds.size() < 4 * count) scratch.bounds.resize(4 * count);
    return HWY_DYNAMIC_DISPATCH(drop_dominated)(features, list, count, cell, scratch.bounds.data());
}

} // namespace proxima

#endif
