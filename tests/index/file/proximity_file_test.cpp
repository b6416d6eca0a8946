// Proximity octrees come back from files as they were; damaged files are refused or harmless.
#include "index/file/proximity_file.h"

#include "base/binary_file.h"
#include "base/text.h"
#include "cancellation.h"
#include "damaged_files.h"
#include "exact_copy.h"
#include "folder_test.h"
#include "index/lists/build_proximity_octree.h"
#include "index/lists/check_proximity_structure.h"
#include "index/test_meshes.h"
#include "proxima/sample_meshes.h"
#include "query/closest/closest_feature.h"

#include <algorithm>
#include <cstring>
#include <fstream>
#include <gtest/gtest.h>
#include <new>
#include <random>

namespace proxima {
namespace {

using testing::NamedMesh;
using testing::proximity_meshes;
using testing::proximity_points;

std::string slurp(const std::filesystem::path& path)
{
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

/// Loads from an exact copy of the bytes, so that a sanitizer sees the first one out of bounds.
Result<ProximityOctree> load_bytes(const std::string& bytes,
                                   Verification verify = Verification::full)
{
    const auto copy = testing::exact_copy(bytes.data(), bytes.size());
    return load_proximity_octree(std::span(copy.get(), bytes.size()), copy, "memory",
                                 {.verify = verify});
}

ProximityOctree built(const TriangleMesh& mesh, std::uint64_t bytes_per_triangle = 600)
{
    auto octree = build_proximity_octree(
        mesh, {.budget_bytes = bytes_per_triangle * mesh.triangle_count() + 4096});
    EXPECT_TRUE(octree) << describe(octree.error());
    return std::move(*octree);
}

template <class T>
bool same_bytes(std::span<const T> a, std::span<const T> b)
{
    return a.size() == b.size() &&
           (a.empty() || std::memcmp(a.data(), b.data(), a.size_bytes()) == 0);
}

void expect_equal(const ProximityOctree& a, const ProximityOctree& b)
{
    EXPECT_EQ(a.frame().center, b.frame().center);
    EXPECT_EQ(a.frame().half, b.frame().half);
    EXPECT_EQ(a.frame().scale, b.frame().scale);
    EXPECT_EQ(a.table_depth(), b.table_depth());
    EXPECT_EQ(a.statistics(), b.statistics());
    EXPECT_EQ(a.mesh_fingerprint(), b.mesh_fingerprint());
    EXPECT_EQ(a.tree().origin(), b.tree().origin());
    EXPECT_EQ(a.tree().scale(), b.tree().scale());
    EXPECT_EQ(a.tree().reach(), b.tree().reach());
    EXPECT_TRUE(same_bytes(a.tree().blocks(), b.tree().blocks()));
    EXPECT_TRUE(same_bytes(a.arrays().table, b.arrays().table));
    EXPECT_TRUE(same_bytes(a.arrays().nodes, b.arrays().nodes));
    EXPECT_TRUE(same_bytes(a.arrays().runs, b.arrays().runs));
    EXPECT_TRUE(same_bytes(a.arrays().arena, b.arrays().arena));
    EXPECT_TRUE(same_bytes(a.arrays().float_rows, b.arrays().float_rows));
    EXPECT_TRUE(same_bytes(a.arrays().double_rows, b.arrays().double_rows));
    EXPECT_TRUE(same_bytes(a.arrays().vertex_places, b.arrays().vertex_places));
    EXPECT_TRUE(same_bytes(a.arrays().edge_places, b.arrays().edge_places));
}

/// Whether two octrees answer with the same bits.
void expect_same_answers(const ProximityOctree& a, const ProximityOctree& b,
                         std::span<const Vec3> points)
{
    for (const Vec3& p : points) {
        const ClosestFeature one = closest_feature(a, p);
        const ClosestFeature two = closest_feature(b, p);
        ASSERT_EQ(one.feature, two.feature) << p.transpose();
        ASSERT_EQ(one.triangle, two.triangle);
        ASSERT_EQ(one.point, two.point);
        ASSERT_EQ(one.barycentric, two.barycentric);
        ASSERT_EQ(one.squared_distance, two.squared_distance);
    }
}

/// Asks in and around the root; all that is named exists, and no query takes longer than promised.
void expect_harmless(const ProximityOctree& octree, unsigned seed)
{
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> unit(-1.0, 1.0);
    std::vector<Vec3> points;
    for (int i = 0; i < 48; ++i) {
        const double reach = octree.frame().half * (i % 8 == 0 ? 10.0 : 1.0);
        points.emplace_back(octree.frame().center +
                            reach * Vec3{unit(random), unit(random), unit(random)});
    }
    const auto expect_exists = [&](const ClosestFeature& found) {
        const std::array<std::size_t, 3> counts = {octree.arrays().vertex_places.size(),
                                                   octree.arrays().edge_places.size(),
                                                   octree.triangle_count()};
        ASSERT_LT(found.feature.id, counts[static_cast<std::size_t>(found.feature.kind)]);
        ASSERT_LT(index(found.triangle), octree.triangle_count());
    };
    for (const Vec3& p : points) {
        QuerySteps steps;
        expect_exists(closest_feature(octree, p, steps));
        ASSERT_LE(steps.steps, octree.statistics().worst_case_steps);
        ASSERT_LE(steps.blocks, octree.statistics().worst_case_blocks);
    }
    std::vector<ClosestFeature> answers(points.size());
    ASSERT_TRUE(closest_features(octree, points, answers));
    for (const ClosestFeature& found : answers) expect_exists(found);
}

class ProximityFile : public FolderTest {
protected:
    std::string saved(const ProximityOctree& octree)
    {
        const Status status = save_proximity_octree(octree, path("octree.pxp"));
        EXPECT_TRUE(status) << describe(status.error());
        return slurp(path("octree.pxp"));
    }
};

TEST_F(ProximityFile, ComesBackAsItWas)
{
    bool has_floats = false;
    bool has_doubles = false;
    bool has_runs = false;
    bool has_table = false;
    for (const NamedMesh& named : proximity_meshes()) {
        SCOPED_TRACE(named.name);
        for (const std::uint64_t bytes_per_triangle : {200ULL, 2000ULL}) {
            const ProximityOctree octree = built(named.mesh, bytes_per_triangle);
            has_floats = has_floats || !octree.arrays().float_rows.empty();
            has_doubles = has_doubles || !octree.arrays().double_rows.empty();
            has_runs = has_runs || !octree.arrays().runs.empty();
            has_table = has_table || octree.table_depth() > 1;
            const Status sound = check_structure(octree);
            ASSERT_TRUE(sound) << describe(sound.error());
            const std::string bytes = saved(octree);
            for (const Verification verify : {Verification::full, Verification::structure}) {
                const auto loaded = load_proximity_octree(path("octree.pxp"), {.verify = verify});
                ASSERT_TRUE(loaded) << describe(loaded.error());
                expect_equal(octree, *loaded);
                expect_same_answers(octree, *loaded, proximity_points(named.mesh, 100, 1));
                ASSERT_TRUE(check_same_mesh(*loaded, named.mesh));
                // Same octree, same bytes: also written over the file that it is mapped from.
                EXPECT_EQ(saved(*loaded), bytes);
                expect_equal(octree, *loaded);
            }
        }
    }
    EXPECT_TRUE(has_floats && has_doubles && has_runs && has_table);
}

TEST_F(ProximityFile, SameMeshSameBytes)
{
    const TriangleMesh mesh = sample_mesh("torus:24x36").value();
    // Doubles that no floats hold: their rows have bytes to fill up.
    const TriangleMesh thirds = testing::moved(mesh, [](const Vec3& p) { return Vec3(p / 3); });
    for (const TriangleMesh* one : {&mesh, &thirds}) {
        const std::string bytes =
            saved(build_proximity_octree(*one, {.execution = {.threads = {1}}}).value());
        EXPECT_EQ(saved(build_proximity_octree(*one, {.execution = {.threads = {3}}}).value()),
                  bytes);
    }
}

TEST_F(ProximityFile, OutlivesItsFile)
{
    const TriangleMesh mesh = sample_mesh("sphere:12x12").value();
    const ProximityOctree octree = built(mesh);
    (void)saved(octree);
    auto loaded = load_proximity_octree(path("octree.pxp"));
    ASSERT_TRUE(loaded);
    const ProximityOctree copy = *loaded;
    loaded = tl::unexpected(Error{});
    std::filesystem::remove(path("octree.pxp"));
    expect_same_answers(octree, copy, proximity_points(mesh, 100, 2));
}

TEST_F(ProximityFile, RefusesEveryTruncationAndExtension)
{
    testing::refuses_every_truncation_and_extension(saved(built(sample_mesh("cube").value())),
                                                    load_bytes);
}

TEST_F(ProximityFile, RefusesEveryFlippedBit)
{
    testing::refuses_every_flipped_bit(saved(built(sample_mesh("cube").value())), load_bytes);
}

TEST_F(ProximityFile, DamageWithRightChecksumsIsHarmless)
{
    // A crafted file has right checksums, so what is accepted must be safe to query.
    constexpr unsigned seed = 5;
    std::mt19937 random(seed);
    const TriangleMesh torus = testing::torus_mesh(1.0, 0.3, 12, 8);
    const std::vector<std::string> files = {
        saved(built(torus, 200)), saved(built(torus, 4000)),
        saved(built(testing::moved(torus, [](const Vec3& p) { return Vec3(p / 3); }), 600)),
        saved(built(testing::grid_mesh(3)))};
    int accepted = 0;
    int refused = 0;
    for (int round = 0; round < 8000; ++round) {
        std::string damaged = files[static_cast<std::size_t>(round) % files.size()];
        for (int change = 0; change < 1 + round % 3; ++change) {
            damaged[random() % damaged.size()] = static_cast<char>(random());
        }
        reseal_binary_file(std::as_writable_bytes(std::span(damaged)));
        const auto loaded = load_bytes(damaged);
        ++(loaded ? accepted : refused);
        if (!loaded) continue;
        SCOPED_TRACE(round);
        expect_harmless(*loaded, static_cast<unsigned>(round));
        if (HasFatalFailure()) return;
    }
    EXPECT_GT(accepted, 100) << "seed " << seed;
    EXPECT_GT(refused, 100) << "seed " << seed;
}

TEST_F(ProximityFile, NamesTheReason)
{
    const ProximityOctree octree = built(sample_mesh("cube").value());
    const std::string bytes = saved(octree);
    const auto expect_refused = [](const std::string& file, ErrorCode code, const char* why) {
        const auto loaded = load_bytes(file);
        ASSERT_FALSE(loaded);
        EXPECT_EQ(loaded.error().code, code);
        EXPECT_NE(loaded.error().message.find(why), std::string::npos) << loaded.error().message;
    };
    expect_refused("ply\nformat ascii 1.0\n", ErrorCode::unsupported_format,
                   "no proximity octree file");
    expect_refused("", ErrorCode::unsupported_format, "no proximity octree file");
    std::string other = bytes;
    other[7] = 'O'; // a surface octree
    expect_refused(other, ErrorCode::unsupported_format, "no proximity octree file");
    other = bytes;
    std::swap(other[8], other[11]);
    std::swap(other[9], other[10]);
    expect_refused(other, ErrorCode::unsupported_format, "other byte order");
    other = bytes;
    other[12] = 2;
    expect_refused(other, ErrorCode::unsupported_format, "version 2");
    expect_refused(bytes.substr(0, 1000), ErrorCode::malformed_file, "cut off");
    other = bytes;
    other.back() = static_cast<char>(other.back() ^ 1);
    expect_refused(other, ErrorCode::malformed_file, "section 10 is wrong");

    EXPECT_EQ(load_proximity_octree(path("missing.pxp")).error().code, ErrorCode::file_not_found);
    EXPECT_EQ(load_proximity_octree(folder()).error().code, ErrorCode::file_not_found);
    EXPECT_EQ(save_proximity_octree(octree, path("missing") / "x.pxp").error().code,
              ErrorCode::file_not_writable);
    EXPECT_EQ(save_proximity_octree(octree, "/dev/full").error().code,
              ErrorCode::file_not_writable);
}

TEST_F(ProximityFile, TellsAnotherMesh)
{
    const TriangleMesh cube = sample_mesh("cube").value();
    const ProximityOctree octree = built(cube);
    ASSERT_TRUE(check_same_mesh(octree, cube));
    const TriangleMesh larger =
        testing::moved(cube, [](const Vec3& p) { return Vec3(p * (1 + 0x1p-50)); });
    const TriangleMesh sphere = sample_mesh("sphere:8x8").value();
    for (const TriangleMesh* other : {&larger, &sphere}) {
        const Status status = check_same_mesh(octree, *other);
        ASSERT_FALSE(status);
        EXPECT_EQ(status.error().code, ErrorCode::invalid_argument);
        EXPECT_NE(status.error().message.find(" 12 triangles"), std::string::npos)
            << status.error().message;
        EXPECT_NE(status.error().message.find(
                      concat(other->triangle_count(), " triangles, ", other->vertex_count())),
                  std::string::npos)
            << status.error().message;
    }
}

TEST_F(ProximityFile, StopsWhenAskedTo)
{
    const ProximityOctree octree = built(sample_mesh("torus:30x40").value());
    (void)saved(octree);
    const auto nothing_kept = [&] { return entries() == 1; };
    ASSERT_TRUE(load_proximity_octree(path("octree.pxp")));
    testing::cancel_at_every_stage(
        [&](Progress& progress) {
            return load_proximity_octree(path("octree.pxp"),
                                         {.execution = {.progress = &progress}});
        },
        nothing_kept);
    testing::cancel_at_every_stage(
        [&](Progress& progress) {
            return save_proximity_octree(octree, path("other.pxp"),
                                         {.execution = {.progress = &progress}});
        },
        nothing_kept);
}

} // namespace
} // namespace proxima
