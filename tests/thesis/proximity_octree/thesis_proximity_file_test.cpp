#include "thesis/proximity_octree/thesis_proximity_file.h"

#include "base/binary_file.h"
#include "code_of.h"
#include "damaged_files.h"
#include "exact_copy.h"
#include "proxima/sample_meshes.h"
#include "thesis/proximity_octree/thesis_closest.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <random>
#include <unistd.h>

namespace proxima::thesis_proximity_file_test {
namespace {

Result<ThesisProximityOctree> load_bytes(const std::string& bytes,
                                         Verification /*always full*/ = Verification::full)
{
    const auto copy = testing::exact_copy(bytes.data(), bytes.size());
    return load_thesis_proximity_octree(std::span(copy.get(), bytes.size()), copy, "memory");
}

class ThesisProximityFile : public ::testing::Test {
protected:
    void TearDown() override { std::filesystem::remove(path); }

    std::string saved(const ThesisProximityOctree& octree)
    {
        const Status status = save_thesis_proximity_octree(octree, path);
        EXPECT_TRUE(status);
        std::ifstream file(path, std::ios::binary);
        return {std::istreambuf_iterator<char>(file), {}};
    }

    const std::filesystem::path path =
        std::filesystem::path(::testing::TempDir()) /
        ("thesis_proximity_" + std::to_string(::getpid()) + thesis_proximity_extension);
};

TEST_F(ThesisProximityFile, AnswersTheSameAfterLoading)
{
    const TriangleMesh mesh = make_sphere(20, 20);
    const Topology topology = *build_topology(mesh);
    const auto built = build_thesis_proximity_octree(mesh, topology, {.margin = 0.75});
    ASSERT_TRUE(built);
    const std::string bytes = saved(*built);
    const auto opened = load_thesis_proximity_octree(path);
    ASSERT_TRUE(opened) << describe(opened.error());
    EXPECT_EQ(opened->bytes(), built->bytes());
    EXPECT_EQ(opened->depth_reached(), built->depth_reached());
    EXPECT_EQ(opened->margin(), 0.75);
    EXPECT_EQ(opened->thresholds(), built->thresholds());
    EXPECT_TRUE(fits_mesh(*opened, mesh, topology));
    EXPECT_EQ(saved(*opened), bytes);
    std::mt19937_64 random(1);
    std::uniform_real_distribution<double> coordinate(-2, 2);
    for (int i = 0; i < 2000; ++i) {
        const Vec3 point(coordinate(random), coordinate(random), coordinate(random));
        const auto expected = closest_feature(*built, mesh, topology, point);
        const auto found = closest_feature(*opened, mesh, topology, point);
        ASSERT_EQ(found.has_value(), expected.has_value());
        if (!found) continue;
        ASSERT_EQ(found->feature, expected->feature);
        ASSERT_EQ(found->squared_distance, expected->squared_distance);
    }
}

TEST_F(ThesisProximityFile, RefusesDamage)
{
    const std::string bytes =
        saved(*build_thesis_proximity_octree(make_octahedron(), {.max_depth = 1}));
    testing::refuses_every_truncation_and_extension(bytes, load_bytes);
    testing::refuses_every_flipped_bit(bytes, load_bytes);
}

/// What checksums cannot see: a file that somebody made. It is refused, or answers within its
/// arrays (a sanitizer sees those that do not).
TEST_F(ThesisProximityFile, SurvivesResealedDamage)
{
    const TriangleMesh mesh = make_octahedron();
    const Topology topology = *build_topology(mesh);
    const std::string bytes = saved(*build_thesis_proximity_octree(mesh, topology));
    std::mt19937_64 random(5);
    int refused = 0;
    for (int i = 0; i < 4000; ++i) {
        std::string damaged = bytes;
        const std::size_t at = random() % damaged.size();
        damaged[at] = static_cast<char>(random());
        reseal_binary_file(std::as_writable_bytes(std::span(damaged)));
        const auto opened = load_bytes(damaged);
        if (!opened) {
            ++refused;
            continue;
        }
        const FeatureCounts& features = opened->features();
        if (features.vertices != mesh.vertex_count() || features.edges != topology.edge_count() ||
            features.faces != mesh.triangle_count())
            continue;
        for (int k = 0; k < 8; ++k) {
            const Vec3 corner((k & 1) != 0 ? 1 : -1, (k & 2) != 0 ? 1 : -1, (k & 4) != 0 ? 1 : -1);
            (void)closest_feature(*opened, mesh, topology, corner);
        }
    }
    EXPECT_GT(refused, 1000);
}

/// Each of n leaves could list all of n labels: checking them would take the square of the file's size.
TEST_F(ThesisProximityFile, RefusesListsThatOverlap)
{
    ThesisProximityOctree::Parts parts =
        build_thesis_proximity_octree(make_octahedron(), {.max_depth = 1})->parts();
    ASSERT_TRUE(load_bytes(saved(ThesisProximityOctree(parts))));
    ASSERT_GT(parts.leaves.size(), 1U);
    ASSERT_EQ(parts.leaves[1].closest, parts.leaves[0].closest);
    parts.leaves[1].first = parts.leaves[0].first;
    const auto opened = load_bytes(saved(ThesisProximityOctree(parts)));
    ASSERT_FALSE(opened);
    EXPECT_EQ(code_of(opened), ErrorCode::malformed_file);
}

} // namespace
} // namespace proxima::thesis_proximity_file_test
