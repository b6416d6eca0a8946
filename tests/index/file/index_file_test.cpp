// Mesh indexes come back from files as they were; damaged files are refused or harmless.
#include "proxima/index_io.h"

#include "base/binary_file.h"
#include "base/simd.h"
#include "base/text.h"
#include "cancellation.h"
#include "code_of.h"
#include "damaged_files.h"
#include "exact_copy.h"
#include "folder_test.h"
#include "index/check_structure.h"
#include "index/index_parts.h"
#include "index/listed_index.h"
#include "index/lists/proximity_lists.h"
#include "index/signs/sign_parts.h"
#include "index/slabs/block_slab.h"
#include "index/test_meshes.h"
#include "proxima/closest_feature.h"
#include "proxima/mesh_index.h"
#include "proxima/sample_meshes.h"
#include "proxima/signed_distance.h"
#include "query/ask_every_query.h"
#include "query/closest/find_closest.h"

#include <algorithm>
#include <cstring>
#include <fstream>
#include <gtest/gtest.h>
#include <random>

namespace proxima::index_file_test {
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
Result<MeshIndex> load_bytes(const std::string& bytes, Verification verify = Verification::full)
{
    const auto copy = testing::exact_copy(bytes.data(), bytes.size());
    return load_index(std::span(copy.get(), bytes.size()), copy, "memory", {.verify = verify});
}

/// With slabs, signs and lists of so many bytes; without all for none.
MeshIndex built(const TriangleMesh& mesh, std::uint64_t bytes_per_triangle = 520)
{
    const MeshIndex plain = build_mesh_index(mesh).value();
    if (bytes_per_triangle == 0) return plain;
    const ListOptions options{.list_bytes = bytes_per_triangle * mesh.triangle_count() + 4096};
    return with_signs(with_lists(with_slabs(plain).value(), options).value()).value();
}

template <class T>
bool same_bytes(std::span<const T> a, std::span<const T> b)
{
    return a.size() == b.size() &&
           (a.empty() || std::memcmp(a.data(), b.data(), a.size_bytes()) == 0);
}

void expect_equal(const ProximityLists* a, const ProximityLists* b)
{
    ASSERT_EQ(a == nullptr, b == nullptr);
    if (a == nullptr) return;
    EXPECT_EQ(a->frame().center, b->frame().center);
    EXPECT_EQ(a->frame().half, b->frame().half);
    EXPECT_EQ(a->frame().scale, b->frame().scale);
    EXPECT_EQ(a->table_depth(), b->table_depth());
    EXPECT_EQ(a->statistics(), b->statistics());
    EXPECT_TRUE(same_bytes(a->arrays().table, b->arrays().table));
    EXPECT_TRUE(same_bytes(a->arrays().nodes, b->arrays().nodes));
    EXPECT_TRUE(same_bytes(a->arrays().runs, b->arrays().runs));
    EXPECT_TRUE(same_bytes(a->arrays().arena, b->arrays().arena));
}

void expect_equal(const SignParts* a, const SignParts* b)
{
    ASSERT_EQ(a == nullptr, b == nullptr);
    if (a == nullptr) return;
    EXPECT_EQ(a->is_local(), b->is_local());
    const SignArrays& one = a->arrays();
    const SignArrays& two = b->arrays();
    EXPECT_EQ(one.bounds.lower, two.bounds.lower);
    EXPECT_EQ(one.bounds.upper, two.bounds.upper);
    EXPECT_EQ(one.least_height, two.least_height);
    EXPECT_EQ(one.winding.unit, two.winding.unit);
    EXPECT_TRUE(same_bytes(one.rows, two.rows));
    EXPECT_TRUE(same_bytes(one.sides, two.sides));
    EXPECT_TRUE(same_bytes(one.vertex_sides, two.vertex_sides));
    EXPECT_TRUE(same_bytes(one.vertices, two.vertices));
    EXPECT_TRUE(same_bytes(one.edges, two.edges));
    EXPECT_TRUE(same_bytes(one.edge_lists, two.edge_lists));
    EXPECT_TRUE(same_bytes(one.winding.clusters, two.winding.clusters));
    EXPECT_TRUE(same_bytes(one.winding.order, two.winding.order));
}

void expect_equal(const MeshIndex& a, const MeshIndex& b)
{
    EXPECT_EQ(a.parts().center(), b.parts().center());
    EXPECT_EQ(a.parts().scale(), b.parts().scale());
    EXPECT_EQ(a.parts().root(), b.parts().root());
    EXPECT_EQ(a.parts().has_exact_leaves(), b.parts().has_exact_leaves());
    EXPECT_EQ(a.mesh_fingerprint(), b.mesh_fingerprint());
    EXPECT_TRUE(same_bytes(a.parts().blocks(), b.parts().blocks()));
    EXPECT_TRUE(same_bytes(a.parts().float_rows(), b.parts().float_rows()));
    EXPECT_TRUE(same_bytes(a.parts().double_rows(), b.parts().double_rows()));
    EXPECT_TRUE(same_bytes(a.ids(), b.ids()));
    EXPECT_TRUE(same_bytes(a.parts().vertex_incidences(), b.parts().vertex_incidences()));
    EXPECT_TRUE(same_bytes(a.parts().edge_incidences(), b.parts().edge_incidences()));
    EXPECT_TRUE(same_bytes(a.parts().slabs(), b.parts().slabs()));
    expect_equal(a.parts().lists(), b.parts().lists());
    expect_equal(a.parts().signs(), b.parts().signs());
}

/// Whether two indexes answer with the same bits.
void expect_same_answers(const MeshIndex& a, const MeshIndex& b, std::span<const Vec3> points)
{
    for (const Vec3& p : points) {
        const ClosestFeature one = closest_feature(a, p).value();
        const ClosestFeature two = closest_feature(b, p).value();
        ASSERT_EQ(one.feature, two.feature) << p.transpose();
        ASSERT_EQ(one.triangle, two.triangle);
        ASSERT_EQ(one.point, two.point);
        ASSERT_EQ(one.barycentric, two.barycentric);
        ASSERT_EQ(one.squared_distance, two.squared_distance);
        if (!a.has_signs()) continue;
        const SignedDistance sign_one = signed_distance(a, p).value();
        const SignedDistance sign_two = signed_distance(b, p).value();
        ASSERT_EQ(sign_one.distance, sign_two.distance) << p.transpose();
        ASSERT_EQ(sign_one.method, sign_two.method) << p.transpose();
    }
}

/// Asks in and around the root; all that is named exists, and no query takes longer than promised.
void expect_harmless(const MeshIndex& index, unsigned seed)
{
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> unit(-1.0, 1.0);
    std::vector<Vec3> points;
    for (int i = 0; i < 48; ++i) {
        const double reach = index.parts().unscale() * (i % 8 == 0 ? 10.0 : 1.0);
        points.emplace_back(index.parts().center() +
                            reach * Vec3{unit(random), unit(random), unit(random)});
    }
    const auto expect_exists = [&](const ClosestFeature& found) {
        const std::array<std::size_t, 3> counts = {index.vertex_count(), index.edge_count(),
                                                   index.triangle_count()};
        ASSERT_LT(found.feature.id, counts[static_cast<std::size_t>(found.feature.kind)]);
        ASSERT_LT(to_index(found.triangle), index.triangle_count());
    };
    for (const Vec3& p : points) {
        QuerySteps steps;
        const auto found = closest_feature(index, p, {}, steps);
        ASSERT_TRUE(found) << p.transpose();
        expect_exists(*found);
        ASSERT_EQ(signed_distance(index, p).has_value(), index.has_signs());
        if (!index.has_lists()) continue;
        ASSERT_LE(steps.steps, index.parts().lists()->statistics().worst_case_steps);
        ASSERT_LE(steps.blocks, index.parts().lists()->statistics().worst_case_blocks);
    }
    if (seed % 8 == 0) testing::EveryQuery(index, seed).ask(); // the fuzzer load_index asks all
}

class IndexFile : public FolderTest {
protected:
    std::string saved(const MeshIndex& index)
    {
        const Status status = save_index(index, path("index.pxi"));
        EXPECT_TRUE(status) << describe(status.error());
        return slurp(path("index.pxi"));
    }
};

TEST_F(IndexFile, SurvivesSavingAndLoading)
{
    bool has_floats = false;
    bool has_doubles = false;
    bool has_runs = false;
    bool has_table = false;
    for (const NamedMesh& named : proximity_meshes()) {
        SCOPED_TRACE(named.name);
        for (const std::uint64_t bytes_per_triangle : {0ULL, 130ULL, 1930ULL}) {
            const MeshIndex index = built(named.mesh, bytes_per_triangle);
            has_floats = has_floats || !index.parts().float_rows().empty();
            has_doubles = has_doubles || !index.parts().double_rows().empty();
            if (index.has_lists()) {
                has_runs = has_runs || !index.parts().lists()->arrays().runs.empty();
                has_table = has_table || index.parts().lists()->table_depth() > 1;
            }
            const Status sound = check_structure(index);
            ASSERT_TRUE(sound) << describe(sound.error());
            const std::string bytes = saved(index);
            for (const Verification verify : {Verification::full, Verification::structure}) {
                const auto loaded = load_index(path("index.pxi"), {.verify = verify});
                ASSERT_TRUE(loaded) << describe(loaded.error());
                expect_equal(index, *loaded);
                expect_same_answers(index, *loaded, proximity_points(named.mesh, 100, 1));
                ASSERT_TRUE(check_same_mesh(*loaded, named.mesh));
                // Same index, same bytes: also written over the file that it is mapped from.
                EXPECT_EQ(saved(*loaded), bytes);
                expect_equal(index, *loaded);
            }
        }
    }
    EXPECT_TRUE(has_floats && has_doubles && has_runs && has_table);
}

TEST_F(IndexFile, SurvivesSavingAndLoadingOfListsThatAllLeavesLack)
{
    const TriangleMesh ball = sample_mesh("icosphere:4").value();
    for (const std::uint64_t bytes : {1024U, 16000U}) {
        const MeshIndex index = testing::listed_index(ball, {.list_bytes = bytes}).value();
        ASSERT_EQ(index.parts().lists()->statistics().blocks, 0U);
        (void)saved(index);
        const auto loaded = load_index(path("index.pxi"));
        ASSERT_TRUE(loaded) << describe(loaded.error());
        expect_equal(index, *loaded);
    }
}

TEST_F(IndexFile, SurvivesSavingAndLoadingOfMeshesAsFarAsNumbersReach)
{
    const auto tetrahedron = [](double reach) {
        return testing::mesh_of(
            {Vec3(-reach, 0, 0), Vec3(reach, 0, 0), Vec3(0, reach, 0), Vec3(0, 0, reach)},
            {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}});
    };
    for (const double reach : {1e301, 5e302, 1.7e308}) {
        SCOPED_TRACE(reach);
        // One leaf, and many.
        for (const TriangleMesh& mesh :
             {tetrahedron(reach), testing::sphere_mesh(Vec3::Zero(), reach, 12, 16)}) {
            const MeshIndex index = build_mesh_index(mesh).value();
            (void)saved(index);
            const auto loaded = load_index(path("index.pxi"));
            ASSERT_TRUE(loaded) << describe(loaded.error());
            expect_equal(index, *loaded);
        }
    }
}

TEST_F(IndexFile, SurvivesSavingAndLoadingOfAPointFarAwayWithLists)
{
    for (const double reach : {1.0, 1e154, 1e200, 1e308}) {
        SCOPED_TRACE(reach);
        const Vec3 point(reach, -reach / 2, 0);
        const MeshIndex index =
            testing::listed_index(testing::mesh_of({point}, {{0, 0, 0}})).value();
        (void)saved(index);
        const auto loaded = load_index(path("index.pxi"));
        ASSERT_TRUE(loaded) << describe(loaded.error());
        expect_equal(index, *loaded);
        expect_same_answers(index, *loaded, std::array{point});
    }
}

TEST_F(IndexFile, IsNotWrittenOfNoMesh)
{
    const Status status = save_index(MeshIndex{}, path("index.pxi"));
    ASSERT_FALSE(status);
    EXPECT_EQ(code_of(status), ErrorCode::invalid_argument);
    EXPECT_EQ(entries(), 0U);
}

TEST_F(IndexFile, RefusesBytesThatAreNotAligned)
{
    const std::string bytes = saved(built(sample_mesh("cube").value()));
    alignas(section_alignment) static std::array<std::byte, std::size_t{1} << 18U> memory;
    ASSERT_LE(bytes.size() + section_alignment, memory.size());
    for (const std::size_t offset : {0U, 1U, 8U, 64U, 128U}) {
        const auto content = std::span(memory).subspan(offset, bytes.size());
        std::ranges::copy(std::as_bytes(std::span(bytes)), content.begin());
        const auto loaded = load_index(content, nullptr, "memory");
        ASSERT_EQ(loaded.has_value(), offset % section_alignment == 0) << offset;
        if (loaded) continue;
        EXPECT_EQ(code_of(loaded), ErrorCode::invalid_argument);
        EXPECT_NE(loaded.error().message.find("128"), std::string::npos) << loaded.error().message;
    }
}

TEST_F(IndexFile, HasTheSameBytesForTheSameMesh)
{
    const TriangleMesh mesh = sample_mesh("torus:24x36").value();
    // Doubles that no floats hold: their rows have bytes to fill up.
    const TriangleMesh thirds = testing::moved(mesh, [](const Vec3& p) { return Vec3(p / 3); });
    for (const TriangleMesh* one : {&mesh, &thirds}) {
        const std::string bytes =
            saved(testing::listed_index(*one, {.execution = {.threads = {1}}}).value());
        EXPECT_EQ(saved(testing::listed_index(*one, {.execution = {.threads = {3}}}).value()),
                  bytes);
    }
}

TEST_F(IndexFile, OutlivesItsFile)
{
    const TriangleMesh mesh = sample_mesh("sphere:12x12").value();
    const MeshIndex index = built(mesh);
    (void)saved(index);
    auto loaded = load_index(path("index.pxi"), {.access = FileAccess::map});
    ASSERT_TRUE(loaded);
    const MeshIndex copy = *loaded;
    loaded = tl::unexpected(Error{});
    std::filesystem::remove(path("index.pxi"));
    expect_same_answers(index, copy, proximity_points(mesh, 100, 2));
}

TEST_F(IndexFile, MayChangeOnceItIsRead)
{
    const TriangleMesh mesh = sample_mesh("sphere:12x12").value();
    const MeshIndex index = built(mesh);
    const auto bytes = saved(index);
    const auto loaded = load_index(path("index.pxi"));
    ASSERT_TRUE(loaded) << describe(loaded.error());
    std::filesystem::resize_file(path("index.pxi"), bytes.size() / 2);
    expect_same_answers(index, *loaded, proximity_points(mesh, 100, 2));
    const auto damaged = load_index(path("index.pxi"));
    ASSERT_FALSE(damaged);
    EXPECT_EQ(code_of(damaged), ErrorCode::malformed_file);
    EXPECT_NE(describe(damaged.error()).find("index.pxi"), std::string::npos);
    const auto missing = load_index(path("missing.pxi"));
    ASSERT_FALSE(missing);
    EXPECT_EQ(code_of(missing), ErrorCode::file_not_found);
}

TEST_F(IndexFile, IsReadWithinTheBudgetOrMapped)
{
    const TriangleMesh mesh = sample_mesh("sphere:12x12").value();
    const MeshIndex index = built(mesh);
    const auto bytes = saved(index);
    const auto large = load_index(path("index.pxi"), {.execution = {.budget = {bytes.size() - 1}}});
    ASSERT_FALSE(large);
    EXPECT_EQ(code_of(large), ErrorCode::budget_exceeded);
    EXPECT_TRUE(load_index(path("index.pxi"), {.execution = {.budget = {bytes.size()}}}));
    const auto mapped =
        load_index(path("index.pxi"), {.access = FileAccess::map, .execution = {.budget = {1}}});
    ASSERT_TRUE(mapped) << describe(mapped.error());
    expect_same_answers(index, *mapped, proximity_points(mesh, 100, 2));
}

TEST_F(IndexFile, RefusesEveryTruncationAndExtension)
{
    testing::refuses_every_truncation_and_extension(saved(built(sample_mesh("cube").value())),
                                                    load_bytes);
}

TEST_F(IndexFile, RefusesEveryFlippedBit)
{
    testing::refuses_every_flipped_bit(saved(built(sample_mesh("cube").value())), load_bytes);
}

TEST_F(IndexFile, DamageWithRightChecksumsIsHarmless)
{
    // A crafted file has right checksums, so what is accepted must be safe to query.
    constexpr unsigned seed = 5;
    std::mt19937 random(seed);
    const TriangleMesh torus = testing::torus_mesh(1.0, 0.3, 12, 8);
    const std::vector<std::string> files = {
        saved(built(torus, 0)), saved(built(torus, 130)), saved(built(torus, 4000)),
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
        // Lanes without a triangle hold other numbers on each.
        for (const SimdTarget& target : simd_targets()) {
            SCOPED_TRACE(::testing::Message() << "round " << round << " " << target.name);
            force_simd_target(target);
            expect_harmless(*loaded, static_cast<unsigned>(round));
            if (HasFatalFailure()) break;
        }
        restore_simd_targets();
        if (HasFatalFailure()) return;
    }
    EXPECT_GT(accepted, 100) << "seed " << seed;
    EXPECT_GT(refused, 100) << "seed " << seed;
}

TEST_F(IndexFile, ReportsWhyAFileIsRefused)
{
    const MeshIndex index = built(sample_mesh("cube").value());
    const std::string bytes = saved(index);
    const auto expect_refused = [](const std::string& file, ErrorCode code, const char* why) {
        const auto loaded = load_bytes(file);
        ASSERT_FALSE(loaded);
        EXPECT_EQ(code_of(loaded), code);
        EXPECT_NE(loaded.error().message.find(why), std::string::npos) << loaded.error().message;
    };
    expect_refused("ply\nformat ascii 1.0\n", ErrorCode::unsupported_format, "no mesh index file");
    expect_refused("", ErrorCode::unsupported_format, "no mesh index file");
    std::string other = bytes;
    other[7] = 'O'; // an index
    expect_refused(other, ErrorCode::unsupported_format, "no mesh index file");
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
    expect_refused(other, ErrorCode::malformed_file, "section 22 is wrong");

    EXPECT_EQ(code_of(load_index(path("missing.pxi"))), ErrorCode::file_not_found);
    EXPECT_EQ(code_of(load_index(folder())), ErrorCode::file_not_found);
    EXPECT_EQ(code_of(save_index(index, path("missing") / "x.pxi")), ErrorCode::file_not_writable);
    EXPECT_EQ(code_of(save_index(index, "/dev/full")), ErrorCode::file_not_writable);
}

TEST_F(IndexFile, StopsOnRequest)
{
    const MeshIndex index = built(sample_mesh("torus:30x40").value());
    (void)saved(index);
    const auto nothing_kept = [&] { return entries() == 1; };
    ASSERT_TRUE(load_index(path("index.pxi")));
    testing::cancel_at_every_stage(
        [&](Progress& progress) {
            return load_index(path("index.pxi"), {.execution = {.progress = &progress}});
        },
        nothing_kept);
    testing::cancel_at_every_stage(
        [&](Progress& progress) {
            return save_index(index, path("other.pxi"), {.execution = {.progress = &progress}});
        },
        nothing_kept);
}

} // namespace
} // namespace proxima::index_file_test
