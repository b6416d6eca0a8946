#include "octree/hole_caps.h"

#include "octree/small_meshes.h"
#include "proxima/sample_meshes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <map>
#include <random>

namespace proxima::hole_caps_test {
namespace {

using namespace testing;

/// How many more triangles run along edges one way than the other, by comparing positions.
std::int64_t slow_excess(const TriangleMesh& mesh)
{
    using Position = std::array<double, 3>;
    std::map<std::pair<Position, Position>, std::int64_t> excess;
    for (std::uint32_t i = 0; i < mesh.triangle_count(); ++i) {
        const Triangle triangle = mesh.triangle(TriangleId{i});
        for (int k = 0; k < 3; ++k) {
            const Vec3& a = triangle[k];
            const Vec3& b = triangle[(k + 1) % 3];
            const Position from = {a[0], a[1], a[2]};
            const Position to = {b[0], b[1], b[2]};
            if (from < to) ++excess[{from, to}];
            if (to < from) --excess[{to, from}];
        }
    }
    std::int64_t sum = 0;
    for (const auto& [edge, count] : excess) sum += std::abs(count);
    return sum;
}

TriangleMesh shuffled(const TriangleMesh& mesh, std::mt19937& random)
{
    std::vector<TriangleCorners> triangles(mesh.triangles().begin(), mesh.triangles().end());
    std::ranges::shuffle(triangles, random);
    return mesh_of({mesh.positions().begin(), mesh.positions().end()}, triangles);
}

TriangleMesh without_shared_vertices(const TriangleMesh& mesh)
{
    std::vector<Vec3> positions;
    std::vector<TriangleCorners> triangles;
    for (std::uint32_t i = 0; i < mesh.triangle_count(); ++i) {
        for (const Vec3& p : mesh.triangle(TriangleId{i}).vertices) positions.push_back(p);
        triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
    }
    return mesh_of(positions, triangles);
}

/// Many more edges than can wait for their opposites at once.
const TriangleMesh& large_sphere()
{
    static const TriangleMesh mesh = make_sphere(160, 160);
    return mesh;
}

TEST(HoleCaps, AreNoneOnAClosedMeshInAnyOrder)
{
    std::mt19937 random(5);
    const TriangleMesh mixed = shuffled(large_sphere(), random);
    EXPECT_EQ(hole_caps(large_sphere(), nullptr).value().triangle_count(), 0U);
    EXPECT_EQ(hole_caps(mixed, nullptr).value().triangle_count(), 0U);
    EXPECT_EQ(hole_caps(without_shared_vertices(mixed), nullptr).value().triangle_count(), 0U);
}

TEST(HoleCaps, HaveATriangleForEveryUnbalancedEdgeInAnyOrder)
{
    std::mt19937 random(6);
    std::vector<TriangleCorners> triangles;
    for (TriangleCorners corners : large_sphere().triangles()) {
        const auto change = random() % 300;
        if (change == 0) continue;                          // a hole
        if (change == 1) std::swap(corners[0], corners[1]); // the other way round
        triangles.insert(triangles.end(), change == 2 ? 3 : 1, corners);
    }
    const TriangleMesh bad =
        mesh_of({large_sphere().positions().begin(), large_sphere().positions().end()}, triangles);
    const TriangleMesh caps = hole_caps(bad, nullptr).value();
    EXPECT_GT(caps.triangle_count(), 1000U);
    EXPECT_EQ(static_cast<std::int64_t>(caps.triangle_count()), slow_excess(bad));
    EXPECT_EQ(slow_excess(joined(bad, caps)), 0);
    const TriangleMesh mixed = shuffled(bad, random);
    const TriangleMesh caps_of_mixed = hole_caps(mixed, nullptr).value();
    EXPECT_TRUE(std::ranges::equal(caps.positions(), caps_of_mixed.positions()));
    EXPECT_TRUE(std::ranges::equal(caps.triangles(), caps_of_mixed.triangles()));
    const TriangleMesh soup = without_shared_vertices(mixed);
    const TriangleMesh caps_of_soup = hole_caps(soup, nullptr).value();
    EXPECT_EQ(caps_of_soup.triangle_count(), caps.triangle_count());
    EXPECT_EQ(slow_excess(joined(soup, caps_of_soup)), 0);
}

} // namespace
} // namespace proxima::hole_caps_test
