#include "proxima/scene.h"

#include "base/simd.h"
#include "cancellation.h"
#include "counted_allocations.h"
#include "proxima/intersect_meshes.h"
#include "query/scene/scenes_one_by_one.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <gtest/gtest.h>
#include <memory>

namespace proxima {
namespace {

using namespace testing;

std::uint32_t some_layers(SceneGenerator& random)
{
    return random.below(3) == 0 ? 1U << random.below(3) : all_layers;
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
            plane.offset = -plane.normal.dot(query.place());
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
            Box tight;
            for (std::uint32_t row = 0; row < parts.triangle_count(); ++row) {
                for (const Vec3& corner : at.pose(parts.triangle(row)).vertices) {
                    EXPECT_TRUE(box.contains(corner));
                    tight.extend(corner);
                }
            }
        }
    }
}

/// Ten thousand instances of some shapes, a tenth of their boxes overlapping others.
RandomScene many_instances(std::size_t count, std::uint64_t seed)
{
    SceneGenerator random(seed);
    RandomScene of;
    of.shapes = {build_mesh_index(sphere_mesh(Vec3::Zero(), 0.5, 8, 12)).value(),
                 build_mesh_index(torus_mesh(0.4, 0.15, 12, 8)).value(),
                 build_mesh_index(cube_mesh(Vec3::Zero(), 0.3)).value()};
    of.size = std::cbrt(static_cast<double>(count));
    for (std::size_t i = 0; i < count; ++i) {
        Instance instance;
        instance.shape = static_cast<std::uint32_t>(random.below(3));
        instance.pose.rotation = random.rotation();
        instance.pose.translation = of.size * random.vector();
        instance.layers = 1U << (i % 4);
        of.instances.push_back(instance);
    }
    return of;
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
    EXPECT_EQ(all_hits(scene, rays, {.execution = {.budget = {20'000}}}).error().code,
              ErrorCode::budget_exceeded);
    EXPECT_EQ(all_hits(scene, rays, {.execution = {.budget = {1000}}}).error().code,
              ErrorCode::budget_exceeded);
    rays[7].direction.setZero();
    const auto wrong = all_hits(scene, rays);
    ASSERT_FALSE(wrong);
    EXPECT_NE(wrong.error().message.find("ray 7"), std::string::npos) << wrong.error().message;
    std::array<bool, 2> too_few{};
    EXPECT_EQ(any_hits(scene, rays, too_few).error().code, ErrorCode::invalid_argument);
}

TEST(Scene, QueriesDoNotAllocate)
{
    const RandomScene of = many_instances(2000, 5);
    const Scene scene = build_scene(of.shapes, of.instances).value();
    SceneGenerator random(5);
    SceneQueries query(of, random);
    std::size_t found = 0;
    for (int i = 0; i < 500; ++i) {
        const Ray ray = query.ray();
        const Vec3 p = query.place();
        const Box box = scene.bounds(id_of(static_cast<std::size_t>(i)));
        const std::size_t before = allocation_count();
        found += closest_hit(scene, ray) ? 1U : 0U;
        found += any_hit(scene, ray) ? 1U : 0U;
        found += closest_feature(scene, p) ? 1U : 0U;
        visit_instances(scene, box, all_layers, [&](InstanceId /*id*/) {
            ++found;
            return Flow::proceed;
        });
        visit_hits(scene, ray, {}, [&](const SceneHit& /*hit*/) {
            ++found;
            return Flow::proceed;
        });
        ASSERT_EQ(allocation_count(), before);
    }
    EXPECT_GT(found, 1500U);
}

TEST(Scene, VisitorsEndASearch)
{
    const MeshIndex cube = build_mesh_index(cube_mesh(Vec3::Zero(), 1)).value();
    std::vector<Instance> instances(20);
    const Scene scene = build_scene({&cube, 1}, instances).value();
    int visited = 0;
    visit_hits(
        scene, {.origin = Vec3(-3, 0.1, 0.2), .direction = Vec3::UnitX()}, {},
        [&](const SceneHit& /*hit*/) { return ++visited == 3 ? Flow::stop : Flow::proceed; });
    EXPECT_EQ(visited, 3);
    visited = 0;
    visit_instances(scene, {Vec3::Zero(), Vec3::Ones()}, all_layers,
                    [&](InstanceId /*id*/) { return ++visited == 3 ? Flow::stop : Flow::proceed; });
    EXPECT_EQ(visited, 3);
}

TEST(Scene, WithoutInstancesFindsNothing)
{
    const ViewVolume all = make_view_volume(std::vector<ViewPlane>{{}}).value();
    const MeshIndex none;
    const std::vector<Instance> of_nothing(3);
    for (const Scene& scene :
         {Scene(), build_scene({}, {}).value(), build_scene({&none, 1}, of_nothing).value(),
          move_instances(Scene(), {}).value()}) {
        EXPECT_FALSE(closest_hit(scene, {}));
        EXPECT_FALSE(any_hit(scene, {}));
        EXPECT_FALSE(closest_feature(scene, Vec3::Zero()));
        EXPECT_TRUE(pairs_in_contact(scene).value().empty());
        EXPECT_TRUE(pairs_within(scene, 1e9).value().empty());
        EXPECT_TRUE(visible_instances(scene, all).value().empty());
        visit_instances(scene, {Vec3::Zero(), Vec3::Ones()}, all_layers, [](InstanceId /*id*/) {
            ADD_FAILURE() << "an instance of nothing";
            return Flow::stop;
        });
    }
    EXPECT_TRUE(build_scene({&none, 1}, of_nothing).value().bounds(id_of(2)).empty());
}

TEST(Scene, QueriesThatAreNoneFindNothing)
{
    const MeshIndex cube = build_mesh_index(cube_mesh(Vec3::Zero(), 1)).value();
    const std::vector<Instance> instances(2);
    const Scene scene = build_scene({&cube, 1}, instances).value();
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    constexpr double infinity = std::numeric_limits<double>::infinity();
    EXPECT_FALSE(closest_hit(scene, {.direction = Vec3::Zero()}));
    EXPECT_FALSE(closest_hit(scene, {.origin = Vec3(nan, 0, 0)}));
    EXPECT_FALSE(any_hit(scene, {.t_min = 2, .t_max = 1}));
    EXPECT_FALSE(closest_feature(scene, Vec3(infinity, 0, 0)));
    EXPECT_FALSE(closest_feature(scene, Vec3::Zero(), {.radius = nan}));
    EXPECT_FALSE(closest_feature(scene, Vec3::Zero(), {.radius = -1}));
    EXPECT_TRUE(closest_hit(scene, {}));
    EXPECT_TRUE(closest_feature(scene, Vec3(1e300, 0, 0)));
    std::vector<std::optional<SceneHit>> hits(1);
    const std::vector<Ray> bad = {{.direction = Vec3(nan, 0, 0)}};
    EXPECT_EQ(closest_hits(scene, bad, hits).error().code, ErrorCode::invalid_argument);
    EXPECT_EQ(closest_hits(scene, {}, hits).error().code, ErrorCode::invalid_argument);
    std::vector<std::optional<SceneFeature>> near(1);
    const std::vector<Vec3> no_point = {Vec3(0, nan, 0)};
    EXPECT_EQ(closest_features(scene, no_point, near).error().code, ErrorCode::invalid_argument);
    for (const double distance : {nan, -1.0, infinity}) {
        EXPECT_EQ(pairs_within(scene, distance).error().code, ErrorCode::invalid_argument);
        EXPECT_EQ(overlapping_bounds(scene, distance).error().code, ErrorCode::invalid_argument);
    }
}

TEST(Scene, RefusesInstancesThatAreNone)
{
    const MeshIndex cube = build_mesh_index(cube_mesh(Vec3::Zero(), 1)).value();
    const auto expect_refused = [&](const Instance& wrong, const char* says) {
        std::vector<Instance> instances(5);
        instances[3] = instances[4] = wrong;
        const auto scene = build_scene({&cube, 1}, instances);
        ASSERT_FALSE(scene) << says;
        EXPECT_EQ(scene.error().code, ErrorCode::invalid_argument);
        EXPECT_EQ(scene.error().where, "instance 3");
        EXPECT_NE(scene.error().message.find(says), std::string::npos) << scene.error().message;
        if (wrong.shape != 0) return;
        std::vector<RigidTransform> poses(5);
        poses[3] = wrong.pose;
        const auto moved =
            move_instances(build_scene({&cube, 1}, std::vector<Instance>(5)).value(), poses);
        ASSERT_FALSE(moved) << says;
        EXPECT_EQ(moved.error().where, "instance 3");
    };
    expect_refused({.shape = 1}, "shape");
    expect_refused({.pose = {2 * Mat3::Identity(), Vec3::Zero()}}, "rigid");
    expect_refused({.pose = {-Mat3::Identity(), Vec3::Zero()}}, "mirrors");
    expect_refused({.pose = {Mat3::Constant(std::nan("")), Vec3::Zero()}}, "finite");
    expect_refused({.pose = {Mat3::Identity(), Vec3::Constant(HUGE_VAL)}}, "finite");
    expect_refused({.pose = {Mat3::Identity(), Vec3(0, 1e300, 0)}}, "2^500");
    EXPECT_EQ(move_instances(Scene(), std::vector<RigidTransform>(1)).error().code,
              ErrorCode::invalid_argument);
    const std::vector<Instance> instances(1000);
    EXPECT_EQ(build_scene({&cube, 1}, instances, {{.budget = {1000}}}).error().code,
              ErrorCode::budget_exceeded);
    const Scene scene = build_scene({&cube, 1}, instances).value();
    const auto pairs = pairs_in_contact(scene, {.execution = {.budget = {100000}}});
    ASSERT_FALSE(pairs);
    EXPECT_EQ(pairs.error().code, ErrorCode::budget_exceeded);
    const ViewVolume all = make_view_volume(std::vector<ViewPlane>{{}}).value();
    EXPECT_EQ(visible_ranges(scene, all, {.execution = {.budget = {1000}}}).error().code,
              ErrorCode::budget_exceeded);
    const std::vector<MeshIndex> shapes(1000, cube);
    EXPECT_EQ(build_scene(shapes, {}, {{.budget = {100'000}}}).error().code,
              ErrorCode::budget_exceeded);
}

TEST(Scene, StopsOnRequest)
{
    const RandomScene of = many_instances(4000, 9);
    const Scene scene = build_scene(of.shapes, of.instances).value();
    const auto always = [] { return true; };
    std::vector<RigidTransform> poses;
    for (const Instance& instance : of.instances) poses.push_back(instance.pose);
    cancel_at_every_stage(
        [&](Progress& progress) {
            return build_scene(of.shapes, of.instances, {{.progress = &progress}});
        },
        always);
    cancel_at_every_stage(
        [&](Progress& progress) { return move_instances(scene, poses, {{.progress = &progress}}); },
        always);
    cancel_at_every_stage(
        [&](Progress& progress) {
            return pairs_in_contact(scene, {.execution = {.progress = &progress}});
        },
        always);
    const std::vector<Ray> rays(1000);
    cancel_at_every_stage(
        [&](Progress& progress) {
            return all_hits(scene, rays, {.execution = {.progress = &progress}});
        },
        always);
    const ViewVolume half = make_view_volume(std::vector<ViewPlane>{{Vec3::UnitX(), 0}}).value();
    cancel_at_every_stage(
        [&](Progress& progress) {
            return visible_ranges(scene, half, {.execution = {.progress = &progress}});
        },
        always);
}

} // namespace
} // namespace proxima
