// The search of one query, in one instruction set: leaf, block, rows. Read once for each by every
// unit that searches (closest_feature.cpp, closest_features.cpp).
#if defined(PROXIMA_PROXIMITY_SEARCH_OCTREE_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef PROXIMA_PROXIMITY_SEARCH_OCTREE_INL_H
#undef PROXIMA_PROXIMITY_SEARCH_OCTREE_INL_H
#else
#define PROXIMA_PROXIMITY_SEARCH_OCTREE_INL_H
#endif

#include "index/lists/block_scan-inl.h"
#include "index/lists/proximity_octree.h"
#include "index/triangle_lanes.h"
#include "query/closest/closest_feature.h"
#include "query/closest/describe_closest.h"
#include "query/closest/index_query.h"
#include "query/closest/row_distance-inl.h"

#include <array>
#include <cmath>
#include <cstring>
#include <hwy/cache_control.h>
#include <hwy/highway.h>
#include <limits>

HWY_BEFORE_NAMESPACE();
namespace proxima::HWY_NAMESPACE {

/// Where a query ends.
struct FoundLeaf {
    std::uint64_t word = 0;
    int depth = 0;
};

HWY_INLINE FoundLeaf find_leaf(const ProximityOctree& octree,
                               const std::array<std::uint32_t, 3>& at)
{
    const int depth = octree.table_depth();
    int shift = static_cast<int>(ProximityOctree::location_bits) - depth;
    const std::uint64_t* const nodes = octree.arrays().nodes.data();
    std::uint64_t word =
        octree.arrays().table[(std::size_t{at[2] >> shift} << depth | at[1] >> shift) << depth |
                              at[0] >> shift];
    while (!proximity_word::is_leaf(word)) {
        --shift;
        word = nodes[word + ((at[0] >> shift & 1U) | (at[1] >> shift & 1U) << 1U |
                             (at[2] >> shift & 1U) << 2U)];
    }
    return {word, static_cast<int>(ProximityOctree::location_bits) - shift};
}

/// All of a usual one.
HWY_INLINE void prefetch_block(const std::byte* block)
{
    for (std::ptrdiff_t line = 0; line < 6; ++line) hwy::Prefetch(block + 64 * line);
}

template <class Scalar>
HWY_INLINE void prefetch_row(const TriangleRow<Scalar>& row)
{
    hwy::Prefetch(&row);
    if (sizeof(row) > 64) hwy::Prefetch(&row.edges[2]);
}

/// Looks at the candidates in doubles.
template <class Scalar>
HWY_INLINE void recheck(const BlockCandidates& candidates,
                        std::span<const TriangleRow<Scalar>> rows, const Vec3& p,
                        const RowScale& scale, RowDistance& best, QuerySteps& steps)
{
    for (std::uint32_t left = candidates.lanes; left != 0; left &= left - 1)
        prefetch_row(rows[candidates.rank(std::countr_zero(left))]);
    for (std::uint32_t left = candidates.lanes; left != 0; left &= left - 1) {
        const std::uint32_t rank = candidates.rank(std::countr_zero(left));
        const RowDistance found = closest_of_row(rows[rank], rank, p, scale);
        if (found.before(best)) best = found;
        ++steps.rechecks;
    }
}

/// By the tree over all triangles: for points outside of the root and leaves without a list.
/// `known`: some point of the mesh is no farther, up to rounding; infinite where that is not known.
/// Finds nothing where p is not finite.
template <class Scalar>
RowDistance search_tree(const ProximityOctree& octree, std::span<const TriangleRow<Scalar>> rows,
                        const Vec3& p, double known, QuerySteps& steps)
{
    if (!p.allFinite()) return {};
    const RowScale scale = scale_of(octree);
    if (!(octree.frame().to_frame(p).cwiseAbs().maxCoeff() < endless_distance)) [[unlikely]]
        return first_vertex(rows);
    const double tree_scale = octree.tree().scale();
    const double reach = octree.tree().reach();
    RowDistance best;
    const double bound = known * known * (1 + 0x1p-40) + std::numeric_limits<double>::min();
    const auto least = [&] { return std::min(bound, scale.unscale_squared(best.squared)); };
    visit_nearest(octree.tree(), p, bound, [&](RankRange ranks) noexcept {
        const auto group = rows.subspan(ranks.first, ranks.count);
        std::array<double, TriangleTree::width> squared;
        triangle_distances(group, p, tree_scale, squared);
        ++steps.groups;
        offer_nearest(
            squared, group.size(),
            [&] { return triangle_distance_limit(least() * tree_scale * tree_scale, reach); },
            [&](std::size_t i) {
                const auto rank = static_cast<std::uint32_t>(ranks.first + i);
                const RowDistance found = closest_of_row(rows[rank], rank, p, scale);
                if (found.before(best)) best = found;
                ++steps.rechecks;
            });
        return least();
    });
    return best;
}

/// A leaf of several blocks: those whose lower bound is beyond what was found are passed over.
template <class Scalar>
void search_run(const ProximityOctree& octree, std::span<const TriangleRow<Scalar>> rows,
                std::uint64_t word, const Vec3& frame_p, const Vec3& p, double known,
                RowDistance& best, QuerySteps& steps)
{
    const RunEntry* const run = octree.arrays().runs.data() + proximity_word::place(word);
    const Vec3 from_center = frame_p - Eigen::Vector3f(run->direction).cast<double>();
    const double radius = from_center.norm();
    const std::byte* const arena = octree.arrays().arena.data();
    // In the frame, rounded up.
    double nearest = known * octree.frame().scale * (1 + 0x1p-40) + 0x1p-44;
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
        BlockCandidates candidates;
        scan_block<true>(block, entry.mask, frame_p, in_units, candidates);
        if (candidates.lanes == 0) continue;
        recheck(candidates, rows, p, scale_of(octree), best, steps);
        nearest = std::min(nearest, std::sqrt(best.squared) * (1 + 0x1p-40) + 0x1p-44);
    }
}

template <class Scalar>
HWY_INLINE RowDistance search(const ProximityOctree& octree,
                              std::span<const TriangleRow<Scalar>> rows, const Vec3& p,
                              double known, QuerySteps& steps)
{
    RowDistance best;
    const Vec3 frame_p = octree.frame().to_frame(p);
    std::array<std::uint32_t, 3> at{};
    if (!octree.locate(frame_p, at)) return search_tree(octree, rows, p, known, steps);
    const FoundLeaf leaf = find_leaf(octree, at);
    steps.steps += 1 + static_cast<std::uint32_t>(HWY_MAX(leaf.depth - octree.table_depth(), 0));
    if (!proximity_word::is_block(leaf.word)) [[unlikely]] {
        if (leaf.word == proximity_word::search) return search_tree(octree, rows, p, known, steps);
        search_run(octree, rows, leaf.word, frame_p, p, known, best, steps);
        return best;
    }
    const std::byte* const block = octree.arrays().arena.data() +
                                   std::size_t{proximity_word::place(leaf.word)} * block_alignment;
    prefetch_block(block);
    ++steps.blocks;
    BlockCandidates candidates;
    scan_block<false>(block, proximity_word::mask(leaf.word), frame_p, 0, candidates);
    recheck(candidates, rows, p, scale_of(octree), best, steps);
    return best;
}

} // namespace proxima::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
