// Spans of rays that look alike are cast as packets.
#include "base/simd.h"
#include "index/index_parts.h"
#include "index/test_meshes.h"
#include "mesh/random_soups.h"
#include "octree/nasty_meshes.h"
#include "octree/small_meshes.h"
#include "oracles/ray_hits.h"
#include "proxima/cast_ray.h"
#include "query/rays/test_rays.h"

#include <gtest/gtest.h>

namespace proxima::cast_packet_test {
namespace {

using namespace testing;

/// Rows of rays that go much the same way: from a point or all in one direction, from near or far,
/// with ranges that begin or end in the mesh, some of them odd ones out.
std::vector<Ray> rows_of_rays(const TriangleMesh& mesh, std::uint32_t seed)
{
    std::mt19937 random(seed);
    std::normal_distribution<double> normal;
    std::uniform_real_distribution<double> unit(0, 1);
    const Box box = bounding_box(mesh);
    const double size = std::max(box.extent().maxCoeff(), 1e-3);
    constexpr double ways[] = {0.1, 1, 3, 1000, 0x1p30};
    std::vector<Ray> rays;
    for (int row = 0; row < 24; ++row) {
        Vec3 way = Vec3{normal(random), normal(random), normal(random)}.normalized();
        if (row % 4 == 0) way = Vec3::Unit(row / 4 % 3); // axes, whose other components are zero
        const double far = size * ways[static_cast<std::size_t>(row) % 5];
        const Vec3 eye = box.center() - far * way;
        const Vec3 across = way.unitOrthogonal();
        const bool from_point = row % 2 == 0;
        const double width = size * (row % 3 == 0 ? 1.2 : 0.1);
        const Vec3& aim = mesh.positions()[random() % mesh.vertex_count()];
        for (int i = 0; i < 50; ++i) {
            const Vec3 off = width * (i / 50.0 - 0.5) * across;
            Ray ray{from_point ? eye : Vec3(aim - far * way + off),
                    from_point ? Vec3(aim - eye + off) : way};
            if (row % 5 == 1) ray.t_max = 0.8 * far + 0.4 * size * unit(random);
            if (row % 5 == 2) ray.t_min = 0.8 * far + 0.4 * size * unit(random);
            if (i == 45 && row % 7 == 0) ray.direction = -ray.direction;
            if (is_valid(ray)) rays.push_back(ray);
        }
    }
    return rays;
}

TEST(CastPacket, AnswersLikeBruteForceOnEveryInstructionSet)
{
    std::size_t hits = 0;
    std::size_t cast = 0;
    const auto expect_truth_of_rows = [&](const TriangleMesh& mesh, std::uint32_t seed) {
        if (!checked_bounding_box(mesh)) return;
        const MeshIndex index = ray_index_of(mesh);
        const std::vector<Ray> rays = rows_of_rays(mesh, seed);
        const Faces faces = all_faces[seed % 3];
        std::vector<std::optional<RayHit>> truth;
        truth.reserve(rays.size());
        for (const Ray& ray : rays) {
            truth.push_back(closest_hit_by_brute_force(mesh, ray, faces));
            hits += truth.back() ? 1 : 0;
        }
        cast += rays.size();
        for (const SimdTarget& target : simd_targets()) {
            SCOPED_TRACE(::testing::Message() << target.name << ", seed " << seed);
            force_simd_target(target);
            std::vector<std::optional<RayHit>> closest(rays.size());
            const auto any = std::make_unique<bool[]>(rays.size());
            EXPECT_TRUE(closest_hits(index, rays, closest, {.faces = faces}));
            EXPECT_TRUE(any_hits(index, rays, {any.get(), rays.size()}, {.faces = faces}));
            restore_simd_targets();
            for (std::size_t i = 0; i < rays.size(); ++i) {
                ASSERT_EQ(closest[i], truth[i]) << "ray " << i;
                ASSERT_EQ(any[i], truth[i].has_value()) << "ray " << i;
            }
        }
    };
    for (std::uint32_t seed = 0; seed < 9 && !HasFailure(); ++seed) {
        for (const TriangleMesh& mesh : {nasty_mesh(seed), grid_mesh(seed), random_soup(seed)})
            expect_truth_of_rows(mesh, seed);
    }
    expect_truth_of_rows(torus_mesh(1.0, 0.4, 24, 16), 1);
    const TriangleMesh sphere = sphere_mesh(Vec3(5, 6, 7), 1.0, 20, 30);
    expect_truth_of_rows(sphere, 3);
    // Coordinates that floats hold: hits are computed from leaves.
    const TriangleMesh coarse =
        moved(sphere, [](const Vec3& p) { return Vec3((4096 * p).array().round() / 4096); });
    EXPECT_TRUE(ray_index_of(coarse).parts().has_exact_leaves());
    EXPECT_FALSE(ray_index_of(sphere).parts().has_exact_leaves());
    for (std::uint32_t seed = 4; seed < 7; ++seed) expect_truth_of_rows(coarse, seed);
    EXPECT_GT(hits, cast / 10);
}

TriangleMesh scattered_triangles(std::mt19937& random)
{
    std::uniform_real_distribution<double> unit(0, 1);
    const auto place = [&] { return Vec3{unit(random), unit(random), unit(random)}; };
    std::vector<Vec3> positions;
    std::vector<TriangleCorners> triangles(10 + below(random, 200));
    std::uint32_t vertex = 0;
    for (TriangleCorners& corners : triangles) {
        const Vec3 middle = place();
        for (std::uint32_t& corner : corners) {
            positions.emplace_back(middle + 0.2 * place());
            corner = vertex++;
        }
    }
    return mesh_of(std::move(positions), std::move(triangles));
}

/// Sixteens of rays as unlike as a packet's may be: through all of the mesh, from about one place.
std::vector<Ray> broad_sixteens(const TriangleMesh& mesh, std::uint32_t seed)
{
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> unit(0, 1);
    const Box box = bounding_box(mesh);
    const double size = std::max(box.extent().maxCoeff(), 1e-3);
    std::vector<Ray> rays;
    for (int sixteen = 0; sixteen < 100; ++sixteen) {
        Vec3 signs;
        for (double& sign : signs) sign = below(random, 2) == 0 ? 1 : -1;
        const Vec3 place =
            box.lower + Vec3{unit(random), unit(random), unit(random)}.cwiseProduct(box.extent());
        const Vec3 middle(0.7, 0.7, 1.3);
        const double unlike = 0.3 * unit(random);
        const double apart = 0.1 * size * unit(random);
        for (int i = 0; i < 16; ++i) {
            Ray ray{place, middle};
            for (int axis = 0; axis < 3; ++axis) {
                ray.origin[axis] += apart * (unit(random) - 0.5);
                ray.direction[axis] *= signs[axis] * (1 + unlike * (2 * unit(random) - 1));
            }
            ray.origin -= (sixteen % 3) * 0.3 * size * middle.cwiseProduct(signs);
            rays.push_back(ray);
        }
    }
    return rays;
}

TEST(CastPacket, LosesNoHitNextToEmptyChildren)
{
    // The box of such a place is empty, but the intervals of a packet's rays may meet it.
    std::size_t hits = 0;
    for (std::uint32_t seed = 0; seed < 60; ++seed) {
        SCOPED_TRACE(::testing::Message() << "seed " << seed);
        std::mt19937 random(seed);
        const TriangleMesh mesh = scattered_triangles(random);
        const MeshIndex index = ray_index_of(mesh);
        const std::vector<Ray> rays = broad_sixteens(mesh, seed);
        std::vector<std::optional<RayHit>> closest(rays.size());
        ASSERT_TRUE(closest_hits(index, rays, closest));
        for (std::size_t i = 0; i < rays.size(); ++i) {
            const auto truth = closest_hit_by_brute_force(mesh, rays[i], Faces::both);
            hits += truth ? 1 : 0;
            ASSERT_EQ(closest[i], truth) << "ray " << i;
        }
    }
    EXPECT_GT(hits, 10'000U);
}

TEST(CastPacket, AnswersWherePacketsAreGivenUp)
{
    // Each sixteen in a row spans many leaves or few, in turns and for long.
    const TriangleMesh sphere = sphere_mesh(Vec3::Zero(), 1.0, 120, 160);
    const MeshIndex index = ray_index_of(sphere);
    std::vector<Ray> rays;
    for (int sixteen = 0; sixteen < 600; ++sixteen) {
        const bool is_broad = sixteen < 200 || (sixteen < 400 && sixteen % 3 == 0);
        const double width = is_broad ? 0.04 : 0.001;
        for (int i = 0; i < 16; ++i) {
            const Vec3 eye(2, 2, 3);
            const Vec3 aim(0.5 * std::sin(sixteen), 0.5 * std::cos(sixteen * 1.7) - width * i, 0);
            rays.push_back({eye, aim - eye});
        }
    }
    for (const SimdTarget& target : simd_targets()) {
        SCOPED_TRACE(target.name);
        force_simd_target(target);
        std::vector<std::optional<RayHit>> closest(rays.size());
        const auto any = std::make_unique<bool[]>(rays.size());
        EXPECT_TRUE(closest_hits(index, rays, closest));
        EXPECT_TRUE(any_hits(index, rays, {any.get(), rays.size()}));
        restore_simd_targets();
        std::size_t hits = 0;
        for (std::size_t i = 0; i < rays.size(); ++i) {
            ASSERT_EQ(closest[i], closest_hit(index, rays[i])) << "ray " << i;
            ASSERT_EQ(any[i], closest[i].has_value()) << "ray " << i;
            hits += closest[i] ? 1 : 0;
        }
        EXPECT_GT(hits, rays.size() / 2);
    }
}

} // namespace
} // namespace proxima::cast_packet_test
