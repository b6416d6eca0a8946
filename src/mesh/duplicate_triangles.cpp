#include "mesh/duplicate_triangles.h"

#include "base/disjoint_sets.h"
#include "base/progress.h"
#include "mesh/surface_parts.h"
#include "proxima/topology.h"

#include <algorithm>
#include <cstdlib>

namespace proxima::detail {

namespace {

/// Two triangles of the same vertices that face each other.
struct TwoSides {
    std::uint32_t kept = 0;     ///< stays in any case
    std::uint32_t opposite = 0; ///< stays where both sides do
};

/// Decides of which sets both sides stay.
class SideChooser {
public:
    SideChooser(const Topology& topology, std::span<const TriangleCorners> triangles,
                std::span<const std::uint8_t> redundant, std::span<const TwoSides> pairs)
        : topology_(topology), triangles_(triangles), redundant_(redundant),
          pair_of_(triangles.size(), no_pair), groups_(pairs.size()), one_side_(pairs.size(), 0)
    {
        for (std::uint32_t pair = 0; pair < pairs.size(); ++pair) pair_of_[pairs[pair].kept] = pair;
    }

    /// By pair, 1 where one side is enough. Early, with no answer, where `progress` asks to stop.
    std::vector<std::uint8_t> choose(Progress* progress)
    {
        begin_stage(progress, "choosing sides of walls", 3);
        join_groups();
        advance_stage(progress, 1);
        find_borders();
        advance_stage(progress, 1);
        while (!is_cancelled(progress) && (drop_sides(Share::all) || drop_sides(Share::most))) {
        }
        std::vector<std::uint8_t> chosen(one_side_.size());
        for (std::uint32_t pair = 0; pair < chosen.size(); ++pair)
            chosen[pair] = one_side_[groups_.find(pair)];
        advance_stage(progress, 1);
        return chosen;
    }

private:
    static constexpr std::uint32_t no_pair = ~std::uint32_t{0};

    /// An edge that has an odd number of the group's sets.
    struct Border {
        std::uint32_t group = 0;
        std::uint32_t edge = 0;
    };

    enum class Share : std::uint8_t { all, most };

    /// Calls visit(triangle) for one triangle of each set at the edge.
    template <class Visit>
    void visit_sets(std::uint32_t edge, const Visit& visit) const
    {
        for (const TriangleId id : topology_.triangles(EdgeId{edge})) {
            const std::uint32_t triangle = to_index(id);
            if (redundant_[triangle] == 0 && is_proper(triangles_[triangle])) visit(triangle);
        }
    }

    /// Pairs that meet at an edge of no other set are of one group. Groups of components of pairs
    /// alone have one side.
    void join_groups()
    {
        DisjointSets components(triangles_.size());
        std::vector<std::uint8_t> needs_sides(triangles_.size(), 0); // at a component's triangles
        for (std::uint32_t edge = 0; edge < topology_.edge_count(); ++edge) {
            std::uint32_t last = no_pair; // a triangle
            std::uint32_t before_last = no_pair;
            std::uint32_t sets = 0;
            visit_sets(edge, [&](std::uint32_t triangle) {
                if (sets++ > 0) components.unite(last, triangle);
                before_last = last;
                last = triangle;
                if (pair_of_[triangle] == no_pair) needs_sides[triangle] = 1;
            });
            if (sets > 2 && sets % 2 != 0) needs_sides[last] = 1;
            if (sets != 2) continue;
            const std::uint32_t pair = pair_of_[last];
            const std::uint32_t other = pair_of_[before_last];
            if (pair != no_pair && other != no_pair) groups_.unite(pair, other);
        }
        for (std::uint32_t triangle = 0; triangle < triangles_.size(); ++triangle)
            if (needs_sides[triangle] != 0) needs_sides[components.find(triangle)] = 1;
        for (std::uint32_t triangle = 0; triangle < triangles_.size(); ++triangle) {
            const std::uint32_t pair = pair_of_[triangle];
            if (pair != no_pair && needs_sides[components.find(triangle)] == 0)
                one_side_[groups_.find(pair)] = 1;
        }
    }

    void find_borders()
    {
        is_open_.assign(topology_.edge_count(), 0);
        std::vector<std::uint32_t> groups;
        for (std::uint32_t edge = 0; edge < topology_.edge_count(); ++edge) {
            groups.clear();
            std::uint32_t others = 0;
            visit_sets(edge, [&](std::uint32_t triangle) {
                if (pair_of_[triangle] == no_pair) {
                    ++others;
                } else {
                    groups.push_back(groups_.find(pair_of_[triangle]));
                }
            });
            if (groups.empty() || others + groups.size() < 2) continue;
            is_open_[edge] = others % 2 != 0 ? 1 : 0;
            std::ranges::sort(groups);
            for (auto group = groups.begin(); group != groups.end();) {
                const auto next = std::upper_bound(group, groups.end(), *group);
                if ((next - group) % 2 != 0) borders_.push_back({*group, edge});
                group = next;
            }
        }
        std::ranges::stable_sort(borders_, {}, &Border::group);
    }

    /// Has groups keep one side of which so many borders are open; returns whether there was any.
    bool drop_sides(Share share)
    {
        bool dropped = false;
        for (auto border = borders_.begin(); border != borders_.end();) {
            const std::uint32_t group = border->group;
            const auto next = std::find_if(
                border, borders_.end(), [&](const Border& other) { return other.group != group; });
            const auto open = std::count_if(
                border, next, [&](const Border& one) { return is_open_[one.edge] != 0; });
            const auto least = share == Share::all ? next - border : (next - border) / 2 + 1;
            if (one_side_[group] == 0 && open >= least) {
                one_side_[group] = 1;
                dropped = true;
                for (; border != next; ++border) is_open_[border->edge] ^= 1U;
            }
            border = next;
        }
        return dropped;
    }

    const Topology& topology_;
    std::span<const TriangleCorners> triangles_;
    std::span<const std::uint8_t> redundant_;
    std::vector<std::uint32_t> pair_of_; ///< by the triangle that stays
    DisjointSets groups_;                ///< of pairs
    std::vector<std::uint8_t> one_side_; ///< at the lowest pair of each group
    std::vector<std::uint8_t> is_open_;  ///< by edge of several sets, if some are pairs
    std::vector<Border> borders_;        ///< by group
};

} // namespace

bool face_the_same_way(const TriangleCorners& a, const TriangleCorners& b) noexcept
{
    const auto place = static_cast<std::size_t>(std::ranges::find(b, a[0]) - b.begin());
    return b[(place + 1) % 3] == a[1];
}

Result<std::vector<std::uint8_t>> redundant_triangles(std::span<const Vec3> positions,
                                                      std::span<const TriangleCorners> triangles,
                                                      std::span<const std::uint32_t> first,
                                                      const Execution& execution)
{
    struct Set {
        std::int32_t surplus = 0;   ///< triangles that face as the first does, less the others
        std::uint32_t opposite = 0; ///< the first of the others, 0 without any
    };
    const auto count = static_cast<std::uint32_t>(first.size());
    std::vector<Set> sets(count); // at the first triangle of each
    std::vector<std::uint8_t> redundant(count, 0);
    for (std::uint32_t i = 0; i < count; ++i) {
        Set& set = sets[first[i]];
        const bool same_way = first[i] == i || face_the_same_way(triangles[first[i]], triangles[i]);
        set.surplus += same_way ? 1 : -1;
        if (!same_way && set.opposite == 0) set.opposite = i;
        redundant[i] = first[i] == i ? 0 : 1;
    }
    std::vector<TwoSides> pairs;
    for (std::uint32_t i = 0; i < count; ++i) {
        const Set& set = sets[i];
        if (set.opposite == 0) continue;
        const bool is_first = set.surplus >= 0;
        if (!is_first) std::swap(redundant[i], redundant[set.opposite]);
        if (std::abs(set.surplus) > 1) continue;
        pairs.push_back({is_first ? i : set.opposite, is_first ? set.opposite : i});
    }
    if (pairs.empty()) return redundant;

    const auto mesh = make_triangle_mesh({positions.begin(), positions.end()},
                                         {triangles.begin(), triangles.end()});
    if (!mesh) return tl::unexpected(mesh.error());
    const auto topology = build_topology(*mesh, {.execution = execution});
    if (!topology) return tl::unexpected(topology.error());
    const std::vector<std::uint8_t> one_side =
        SideChooser(*topology, triangles, redundant, pairs).choose(execution.progress);
    for (std::size_t pair = 0; pair < pairs.size(); ++pair)
        if (one_side[pair] == 0) redundant[pairs[pair].opposite] = 0;
    return redundant;
}

} // namespace proxima::detail
