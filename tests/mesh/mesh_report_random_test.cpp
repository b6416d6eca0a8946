// The mesh report against definitions taken literally: all pairs, breadth-first search.
#include "proxima/mesh_report.h"

#include "mesh/random_soups.h"
#include "mesh/surface_parts.h"
#include "proxima/topology.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <map>
#include <set>

namespace proxima::mesh_report_random_test {
namespace {

using Corners = std::set<std::uint32_t>;

Corners ids_of(const TriangleCorners& corners)
{
    return {corners.begin(), corners.end()};
}

// Number of classes that `related` and its transitive closure make of the items.
std::uint64_t count_classes(const std::vector<std::uint32_t>& items,
                            const std::function<bool(std::uint32_t, std::uint32_t)>& related)
{
    std::uint64_t classes = 0;
    std::set<std::uint32_t> seen;
    for (const std::uint32_t start : items) {
        if (!seen.insert(start).second) continue;
        ++classes;
        std::vector<std::uint32_t> queue = {start};
        while (!queue.empty()) {
            const std::uint32_t item = queue.back();
            queue.pop_back();
            for (const std::uint32_t other : items) {
                if (related(item, other) && seen.insert(other).second) queue.push_back(other);
            }
        }
    }
    return classes;
}

struct Counts {
    std::map<FindingKind, std::uint64_t> findings;
    std::uint64_t components = 0;
    std::uint64_t boundary_loops = 0;
    std::int64_t euler_characteristic = 0;
    bool closed = false;
};

// Grid positions are small whole numbers: products of doubles are exact.
Counts slow_counts(const TriangleMesh& mesh)
{
    Counts counts;
    auto& findings = counts.findings;
    const auto triangles = mesh.triangles();
    const auto positions = mesh.positions();
    const auto position_key = [&](std::uint32_t v) {
        return std::array{positions[v].x(), positions[v].y(), positions[v].z()};
    };
    const auto places_of = [&](std::uint32_t t) {
        std::set<std::array<double, 3>> places;
        for (const std::uint32_t corner : triangles[t]) places.insert(position_key(corner));
        return places;
    };

    std::vector<std::uint32_t> proper;
    if (triangles.empty()) ++findings[FindingKind::no_triangles];
    for (std::uint32_t t = 0; t < triangles.size(); ++t) {
        if (ids_of(triangles[t]).size() < 3) {
            ++findings[FindingKind::degenerate_triangles];
            continue;
        }
        const bool flat = scaled_normal(mesh.triangle(TriangleId{t})) == Vec3(0, 0, 0);
        if (flat) ++findings[FindingKind::zero_area_triangles];
        const auto same_ids = [&](std::uint32_t o) {
            return ids_of(triangles[o]) == ids_of(triangles[t]);
        };
        const auto same_places = [&](std::uint32_t o) {
            return places_of(t).size() == 3 && places_of(o) == places_of(t);
        };
        if (std::any_of(proper.begin(), proper.end(), same_ids)) {
            ++findings[FindingKind::duplicate_triangles];
        } else if (std::any_of(proper.begin(), proper.end(), same_places)) {
            ++findings[FindingKind::coincident_triangles];
        }
        proper.push_back(t);
    }
    for (std::uint32_t v = 0; v < positions.size(); ++v) {
        const auto uses = [&](const TriangleCorners& corners) {
            return ids_of(corners).count(v) > 0;
        };
        if (std::none_of(triangles.begin(), triangles.end(), uses)) {
            ++findings[FindingKind::unreferenced_vertices];
        }
        for (std::uint32_t other = 0; other < v; ++other) {
            if (positions[other] != positions[v]) continue;
            ++findings[FindingKind::duplicate_vertices];
            break;
        }
    }

    const auto shared = [&](std::uint32_t s, std::uint32_t t) {
        Corners common;
        for (const std::uint32_t v : ids_of(triangles[s])) {
            if (ids_of(triangles[t]).count(v) > 0) common.insert(v);
        }
        return common;
    };
    counts.components = count_classes(
        proper, [&](std::uint32_t s, std::uint32_t t) { return shared(s, t).size() >= 2; });
    std::int64_t used_vertices = 0;
    for (std::uint32_t v = 0; v < positions.size(); ++v) {
        std::vector<std::uint32_t> star;
        for (const std::uint32_t t : proper) {
            if (ids_of(triangles[t]).count(v) > 0) star.push_back(t);
        }
        used_vertices += star.empty() ? 0 : 1;
        const std::uint64_t fans = count_classes(
            star, [&](std::uint32_t s, std::uint32_t t) { return shared(s, t).size() >= 2; });
        if (fans > 1) ++findings[FindingKind::non_manifold_vertices];
    }

    std::map<Corners, std::pair<int, int>> edges;
    for (const std::uint32_t t : proper) {
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t from = triangles[t][k];
            const std::uint32_t to = triangles[t][(k + 1) % 3];
            auto& [up, down] = edges[{from, to}];
            ++(from < to ? up : down);
        }
    }
    counts.closed = !edges.empty();
    std::vector<Corners> border;
    for (const auto& [ends, uses] : edges) {
        const auto [up, down] = uses;
        if (up + down == 1) border.push_back(ends);
        if (up + down > 2) ++findings[FindingKind::non_manifold_edges];
        const bool even = (up + down) % 2 == 0;
        counts.closed = counts.closed && even;
        if (even && up != down) ++findings[FindingKind::inconsistent_edges];
    }
    if (!border.empty()) findings[FindingKind::boundary_edges] = border.size();
    std::vector<std::uint32_t> numbers;
    for (std::uint32_t b = 0; b < border.size(); ++b) numbers.push_back(b);
    counts.boundary_loops = count_classes(numbers, [&](std::uint32_t a, std::uint32_t b) {
        return std::any_of(border[a].begin(), border[a].end(),
                           [&](std::uint32_t v) { return border[b].count(v) > 0; });
    });
    counts.euler_characteristic = used_vertices - static_cast<std::int64_t>(edges.size()) +
                                  static_cast<std::int64_t>(proper.size());
    return counts;
}

TEST(MeshReportRandom, AgreesWithTheDefinitionsOnSoups)
{
    std::set<FindingKind> met;
    for (std::uint32_t seed = 0; seed < 1500; ++seed) {
        SCOPED_TRACE(seed);
        const TriangleMesh mesh = random_soup(seed);
        const Counts expected = slow_counts(mesh);
        const auto report = report_mesh(mesh, {.max_ids = 1000});
        ASSERT_TRUE(report);
        std::map<FindingKind, std::uint64_t> found;
        for (const MeshFinding& finding : report->findings) {
            if (finding.kind == FindingKind::inward_components) continue;
            found[finding.kind] = finding.count;
            met.insert(finding.kind);
            if (finding.element != ElementKind::mesh) {
                EXPECT_EQ(finding.first_ids.size(), finding.count);
                EXPECT_TRUE(std::is_sorted(finding.first_ids.begin(), finding.first_ids.end()));
            }
        }
        ASSERT_EQ(found, expected.findings);
        EXPECT_EQ(report->components, expected.components);
        EXPECT_EQ(report->boundary_loops, expected.boundary_loops);
        EXPECT_EQ(report->euler_characteristic, expected.euler_characteristic);
        EXPECT_EQ(report->closed, expected.closed);
    }
    EXPECT_EQ(met.size(), 11U); // all but those of odd positions, and inward_components
}

TEST(MeshReportRandom, FindsTheFirstOfRepeatedTriangles)
{
    for (std::uint32_t seed = 0; seed < 300; ++seed) {
        SCOPED_TRACE(seed);
        std::mt19937 random(seed);
        const std::uint32_t vertices = 3 + below(random, 6);
        std::vector<TriangleCorners> triangles(below(random, 200));
        for (TriangleCorners& corners : triangles) {
            for (std::uint32_t& corner : corners) corner = below(random, vertices);
        }
        const TriangleMesh mesh =
            *make_triangle_mesh(std::vector<Vec3>(vertices, Vec3::Zero()), triangles);
        const std::vector<std::uint32_t> first = detail::first_duplicates(mesh);
        ASSERT_EQ(first.size(), triangles.size());
        for (std::uint32_t t = 0; t < triangles.size(); ++t) {
            const Corners own = ids_of(triangles[t]);
            std::uint32_t expected = t;
            for (std::uint32_t other = 0; own.size() == 3 && other < expected; ++other) {
                if (ids_of(triangles[other]) == own) expected = other;
            }
            EXPECT_EQ(first[t], expected);
        }
    }
}

// A search among all triangles at an edge takes a minute.
TEST(MeshReportRandom, TakesManyRepeatedTriangles)
{
    constexpr std::uint32_t copies = 100'000;
    const std::vector<Vec3> positions = {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0),
                                         Vec3(0, 0, 1)};
    std::vector<TriangleCorners> triangles;
    for (const TriangleCorners& corners :
         {TriangleCorners{0, 1, 2}, {0, 1, 3}, {0, 2, 3}, {1, 2, 3}}) {
        triangles.insert(triangles.end(), copies, corners);
    }
    const auto report = report_mesh(*make_triangle_mesh(positions, triangles));
    ASSERT_TRUE(report);
    const MeshFinding* found = report->find(FindingKind::duplicate_triangles);
    ASSERT_NE(found, nullptr);
    EXPECT_EQ(found->count, 4 * (copies - 1));
}

TEST(MeshReportRandom, IsTheSameForAnyNumberOfThreads)
{
    for (std::uint32_t seed = 0; seed < 50; ++seed) {
        const auto one = report_mesh(random_soup(seed), {.execution = {.threads = {1}}});
        const auto three = report_mesh(random_soup(seed), {.execution = {.threads = {3}}});
        ASSERT_EQ(one->findings.size(), three->findings.size());
        for (std::size_t k = 0; k < one->findings.size(); ++k) {
            EXPECT_EQ(one->findings[k].kind, three->findings[k].kind);
            EXPECT_EQ(one->findings[k].count, three->findings[k].count);
            EXPECT_EQ(one->findings[k].first_ids, three->findings[k].first_ids);
        }
        EXPECT_EQ(one->area, three->area);
    }
}

} // namespace
} // namespace proxima::mesh_report_random_test
