#include "proxima/scene.h"

#include "base/simd.h"
#include "code_of.h"
#include "proxima/intersect_meshes.h"
#include "query/scene/scenes_one_by_one.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <gtest/gtest.h>
#include <memory>

namespace proxima::scene_test {
namespace {

using namespace testing;

std::uint32_t some_layers(SceneGenerator& random)
{
    return random.below(3) == 0 ? 1U << random.below(3) : all_layers;
}

/// A plane at this height along the normal only just touches one of the instances, but for roundings.
double most_along(const RandomScene& of, const Vec3& normal, SceneGenerator& random)
{
    const Instance& at = of.instances[random.below(of.instances.size())];
    const IndexParts& parts = of.shapes[at.shape].parts();
    double most = std::numeric_limits<double>::lowest();
    for (std::uint32_t row = 0; row < parts.triangle_count(); ++row) {
        for (const Vec3& corner : at.pose(parts.triangle(row)).vertices)
            most = std::max(most, normal.dot(corner));
    }
    return most;
}

/// All queries of a scene against all instances one by one. Returns how many found something.
struct Found {
    std::size_t rays = 0;
    std::size_t points = 0;
    std::size_t contacts = 0;
    std::size_t near = 0;
    std::size_t ranges = 0;
};

void expect_truth(const RandomScene& of, const Scene& scene, SceneGenerator& random, int queries,
                  Found& found)
{
    SceneQueries query(of, random);
    for (int i = 0; i < queries && !::testing::Test::HasFailure(); ++i) {
        SCOPED_TRACE(::testing::Message() << "query " << i);
        const Ray ray = query.ray();
        const SceneRayOptions options = {.faces = static_cast<Faces>(random.below(3)),
                                         .layers = some_layers(random)};
        const std::vector<SceneHit> truth = hits_one_by_one(of, ray, options);
        found.rays += truth.empty() ? 0U : 1U;
        const auto hit = closest_hit(scene, ray, options);
        ASSERT_EQ(hit.has_value(), !truth.empty());
        if (hit) {
            ASSERT_EQ(*hit, truth.front());
        }
        ASSERT_EQ(any_hit(scene, ray, options), !truth.empty());
        ASSERT_EQ(all_hits(scene, ray, options), truth);

        const Vec3 p = query.place();
        SceneFeatureOptions near = {.layers = some_layers(random)};
        if (random.below(3) == 0) near.radius = query.reach() * std::abs(random.unit());
        const auto closest = closest_one_by_one(of, p, near);
        found.points += closest ? 1U : 0U;
        ASSERT_TRUE(same(closest_feature(scene, p, near), closest)) << p.transpose();
    }
    const ScenePairOptions options = {.layers = some_layers(random), .others = some_layers(random)};
    const auto pairs = pairs_in_contact(scene, options).value();
    ASSERT_EQ(pairs, contacts_one_by_one(of, options));
    found.contacts += pairs.size();
    const double distance = query.reach() * std::abs(random.unit());
    const auto near = pairs_within(scene, distance, options).value();
    const auto truth = near_one_by_one(of, distance, options);
    for (const NearInstances& pair : truth) {
        ASSERT_TRUE(std::ranges::any_of(near,
                                        [&](const NearInstances& found_pair) {
                                            return found_pair.a == pair.a && found_pair.b == pair.b;
                                        }))
            << to_index(pair.a) << " and " << to_index(pair.b) << " are " << pair.nearest.distance
            << " apart, up to " << distance << " is wanted; boxes "
            << scene.bounds(pair.a).lower.transpose() << " to "
            << scene.bounds(pair.a).upper.transpose() << " and "
            << scene.bounds(pair.b).lower.transpose() << " to "
            << scene.bounds(pair.b).upper.transpose();
    }
    ASSERT_EQ(near.size(), truth.size());
    for (std::size_t i = 0; i < near.size(); ++i) {
        ASSERT_TRUE(near[i].a == truth[i].a && near[i].b == truth[i].b);
        ASSERT_EQ(near[i].nearest.distance, truth[i].nearest.distance);
        ASSERT_EQ(near[i].nearest.triangle_a, truth[i].nearest.triangle_a);
        ASSERT_EQ(near[i].nearest.triangle_b, truth[i].nearest.triangle_b);
        ASSERT_EQ(near[i].point_a, truth[i].point_a);
        ASSERT_EQ(near[i].point_b, truth[i].point_b);
    }
    found.near += near.size();
    for (int i = 0; i < 4; ++i) {
        std::vector<ViewPlane> planes(1 + random.below(6));
        for (ViewPlane& plane : planes) {
            plane.normal = random.below(3) == 0 ? Vec3::Unit(static_cast<int>(random.below(3)))
                                                : random.vector();
            plane.offset = random.below(2) == 0 ? -plane.normal.dot(query.place())
                                                : -most_along(of, plane.normal, random);
        }
        const ViewVolume volume = make_view_volume(planes).value();
        const SceneCullOptions cull = {.mode = random.below(2) == 0 ? CullMode::conservative
                                                                    : CullMode::exact,
                                       .layers = some_layers(random)};
        const auto ranges = visible_ranges(scene, volume, cull).value();
        ASSERT_EQ(ranges, ranges_one_by_one(of, volume, cull));
        std::vector<InstanceId> seen;
        for (const InstanceRange& range : ranges)
            if (seen.empty() || seen.back() != range.instance) seen.push_back(range.instance);
        ASSERT_EQ(visible_instances(scene, volume, cull).value(), seen);
        found.ranges += ranges.size();
    }
}

TEST(Scene, AnswersLikeAllInstancesOneByOne)
{
    Found found;
    for (std::uint64_t seed = 1; seed <= 100; ++seed) {
        SCOPED_TRACE(::testing::Message() << "seed " << seed);
        SceneGenerator random(seed);
        const RandomScene of = random(seed % 10 == 0 ? 300 : 40);
        const auto scene = build_scene(of.shapes, of.instances);
        ASSERT_TRUE(scene) << describe(scene.error());
        expect_truth(of, *scene, random, 60, found);
        if (HasFailure()) return;
    }
    EXPECT_GT(found.rays, 1500U);
    EXPECT_GT(found.points, 3000U);
    EXPECT_GT(found.contacts, 1000U);
    EXPECT_GT(found.near, 1500U);
    EXPECT_GT(found.ranges, 1500U);
}

TEST(Scene, AnswersAlikeAfterInstancesMoved)
{
    Found found;
    for (std::uint64_t seed = 1; seed <= 24; ++seed) {
        SCOPED_TRACE(::testing::Message() << "seed " << seed);
        SceneGenerator random(seed);
        RandomScene of = random(40);
        // Now and then far apart beside their size.
        const double reach = of.size > 0 && seed % 8 != 7 ? of.size : 1e-3;
        Scene scene = build_scene(of.shapes, of.instances).value();
        for (int step = 0; step < 3; ++step) {
            std::vector<RigidTransform> poses;
            for (Instance& instance : of.instances) {
                if (random.below(2) == 0) {
                    instance.pose.rotation = random.rotation();
                    instance.pose.translation = of.center + reach * random.vector();
                }
                poses.push_back(instance.pose);
            }
            const auto moved = move_instances(scene, poses);
            ASSERT_TRUE(moved) << describe(moved.error());
            scene = *moved;
            expect_truth(of, scene, random, 20, found);
            if (HasFailure()) return;
        }
    }
    EXPECT_GT(found.rays, 300U);
}

TEST(Scene, AnswersAlikeAfterSomeInstancesMovedAndItsCopiesDidNot)
{
    Found found;
    for (std::uint64_t seed = 1; seed <= 24; ++seed) {
        SCOPED_TRACE(::testing::Message() << "seed " << seed);
        SceneGenerator random(seed);
        RandomScene of = random(60);
        const double reach = of.size > 0 ? of.size : 1e-3;
        Scene scene = build_scene(of.shapes, of.instances).value();
        for (int step = 0; step < 4; ++step) {
            const RandomScene old = of;
            const std::optional<Scene> copy = step % 2 == 0 ? std::optional(scene) : std::nullopt;
            std::vector<InstanceId> ids;
            std::vector<RigidTransform> poses;
            for (std::uint64_t left = of.instances.size() / 10 + 1; left > 0; --left) {
                const std::uint64_t id = random.below(of.instances.size());
                RigidTransform& pose = of.instances[id].pose;
                pose.rotation = random.rotation();
                // Now and then beyond the box of all.
                pose.translation = of.center + (step == 3 ? 3 : 0.8) * reach * random.vector();
                ids.push_back(id_of(id));
                poses.push_back(pose);
            }
            const Status moved = move_in_place(scene, ids, poses);
            ASSERT_TRUE(moved) << describe(moved.error());
            expect_truth(of, scene, random, 20, found);
            if (copy) expect_truth(old, *copy, random, 5, found);
            if (HasFailure()) return;
        }
    }
    EXPECT_GT(found.rays, 400U);
}

TEST(Scene, FindsWhereBoundsOverlap)
{
    for (std::uint64_t seed = 1; seed <= 40; ++seed) {
        SCOPED_TRACE(::testing::Message() << "seed " << seed);
        SceneGenerator random(seed);
        const RandomScene of = random(200);
        const Scene scene = build_scene(of.shapes, of.instances).value();
        std::vector<InstancePair> truth;
        for_wanted_pairs(of, {}, [&](std::size_t i, std::size_t j) {
            const Box a = scene.bounds(id_of(i));
            const Box b = scene.bounds(id_of(j));
            if (a.empty() || b.empty() || (a.lower.array() > b.upper.array()).any() ||
                (b.lower.array() > a.upper.array()).any())
                return;
            truth.push_back({id_of(i), id_of(j)});
        });
        EXPECT_EQ(overlapping_bounds(scene).value(), truth);
        const double distance = of.size * std::abs(random.unit());
        std::vector<InstancePair> near_truth;
        for_wanted_pairs(of, {}, [&](std::size_t i, std::size_t j) {
            const Box a = scene.bounds(id_of(i));
            const Box b = scene.bounds(id_of(j));
            if (a.empty() || b.empty()) return;
            const Vec3 gap = (a.lower - b.upper).cwiseMax(b.lower - a.upper).cwiseMax(0.0);
            if (gap.stableNorm() <= distance) near_truth.push_back({id_of(i), id_of(j)});
        });
        EXPECT_EQ(overlapping_bounds(scene, distance).value(), near_truth);
        const Box box = scene.bounds(id_of(random.below(of.instances.size())));
        std::vector<InstanceId> near;
        visit_instances(scene, box, all_layers, [&](InstanceId id) {
            near.push_back(id);
            return Flow::proceed;
        });
        std::ranges::sort(near);
        std::vector<InstanceId> expected;
        for (std::size_t i = 0; i < of.instances.size(); ++i) {
            const Box own = scene.bounds(id_of(i));
            if (!own.empty() && !box.empty() && (own.lower.array() <= box.upper.array()).all() &&
                (box.lower.array() <= own.upper.array()).all())
                expected.push_back(id_of(i));
        }
        EXPECT_EQ(near, expected);
    }
}

TEST(Scene, BoundsThatTouchOverlap)
{
    const MeshIndex cube = build_mesh_index(cube_mesh(Vec3::Zero(), 1)).value();
    for (const int side : {1, -1}) {
        SCOPED_TRACE(side);
        std::vector<Instance> instances(2);
        Scene scene;
        double gap = 1;
        for (int i = 0; i < 100 && gap != 0; ++i) {
            instances[1].pose.translation.x() -= side * gap;
            scene = build_scene({&cube, 1}, instances).value();
            const Box still = scene.bounds(id_of(0));
            const Box moved = scene.bounds(id_of(1));
            gap = side > 0 ? moved.lower.x() - still.upper.x() : still.lower.x() - moved.upper.x();
        }
        ASSERT_EQ(gap, 0);
        EXPECT_EQ(overlapping_bounds(scene).value().size(), 1U);
        for (const bool above : {false, true}) {
            Box beside = scene.bounds(id_of(0));
            (above ? beside.lower : beside.upper).x() = above ? beside.upper.x() : beside.lower.x();
            (above ? beside.upper : beside.lower).x() += above ? 0.5 : -0.5;
            int met = 0;
            visit_instances(scene, beside, all_layers, [&](InstanceId id) {
                met += id == id_of(0) ? 1 : 0;
                return Flow::proceed;
            });
            EXPECT_EQ(met, 1) << above;
        }
        instances[1].pose.translation.x() += side * 1e-9;
        scene = build_scene({&cube, 1}, instances).value();
        EXPECT_TRUE(overlapping_bounds(scene).value().empty());
    }
}

TEST(Scene, BoundsHoldEveryMovedVertex)
{
    for (std::uint64_t seed = 1; seed <= 60; ++seed) {
        SCOPED_TRACE(::testing::Message() << "seed " << seed);
        SceneGenerator random(seed);
        const RandomScene of = random(20);
        const Scene scene = build_scene(of.shapes, of.instances).value();
        for (std::size_t i = 0; i < of.instances.size(); ++i) {
            const Instance& at = of.instances[i];
            const Box box = scene.bounds(id_of(i));
            EXPECT_EQ(scene.instance(id_of(i)).pose.translation, at.pose.translation);
            EXPECT_EQ(scene.instance(id_of(i)).shape, at.shape);
            EXPECT_EQ(scene.instance(id_of(i)).layers, at.layers);
            const IndexParts& parts = of.shapes[at.shape].parts();
            EXPECT_EQ(box.empty(), parts.triangle_count() == 0);
            if (box.empty()) continue;
            Box tight;
            double reach = at.pose.translation.norm();
            for (std::uint32_t row = 0; row < parts.triangle_count(); ++row) {
                for (const Vec3& corner : at.pose(parts.triangle(row)).vertices) {
                    EXPECT_TRUE(box.contains(corner));
                    tight.extend(corner);
                }
                for (const Vec3& corner : parts.triangle(row).vertices)
                    reach = std::max(reach, corner.norm());
            }
            // Turned boxes of parts are larger, but not by much.
            const double slack = 1e-12 * reach + 1e-300;
            EXPECT_LE(box.extent().stableNorm(), 2 * tight.extent().stableNorm() + slack);
        }
    }
}

TEST(Scene, AnswersThousandsOfInstancesLikeOneByOne)
{
    constexpr std::uint64_t seed = 7;
    const RandomScene of = many_instances(3000, seed);
    const Scene scene = build_scene(of.shapes, of.instances).value();
    SceneGenerator random(seed);
    Found found;
    expect_truth(of, scene, random, 200, found);
    EXPECT_GT(found.contacts, 20U);
}

// Half a minute and 400 MB, so not in the suite: scripts/soak scene.
TEST(Scene, DISABLED_AnswersAMillionInstances)
{
    constexpr std::uint64_t seed = 11;
    RandomScene of = many_instances(1'000'000, seed);
    SceneGenerator random(seed);
    const auto seconds_since = [](std::chrono::steady_clock::time_point start) {
        return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    };
    auto start = std::chrono::steady_clock::now();
    const Scene built = build_scene(of.shapes, of.instances).value();
    std::printf("building %.3g s, %.3g bytes an instance\n", seconds_since(start),
                1e-6 * static_cast<double>(built.bytes()));
    std::vector<RigidTransform> poses;
    for (Instance& instance : of.instances) {
        instance.pose.translation += 0.1 * random.vector();
        poses.push_back(instance.pose);
    }
    start = std::chrono::steady_clock::now();
    const Scene scene = move_instances(built, poses).value();
    std::printf("moving %.3g s\n", seconds_since(start));
    SceneQueries query(of, random);
    for (int i = 0; i < 3; ++i) {
        const Ray ray = query.ray();
        EXPECT_EQ(all_hits(scene, ray), hits_one_by_one(of, ray, {})) << i;
        const Vec3 p = query.place();
        EXPECT_TRUE(same(closest_feature(scene, p), closest_one_by_one(of, p, {}))) << i;
    }
    start = std::chrono::steady_clock::now();
    const auto pairs = pairs_in_contact(scene).value();
    std::printf("%zu pairs in contact, %.3g s\n", pairs.size(), seconds_since(start));
    EXPECT_GT(pairs.size(), 1000U);
    // All pairs of the first instances.
    std::vector<InstancePair> first;
    for (const InstancePair& pair : pairs)
        if (to_index(pair.b) < 2000) first.push_back(pair);
    of.instances.resize(2000);
    EXPECT_EQ(first, contacts_one_by_one(of, {}));
}

TEST(Scene, IsTheSameWithEveryInstructionSet)
{
    constexpr std::uint64_t seed = 8;
    const RandomScene of = many_instances(500, seed);
    const Scene scene = build_scene(of.shapes, of.instances).value();
    for (const SimdTarget& target : simd_targets()) {
        SCOPED_TRACE(target.name);
        force_simd_target(target);
        SceneGenerator random(seed);
        Found found;
        expect_truth(of, scene, random, 150, found);
        const Scene own = build_scene(of.shapes, of.instances).value();
        for (std::size_t i = 0; i < of.instances.size(); ++i) {
            EXPECT_EQ(own.bounds(id_of(i)).lower, scene.bounds(id_of(i)).lower);
            EXPECT_EQ(own.bounds(id_of(i)).upper, scene.bounds(id_of(i)).upper);
        }
        restore_simd_targets();
        EXPECT_GT(found.rays, 40U);
    }
}

TEST(Scene, IsTheSameForAnyNumberOfThreads)
{
    constexpr std::uint64_t seed = 3;
    const RandomScene of = many_instances(5000, seed);
    const Scene one = build_scene(of.shapes, of.instances, {{.threads = {1}}}).value();
    const Scene many = build_scene(of.shapes, of.instances, {{.threads = {3}}}).value();
    for (std::size_t i = 0; i < of.instances.size(); ++i) {
        EXPECT_EQ(one.bounds(id_of(i)).lower, many.bounds(id_of(i)).lower);
        EXPECT_EQ(one.bounds(id_of(i)).upper, many.bounds(id_of(i)).upper);
    }
    SceneGenerator random(seed);
    SceneQueries query(of, random);
    std::vector<Ray> rays;
    std::vector<Vec3> points;
    for (int i = 0; i < 2000; ++i) {
        rays.push_back(query.ray());
        points.push_back(query.place());
    }
    std::vector<std::optional<SceneHit>> hits(rays.size());
    std::vector<std::optional<SceneHit>> other_hits(rays.size());
    ASSERT_TRUE(closest_hits(one, rays, hits, {.execution = {.threads = {1}}}));
    ASSERT_TRUE(closest_hits(many, rays, other_hits, {.execution = {.threads = {3}}}));
    EXPECT_EQ(hits, other_hits);
    std::vector<std::optional<SceneFeature>> near(points.size());
    std::vector<std::optional<SceneFeature>> other_near(points.size());
    ASSERT_TRUE(closest_features(one, points, near, {.execution = {.threads = {1}}}));
    ASSERT_TRUE(closest_features(many, points, other_near, {.execution = {.threads = {3}}}));
    for (std::size_t i = 0; i < points.size(); ++i) {
        EXPECT_TRUE(same(near[i], other_near[i])) << i;
        EXPECT_TRUE(same(near[i], closest_feature(one, points[i]))) << i;
    }
    EXPECT_EQ(pairs_in_contact(one, {.execution = {.threads = {1}}}).value(),
              pairs_in_contact(many, {.execution = {.threads = {3}}}).value());
    const ViewVolume half = make_view_volume(std::vector<ViewPlane>{{Vec3::UnitX(), 0}}).value();
    const auto ranges = visible_ranges(one, half, {.execution = {.threads = {1}}}).value();
    EXPECT_GT(ranges.size(), 2000U);
    EXPECT_EQ(ranges, visible_ranges(many, half, {.execution = {.threads = {3}}}).value());
}

TEST(Scene, AnswersManyRaysLikeSingleOnes)
{
    constexpr std::uint64_t seed = 4;
    const RandomScene of = many_instances(2000, seed);
    const Scene scene = build_scene(of.shapes, of.instances).value();
    SceneGenerator random(seed);
    SceneQueries query(of, random);
    std::vector<Ray> rays;
    for (int i = 0; i < 1500; ++i) rays.push_back(query.ray());
    for (const int threads : {1, 3}) {
        const SceneRayOptions options = {
            .faces = Faces::front, .layers = 5, .execution = {.threads = {threads}}};
        const auto any = std::make_unique<bool[]>(rays.size());
        ASSERT_TRUE(any_hits(scene, rays, {any.get(), rays.size()}, options));
        const auto lists = all_hits(scene, rays, options);
        ASSERT_TRUE(lists) << describe(lists.error());
        ASSERT_EQ(lists->first.size(), rays.size() + 1);
        std::vector<SceneHit> truth;
        for (std::size_t i = 0; i < rays.size(); ++i) {
            ASSERT_EQ(lists->first[i], truth.size());
            const auto hits = all_hits(scene, rays[i], options);
            ASSERT_EQ(any[i], !hits.empty()) << i;
            truth.insert(truth.end(), hits.begin(), hits.end());
        }
        EXPECT_EQ(lists->first.back(), truth.size());
        EXPECT_EQ(lists->hits, truth);
        EXPECT_GT(truth.size(), rays.size() / 4);
    }
    EXPECT_EQ(all_hits(scene, std::span<const Ray>()).value().first, std::vector<std::size_t>{0});
    EXPECT_EQ(code_of(all_hits(scene, rays, {.execution = {.budget = {20'000}}})),
              ErrorCode::budget_exceeded);
    EXPECT_EQ(code_of(all_hits(scene, rays, {.execution = {.budget = {1000}}})),
              ErrorCode::budget_exceeded);
    rays[7].direction.setZero();
    const auto wrong = all_hits(scene, rays);
    ASSERT_FALSE(wrong);
    EXPECT_NE(wrong.error().message.find("ray 7"), std::string::npos) << wrong.error().message;
    std::array<bool, 2> too_few{};
    EXPECT_EQ(code_of(any_hits(scene, rays, too_few)), ErrorCode::invalid_argument);
}

} // namespace
} // namespace proxima::scene_test
