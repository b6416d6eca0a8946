#include "query/contact/self_intersection.h"

#include "code_of.h"
#include "geometry/triangle_intersection.h"
#include "index/test_meshes.h"
#include "mesh/random_soups.h"
#include "octree/nasty_meshes.h"
#include "octree/small_meshes.h"
#include "proxima/intersect_meshes.h"
#include "proxima/mesh_index.h"
#include "proxima/sample_meshes.h"

#include <algorithm>
#include <array>
#include <gtest/gtest.h>
#include <random>

namespace proxima::self_intersection_test {
namespace {

using namespace testing;

MeshIndex index_of(const TriangleMesh& mesh)
{
    return build_mesh_index(mesh).value();
}

std::vector<TrianglePair> pairs_of(const TriangleMesh& mesh)
{
    return find_self_intersections(index_of(mesh))->pairs;
}

/// All pairs asked.
std::vector<TrianglePair> brute_pairs(const TriangleMesh& mesh)
{
    std::vector<TrianglePair> pairs;
    for (std::uint32_t i = 0; i < mesh.triangle_count(); ++i) {
        for (std::uint32_t j = i + 1; j < mesh.triangle_count(); ++j) {
            if (meet_beyond_corners(mesh.triangle(TriangleId{i}), mesh.triangle(TriangleId{j})))
                pairs.push_back({TriangleId{i}, TriangleId{j}});
        }
    }
    return pairs;
}

TEST(MeetBeyondCorners, IgnoresContactAtSharedCornersAndEdges)
{
    const Vec3 o(0, 0, 0);
    const Vec3 x(4, 0, 0);
    const Vec3 y(0, 4, 0);
    const Vec3 z(0, 0, 4);
    const Triangle floor = {{o, x, y}};
    const auto meet = [&](const Vec3& p, const Vec3& q, const Vec3& r) {
        const bool answer = meet_beyond_corners(floor, {{p, q, r}});
        EXPECT_EQ(meet_beyond_corners({{q, r, p}}, floor), answer);
        return answer;
    };
    // Two corners in common: a wall, a floor beside, a floor over it.
    EXPECT_FALSE(meet(o, x, z));
    EXPECT_FALSE(meet(o, x, Vec3(1, -1, 0)));
    EXPECT_TRUE(meet(o, x, Vec3(1, 1, 0)));
    EXPECT_TRUE(meet(o, x, Vec3(9, 9, 0)));
    // One: beside, through, along a side of the other, and back over it.
    EXPECT_FALSE(meet(o, Vec3(-1, -1, 1), Vec3(-1, -1, -1)));
    EXPECT_TRUE(meet(o, Vec3(1, 1, 1), Vec3(1, 1, -1)));
    EXPECT_TRUE(meet(o, Vec3(2, 0, 0), z));
    EXPECT_TRUE(meet(o, Vec3(1, 1, 0), z));
    EXPECT_TRUE(meet(o, Vec3(1, 1, 0), Vec3(1, 2, 0)));
    EXPECT_FALSE(meet(o, Vec3(-1, -1, 0), Vec3(-1, -2, 0)));
    // Three: duplicates. None: any touch.
    EXPECT_TRUE(meet(y, x, o));
    EXPECT_TRUE(meet(Vec3(1, 0, 0), Vec3(2, 0, 1), Vec3(1, 0, 1)));
    EXPECT_FALSE(meet(Vec3(1, 0, 1), Vec3(2, 0, 1), Vec3(1, 0, 2)));
    // A sliver between neighbours touches them only where they share corners.
    EXPECT_FALSE(meet_beyond_corners({{o, Vec3(2, 0, 0), x}}, floor));
    EXPECT_FALSE(meet_beyond_corners({{o, Vec3(2, 0, 0), x}}, {{o, Vec3(2, 0, 0), z}}));
    EXPECT_TRUE(meet_beyond_corners({{o, Vec3(2, 0, 0), x}}, {{Vec3(3, 0, 0), y, z}}));
    // Two slivers that cross where both have a corner, in the middle of both; and that lie on each other.
    EXPECT_FALSE(meet_beyond_corners({{o, x, -x}}, {{y, o, -y}}));
    EXPECT_TRUE(meet_beyond_corners({{o, x, -x}}, {{-2 * x, o, 2 * x}}));
}

/// What meet_beyond_corners() means, by the exact intersection of the two.
bool meet_beyond_corners_slowly(const Triangle& a, const Triangle& b)
{
    const auto has = [](const Triangle& triangle, const Vec3& point) {
        return std::ranges::find(triangle.vertices, point) != triangle.vertices.end();
    };
    const TriangleIntersection found = intersect(a, b);
    if (found.size() == 1) return false; // the corner in common
    return found.size() > 2 || !std::ranges::all_of(found.ends(), [&](const MeetingParts& parts) {
               return is_corner(parts.of_a)   ? has(b, a[number_of(parts.of_a)])
                      : is_corner(parts.of_b) ? has(a, b[number_of(parts.of_b)])
                                              : false;
           });
}

TEST(MeetBeyondCorners, AgreesWithExactIntersectionsInOnePlane)
{
    constexpr std::uint64_t seed = 8;
    SCOPED_TRACE(::testing::Message() << "seed " << seed);
    std::mt19937_64 random(seed);
    // On small grids in a few planes, corners and sides lie on each other all the time.
    const std::array<std::array<Vec3, 2>, 4> planes = {{{Vec3(1, 0, 0), Vec3(0, 1, 0)},
                                                        {Vec3(0, 0, 1), Vec3(1, 0, 0)},
                                                        {Vec3(0, 1, 0), Vec3(0, 0, -3)},
                                                        {Vec3(1, 0, 1), Vec3(0, 2, -1)}}};
    std::array<std::array<int, 2>, 3> seen = {}; // by corners in common, then by the answer
    for (int i = 0; i < 60'000; ++i) {
        const std::array<Vec3, 2>& plane = planes[static_cast<std::size_t>(i % 4)];
        const auto place = [&] {
            const auto x = static_cast<double>(random() % 5);
            return Vec3(x * plane[0] + static_cast<double>(random() % 5) * plane[1]);
        };
        const Triangle a = {{place(), place(), place()}};
        Triangle b = {{place(), place(), place()}};
        b.vertices[random() % 3] = a[static_cast<int>(random() % 3)];
        if (i % 3 == 0) b.vertices[random() % 3] = a[static_cast<int>(random() % 3)];
        const auto shared = std::ranges::count_if(b.vertices, [&](const Vec3& corner) {
            return std::ranges::find(a.vertices, corner) != a.vertices.end();
        });
        if (shared > 2) continue; // duplicates, and segments
        const bool truth = meet_beyond_corners_slowly(a, b);
        ASSERT_EQ(meet_beyond_corners(a, b), truth) << i;
        ASSERT_EQ(meet_beyond_corners(b, a), truth) << i;
        ++seen[static_cast<std::size_t>(shared)][truth ? 1 : 0];
    }
    for (const std::size_t shared : {1U, 2U})
        EXPECT_GT(std::min(seen[shared][0], seen[shared][1]), 1000);
}

TEST(SelfIntersection, FindsNoneInValidMeshes)
{
    for (const TriangleMesh& mesh : {make_sphere(20, 20), make_torus(30, 12), make_cube(),
                                     torus_mesh(1.0, 0.4, 24, 16), make_octahedron()}) {
        EXPECT_TRUE(pairs_of(mesh).empty());
    }
}

TEST(SelfIntersection, AgreesWithAllPairs)
{
    std::size_t found = 0;
    std::size_t none = 0;
    const auto compare = [&](const TriangleMesh& mesh) {
        const std::vector<TrianglePair> truth = brute_pairs(mesh);
        EXPECT_EQ(pairs_of(mesh), truth);
        found += truth.size();
        none += truth.empty() ? 1U : 0U;
    };
    for (const NamedMesh& named : proximity_meshes()) {
        SCOPED_TRACE(named.name);
        compare(named.mesh);
    }
    for (std::uint32_t seed = 0; seed < 100; ++seed) {
        SCOPED_TRACE(::testing::Message() << "seed " << seed);
        compare(nasty_mesh(seed));
        const TriangleMesh soup = random_soup(seed);
        if (checked_bounding_box(soup)) compare(soup);
        if (HasFailure()) return;
    }
    EXPECT_GT(found, 1000U);
    EXPECT_GT(none, 3U);
}

TEST(SelfIntersection, OfTwoSpheresLiesWhereTheyMeet)
{
    const TriangleMesh sphere = make_sphere(12, 16);
    const TriangleMesh other =
        moved(sphere, [](const Vec3& p) { return Vec3(p + Vec3(0.9, 0.1, 0.2)); });
    const auto pairs = pairs_of(joined(sphere, other));
    EXPECT_GT(pairs.size(), 20U);
    for (const TrianglePair& pair : pairs) {
        EXPECT_LT(to_index(pair.a), sphere.triangle_count());
        EXPECT_GE(to_index(pair.b), sphere.triangle_count());
    }
}

TEST(SelfIntersection, StopsAtItsLimitForAnyNumberOfThreads)
{
    // 1,000 times the same triangle: half a million pairs.
    const TriangleMesh heap = mesh_of({Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)},
                                      std::vector<TriangleCorners>(1000, {0, 1, 2}));
    const MeshIndex index = index_of(heap);
    const auto one =
        find_self_intersections(index, {.max_pairs = 5000, .execution = {.threads = {1}}});
    const auto two =
        find_self_intersections(index, {.max_pairs = 5000, .execution = {.threads = {2}}});
    EXPECT_FALSE(one->complete);
    EXPECT_EQ(one->pairs.size(), 5000U);
    EXPECT_EQ(one->pairs, two->pairs);
    const auto all = find_self_intersections(index, {.max_pairs = 500'000});
    EXPECT_TRUE(all->complete);
    EXPECT_EQ(all->pairs.size(), 1000U * 999 / 2);
    Progress progress;
    progress.cancel();
    EXPECT_EQ(code_of(find_self_intersections(index, {.execution = {.progress = &progress}})),
              ErrorCode::cancelled);
}

/// Rows are asked in rounds of 65,536.
TEST(SelfIntersection, FindsPairsInEveryRoundAndExactlyAsManyAsMayBe)
{
    constexpr std::uint32_t count = 35'000;
    std::vector<Vec3> positions;
    std::vector<TriangleCorners> triangles;
    for (std::uint32_t i = 0; i < count; ++i) {
        const Vec3 at(3.0 * (i % 200), 3.0 * (i / 200), 0);
        positions.insert(positions.end(), {at, at + Vec3::UnitX(), at + Vec3::UnitY()});
        triangles.insert(triangles.end(), 2, {3 * i, 3 * i + 1, 3 * i + 2});
    }
    const MeshIndex index = index_of(mesh_of(positions, triangles));
    const auto all = find_self_intersections(index, {.max_pairs = count});
    EXPECT_TRUE(all->complete);
    ASSERT_EQ(all->pairs.size(), count);
    for (std::uint32_t i = 0; i < count; ++i)
        ASSERT_EQ(all->pairs[i], (TrianglePair{TriangleId{2 * i}, TriangleId{2 * i + 1}}));
    EXPECT_FALSE(find_self_intersections(index, {.max_pairs = count - 1})->complete);
}

} // namespace
} // namespace proxima::self_intersection_test
