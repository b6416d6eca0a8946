#include "proxima/intersect_meshes.h"

#include "base/parallel.h"
#include "base/progress.h"
#include "index/index_parts.h"
#include "query/batch_size.h"
#include "query/contact/contact_search.h"
#include "query/contact/find_pairs.h"

#include <algorithm>
#include <array>
#include <span>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "query/contact/intersect_meshes.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
// After them: it is read once for every instruction set.
#include "query/contact/walk_pairs-inl.h"

HWY_BEFORE_NAMESPACE();
namespace proxima::HWY_NAMESPACE {

/// Ends at the first pair that meets.
class FirstPair {
public:
    static constexpr bool deepest_first = true;

    FirstPair(const ContactSearch& open, RowPair& found) : open_(open), found_(found) {}

    HWY_INLINE bool take(std::uint32_t row_a, std::uint32_t row_b, bool sure) const
    {
        if (!sure && !ask_rows(open_, row_a, row_b)) return true;
        found_ = {row_a, row_b};
        return false;
    }

private:
    const ContactSearch& open_;
    RowPair& found_;
};

/// Passes on all pairs that meet.
class AllPairs {
public:
    static constexpr bool deepest_first = false;

    AllPairs(const ContactSearch& open, RowPairVisitor visitor) : open_(open), visitor_(visitor) {}

    HWY_INLINE bool take(std::uint32_t row_a, std::uint32_t row_b, bool sure)
    {
        if (!sure && !ask_rows(open_, row_a, row_b))
            return ++apart_ < most_apart || flush() == Flow::proceed;
        if (count_ == pairs_.size() && flush() == Flow::stop) return false;
        pairs_[count_++] = {row_a, row_b};
        return true;
    }
    Flow flush()
    {
        apart_ = 0;
        const Flow flow = visitor_(std::span(pairs_).first(count_));
        count_ = 0;
        return flow;
    }

private:
    /// So many pairs that do not meet, one after the other, and the visitor may end the search.
    static constexpr std::size_t most_apart = 4096;

    const ContactSearch& open_;
    RowPairVisitor visitor_;
    std::size_t count_ = 0;
    std::size_t apart_ = 0;
    std::array<RowPair, max_rows_together> pairs_;
};

bool walk_to_first_pair(const ContactSearch& open, RowPair& found)
{
    FirstPair search(open, found);
    return !walk_pairs(open, search);
}

void walk_to_all_pairs(const ContactSearch& open, RowPairVisitor visitor)
{
    AllPairs search(open, visitor);
    if (walk_pairs(open, search)) (void)search.flush();
}

} // namespace proxima::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace proxima {

HWY_EXPORT(walk_to_first_pair);
HWY_EXPORT(walk_to_all_pairs);

namespace {

/// Asks all pairs whose boxes meet, for poses that floats know nothing of, until visit returns
/// false.
template <class Visit>
bool ask_all(const IndexParts& a, const IndexParts& b, const RigidTransform& pose_b,
             const Visit& visit)
{
    for (std::uint32_t j = 0; j < b.triangle_count(); ++j) {
        const Box box_b = bounding_box(pose_b(b.triangle(j)));
        for (std::uint32_t i = 0; i < a.triangle_count(); ++i) {
            const Box box_a = bounding_box(a.triangle(i));
            const bool apart = (box_a.lower.array() > box_b.upper.array()).any() ||
                               (box_b.lower.array() > box_a.upper.array()).any();
            if (!apart && ask_rows(a, i, b, j, pose_b) && !visit(RowPair{i, j})) return true;
        }
    }
    return false;
}

bool find_first(const IndexParts& a, const IndexParts& b, const RigidTransform& pose_b,
                RowPair& found)
{
    ContactSearch open;
    switch (contact_search(a, b, pose_b, open)) {
    case PairStart::apart:
        return false;
    case PairStart::ready:
        return HWY_DYNAMIC_DISPATCH(walk_to_first_pair)(open, found);
    case PairStart::too_far:
        break;
    }
    return ask_all(a, b, pose_b, [&](const RowPair& pair) {
        found = pair;
        return false;
    });
}

/// In linear time where ids are spread: by the upper bits of a, then each of these groups.
void sort_pairs(std::vector<TrianglePair>& pairs)
{
    constexpr std::size_t few = 64;
    if (pairs.size() < few) {
        std::ranges::sort(pairs);
        return;
    }
    const auto by_a = [](const TrianglePair& x, const TrianglePair& y) { return x.a < y.a; };
    const auto [least, most] = std::ranges::minmax_element(pairs, by_a);
    const std::uint32_t start = to_index(least->a);
    const std::uint32_t range = to_index(most->a) - start;
    unsigned shift = 0;
    while ((range >> shift) >= 2 * pairs.size()) ++shift;
    std::vector<std::uint32_t> end((range >> shift) + 2, 0);
    const auto group = [&](const TrianglePair& pair) {
        return (to_index(pair.a) - start) >> shift;
    };
    for (const TrianglePair& pair : pairs) ++end[group(pair) + 1];
    for (std::size_t i = 1; i < end.size(); ++i) end[i] += end[i - 1];
    std::vector<TrianglePair> sorted(pairs.size());
    for (const TrianglePair& pair : pairs) sorted[end[group(pair)]++] = pair;
    pairs.swap(sorted);
    const std::span<TrianglePair> all(pairs);
    for (std::size_t i = 0, first = 0; i + 1 < end.size(); first = end[i++]) {
        if (end[i] - first > 1) std::ranges::sort(all.subspan(first, end[i] - first));
    }
}

constexpr std::size_t poses_per_task = 4;

/// Calls task(i) for all poses.
template <class Task>
Status for_poses(std::size_t count, const PairOptions& options, const Task& task)
{
    begin_stage(options.execution.progress, "intersecting meshes", count);
    parallel_chunks(count, poses_per_task, options.execution.threads,
                    [&](std::size_t first, std::size_t end) {
                        for (std::size_t i = first; i < end; ++i) {
                            if (is_cancelled(options.execution.progress)) return;
                            task(i);
                            advance_stage(options.execution.progress, 1);
                        }
                    });
    if (is_cancelled(options.execution.progress)) return cancelled("intersecting meshes");
    return {};
}

} // namespace

bool meshes_intersect(const MeshIndex& a, const MeshIndex& b, const RigidTransform& pose_b) noexcept
{
    RowPair found;
    return find_first(a.parts(), b.parts(), pose_b, found);
}

std::optional<MeshMeeting> find_meeting(const MeshIndex& a, const MeshIndex& b,
                                        const RigidTransform& pose_b,
                                        const MeetingOptions& options) noexcept
{
    const IndexParts& parts_a = a.parts();
    const IndexParts& parts_b = b.parts();
    const auto meeting = [&](RowPair rows) {
        return MeshMeeting{parts_a.id(rows.a), parts_b.id(rows.b), rows.a, rows.b};
    };
    if (const MeshMeeting* start = options.start_from;
        start != nullptr && start->row_a < a.triangle_count() &&
        start->row_b < b.triangle_count() &&
        ask_rows(parts_a, start->row_a, parts_b, start->row_b, pose_b))
        return meeting({start->row_a, start->row_b});
    RowPair found;
    if (!find_first(parts_a, parts_b, pose_b, found)) return std::nullopt;
    return meeting(found);
}

void visit_intersecting_rows(const IndexParts& a, const IndexParts& b, const RigidTransform& pose_b,
                             RowPairVisitor visitor)
{
    ContactSearch open;
    switch (contact_search(a, b, pose_b, open)) {
    case PairStart::apart:
        return;
    case PairStart::ready:
        HWY_DYNAMIC_DISPATCH(walk_to_all_pairs)(open, visitor);
        return;
    case PairStart::too_far:
        break;
    }
    (void)ask_all(a, b, pose_b, [&](const RowPair& pair) {
        return visitor({&pair, 1}) == Flow::proceed;
    });
}

void visit_intersecting_pairs(const MeshIndex& a, const MeshIndex& b, const RigidTransform& pose_b,
                              FunctionRef<Flow(std::span<const TrianglePair>)> visitor)
{
    const std::span<const TriangleId> ids_a = a.ids();
    const std::span<const TriangleId> ids_b = b.ids();
    visit_intersecting_rows(a.parts(), b.parts(), pose_b, [&](std::span<const RowPair> rows) {
        std::array<TrianglePair, max_rows_together> pairs;
        for (std::size_t i = 0; i < rows.size(); ++i)
            pairs[i] = {ids_a[rows[i].a], ids_b[rows[i].b]};
        return visitor(std::span(pairs).first(rows.size()));
    });
}

std::vector<TrianglePair> find_pairs(const MeshIndex& a, const MeshIndex& b,
                                     const RigidTransform& pose_b, const Progress* progress)
{
    std::vector<TrianglePair> pairs;
    visit_intersecting_pairs(a, b, pose_b, [&](std::span<const TrianglePair> some) {
        pairs.insert(pairs.end(), some.begin(), some.end());
        return is_cancelled(progress) ? Flow::stop : Flow::proceed;
    });
    sort_pairs(pairs);
    return pairs;
}

std::vector<TrianglePair> intersecting_pairs(const MeshIndex& a, const MeshIndex& b,
                                             const RigidTransform& pose_b)
{
    return find_pairs(a, b, pose_b, nullptr);
}

std::size_t intersecting_pairs(const MeshIndex& a, const MeshIndex& b, const RigidTransform& pose_b,
                               std::span<TrianglePair> pairs) noexcept
{
    std::size_t count = 0;
    // A heap, the last one on top, once the list is full.
    visit_intersecting_pairs(a, b, pose_b, [&](std::span<const TrianglePair> some) {
        for (const TrianglePair& pair : some) {
            if (count < pairs.size()) {
                pairs[count] = pair;
                if (count + 1 == pairs.size()) std::ranges::make_heap(pairs);
            } else if (!pairs.empty() && pair < pairs.front()) {
                std::ranges::pop_heap(pairs);
                pairs.back() = pair;
                std::ranges::push_heap(pairs);
            }
            ++count;
        }
        return Flow::proceed;
    });
    std::ranges::sort(pairs.first(std::min(count, pairs.size())));
    return count;
}

Status meshes_intersect(const MeshIndex& a, const MeshIndex& b,
                        std::span<const RigidTransform> poses, std::span<bool> answers,
                        const PairOptions& options)
{
    if (Status status = check_batch_size(answers.size(), poses.size(), "poses"); !status)
        return status;
    return for_poses(poses.size(), options,
                     [&](std::size_t i) { answers[i] = meshes_intersect(a, b, poses[i]); });
}

Result<PairLists> intersecting_pairs(const MeshIndex& a, const MeshIndex& b,
                                     std::span<const RigidTransform> poses,
                                     const PairOptions& options)
{
    std::vector<std::vector<TrianglePair>> found(poses.size());
    const Status status = for_poses(poses.size(), options, [&](std::size_t i) {
        found[i] = find_pairs(a, b, poses[i], options.execution.progress);
    });
    if (!status) return tl::unexpected(status.error());
    PairLists lists;
    lists.first.reserve(poses.size() + 1);
    lists.first.push_back(0);
    for (const std::vector<TrianglePair>& pairs : found) {
        lists.pairs.insert(lists.pairs.end(), pairs.begin(), pairs.end());
        lists.first.push_back(lists.pairs.size());
    }
    return lists;
}

} // namespace proxima

#endif
