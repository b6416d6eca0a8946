#include "proxima/proximity/closest_feature.h"

#include "proxima/proximity/proximity_octree.h"
#include "proxima/proximity/row_search.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <hwy/cache_control.h>
#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "proxima/proximity/closest_feature.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
// After them: it is read once for every instruction set.
#include "proxima/proximity/block_scan-inl.h"

HWY_BEFORE_NAMESPACE();
namespace proxima::HWY_NAMESPACE {

/// Where a query ends.
struct FoundLeaf {
    std::uint32_t word = 0;
    int depth = 0;
};

HWY_INLINE FoundLeaf find_leaf(const ProximityOctree& octree,
                               const std::array<std::uint32_t, 3>& at)
{
    const int depth = octree.table_depth();
    int shift = static_cast<int>(ProximityOctree::location_bits) - depth;
    const std::uint32_t* const nodes = octree.arrays().nodes.data();
    std::uint32_t word =
        octree.arrays().table[(std::size_t{at[2] >> shift} << depth | at[1] >> shift) << depth |
                              at[0] >> shift];
    while ((word & proximity_word::leaf_bit) == 0) {
        --shift;
        word = nodes[word + ((at[0] >> shift & 1U) | (at[1] >> shift & 1U) << 1U |
                             (at[2] >> shift & 1U) << 2U)];
    }
    return {word, static_cast<int>(ProximityOctree::location_bits) - shift};
}

HWY_INLINE void prefetch_block(const std::byte* block)
{
    for (int line = 0; line < 4; ++line) hwy::Prefetch(block + 64 * line);
}

/// Looks at the candidates in doubles.
template <class Scalar>
HWY_INLINE void recheck(const BlockCandidates& candidates,
                        std::span<const TriangleRow<Scalar>> rows, const Vec3& p,
                        FeatureDistance& best, QuerySteps& steps)
{
    for (std::uint32_t left = candidates.lanes; left != 0; left &= left - 1)
        hwy::Prefetch(&rows[candidates.rank(std::countr_zero(left))]);
    for (std::uint32_t left = candidates.lanes; left != 0; left &= left - 1) {
        const std::uint32_t rank = candidates.rank(std::countr_zero(left));
        const FeatureDistance found = closest_of_row(rows[rank], rank, p);
        if (found.before(best)) best = found;
        ++steps.rechecks;
    }
}

/// The leaf's centre in the frame.
HWY_INLINE Vec3 center_of(const ProximityOctree& octree, const std::array<std::uint32_t, 3>& at,
                          int depth)
{
    const int shift = static_cast<int>(ProximityOctree::location_bits) - depth;
    const double half = octree.frame().frame_half();
    const double edge = 2 * half / static_cast<double>(1U << depth);
    Vec3 center;
    for (int axis = 0; axis < 3; ++axis)
        center[axis] = -half + edge * ((at[static_cast<std::size_t>(axis)] >> shift) + 0.5);
    return center;
}

/// A leaf of several blocks: those whose lower bound is beyond what was found are passed over.
template <class Scalar>
void search_run(const ProximityOctree& octree, std::span<const TriangleRow<Scalar>> rows,
                const std::array<std::uint32_t, 3>& at, const FoundLeaf& leaf, const Vec3& frame_p,
                const Vec3& p, FeatureDistance& best, QuerySteps& steps)
{
    const RunEntry* const run =
        octree.arrays().runs.data() + (leaf.word & proximity_word::place_mask);
    const Vec3 from_center = frame_p - center_of(octree, at, leaf.depth);
    const double radius = from_center.norm();
    const std::byte* const arena = octree.arrays().arena.data();
    double nearest = std::numeric_limits<double>::infinity(); // in the frame, rounded up
    for (std::uint32_t i = 1; i <= run->place; ++i) {
        const RunEntry& entry = run[i];
        if (static_cast<double>(entry.least) - radius > nearest) break;
        const double bound = static_cast<double>(entry.least) -
                             static_cast<double>(entry.direction[0]) * from_center[0] -
                             static_cast<double>(entry.direction[1]) * from_center[1] -
                             static_cast<double>(entry.direction[2]) * from_center[2];
        if (bound > nearest) continue;
        const std::byte* const block = arena + std::size_t{entry.place} * block_alignment;
        BlockHeader header;
        std::memcpy(&header, block, sizeof(header));
        ++steps.blocks;
        const double in_units = nearest * static_cast<double>(header.inverse_unit);
        const BlockCandidates candidates = scan_block<true>(block, frame_p, in_units);
        if (candidates.lanes == 0) continue;
        recheck(candidates, rows, p, best, steps);
        nearest = std::sqrt(best.squared) * octree.frame().scale * (1 + 0x1p-40) + 0x1p-44;
    }
}

template <class Scalar>
HWY_INLINE FeatureDistance search(const ProximityOctree& octree,
                                  std::span<const TriangleRow<Scalar>> rows, const Vec3& p,
                                  QuerySteps& steps)
{
    FeatureDistance best;
    best.squared = std::numeric_limits<double>::infinity();
    const Vec3 frame_p = octree.frame().to_frame(p);
    std::array<std::uint32_t, 3> at{};
    if (!octree.locate(frame_p, at)) return search_all_rows(rows, p);
    const FoundLeaf leaf = find_leaf(octree, at);
    steps.steps += 1 + static_cast<std::uint32_t>(HWY_MAX(leaf.depth - octree.table_depth(), 0));
    if ((leaf.word & proximity_word::run_bit) != 0) [[unlikely]] {
        search_run(octree, rows, at, leaf, frame_p, p, best, steps);
        return best;
    }
    const std::byte* const block =
        octree.arrays().arena.data() +
        std::size_t{leaf.word & proximity_word::place_mask} * block_alignment;
    prefetch_block(block);
    ++steps.blocks;
    recheck(scan_block<false>(block, frame_p, 0), rows, p, best, steps);
    return best;
}

FeatureDistance search_octree(const ProximityOctree& octree, const Vec3& p, QuerySteps& steps)
{
    const ProximityArrays& arrays = octree.arrays();
    return arrays.double_rows.empty() ? search(octree, arrays.float_rows, p, steps)
                                      : search(octree, arrays.double_rows, p, steps);
}

} // namespace proxima::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace proxima {

HWY_EXPORT(search_octree);

namespace {

/// The answer in full: named by the lowest triangle that has the feature.
template <class Scalar>
ClosestFeature describe(const ProximityArrays& arrays, std::span<const TriangleRow<Scalar>> rows,
                        const FeatureDistance& found)
{
    const TriangleRow<Scalar>& row = rows[found.rank];
    ClosestFeature answer;
    answer.feature = found.feature;
    answer.squared_distance = found.squared;
    answer.point = found.weights[0] * row.corner(0) + found.weights[1] * row.corner(1) +
                   found.weights[2] * row.corner(2);
    answer.barycentric = found.weights;
    answer.triangle = TriangleId{row.triangle_id()};
    if (found.feature.kind == FeatureKind::face) return answer;
    const std::uint32_t lowest = found.feature.kind == FeatureKind::vertex
                                     ? arrays.vertex_rows[found.feature.id]
                                     : arrays.edge_rows[found.feature.id];
    if (lowest == found.rank) return answer;
    const TriangleRow<Scalar>& named = rows[lowest];
    answer.triangle = TriangleId{named.triangle_id()};
    answer.barycentric = {};
    for (int i = 0; i < 3; ++i) {
        const double weight = found.weights[static_cast<std::size_t>(i)];
        if (weight == 0) continue;
        for (int k = 0; k < 3; ++k) {
            if (named.vertices[k] != row.vertices[i]) continue;
            answer.barycentric[static_cast<std::size_t>(k)] = weight;
            break;
        }
    }
    return answer;
}

ClosestFeature describe(const ProximityOctree& octree, const FeatureDistance& found)
{
    const ProximityArrays& arrays = octree.arrays();
    return arrays.double_rows.empty() ? describe(arrays, arrays.float_rows, found)
                                      : describe(arrays, arrays.double_rows, found);
}

} // namespace

ClosestFeature closest_feature(const ProximityOctree& octree, const Vec3& p,
                               QuerySteps& steps) noexcept
{
    return describe(octree, HWY_DYNAMIC_DISPATCH(search_octree)(octree, p, steps));
}

ClosestFeature closest_feature(const ProximityOctree& octree, const Vec3& p) noexcept
{
    QuerySteps steps;
    return closest_feature(octree, p, steps);
}

std::optional<ClosestFeature> closest_feature(const ProximityOctree& octree, const Vec3& p,
                                              double radius) noexcept
{
    const ClosestFeature closest = closest_feature(octree, p);
    if (closest.squared_distance > radius * radius) return std::nullopt;
    return closest;
}

Status closest_features(const ProximityOctree& octree, std::span<const Vec3> points,
                        std::span<ClosestFeature> answers, const BatchOptions& options)
{
    (void)options;
    for (std::size_t i = 0; i < points.size(); ++i) answers[i] = closest_feature(octree, points[i]);
    return {};
}

} // namespace proxima

#endif
