#include "octree/empty_regions.h"

#include "base/disjoint_sets.h"

#include <algorithm>

namespace proxima {

namespace {

/// Numbers the sets, those of `left_out` aside, by their smallest members.
template <class LeftOut>
std::vector<std::uint32_t> number_sets(const EmptyGroups& groups, DisjointSets& sets,
                                       const LeftOut& left_out)
{
    std::vector<std::uint32_t> set_of(groups.count(), EmptyRegions::none);
    std::uint32_t count = 0;
    for (std::uint32_t group = 0; group < groups.count(); ++group) {
        if (left_out(groups[group])) continue;
        const std::uint32_t smallest = sets.find(group);
        set_of[group] = smallest == group ? count++ : set_of[smallest];
    }
    return set_of;
}

} // namespace

EmptyRegions find_regions(const Octree& octree, EmptyGroups& groups, bool is_capped,
                          const Progress* progress)
{
    struct Meeting {
        std::uint32_t a = 0;
        std::uint32_t b = 0;
    };
    std::vector<Meeting> at_caps;
    DisjointSets sets(groups.count());
    const auto meet = [&](std::uint32_t a, std::uint32_t b) {
        if (is_capped && (groups[a].is_alone || groups[b].is_alone)) {
            at_caps.push_back({a, b});
        } else {
            sets.unite(a, b);
        }
    };
    EmptyFaces(octree, groups, meet, progress).visit_all();
    EmptyRegions regions;
    if (is_cancelled(progress)) return regions;
    regions.of_group =
        number_sets(groups, sets, [](const EmptyGroup& group) { return group.is_alone; });
    for (std::uint32_t group = 0; group < groups.count(); ++group) {
        const std::uint32_t region = regions.of_group[group];
        if (region == EmptyRegions::none) continue;
        const CellKey first = groups[group].first_cell();
        if (region == regions.start.size()) {
            regions.start.push_back(first);
        } else {
            regions.start[region] = std::min(regions.start[region], first);
        }
    }
    if (!is_capped) return regions;
    for (const Meeting& meeting : at_caps) sets.unite(meeting.a, meeting.b);
    regions.component_of = number_sets(groups, sets, [](const EmptyGroup&) { return false; });
    return regions;
}

} // namespace proxima
