// Repairs of random triangles, against comparing all of them.
#include "mesh/mesh_drafts.h"
#include "mesh/random_soups.h"
#include "mesh/repaired.h"
#include "proxima/mesh_repair.h"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <gtest/gtest.h>
#include <iterator>
#include <map>
#include <random>
#include <set>
#include <vector>

namespace proxima::repair_of_soups_test {
namespace {

using namespace testing;
using Kind = RepairStepKind;

/// The first steps, without that of duplicates, done by comparing everything with everything.
struct SlowRepair {
    std::vector<TriangleId> triangles;
    std::vector<TriangleCorners> corners;
    std::set<std::pair<std::uint32_t, std::uint32_t>> welded;
};

bool on_one_line(const TriangleMesh& mesh, const TriangleCorners& corners)
{
    // Exact: coordinates are small whole numbers.
    const Vec3& a = mesh.positions()[corners[0]];
    const Vec3 u = mesh.positions()[corners[1]] - a;
    const Vec3 v = mesh.positions()[corners[2]] - a;
    return u.cross(v).isZero(0);
}

using Ends = std::pair<std::uint32_t, std::uint32_t>;
using Names = std::set<std::uint32_t>;

Names names_of(const TriangleCorners& corners)
{
    return {corners.begin(), corners.end()};
}

std::set<Ends> edges_of(const Names& names)
{
    std::set<Ends> edges;
    for (const std::uint32_t a : names) {
        for (const std::uint32_t b : names)
            if (a < b) edges.insert({a, b});
    }
    return edges;
}

using Ways = std::array<std::vector<std::size_t>, 2>; ///< triangles by the way they face

std::map<Names, Ways> sets_of(std::span<const TriangleCorners> triangles)
{
    std::map<Names, Ways> sets;
    for (std::size_t i = 0; i < triangles.size(); ++i) {
        TriangleCorners corners = triangles[i];
        const Names names = names_of(corners);
        if (names.size() < 3) continue;
        std::rotate(corners.begin(), std::ranges::min_element(corners), corners.end());
        sets[names].at(corners[1] < corners[2] ? 0 : 1).push_back(i);
    }
    return sets;
}

/// Of each set the first of those that face the way of most stays, of `two_sided` the first of each way.
void drop_duplicates(SlowRepair& slow, const std::set<Names>& two_sided)
{
    std::set<std::size_t> dropped;
    for (const auto& [names, ways] : sets_of(slow.corners)) {
        std::set<std::size_t> all(ways[0].begin(), ways[0].end());
        all.insert(ways[1].begin(), ways[1].end());
        if (two_sided.contains(names)) {
            for (const auto& way : ways) all.erase(way.at(0));
        } else if (ways[0].size() == ways[1].size()) {
            all.erase(*all.begin());
        } else {
            all.erase(ways.at(ways[0].size() > ways[1].size() ? 0 : 1)[0]);
        }
        dropped.merge(all);
    }
    std::size_t kept = 0;
    for (std::size_t i = 0; i < slow.triangles.size(); ++i) {
        if (dropped.contains(i)) continue;
        slow.triangles[kept] = slow.triangles[i];
        slow.corners[kept++] = slow.corners[i];
    }
    slow.triangles.resize(kept);
    slow.corners.resize(kept);
}

/// Sets that meet at edges of no other set, as connected ones.
std::vector<std::set<Names>> groups_of(std::set<Names> sets,
                                       const std::map<Ends, std::vector<Names>>& at_edges)
{
    std::vector<std::set<Names>> groups;
    while (!sets.empty()) {
        std::set<Names> group = {*sets.begin()};
        std::vector<Names> open = {*sets.begin()};
        sets.erase(sets.begin());
        while (!open.empty()) {
            const Names one = open.back();
            open.pop_back();
            for (const Ends& edge : edges_of(one)) {
                const std::vector<Names>& there = at_edges.at(edge);
                if (there.size() != 2) continue;
                for (const Names& other : there) {
                    if (sets.erase(other) == 0) continue;
                    group.insert(other);
                    open.push_back(other);
                }
            }
        }
        groups.push_back(std::move(group));
    }
    return groups;
}

/// What must be so of the sets of which both sides stay: none of them could drop one and leave fewer
/// edges open where several sets meet; and both stay where nothing is open.
void expect_sides_well_chosen(const std::map<Names, Ways>& before, const std::set<Names>& two_sided)
{
    std::map<Ends, std::vector<Names>> at_edges;
    for (const auto& [names, ways] : before) {
        for (const Ends& edge : edges_of(names)) at_edges[edge].push_back(names);
    }
    const auto open_edges = [&](const std::set<Names>& double_ones) {
        return std::ranges::count_if(at_edges, [&](const auto& at) {
            const auto is_single = [&](const Names& names) { return !double_ones.contains(names); };
            return at.second.size() > 1 && std::ranges::count_if(at.second, is_single) % 2 != 0;
        });
    };
    std::set<Names> faces_both_ways;
    for (const auto& [names, ways] : before) {
        const auto surplus = static_cast<std::ptrdiff_t>(ways[0].size()) -
                             static_cast<std::ptrdiff_t>(ways[1].size());
        if (!ways[0].empty() && !ways[1].empty() && std::abs(surplus) <= 1)
            faces_both_ways.insert(names);
    }
    EXPECT_TRUE(std::ranges::includes(faces_both_ways, two_sided));
    const auto open_now = open_edges(two_sided);
    for (const std::set<Names>& group : groups_of(two_sided, at_edges)) {
        std::set<Names> others = two_sided;
        for (const Names& names : group) others.erase(names);
        EXPECT_GE(open_edges(others), open_now);
    }
    // Components of such sets alone may be single all the same.
    std::set<Names> beside_others;
    for (bool grows = true; grows;) {
        grows = false;
        for (const auto& [edge, there] : at_edges) {
            const bool joins = std::ranges::any_of(there, [&](const Names& names) {
                return !faces_both_ways.contains(names) || beside_others.contains(names);
            });
            for (const Names& names : there)
                grows = (joins && beside_others.insert(names).second) || grows;
        }
    }
    std::set<Names> may_stay;
    std::ranges::set_intersection(faces_both_ways, beside_others,
                                  std::inserter(may_stay, may_stay.end()));
    if (open_edges(faces_both_ways) == 0) {
        EXPECT_TRUE(std::ranges::includes(two_sided, may_stay));
    }
}

SlowRepair slowly_repaired(const TriangleMesh& mesh, const MeshRepairOptions& options)
{
    SlowRepair slow;
    std::set<std::uint32_t> used;
    for (const TriangleCorners& corners : mesh.triangles())
        used.insert(corners.begin(), corners.end());
    for (std::uint32_t id = 0; id < mesh.triangle_count(); ++id) {
        TriangleCorners corners = mesh.triangles()[id];
        for (std::uint32_t& corner : corners) {
            const auto first = std::ranges::find_if(used, [&](std::uint32_t other) {
                return mesh.positions()[other] == mesh.positions()[corner];
            });
            if (options.weld && *first != corner) slow.welded.insert({corner, *first});
            if (options.weld) corner = *first;
        }
        const std::set<std::uint32_t> own(corners.begin(), corners.end());
        if (own.size() < 3) {
            if (options.drop_degenerate) continue;
        } else {
            if (options.drop_zero_area && on_one_line(mesh, corners)) continue;
        }
        slow.triangles.push_back(TriangleId{id});
        slow.corners.push_back(corners);
    }
    return slow;
}

/// How many pieces the triangles come apart into, and how many of these have one side.
struct SlowPieces {
    std::uint64_t pieces = 0;
    std::uint64_t unorientable = 0;
};

/// Two triangles at an edge of exactly two, and whether they run along it the same way.
struct Seam {
    std::size_t a = 0;
    std::size_t b = 0;
    bool same_way = false;
};

std::vector<Seam> seams_of(std::span<const TriangleCorners> triangles)
{
    std::map<Ends, std::vector<std::pair<std::size_t, bool>>> edges;
    for (std::size_t i = 0; i < triangles.size(); ++i) {
        const TriangleCorners& corners = triangles[i];
        if (std::set<std::uint32_t>(corners.begin(), corners.end()).size() < 3) continue;
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t from = corners[k];
            const std::uint32_t to = corners[(k + 1) % 3];
            edges[std::minmax(from, to)].emplace_back(i, from < to);
        }
    }
    std::vector<Seam> seams;
    for (const auto& [ends, users] : edges) {
        if (users.size() != 2) continue;
        seams.push_back({users[0].first, users[1].first, users[0].second == users[1].second});
    }
    return seams;
}

/// By spreading numbers and sides until nothing changes.
SlowPieces slow_pieces(std::span<const TriangleCorners> triangles)
{
    const std::vector<Seam> seams = seams_of(triangles);
    std::vector<std::size_t> number(triangles.size());
    std::iota(number.begin(), number.end(), 0U);
    std::vector<int> side(triangles.size(), 1);
    for (bool changed = true; changed;) {
        changed = false;
        for (const Seam& seam : seams) {
            if (number[seam.a] == number[seam.b]) continue;
            const auto [to, from] = number[seam.a] < number[seam.b] ? std::pair(seam.b, seam.a)
                                                                    : std::pair(seam.a, seam.b);
            number[to] = number[from];
            side[to] = seam.same_way ? -side[from] : side[from];
            changed = true;
        }
    }
    std::set<std::size_t> pieces;
    for (std::size_t i = 0; i < triangles.size(); ++i) {
        const TriangleCorners& corners = triangles[i];
        if (std::set<std::uint32_t>(corners.begin(), corners.end()).size() == 3)
            pieces.insert(number[i]);
    }
    std::set<std::size_t> unorientable;
    for (const Seam& seam : seams) {
        const bool matches = (side[seam.a] == side[seam.b]) != seam.same_way;
        if (!matches) unorientable.insert(number[seam.a]);
    }
    return {pieces.size(), unorientable.size()};
}

std::uint64_t unmatched_seams(std::span<const TriangleCorners> triangles)
{
    const std::vector<Seam> seams = seams_of(triangles);
    return static_cast<std::uint64_t>(
        std::ranges::count_if(seams, [](const Seam& seam) { return seam.same_way; }));
}

/// The Möbius strip of five triangles, corners and triangles in any order, with a few more or less.
TriangleMesh nearly_a_strip(std::uint32_t seed)
{
    std::mt19937 random(seed);
    Draft draft = Draft().add(make_octahedron());
    std::array<std::uint32_t, 6> names = {0, 1, 2, 3, 4, 5};
    std::ranges::shuffle(names, random);
    draft.triangles.clear();
    for (std::uint32_t i = 0; i < 5; ++i) {
        TriangleCorners corners = {names[i], names[(i + 1) % 5], names[(i + 2) % 5]};
        std::ranges::shuffle(corners, random);
        if (below(random, 10) != 0) draft.triangles.push_back(corners);
    }
    for (std::uint32_t more = below(random, 3); more > 0; --more)
        draft.triangles.push_back({below(random, 6), below(random, 6), below(random, 6)});
    std::ranges::shuffle(draft.triangles, random);
    return draft.mesh();
}

/// The triangles of a repair by the vertices that they had, and as they faced.
std::vector<TriangleCorners> original_corners(const MeshRepair& repair)
{
    std::vector<TriangleCorners> triangles;
    for (std::size_t i = 0; i < repair.mesh.triangle_count(); ++i) {
        TriangleCorners corners = repair.mesh.triangles()[i];
        for (std::uint32_t& corner : corners) corner = to_index(repair.original_vertices[corner]);
        if (repair.turned[i] != 0) std::swap(corners[1], corners[2]);
        triangles.push_back(corners);
    }
    return triangles;
}

TEST(MeshRepair, AgreesWithComparingEverythingOnSoups)
{
    std::uint64_t unorientable = 0;
    std::uint64_t two_sided = 0;
    for (std::uint32_t seed = 0; seed < 4000; ++seed) {
        SCOPED_TRACE(seed);
        const TriangleMesh mesh = seed % 2 == 0 ? random_soup(seed) : nearly_a_strip(seed);
        std::mt19937 random(seed);
        const auto coin = [&] { return random() % 3 != 0; };
        const MeshRepairOptions options{.weld = coin(),
                                        .drop_degenerate = coin(),
                                        .drop_zero_area = coin(),
                                        .drop_duplicates = coin(),
                                        .orient = coin(),
                                        .turn_outward = coin(),
                                        .keep_cavities = coin(),
                                        .drop_unused_vertices = coin()};
        SlowRepair slow = slowly_repaired(mesh, options);
        const MeshRepair repair = repaired(mesh, options);
        if (options.drop_duplicates) {
            const std::map<Names, Ways> sets = sets_of(slow.corners);
            std::set<Names> both_sides;
            for (const auto& [names, ways] : sets_of(original_corners(repair)))
                if (ways[0].size() + ways[1].size() == 2) both_sides.insert(names);
            expect_sides_well_chosen(sets, both_sides);
            drop_duplicates(slow, both_sides);
            two_sided += both_sides.size();
        }
        expect_maps_right(mesh, repair);
        EXPECT_EQ(repair.original_triangles, slow.triangles);
        EXPECT_EQ(count(repair, Kind::weld_vertices), slow.welded.size());
        EXPECT_EQ(count(repair, Kind::drop_degenerate) + count(repair, Kind::drop_zero_area) +
                      count(repair, Kind::drop_duplicates),
                  mesh.triangle_count() - repair.mesh.triangle_count());
        for (std::size_t i = 0; i < slow.corners.size(); ++i) {
            TriangleCorners now = repair.mesh.triangles()[i];
            for (std::uint32_t& corner : now) corner = to_index(repair.original_vertices[corner]);
            TriangleCorners expected = slow.corners[i];
            if (repair.turned[i] != 0) std::swap(expected[1], expected[2]);
            EXPECT_EQ(now, expected);
        }
        if (options.orient || options.turn_outward) {
            EXPECT_EQ(repair.pieces, slow_pieces(slow.corners).pieces);
        }
        if (options.orient) {
            EXPECT_EQ(repair.unorientable_pieces, slow_pieces(slow.corners).unorientable);
            EXPECT_EQ(repair.unorientable_edges, unmatched_seams(repair.mesh.triangles()));
            unorientable += repair.unorientable_pieces;
        }
        expect_idempotent(repair, options);
    }
    EXPECT_GT(unorientable, 200U);
    EXPECT_GT(two_sided, 100U);
}

} // namespace
} // namespace proxima::repair_of_soups_test
