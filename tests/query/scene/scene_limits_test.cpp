// What scenes refuse, how they stop, and that queries neither allocate nor find what is not there.
#include "cancellation.h"
#include "code_of.h"
#include "counted_allocations.h"
#include "proxima/scene.h"
#include "query/scene/scenes_one_by_one.h"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <string_view>

namespace proxima::scene_limits_test {
namespace {

using namespace testing;

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
    EXPECT_EQ(code_of(closest_hits(scene, {}, hits)), ErrorCode::invalid_argument);
    hits.resize(3);
    const std::vector<Ray> bad = {{}, {.direction = Vec3(nan, 0, 0)}, {}};
    const auto cast = closest_hits(scene, bad, hits);
    ASSERT_FALSE(cast);
    EXPECT_EQ(code_of(cast), ErrorCode::invalid_argument);
    EXPECT_NE(cast.error().message.find("ray 1 "), std::string::npos) << cast.error().message;
    std::vector<std::optional<SceneFeature>> near(3);
    const std::vector<Vec3> no_point = {Vec3::Zero(), Vec3::Zero(), Vec3(0, nan, 0)};
    const auto found = closest_features(scene, no_point, near);
    ASSERT_FALSE(found);
    EXPECT_EQ(code_of(found), ErrorCode::invalid_argument);
    EXPECT_NE(found.error().message.find("point 2 "), std::string::npos) << found.error().message;
    const std::vector<Vec3> four(4, Vec3::Zero());
    EXPECT_EQ(code_of(closest_features(scene, four, near)), ErrorCode::invalid_argument);
    for (const double distance : {nan, -1.0, infinity}) {
        EXPECT_EQ(code_of(pairs_within(scene, distance)), ErrorCode::invalid_argument);
        EXPECT_EQ(code_of(overlapping_bounds(scene, distance)), ErrorCode::invalid_argument);
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
        EXPECT_EQ(code_of(scene), ErrorCode::invalid_argument);
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
    EXPECT_EQ(code_of(move_instances(Scene(), std::vector<RigidTransform>(1))),
              ErrorCode::invalid_argument);
    const std::vector<Instance> instances(1000);
    EXPECT_EQ(code_of(build_scene({&cube, 1}, instances, {{.budget = {1000}}})),
              ErrorCode::budget_exceeded);
    Scene scene = build_scene({&cube, 1}, instances).value();
    const std::vector<RigidTransform> poses(1000);
    EXPECT_EQ(code_of(move_instances(scene, poses, {{.budget = {1000}}})),
              ErrorCode::budget_exceeded);
    {
        const Scene copy = scene; // so that a move in place makes one too
        const Status moved = move_in_place(scene, std::vector<InstanceId>{id_of(1)},
                                           std::span(poses).first(1), {{.budget = {1000}}});
        ASSERT_FALSE(moved);
        EXPECT_EQ(code_of(moved), ErrorCode::budget_exceeded);
    }
    const auto pairs = pairs_in_contact(scene, {.execution = {.budget = {100000}}});
    ASSERT_FALSE(pairs);
    EXPECT_EQ(code_of(pairs), ErrorCode::budget_exceeded);
    const ViewVolume all = make_view_volume(std::vector<ViewPlane>{{}}).value();
    EXPECT_EQ(code_of(visible_ranges(scene, all, {.execution = {.budget = {1000}}})),
              ErrorCode::budget_exceeded);
    const std::vector<MeshIndex> shapes(1000, cube);
    EXPECT_EQ(code_of(build_scene(shapes, {}, {{.budget = {100'000}}})),
              ErrorCode::budget_exceeded);
}

TEST(Scene, CullingNamesTheInstanceInWhichAPlaneIsNotFinite)
{
    const MeshIndex cube = build_mesh_index(cube_mesh(Vec3::Zero(), 1)).value();
    std::vector<Instance> instances(30);
    for (std::size_t i = 0; i < instances.size(); ++i)
        instances[i].pose.translation = Vec3(3.0 * static_cast<double>(i), 0, 0);
    for (const std::size_t i : {2U, 7U}) instances[i].pose.translation = Vec3(1e9, 1e9, 0);
    const Scene scene = build_scene({&cube, 1}, instances).value();
    // Its distance from an origin at (1e9, 1e9, 0) is a difference of infinities.
    const ViewVolume volume =
        make_view_volume(std::vector<ViewPlane>{{Vec3(1e300, -1e300, 0), 0}}).value();
    const auto expect_named = [](const auto& seen) {
        ASSERT_FALSE(seen);
        EXPECT_EQ(code_of(seen), ErrorCode::invalid_argument);
        EXPECT_EQ(seen.error().where, "instance 2");
    };
    expect_named(visible_instances(scene, volume));
    expect_named(visible_ranges(scene, volume));
}

TEST(Scene, CountsTheShapesThatItHasMeasured)
{
    const RandomScene of = many_instances(10, 2);
    double most = 0;
    bool is_built = false;
    for (std::uint64_t reports = 1; !is_built; ++reports) {
        ASSERT_LT(reports, 1000U);
        Progress progress;
        progress.cancel_after(reports);
        is_built = build_scene(of.shapes, of.instances, {{.threads = {1}, .progress = &progress}})
                       .has_value();
        if (progress.stage() == std::string_view("measuring shapes"))
            most = std::max(most, progress.fraction());
    }
    EXPECT_EQ(most, 1);
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
    SceneGenerator random(9);
    SceneQueries query(of, random);
    std::vector<Vec3> points;
    std::vector<Ray> rays;
    for (int i = 0; i < 3000; ++i) {
        points.push_back(query.place());
        rays.push_back(query.ray());
    }
    std::vector<std::optional<SceneFeature>> near(points.size());
    cancel_at_every_stage(
        [&](Progress& progress) {
            return closest_features(scene, points, near, {.execution = {.progress = &progress}});
        },
        always);
    std::vector<std::optional<SceneHit>> hits(rays.size());
    cancel_at_every_stage(
        [&](Progress& progress) {
            return closest_hits(scene, rays, hits, {.execution = {.progress = &progress}});
        },
        always);
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

TEST(Scene, SaysHowMuchIsDone)
{
    const RandomScene of = many_instances(4000, 10);
    const Scene scene = build_scene(of.shapes, of.instances).value();
    SceneGenerator random(10);
    SceneQueries query(of, random);
    std::vector<Vec3> points;
    std::vector<Ray> rays;
    for (int i = 0; i < 2048; ++i) {
        points.push_back(query.place());
        rays.push_back(query.ray());
    }
    const auto on_one_thread = [](Progress& progress) {
        return Execution{.threads = {1}, .progress = &progress};
    };
    std::vector<std::optional<SceneFeature>> near(points.size());
    expect_even_progress("closest features", [&](Progress& progress) {
        return closest_features(scene, points, near, {.execution = on_one_thread(progress)});
    });
    std::vector<std::optional<SceneHit>> hits(rays.size());
    expect_even_progress("casting rays", [&](Progress& progress) {
        return closest_hits(scene, rays, hits, {.execution = on_one_thread(progress)});
    });
    const ViewVolume half = make_view_volume(std::vector<ViewPlane>{{Vec3::UnitX(), 0}}).value();
    expect_even_progress("culling instances", [&](Progress& progress) {
        return visible_ranges(scene, half, {.execution = on_one_thread(progress)});
    });
    std::vector<RigidTransform> poses;
    for (const Instance& instance : of.instances) poses.push_back(instance.pose);
    expect_even_progress("placing instances", [&](Progress& progress) {
        return move_instances(scene, poses, {on_one_thread(progress)});
    });
}

TEST(Scene, HasAsManyBytesAsItsInstancesNeed)
{
    const RandomScene of = many_instances(4000, 15);
    const Scene scene = build_scene(of.shapes, of.instances).value();
    EXPECT_GT(scene.bytes(), 4000 * (sizeof(Box) + sizeof(RigidTransform)));
    EXPECT_LT(scene.bytes(), 4000 * 700) << "what the memory budget counts";
}

} // namespace
} // namespace proxima::scene_limits_test
