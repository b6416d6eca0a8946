// The closest feature by the lists of a mesh index: leaf, block, rows. Included once per target.
#if defined(PROXIMA_QUERY_CLOSEST_SEARCH_LISTS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef PROXIMA_QUERY_CLOSEST_SEARCH_LISTS_INL_H
#undef PROXIMA_QUERY_CLOSEST_SEARCH_LISTS_INL_H
#else
#define PROXIMA_QUERY_CLOSEST_SEARCH_LISTS_INL_H
#endif

#include "index/index_parts.h"
#include "index/lists/block_scan-inl.h"
#include "index/lists/proximity_lists.h"
#include "proxima/closest_feature.h"
#include "proxima/mesh_index.h"
#include "query/closest/describe_closest.h"
#include "query/closest/find_closest.h"
#include "query/closest/index_query.h"
#include "query/closest/row_distance-inl.h"
#include "query/closest/search_index-inl.h"

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

HWY_INLINE FoundLeaf find_leaf(const ProximityLists& lists, const std::array<std::uint32_t, 3>& at)
{
    const int depth = lists.table_depth();
    int shift = static_cast<int>(ProximityLists::location_bits) - depth;
    const std::uint64_t* const nodes = lists.arrays().nodes.data();
    std::uint64_t word =
        lists.arrays().table[(std::size_t{at[2] >> shift} << depth | at[1] >> shift) << depth |
                             at[0] >> shift];
    while (!proximity_word::is_leaf(word)) {
        --shift;
        word = nodes[word + ((at[0] >> shift & 1U) | (at[1] >> shift & 1U) << 1U |
                             (at[2] >> shift & 1U) << 2U)];
    }
    return {word, static_cast<int>(ProximityLists::location_bits) - shift};
}

/// All of a usual one.
HWY_INLINE void prefetch_block(const std::byte* block)
{
    for (std::ptrdiff_t line = 0; line < 6; ++line) hwy::Prefetch(block + 64 * line);
}

/// Looks at the candidates in doubles.
template <class Scalar>
HWY_INLINE void recheck(const BlockCandidates& candidates,
                        std::span<const TriangleRow<Scalar>> rows, const Vec3& p,
                        const RowScale& scale, RowDistance& best, QuerySteps& steps)
{
    for (std::uint32_t left = candidates.lanes; left != 0; left &= left - 1)
        prefetch_row_of(rows[candidates.rank(std::countr_zero(left))]);
    for (std::uint32_t left = candidates.lanes; left != 0; left &= left - 1) {
        const std::uint32_t rank = candidates.rank(std::countr_zero(left));
        const RowDistance found = closest_of_row(rows[rank], rank, p, scale);
        if (found.before(best)) best = found;
        ++steps.rechecks;
    }
}

/// A leaf of several blocks: those whose lower bound is beyond what was found are passed over.
template <class Scalar>
void search_run(const IndexParts& index, const ProximityLists& lists,
                std::span<const TriangleRow<Scalar>> rows, std::uint64_t word, const Vec3& frame_p,
                const Vec3& p, double known, RowDistance& best, QuerySteps& steps)
{
    const RunEntry* const run = lists.arrays().runs.data() + proximity_word::position(word);
    const Vec3 from_center = frame_p - Eigen::Vector3f(run->direction).cast<double>();
    const double radius = from_center.norm();
    const std::byte* const arena = lists.arrays().arena.data();
    // In the frame, rounded up.
    const double best_to_frame = index.unscale() * lists.frame().scale;
    double nearest = known * lists.frame().scale * (1 + 0x1p-40) + 0x1p-44;
    for (std::uint32_t i = 1; i <= run->position; ++i) {
        const RunEntry& entry = run[i];
        if (static_cast<double>(entry.least) - radius > nearest) break;
        const double bound = static_cast<double>(entry.least) -
                             static_cast<double>(entry.direction[0]) * from_center[0] -
                             static_cast<double>(entry.direction[1]) * from_center[1] -
                             static_cast<double>(entry.direction[2]) * from_center[2];
        if (bound > nearest) continue;
        const std::byte* const block = arena + std::size_t{entry.position} * block_alignment;
        BlockHeader header;
        std::memcpy(&header, block, sizeof(header));
        ++steps.blocks;
        const double in_units = nearest * static_cast<double>(header.inverse_unit);
        BlockCandidates candidates;
        scan_block<true>(block, entry.mask, frame_p, in_units, candidates);
        if (candidates.lanes == 0) continue;
        recheck(candidates, rows, p, row_scale_of(index), best, steps);
        nearest =
            std::min(nearest, std::sqrt(best.squared) * best_to_frame * (1 + 0x1p-40) + 0x1p-44);
    }
}

/// As search_index: by the lists where p is in their root and its leaf has one.
template <class Scalar>
HWY_NOINLINE inline RowDistance search_lists(const IndexParts& index, const ProximityLists& lists,
                                             std::span<const TriangleRow<Scalar>> rows,
                                             const Vec3& p, double known, QuerySteps& steps)
{
    RowDistance best;
    const Vec3 frame_p = lists.frame().to_frame(p);
    std::array<std::uint32_t, 3> at{};
    if (!lists.locate(frame_p, at)) {
        ++steps.searches;
        return search_index(index, rows, p, known);
    }
    const FoundLeaf leaf = find_leaf(lists, at);
    steps.steps += 1 + static_cast<std::uint32_t>(HWY_MAX(leaf.depth - lists.table_depth(), 0));
    if (!proximity_word::is_block(leaf.word)) [[unlikely]] {
        if (leaf.word == proximity_word::search) {
            ++steps.searches;
            return search_index(index, rows, p, known);
        }
        search_run(index, lists, rows, leaf.word, frame_p, p, known, best, steps);
        return found_or_any(best, rows, known);
    }
    const std::byte* const block =
        lists.arrays().arena.data() +
        std::size_t{proximity_word::position(leaf.word)} * block_alignment;
    prefetch_block(block);
    ++steps.blocks;
    BlockCandidates candidates;
    scan_block<false>(block, proximity_word::mask(leaf.word), frame_p, 0, candidates);
    recheck(candidates, rows, p, row_scale_of(index), best, steps);
    return best;
}

/// By the lists where the index has some.
template <class Scalar>
HWY_INLINE RowDistance search_lists_or_tree(const IndexParts& index,
                                            std::span<const TriangleRow<Scalar>> rows,
                                            const Vec3& p, double known, QuerySteps& steps)
{
    if (index.lists() != nullptr) return search_lists(index, *index.lists(), rows, p, known, steps);
    ++steps.searches;
    return search_index(index, rows, p, known);
}

} // namespace proxima::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
