#include "proxima/octree_io.h"

#include "code_of.h"
#include "damaged_files.h"
#include "exact_copy.h"

#include "base/binary_file.h"
#include "octree/classify_cells.h"
#include "octree/slow_builder.h"
#include "octree/small_meshes.h"
#include "proxima/octree.h"

#include <cstring>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <new>
#include <random>

namespace proxima::octree_file_test {
namespace {

using namespace testing;

std::string slurp(const std::filesystem::path& path)
{
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

/// Loads from an exact copy of the bytes, so that a sanitizer sees the first one out of bounds.
Result<Octree> load_bytes(const std::string& bytes, Verification verify = Verification::full)
{
    const auto copy = testing::exact_copy(bytes.data(), bytes.size());
    return load_octree(std::span(copy.get(), bytes.size()), copy, "memory", {.verify = verify});
}

void expect_equal(const Octree& a, const Octree& b)
{
    EXPECT_EQ(a.parameters(), b.parameters());
    EXPECT_EQ(a.frame().lower, b.frame().lower);
    EXPECT_EQ(a.frame().edge, b.frame().edge);
    EXPECT_EQ(a.triangle_count(), b.triangle_count());
    EXPECT_TRUE(std::equal(a.nodes().begin(), a.nodes().end(), b.nodes().begin(), b.nodes().end()));
    EXPECT_TRUE(std::equal(a.references().begin(), a.references().end(), b.references().begin(),
                           b.references().end()));
}

class OctreeFile : public ::testing::Test {
protected:
    void SetUp() override
    {
        const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
        folder = std::filesystem::path(::testing::TempDir()) /
                 (std::string("octree_file_") + info->name() + "_" + std::to_string(::getpid()));
        std::filesystem::create_directories(folder);
        path = folder / "octree.pxo";
    }
    void TearDown() override { std::filesystem::remove_all(folder); }

    std::string saved(const Octree& octree)
    {
        const Status status = save_octree(octree, path);
        EXPECT_TRUE(status) << describe(status.error());
        return slurp(path);
    }

    std::filesystem::path folder;
    std::filesystem::path path;
    TriangleMesh mesh = cube_mesh(Vec3(0.1, 0.2, 0.3), 1.0);
    Octree small = classify_cells(slow_octree(mesh, {.max_depth = 2}), mesh).value();
};

TEST_F(OctreeFile, SurvivesSavingAndLoading)
{
    const TriangleMesh open =
        without(torus_mesh(1.0, 0.4, 30, 20), [](std::size_t i) { return i < 30; });
    for (const Octree& octree :
         {small, slow_octree(mesh, {.max_depth = 0}),
          slow_octree(open, {.max_depth = 3, .subdivision = Subdivision::uniform}),
          classify_cells(slow_octree(open, {.max_depth = 5}), open).value()}) {
        const std::string bytes = saved(octree);
        for (const Verification verify : {Verification::full, Verification::structure}) {
            const auto loaded = load_octree(path, {.verify = verify});
            ASSERT_TRUE(loaded) << describe(loaded.error());
            expect_equal(octree, *loaded);
            // Same octree, same bytes: also written over the file that it is mapped from.
            EXPECT_EQ(saved(*loaded), bytes);
            expect_equal(octree, *loaded);
        }
    }
}

TEST_F(OctreeFile, IsNotWrittenOfNoMesh)
{
    const Status status = save_octree(Octree{}, path);
    ASSERT_FALSE(status);
    EXPECT_EQ(code_of(status), ErrorCode::invalid_argument);
    EXPECT_FALSE(std::filesystem::exists(path));
}

TEST_F(OctreeFile, RefusesBytesThatAreNotAligned)
{
    const std::string bytes = saved(small);
    alignas(128) static std::array<std::byte, std::size_t{1} << 16U> memory;
    ASSERT_LE(bytes.size() + 128, memory.size());
    for (const std::size_t offset : {0U, 1U, 64U, 128U}) {
        const auto content = std::span(memory).subspan(offset, bytes.size());
        std::ranges::copy(std::as_bytes(std::span(bytes)), content.begin());
        const auto loaded = load_octree(content, nullptr, "memory");
        ASSERT_EQ(loaded.has_value(), offset % 128 == 0) << offset;
        if (loaded) continue;
        EXPECT_EQ(code_of(loaded), ErrorCode::invalid_argument);
        EXPECT_NE(loaded.error().message.find("128"), std::string::npos) << loaded.error().message;
    }
}

TEST_F(OctreeFile, RefusesEveryFlippedBit)
{
    testing::refuses_every_flipped_bit(saved(small), load_bytes);
}

TEST_F(OctreeFile, RefusesEveryTruncationAndExtension)
{
    testing::refuses_every_truncation_and_extension(saved(small), load_bytes);
}

TEST_F(OctreeFile, DamageWithRightChecksumsIsHarmless)
{
    // A crafted file has right checksums, so what is accepted must be safe to walk through.
    const std::string bytes = saved(small);
    std::mt19937 random(5);
    int accepted = 0;
    for (int round = 0; round < 20000; ++round) {
        std::string damaged = bytes;
        for (int change = 0; change < 1 + round % 3; ++change) {
            damaged[random() % damaged.size()] = static_cast<char>(random());
        }
        reseal_binary_file(std::as_writable_bytes(std::span(damaged)));
        const auto loaded = load_bytes(damaged);
        if (!loaded) continue;
        ++accepted;
        EXPECT_EQ(octree_statistics(*loaded).references, loaded->references().size());
    }
    EXPECT_GT(accepted, 0) << "seed 5";
}

TEST_F(OctreeFile, ReportsWhyAFileIsRefused)
{
    const std::string bytes = saved(small);
    const auto expect_refused = [](const std::string& file, ErrorCode code, const char* why) {
        const auto loaded = load_bytes(file);
        ASSERT_FALSE(loaded);
        EXPECT_EQ(code_of(loaded), code);
        EXPECT_NE(loaded.error().message.find(why), std::string::npos) << loaded.error().message;
    };
    expect_refused("ply\nformat ascii 1.0\n", ErrorCode::unsupported_format, "no octree file");
    expect_refused("", ErrorCode::unsupported_format, "no octree file");
    std::string other = bytes;
    std::swap(other[8], other[11]);
    std::swap(other[9], other[10]);
    expect_refused(other, ErrorCode::unsupported_format, "other byte order");
    other = bytes;
    other[12] = 2;
    expect_refused(other, ErrorCode::unsupported_format, "version 2");
    expect_refused(bytes.substr(0, 1000), ErrorCode::malformed_file, "cut off");
    other = bytes;
    other.back() = static_cast<char>(other.back() ^ 1);
    expect_refused(other, ErrorCode::malformed_file, "section 3 is wrong");

    EXPECT_EQ(code_of(load_octree(folder / "missing.pxo")), ErrorCode::file_not_found);
    EXPECT_EQ(code_of(load_octree(folder)), ErrorCode::file_not_found);
    EXPECT_EQ(code_of(load_octree(std::filesystem::path("/dev/null"))), ErrorCode::file_not_found);
    EXPECT_EQ(code_of(save_octree(small, folder / "missing" / "x.pxo")),
              ErrorCode::file_not_writable);
    EXPECT_EQ(code_of(save_octree(small, "/dev/full")), ErrorCode::file_not_writable);
}

TEST_F(OctreeFile, HoldsTheGreatestDepth)
{
    const Octree octree =
        build_octree(mesh, {.max_depth = max_octree_depth, .threshold = 100}).value();
    (void)saved(octree);
    const auto loaded = load_octree(path);
    ASSERT_TRUE(loaded) << describe(loaded.error());
    expect_equal(octree, *loaded);
}

TEST_F(OctreeFile, HoldsALargeOctree)
{
    const TriangleMesh fine = torus_mesh(1.0, 0.4, 200, 100);
    const Octree octree = slow_octree(
        fine, {.max_depth = 7, .threshold = 2}, [](const Triangle& triangle, const Box& box) {
            const Box bounds = bounding_box(triangle);
            return (bounds.lower.array() <= box.upper.array()).all() &&
                   (bounds.upper.array() >= box.lower.array()).all();
        });
    ASSERT_GT(octree.bytes(), 2'000'000U);
    (void)saved(octree);
    const auto loaded = load_octree(path);
    ASSERT_TRUE(loaded) << describe(loaded.error());
    expect_equal(octree, *loaded);
}

} // namespace
} // namespace proxima::octree_file_test
