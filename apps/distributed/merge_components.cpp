#include "distributed/merge_components.h"

#include "base/disjoint_sets.h"

#include <algorithm>
#include <limits>

namespace proxima {

namespace {

std::uint32_t position(const std::vector<std::uint64_t>& ids, std::uint64_t id)
{
    return static_cast<std::uint32_t>(std::ranges::lower_bound(ids, id) - ids.begin());
}

void count_components(const std::vector<ComponentMeeting>& meetings,
                      std::vector<ComponentPart>& parts, ClassificationSummary& summary)
{
    std::vector<std::uint64_t> ids;
    for (const ComponentMeeting& meeting : meetings) {
        ids.insert(ids.end(), {meeting.a, meeting.b});
    }
    std::ranges::sort(ids);
    ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
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
    const std::uint64_t components = world.sum(summary.components);
    const std::uint64_t leaked_components = world.sum(summary.leaked_components);
    if (components > std::numeric_limits<std::uint32_t>::max()) {
        return fail(ErrorCode::limit_exceeded,
                    concat("the empty leaves make ", components,
                           " regions, and an octree counts 2^32 at most: build it less deep"));
    }
    summary.components = static_cast<std::uint32_t>(components);
    summary.leaked_components = static_cast<std::uint32_t>(leaked_components);
    summary.leaked_leaves = world.sum(summary.leaked_leaves);
    return summary;
}

} // namespace proxima
