#include "distributed/merge_regions.h"

#include "base/disjoint_sets.h"

#include <algorithm>

namespace proxima {

namespace {

std::uint32_t position(const std::vector<std::uint64_t>& ids, std::uint64_t id)
{
    return static_cast<std::uint32_t>(std::ranges::lower_bound(ids, id) - ids.begin());
}

Status check_count(const std::vector<std::uint64_t>& ids)
{
    if (ids.size() < std::numeric_limits<std::uint32_t>::max()) return {};
    return fail(ErrorCode::limit_exceeded,
                "2^32 regions of empty cells or more meet at borders of ranks: use fewer ranks");
}

/// The answers to the owners of the regions.
Status answer(const std::vector<RegionTie>& ties, const std::vector<std::uint64_t>& first_region,
              std::vector<std::vector<RegionTie>>& answers)
{
    std::vector<std::uint64_t> ids = {0};
    for (const RegionTie& tie : ties) ids.insert(ids.end(), {tie.region, tie.from});
    make_unique(ids);
    if (const Status status = check_count(ids); !status) return status;
    DisjointOffsets numbers(ids.size());
    for (const RegionTie& tie : ties) {
        numbers.unite(position(ids, tie.from), position(ids, tie.region), tie.difference);
    }
    std::size_t rank = 0;
    for (std::uint32_t i = 1; i < ids.size(); ++i) {
        while (rank + 1 < first_region.size() && first_region[rank + 1] <= ids[i]) ++rank;
        const auto found = numbers.find(i);
        answers[rank].push_back({ids[i], ids[found.smallest], found.difference});
    }
    return {};
}

void count_components(const std::vector<ComponentMeeting>& meetings,
                      std::vector<ComponentPart>& parts, ClassificationSummary& summary)
{
    std::vector<std::uint64_t> ids;
    for (const ComponentMeeting& meeting : meetings) {
        ids.insert(ids.end(), {meeting.a, meeting.b});
    }
    make_unique(ids);
    DisjointSets sets(ids.size());
    for (const ComponentMeeting& meeting : meetings) {
        sets.unite(position(ids, meeting.a), position(ids, meeting.b));
    }
    for (ComponentPart& part : parts) {
        const std::uint32_t at = position(ids, part.component);
        if (at < ids.size() && ids[at] == part.component) part.component = ids[sets.find(at)];
    }
    std::ranges::sort(parts, {}, &ComponentPart::component);
    for (std::size_t i = 0; i < parts.size();) {
        ComponentPart whole{parts[i].component};
        for (; i < parts.size() && parts[i].component == whole.component; ++i) whole.add(parts[i]);
        count_component(whole, summary);
    }
}

} // namespace

Result<std::vector<RegionTie>> join_regions(std::vector<RegionTie> ties, std::uint64_t own_regions,
                                            World& world)
{
    const std::vector<std::uint64_t> counts = world.gather(own_regions);
    auto all = world.collect(std::move(ties));
    if (!all) return tl::unexpected(all.error());
    std::vector<std::vector<RegionTie>> answers(static_cast<std::size_t>(world.size()));
    const Status status = world.agree_on([&]() -> Status {
        if (world.rank() != 0) return {};
        std::vector<std::uint64_t> first_region;
        std::uint64_t next = 1;
        for (const std::uint64_t count : counts) {
            first_region.push_back(next);
            next += count;
        }
        make_unique(all->items);
        return answer(all->items, first_region, answers);
    });
    if (!status) return tl::unexpected(status.error());
    auto own = world.exchange(std::move(answers));
    if (!own) return tl::unexpected(own.error());
    return std::move(own->items);
}

void count_component(const ComponentPart& whole, ClassificationSummary& summary) noexcept
{
    ++summary.components;
    if (whole.has_inner == 0 || whole.has_outer == 0) return;
    ++summary.leaked_components;
    summary.leaked_leaves += whole.leaves;
}

Result<ClassificationSummary> join_components(std::vector<ComponentMeeting> meetings,
                                              std::vector<ComponentPart> parts,
                                              const ClassificationSummary& own, World& world)
{
    const auto all_meetings = world.collect(std::move(meetings));
    if (!all_meetings) return tl::unexpected(all_meetings.error());
    auto all_parts = world.collect(std::move(parts));
    if (!all_parts) return tl::unexpected(all_parts.error());
    ClassificationSummary summary = own;
    const Status status = world.agree_on([&]() -> Status {
        count_components(all_meetings->items, all_parts->items, summary);
        return {};
    });
    if (!status) return tl::unexpected(status.error());
    summary.components = static_cast<std::uint32_t>(world.sum(summary.components));
    summary.leaked_components = static_cast<std::uint32_t>(world.sum(summary.leaked_components));
    summary.leaked_leaves = world.sum(summary.leaked_leaves);
    return summary;
}

} // namespace proxima
