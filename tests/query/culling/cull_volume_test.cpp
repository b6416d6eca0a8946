#include "proxima/cull.h"

#include "base/simd.h"
#include "counted_allocations.h"
#include "geometry/test_volumes.h"
#include "geometry/view_contact.h"
#include "index/test_meshes.h"
#include "proxima/mesh_index.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>

namespace proxima::cull_volume_test {
namespace {

using namespace testing;

constexpr std::array modes = {CullMode::conservative, CullMode::exact};

MeshIndex index_of(const TriangleMesh& mesh)
{
    return build_mesh_index(mesh).value();
}

/// Every triangle asked.
std::vector<TriangleId> brute_force(const TriangleMesh& mesh, const ViewVolume& volume,
                                    CullMode mode)
{
    std::vector<TriangleId> ids;
    for (std::uint32_t i = 0; i < mesh.triangle_count(); ++i) {
        const Triangle triangle = mesh.triangle(TriangleId{i});
        if (mode == CullMode::exact ? meets_volume(volume, triangle)
                                    : passes_planes(volume, triangle))
            ids.push_back(TriangleId{i});
    }
    return ids;
}

/// How many triangles were seen, partly seen, or not, over all volumes.
struct Seen {
    std::size_t nothing = 0;
    std::size_t something = 0;
    std::size_t all = 0;
    std::size_t conservative_only = 0; ///< triangles

    void add(std::size_t visible, std::size_t triangles)
    {
        ++(visible == 0 ? nothing : visible == triangles ? all : something);
    }
};

void expect_truth(const TriangleMesh& mesh, const MeshIndex& index, const ViewVolume& volume,
                  Seen& seen)
{
    std::size_t conservative = 0;
    for (const CullMode mode : modes) {
        SCOPED_TRACE(mode == CullMode::exact ? "exact" : "conservative");
        const std::vector<TriangleId> truth = brute_force(mesh, volume, mode);
        ASSERT_EQ(visible_triangles(index, volume, mode), truth);
        std::vector<TriangleRange> ranges(mesh.triangle_count() / 2 + 1);
        const std::size_t before = allocation_count();
        const std::size_t count = visible_ranges(index, volume, ranges, mode);
        ASSERT_EQ(allocation_count(), before);
        ASSERT_LE(count, ranges.size());
        ranges.resize(count);
        std::vector<TriangleId> ids;
        std::uint32_t end = 0;
        for (const TriangleRange& range : ranges) {
            ASSERT_GT(range.count, 0U);
            // As long as can be: there is a gap before each but the first.
            ASSERT_TRUE(range.first > end || (range.first == 0 && ids.empty()));
            end = range.first + range.count;
            for (std::uint32_t row = range.first; row < end; ++row) ids.push_back(index.ids()[row]);
        }
        ASSERT_LE(end, mesh.triangle_count());
        std::ranges::sort(ids);
        ASSERT_EQ(ids, truth);
        seen.add(truth.size(), mesh.triangle_count());
        if (mode == CullMode::exact) {
            ASSERT_LE(truth.size(), conservative);
            seen.conservative_only += conservative - truth.size();
        }
        conservative = truth.size();
    }
}

TEST(CullVolume, AgreesWithBruteForce)
{
    Seen seen;
    std::uint64_t seed = 1;
    for (const NamedMesh& named : proximity_meshes()) {
        const MeshIndex index = index_of(named.mesh);
        VolumeGenerator generate(named.mesh.positions(), seed++);
        for (int i = 0; i < 60; ++i) {
            SCOPED_TRACE(::testing::Message()
                         << named.name << ", seed " << seed - 1 << ", volume " << i);
            expect_truth(named.mesh, index, generate(), seen);
            if (HasFatalFailure()) return;
        }
    }
    EXPECT_GT(seen.nothing, 300U);
    EXPECT_GT(seen.something, 1000U);
    EXPECT_GT(seen.all, 300U);
    EXPECT_GT(seen.conservative_only, 100U);
}

TEST(CullVolume, AgreesWithBruteForceOnALargeMesh)
{
    const TriangleMesh mesh = torus_mesh(1.0, 0.4, 300, 200); // more triangles than 16 bits count
    const MeshIndex index = index_of(mesh);
    VolumeGenerator generate(mesh.positions(), 31);
    Seen seen;
    for (int i = 0; i < 10; ++i) {
        SCOPED_TRACE(i);
        expect_truth(mesh, index, generate(), seen);
        if (HasFatalFailure()) return;
    }
    EXPECT_GT(seen.something, 3U);
}

TEST(CullVolume, AgreesWithBruteForceOnNastyMeshes)
{
    Seen seen;
    for (std::uint32_t seed = 0; seed < 400; ++seed) {
        for (const TriangleMesh& mesh : {nasty_mesh(seed), grid_mesh(seed)}) {
            const MeshIndex index = index_of(mesh);
            VolumeGenerator generate(mesh.positions(), seed);
            for (int i = 0; i < 12; ++i) {
                SCOPED_TRACE(::testing::Message() << "seed " << seed << ", volume " << i);
                expect_truth(mesh, index, generate(), seen);
                if (HasFatalFailure()) return;
            }
        }
    }
    EXPECT_GT(seen.something, 3000U);
    EXPECT_GT(seen.conservative_only, 300U);
}

TEST(CullVolume, IsTheSameOnEveryInstructionSet)
{
    const TriangleMesh mesh = torus_mesh(1.0, 0.4, 60, 40);
    const MeshIndex index = index_of(mesh);
    for (const SimdTarget& target : simd_targets()) {
        SCOPED_TRACE(target.name);
        force_simd_target(target);
        VolumeGenerator generate(mesh.positions(), 21);
        Seen seen;
        for (int i = 0; i < 40; ++i) expect_truth(mesh, index, generate(), seen);
        EXPECT_GT(seen.something, 20U);
        restore_simd_targets();
    }
}

TEST(CullVolume, DoesNotDependOnScaleOrPosition)
{
    const TriangleMesh torus = torus_mesh(1.0, 0.4, 60, 40);
    for (const double scale : {1e-6, 1.0, 1e6, 1e-90, 1e90}) {
        for (const double far : {0.0, 1e4}) {
            SCOPED_TRACE(::testing::Message() << "scale " << scale << ", " << far << " away");
            const TriangleMesh mesh = moved(
                torus, [&](const Vec3& p) { return Vec3(scale * (p + Vec3::Constant(far))); });
            const MeshIndex index = index_of(mesh);
            VolumeGenerator generate(mesh.positions(), 22);
            Seen seen;
            for (int i = 0; i < 20; ++i) expect_truth(mesh, index, generate(), seen);
            EXPECT_GT(seen.something, 5U);
        }
    }
}

TEST(CullVolume, CountsTouching)
{
    const TriangleMesh cube = cube_mesh(Vec3::Zero(), 1.0);
    const MeshIndex index = index_of(cube);
    const Box box = bounding_box(cube);
    const auto count = [&](const std::vector<ViewPlane>& planes, CullMode mode) {
        return visible_triangles(index, make_view_volume(planes).value(), mode).size();
    };
    for (const CullMode mode : modes) {
        // A face from outside: its two triangles, and those that have a side or corner in it.
        const double x = box.upper.x();
        EXPECT_EQ(count({{Vec3::UnitX(), -x}}, mode), 10U);
        EXPECT_EQ(count({{Vec3::UnitX(), -std::nextafter(x, 9.0)}}, mode), 0U);
        // A corner.
        EXPECT_GT(count({{Vec3(1, 1, 1), -box.upper.sum()}}, mode), 2U);
        // Nothing, by planes that contradict each other.
        EXPECT_EQ(count({{Vec3::UnitX(), 0}, {-Vec3::UnitX(), -1e-9}}, mode), 0U);
        EXPECT_EQ(count({{Vec3::UnitX(), 0}, {-Vec3::UnitX(), 0}}, mode), 8U);
    }
}

/// Eight triangles lie across the way in front of a thin wedge's tip: each has corners inside of either plane of the wedge,
/// none a point inside of both. The wedge's planes come after more and more planes that the eight are inside of.
TEST(CullVolume, IsExactWithAnyNumberOfPlanes)
{
    std::vector<Vec3> positions;
    std::vector<TriangleCorners> triangles;
    for (int i = 0; i < 8; ++i) {
        const double x = 0.8 + 1e-3 * i;
        positions.insert(positions.end(), {Vec3(x, 1, 0), Vec3(x, -1, 0), Vec3(x, 0, 0.01)});
    }
    for (int i = 0; i < 120; ++i) {
        const double y = 0.1 * i - 6;
        positions.insert(positions.end(), {Vec3(8, y, 0), Vec3(8.1, y, 0), Vec3(8, y, 0.1)});
    }
    for (std::uint32_t i = 0; i < positions.size(); i += 3) triangles.push_back({i, i + 1, i + 2});
    const TriangleMesh mesh = mesh_of(positions, triangles);
    const MeshIndex index = index_of(mesh);
    for (std::uint32_t before = 0; before <= 100; ++before) {
        std::vector<ViewPlane> planes;
        for (std::uint32_t i = 0; i < before; ++i) planes.push_back({-Vec3::UnitX(), 5 + 1e-3 * i});
        planes.push_back({Vec3(0.2, -1, 0), 0.03 - 0.2});
        planes.push_back({Vec3(0.2, 1, 0), -0.03 - 0.2});
        const ViewVolume volume = make_view_volume(planes).value();
        for (const CullMode mode : modes) {
            EXPECT_EQ(visible_triangles(index, volume, mode), brute_force(mesh, volume, mode))
                << before;
        }
    }
}

TEST(CullVolume, FillsASmallBufferAndReturnsTheWholeCount)
{
    const TriangleMesh mesh = torus_mesh(1.0, 0.4, 60, 40);
    const MeshIndex index = index_of(mesh);
    const ViewVolume volume =
        make_view_volume(std::vector<ViewPlane>{{Vec3(1, 2, 3), 0.1}}).value();
    std::vector<TriangleRange> all(mesh.triangle_count());
    const std::size_t count = visible_ranges(index, volume, all);
    ASSERT_GT(count, 10U);
    std::vector<TriangleRange> some(7);
    EXPECT_EQ(visible_ranges(index, volume, some), count);
    EXPECT_TRUE(std::ranges::equal(some, std::span(all).first(7)));
    EXPECT_EQ(visible_ranges(index, volume, {}), count);
    EXPECT_EQ(visible_ranges(MeshIndex(), volume, all), 0U);
}

TEST(CullVolume, StopsWhereTheVisitorSaysSo)
{
    const MeshIndex index = index_of(torus_mesh(1.0, 0.4, 60, 40));
    const ViewVolume volume =
        make_view_volume(std::vector<ViewPlane>{{Vec3(1, 2, 3), 0.1}}).value();
    std::vector<TriangleRange> all(index.triangle_count());
    all.resize(visible_ranges(index, volume, all));
    for (std::size_t most = 1; most <= all.size(); ++most) {
        std::vector<TriangleRange> seen;
        visit_visible(index, volume, CullMode::conservative, [&](TriangleRange range) {
            seen.push_back(range);
            return seen.size() < most ? Flow::proceed : Flow::stop;
        });
        EXPECT_TRUE(std::ranges::equal(seen, std::span(all).first(most)));
    }
}

} // namespace
} // namespace proxima::cull_volume_test
