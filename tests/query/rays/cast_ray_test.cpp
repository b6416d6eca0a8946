#include "proxima/cast_ray.h"

#include "base/simd.h"
#include "base/text.h"
#include "cancellation.h"
#include "code_of.h"
#include "counted_allocations.h"
#include "index/index_parts.h"
#include "index/test_meshes.h"
#include "mesh/random_soups.h"
#include "octree/nasty_meshes.h"
#include "octree/small_meshes.h"
#include "oracles/ray_hits.h"
#include "query/rays/prepare_ray.h"
#include "query/rays/test_rays.h"

#include <gtest/gtest.h>

namespace proxima::cast_ray_test {
namespace {

using namespace testing;

std::vector<Ray> rays_for(const TriangleMesh& mesh, int count, std::uint64_t seed)
{
    RayGenerator generate(mesh, seed);
    std::vector<Ray> rays;
    rays.reserve(count);
    for (int i = 0; i < count; ++i) rays.push_back(generate());
    return rays;
}

/// Answers of single rays against the slow search, bit for bit. Returns how many hits there were.
std::size_t expect_truth(const TriangleMesh& mesh, const MeshIndex& index,
                         std::span<const Ray> rays)
{
    std::size_t hits = 0;
    for (std::size_t i = 0; i < rays.size(); ++i) {
        const Faces faces = all_faces[i % 5 < 3 ? 0 : i % 3];
        const std::vector<RayHit> truth = all_hits_by_brute_force(mesh, rays[i], faces);
        hits += truth.size();
        const auto closest = closest_hit(index, rays[i], faces);
        EXPECT_EQ(closest.has_value(), !truth.empty()) << "ray " << i;
        if (!truth.empty()) {
            EXPECT_EQ(closest, truth.front()) << "ray " << i;
        }
        EXPECT_EQ(any_hit(index, rays[i], faces), !truth.empty()) << "ray " << i;
        EXPECT_EQ(all_hits(index, rays[i], faces), truth) << "ray " << i;
        if (::testing::Test::HasFailure()) break;
    }
    return hits;
}

TEST(CastRay, AnswersLikeBruteForceOnNamedMeshes)
{
    std::size_t hits = 0;
    std::uint64_t seed = 1;
    for (const NamedMesh& named : proximity_meshes()) {
        SCOPED_TRACE(::testing::Message() << named.name << ", seed " << seed);
        hits +=
            expect_truth(named.mesh, ray_index_of(named.mesh), rays_for(named.mesh, 2000, seed++));
    }
    EXPECT_GT(hits, 10'000U);
}

TEST(CastRay, AnswersLikeBruteForceOnManyRandomMeshes)
{
    std::size_t rays = 0;
    std::size_t hits = 0;
    for (std::uint32_t seed = 0; seed < 400; ++seed) {
        SCOPED_TRACE(::testing::Message() << "seed " << seed);
        for (const TriangleMesh& mesh : {nasty_mesh(seed), grid_mesh(seed), random_soup(seed)}) {
            if (!checked_bounding_box(mesh)) continue;
            const std::vector<Ray> some = rays_for(mesh, 100, seed);
            rays += some.size();
            hits += expect_truth(mesh, ray_index_of(mesh), some);
        }
    }
    RecordProperty("rays", static_cast<int>(rays));
    EXPECT_GT(rays, 100'000U);
    EXPECT_GT(hits, rays / 10);
}

TEST(CastRay, RaysThatBeginOnTheSurfaceHitIt)
{
    constexpr std::uint64_t seed = 12;
    SCOPED_TRACE(::testing::Message() << "seed " << seed);
    std::mt19937_64 random(seed);
    const auto unit = [&] { return std::uniform_real_distribution<double>(-1, 1)(random); };
    // Corners of few bits are in the leaves as they are, those of more are not.
    for (const double grid : {0x1p10, 0x1p40}) {
        const TriangleMesh mesh = moved(sphere_mesh(Vec3::Zero(), 1.0, 12, 16), [&](const Vec3& p) {
            return Vec3((grid * p).array().round() / grid);
        });
        const MeshIndex index = ray_index_of(mesh);
        EXPECT_EQ(index.parts().has_exact_leaves(), grid < 0x1p20);
        std::vector<Ray> rays;
        for (int i = 0; i < 20'000; ++i) {
            const Triangle triangle = mesh.triangle(
                TriangleId{static_cast<std::uint32_t>(random() % mesh.triangle_count())});
            const auto u = static_cast<double>(random() % 9) / 8;
            const double v = static_cast<double>(random() % 9) / 8;
            const double w = 1 - u - v;
            const Vec3 direction = i % 3 == 0 ? Vec3(triangle[1] - triangle[0]) // along the face
                                              : Vec3(unit(), unit(), unit());
            rays.push_back({w * triangle[0] + u * triangle[1] + v * triangle[2], direction});
            if (w < 0) rays.pop_back(); // not on it
        }
        std::vector<std::optional<RayHit>> hits(rays.size());
        ASSERT_TRUE(closest_hits(index, rays, hits));
        for (std::size_t i = 0; i < rays.size(); ++i) {
            const auto truth = closest_hit_by_brute_force(mesh, rays[i]);
            ASSERT_TRUE(truth && truth->t == 0) << "ray " << i;
            ASSERT_EQ(closest_hit(index, rays[i]), truth) << "ray " << i;
            ASSERT_EQ(hits[i], truth) << "ray " << i;
            ASSERT_TRUE(any_hit(index, rays[i])) << "ray " << i;
        }
    }
}

TEST(CastRay, HitsTheSameAtAnyScaleAndPosition)
{
    const TriangleMesh torus = torus_mesh(1.0, 0.4, 24, 16);
    const MeshIndex index = ray_index_of(torus);
    const std::vector<Ray> rays = rays_for(torus, 3000, 3);
    for (const int exponent : {-20, 20, -200, 200}) {
        SCOPED_TRACE(exponent);
        const double scale = std::ldexp(1.0, exponent);
        const TriangleMesh scaled = moved(torus, [&](const Vec3& p) { return Vec3(scale * p); });
        const MeshIndex other = ray_index_of(scaled);
        for (const Ray& ray : rays) {
            const Ray same{scale * ray.origin, scale * ray.direction, ray.t_min, ray.t_max};
            ASSERT_EQ(closest_hit(other, same), closest_hit(index, ray));
        }
    }
    // Far away coordinates are coarse: another mesh, but a closed one, and the same by brute force.
    const TriangleMesh far =
        moved(torus, [](const Vec3& p) { return Vec3(p + Vec3(3e7, -5e8, 2e9)); });
    expect_truth(far, ray_index_of(far), rays_for(far, 1000, 4));
    const TriangleMesh tiny = moved(torus, [](const Vec3& p) { return Vec3(1e-6 * p); });
    expect_truth(tiny, ray_index_of(tiny), rays_for(tiny, 1000, 5));
    const TriangleMesh coarse =
        moved(torus, [](const Vec3& p) { return Vec3((4096 * p).array().round() / 4096); });
    ASSERT_TRUE(ray_index_of(coarse).parts().has_exact_leaves());
    expect_truth(coarse, ray_index_of(coarse), rays_for(coarse, 3000, 7));
    const TriangleMesh huge = moved(torus, [](const Vec3& p) { return Vec3(1e6 * p); });
    expect_truth(huge, ray_index_of(huge), rays_for(huge, 1000, 6));
}

TEST(CastRay, MeetsTrianglesWhoseAreasOverflow)
{
    // Each weight of a corner is a double, their sum is beyond doubles.
    for (const double scale : {0x1p511, 9e153}) {
        const std::vector<Vec3> corners = {scale * Vec3(-1, -1, 0.5), scale * Vec3(1, -1, 0.25),
                                           scale * Vec3(0, 1, 0.875)};
        const MeshIndex index = ray_index_of(mesh_of(corners, {{0, 1, 2}}));
        EXPECT_EQ(index.parts().has_exact_leaves(), scale == 0x1p511);
        const Ray ray{Vec3(0, 0, -scale), Vec3(0, 0, scale)};
        const std::vector<Ray> rays(64, ray);
        for (const SimdTarget& target : simd_targets()) {
            SCOPED_TRACE(::testing::Message() << target.name << ", scale " << scale);
            force_simd_target(target);
            std::vector<std::optional<RayHit>> hits(rays.size());
            EXPECT_TRUE(closest_hits(index, rays, hits));
            hits.push_back(closest_hit(index, ray));
            restore_simd_targets();
            for (const auto& hit : hits) {
                ASSERT_TRUE(hit);
                ASSERT_NEAR(hit->t, 1.625, 1e-15);
                ASSERT_NEAR(hit->u, 0.25, 1e-15);
                ASSERT_NEAR(hit->v, 0.5, 1e-15);
            }
        }
    }
}

TEST(CastRay, LosesNoRayAimedAtEdgesAndVerticesOfClosedMeshes)
{
    std::mt19937_64 random(9);
    std::normal_distribution<double> normal;
    for (const TriangleMesh& mesh :
         {sphere_mesh(Vec3(0.1, 0.2, 0.3), 1.0, 30, 40), cube_mesh(Vec3(5, 5, 5), 2.0),
          moved(torus_mesh(1.0, 0.4, 40, 30),
                [](const Vec3& p) { return Vec3(1e3 * p + Vec3(1e6, 2e6, -3e6)); })}) {
        const MeshIndex index = ray_index_of(mesh);
        const double size = bounding_box(mesh).extent().norm();
        std::vector<Ray> rays;
        for (std::uint32_t id = 0; id < mesh.triangle_count(); ++id) {
            const Triangle triangle = mesh.triangle(TriangleId{id});
            for (int i = 0; i < 3; ++i) {
                const Vec3& a = triangle[i];
                const Vec3& b = triangle[(i + 1) % 3];
                const double share = static_cast<double>(random() % 1024) / 1024;
                for (const Vec3& target : {a, Vec3(a + share * (b - a))}) {
                    const double x = normal(random);
                    const double y = normal(random);
                    const Vec3 away(x, y, normal(random));
                    // Through the target, up to rounding, from outside to outside.
                    const Vec3 origin = target + 2 * size * away.normalized();
                    rays.push_back({origin, target - origin});
                }
            }
        }
        std::size_t hits = 0;
        for (const Ray& ray : rays) {
            // What goes in comes out: a ray lost on either side would show.
            const bool entered = any_hit(index, ray, Faces::front);
            ASSERT_EQ(entered, any_hit(index, ray, Faces::back));
            const auto all = all_hits(index, ray);
            if (!all.empty()) {
                ASSERT_EQ(closest_hit(index, ray), all.front());
            }
            hits += entered ? 1 : 0;
        }
        EXPECT_GT(hits, rays.size() * 9 / 10);
    }
}

TEST(CastRay, NeverLeavesAConvexMeshThroughAGap)
{
    // From the centre every direction must hit, exactly at shared vertices and edges as well.
    const TriangleMesh sphere = sphere_mesh(Vec3::Zero(), 1.0, 40, 60);
    const MeshIndex index = ray_index_of(sphere);
    std::vector<Ray> rays;
    for (std::uint32_t id = 0; id < sphere.triangle_count(); ++id) {
        const Triangle triangle = sphere.triangle(TriangleId{id});
        for (int i = 0; i < 3; ++i) {
            rays.push_back({Vec3::Zero(), triangle[i]});
            rays.push_back({Vec3::Zero(), triangle[i] + triangle[(i + 1) % 3]});
            rays.push_back({0.25 * triangle[i], triangle[(i + 1) % 3] - 0.25 * triangle[i]});
        }
    }
    std::vector<std::optional<RayHit>> hits(rays.size());
    ASSERT_TRUE(closest_hits(index, rays, hits));
    const double inner = inner_radius(sphere);
    for (std::size_t i = 0; i < rays.size(); ++i) {
        ASSERT_TRUE(hits[i]);
        ASSERT_TRUE(closest_hit(index, rays[i], Faces::back));
        ASSERT_FALSE(closest_hit(index, rays[i], Faces::front));
        const double distance = rays[i].at(hits[i]->t).norm();
        ASSERT_GE(distance, inner - 1e-12);
        ASSERT_LE(distance, 1 + 1e-12);
    }
}

TEST(CastRay, BatchesAnswerLikeSingleRaysForAnyNumberOfThreads)
{
    const TriangleMesh torus = torus_mesh(1.0, 0.4, 24, 16);
    const MeshIndex index = ray_index_of(torus);
    const std::vector<Ray> rays = rays_for(torus, 5000, 11);
    for (const Faces faces : all_faces) {
        std::vector<std::optional<RayHit>> closest_of;
        std::vector<bool> any_of;
        std::vector<std::vector<RayHit>> all_of;
        for (const Ray& ray : rays) {
            closest_of.push_back(closest_hit(index, ray, faces));
            any_of.push_back(any_hit(index, ray, faces));
            all_of.push_back(all_hits(index, ray, faces));
        }
        for (const int threads : {1, 3}) {
            const RayBatchOptions options{.faces = faces, .execution = {.threads = {threads}}};
            std::vector<std::optional<RayHit>> closest(rays.size());
            const auto any = std::make_unique<bool[]>(rays.size());
            ASSERT_TRUE(closest_hits(index, rays, closest, options));
            ASSERT_TRUE(any_hits(index, rays, {any.get(), rays.size()}, options));
            const auto lists = all_hits(index, rays, options);
            ASSERT_TRUE(lists);
            ASSERT_EQ(lists->first.size(), rays.size() + 1);
            for (std::size_t i = 0; i < rays.size(); ++i) {
                ASSERT_EQ(closest[i], closest_of[i]);
                ASSERT_EQ(any[i], any_of[i]);
                const std::vector<RayHit> list(
                    lists->hits.begin() + static_cast<std::ptrdiff_t>(lists->first[i]),
                    lists->hits.begin() + static_cast<std::ptrdiff_t>(lists->first[i + 1]));
                ASSERT_EQ(list, all_of[i]);
            }
        }
    }
}

TEST(CastRay, AnswersTheSameOnEveryInstructionSetWithoutAllocating)
{
    const TriangleMesh torus = torus_mesh(1.0, 0.4, 24, 16);
    const MeshIndex index = ray_index_of(torus);
    const std::vector<Ray> rays = rays_for(torus, 4000, 13);
    std::vector<std::optional<RayHit>> truth;
    truth.reserve(rays.size());
    for (const Ray& ray : rays) truth.push_back(closest_hit(index, ray));
    std::array<RayHit, 4> first_hits;
    for (const SimdTarget& target : simd_targets()) {
        SCOPED_TRACE(target.name);
        force_simd_target(target);
        const std::size_t before = allocation_count();
        std::size_t wrong = 0;
        for (std::size_t i = 0; i < rays.size(); ++i) {
            if (closest_hit(index, rays[i]) != truth[i]) ++wrong;
            if (any_hit(index, rays[i]) != truth[i].has_value()) ++wrong;
            const std::size_t count = all_hits(index, rays[i], first_hits);
            if ((count > 0) != truth[i].has_value()) ++wrong;
            if (count > 0 && first_hits[0] != *truth[i]) ++wrong;
        }
        EXPECT_EQ(allocation_count(), before);
        EXPECT_EQ(wrong, 0U);
        std::vector<std::optional<RayHit>> batch(rays.size());
        ASSERT_TRUE(closest_hits(index, rays, batch));
        EXPECT_EQ(batch, truth);
        restore_simd_targets();
    }
}

TEST(CastRay, WalksFromFarAway)
{
    // At t = 1 the ray is exactly at x = 0 and the target's y and z, however far it begins.
    const TriangleMesh sphere = moved(sphere_mesh(Vec3::Zero(), 1.0, 20, 30), [](const Vec3& p) {
        return Vec3((4096 * p).array().round() / 4096);
    });
    const MeshIndex index = ray_index_of(sphere);
    std::mt19937_64 random(5);
    std::uniform_real_distribution<double> unit(-1.1, 1.1);
    std::size_t hits = 0;
    for (int exponent = 0; exponent < 110; ++exponent) {
        SCOPED_TRACE(::testing::Message() << "from 2^" << exponent << ", seed 5");
        const double far = std::ldexp(1.0, exponent);
        std::vector<Ray> rays;
        for (int i = 0; i < 30; ++i) {
            const Vec3 target(0, std::round(1024 * unit(random)) / 1024,
                              std::round(1024 * unit(random)) / 1024);
            const Vec3 along(far, std::round(8 * unit(random)), std::round(8 * unit(random)));
            Ray ray{target - along, along};
            if (i % 3 == 1) ray.t_max = 1;
            if (i % 3 == 2) ray.t_min = 1;
            rays.push_back(ray);
            RayTraversal open;
            const RayStart start = prepare_ray(index.parts(), ray, Faces::both, open);
            // In the index's units, half of the mesh's.
            EXPECT_EQ(start == RayStart::too_far, exponent > 80);
        }
        hits += expect_truth(sphere, index, rays);
    }
    EXPECT_GT(hits, 1000U);
}

TEST(CastRay, KeepsTheFirstOfManyHits)
{
    // A stack of squares, so that a ray has many hits.
    std::vector<Vec3> positions;
    std::vector<TriangleCorners> triangles;
    for (std::uint32_t i = 0; i < 50; ++i) {
        for (const Vec3& corner : {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)})
            positions.emplace_back(corner + Vec3(0, 0, (i * 7) % 50));
        triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
    }
    const TriangleMesh mesh = mesh_of(positions, triangles);
    const MeshIndex index = ray_index_of(mesh);
    const Ray ray{Vec3(0.25, 0.25, -1), Vec3::UnitZ()};
    const std::vector<RayHit> truth = all_hits_by_brute_force(mesh, ray);
    ASSERT_EQ(truth.size(), 50U);
    for (const std::size_t capacity : {0U, 1U, 7U, 49U, 50U, 60U}) {
        std::vector<RayHit> hits(capacity);
        EXPECT_EQ(all_hits(index, ray, hits), 50U);
        for (std::size_t i = 0; i < std::min<std::size_t>(capacity, 50); ++i)
            EXPECT_EQ(hits[i], truth[i]);
    }
    // A visitor may stop early, also where every triangle is tested for a ray from far away.
    for (const Ray& from : {ray, Ray{Vec3(0.25, 0.25, -0x1p90), Vec3::UnitZ()}}) {
        std::size_t calls = 0;
        visit_hits(index, from, Faces::both,
                   [&](const RayHit& /*hit*/) { return ++calls < 3 ? Flow::proceed : Flow::stop; });
        EXPECT_EQ(calls, 3U);
    }
}

TEST(CastRay, ReportsWhichRayOfABatchIsInvalid)
{
    const TriangleMesh cube = cube_mesh(Vec3::Zero(), 1.0);
    const MeshIndex index = ray_index_of(cube);
    // More than a chunk of them, that look alike.
    std::vector<Ray> rays(5000, Ray{Vec3(-5, 0, 0), Vec3::UnitX()});
    std::vector<std::optional<RayHit>> hits(rays.size());
    const auto any_memory = std::make_unique<bool[]>(rays.size());
    const std::span<bool> any_of_all(any_memory.get(), rays.size());
    ASSERT_TRUE(closest_hits(index, rays, hits));
    ASSERT_TRUE(any_hits(index, rays, any_of_all));
    const double nan = std::numeric_limits<double>::quiet_NaN();
    for (const Ray& bad :
         {Ray{Vec3::Zero(), Vec3::Zero()}, Ray{Vec3::Zero(), Vec3(nan, 0, 1)},
          Ray{Vec3(nan, 0, 0), Vec3::UnitX()}, Ray{Vec3::Zero(), Vec3::UnitX(), 2, 1},
          Ray{Vec3::Zero(), Vec3::UnitX(), nan, 1}, Ray{Vec3::Zero(), Vec3::UnitX(), 0, nan}}) {
        EXPECT_FALSE(closest_hit(index, bad));
        EXPECT_FALSE(any_hit(index, bad));
        EXPECT_TRUE(all_hits(index, bad).empty());
        EXPECT_FALSE(closest_hit_by_brute_force(cube, bad));
        for (const std::size_t number : {4700U, 2500U, 7U}) {
            rays[number] = bad;
            for (const int threads : {1, 2}) {
                const Status status =
                    closest_hits(index, rays, hits, {.execution = {.threads = {threads}}});
                ASSERT_FALSE(status);
                EXPECT_EQ(code_of(status), ErrorCode::invalid_argument);
                const std::string says = concat("ray ", number, " is none");
                EXPECT_NE(status.error().message.find(says), std::string::npos)
                    << status.error().message;
                const Status any =
                    any_hits(index, rays, any_of_all, {.execution = {.threads = {threads}}});
                ASSERT_FALSE(any);
                EXPECT_EQ(any.error().message, status.error().message);
                const auto lists = all_hits(index, rays, {.execution = {.threads = {threads}}});
                ASSERT_FALSE(lists);
                EXPECT_EQ(lists.error().message, status.error().message);
            }
        }
        for (const std::size_t number : {4700U, 2500U, 7U}) rays[number] = rays[0];
    }
    hits.pop_back();
    for (const std::size_t count : {3U, 5000U}) {
        const std::span<const Ray> some = std::span(rays).first(count);
        EXPECT_EQ(code_of(closest_hits(index, some, hits)), ErrorCode::invalid_argument);
        EXPECT_EQ(code_of(any_hits(index, some, any_of_all.first(4999))),
                  ErrorCode::invalid_argument);
    }
    EXPECT_FALSE(closest_hit(MeshIndex(), Ray{}));
}

TEST(CastRay, BatchesThatAreCancelledSaySo)
{
    const MeshIndex index = ray_index_of(cube_mesh(Vec3::Zero(), 1.0));
    const std::vector<Ray> rays(5000, Ray{Vec3(-5, 0, 0), Vec3::UnitX()});
    std::vector<std::optional<RayHit>> hits(rays.size());
    const auto any = std::make_unique<bool[]>(rays.size());
    const auto always = [] { return true; };
    cancel_at_every_stage(
        [&](Progress& progress) {
            return closest_hits(index, rays, hits, {.execution = {.progress = &progress}});
        },
        always);
    cancel_at_every_stage(
        [&](Progress& progress) {
            return any_hits(index, rays, {any.get(), rays.size()},
                            {.execution = {.progress = &progress}});
        },
        always);
    cancel_at_every_stage(
        [&](Progress& progress) {
            return all_hits(index, rays, {.execution = {.progress = &progress}});
        },
        always);
}

} // namespace
} // namespace proxima::cast_ray_test
