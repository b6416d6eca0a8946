// What a scene keeps of its objects from tick to tick changes no answer: sessions of octrees, whose
// surfaces are kept, beside sessions of bodies that look at every triangle in every question.
#include "counted_allocations.h"
#include "haptics/force/surface_renderer.h"
#include "haptics/scene/object_cache.h"
#include "haptics/scene/object_trajectory.h"
#include "haptics/scene/touch_access.h"
#include "haptics/scenes_to_touch.h"
#include "haptics/surface/contact_surface.h"
#include "index/listed_index.h"
#include "proxima/device.h"
#include "proxima/haptic_renderer.h"
#include "proxima/touch_scene.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <random>
#include <set>
#include <string>
#include <vector>

namespace proxima::scene_cache_test {
namespace {

using namespace testing;

constexpr double tick_seconds = 1e-3;

enum class Words { smooth, jumps, mixed };

/// A kind of scene, and who touches it.
struct Session {
    std::string name;
    std::vector<std::string> meshes;
    Words words = Words::smooth;
    double seconds = 0.05; ///< of a word, at most
    double spread = 0.8;   ///< where objects go, in the mesh's unit
    Vec3 middle = Vec3::Zero();
    double radius = 0;
    double friction = 0;
    bool exchanges = false;
};

TriangleMesh named_mesh(const std::string& name)
{
    if (name == "plate") return thin_plate();
    if (name == "sheet") return bumpy_sheet(10);
    if (name == "soup") return triangle_soup(5, 60);
    return *sample_mesh(name);
}

/// Two scenes that hear the same words: one that keeps what is near, one that keeps nothing.
class TwinScenes {
public:
    TwinScenes(const Session& session, std::uint32_t seed)
        : session_(session), random_(seed), fast_(room()), slow_(room())
    {
        for (const std::string& name : session.meshes) {
            const RigidTransform pose = any_pose();
            objects_.push_back(*fast_.add(body_of(named_mesh(name)), pose));
            (void)*slow_.add(every_triangle_of(name), pose);
        }
    }

    [[nodiscard]] TouchScene& fast() { return fast_; }
    [[nodiscard]] TouchScene& slow() { return slow_; }
    [[nodiscard]] std::span<const ObjectId> objects() const { return objects_; }
    [[nodiscard]] std::mt19937& random() { return random_; }
    double number() { return std::uniform_real_distribution<double>(-1, 1)(random_); }
    Vec3 vector()
    {
        const double x = number();
        const double y = number();
        return {x, y, number()};
    }

    /// What an application says before a tick.
    void say()
    {
        for (const ObjectId object : objects_) {
            if (random_() % 25 == 0) {
                const bool jumps = session_.words == Words::jumps ||
                                   (session_.words == Words::mixed && random_() % 4 == 0);
                ObjectMotion motion;
                motion.pose = any_pose();
                motion.seconds = jumps ? 0 : session_.seconds * std::abs(number());
                if (random_() % 3 == 0) {
                    motion.velocity = vector();
                    motion.spin = 3 * vector();
                    motion.coast_seconds = 0.05;
                }
                EXPECT_TRUE(fast_.move(object, motion));
                EXPECT_TRUE(slow_.move(object, motion));
            }
            if (session_.exchanges && random_() % 300 == 0) {
                const std::string& name = session_.meshes[random_() % session_.meshes.size()];
                EXPECT_TRUE(fast_.exchange(object, body_of(named_mesh(name))));
                EXPECT_TRUE(slow_.exchange(object, every_triangle_of(name)));
            }
        }
    }

private:
    [[nodiscard]] Box room() const
    {
        return {session_.middle - Vec3::Constant(20), session_.middle + Vec3::Constant(20)};
    }
    static TouchBody every_triangle_of(const std::string& name)
    {
        return body_of(named_mesh(name), {}, BodySearch::every_triangle);
    }
    RigidTransform any_pose()
    {
        const double angle = 3 * number();
        const Vec3 axis = vector();
        return posed(angle, axis, session_.middle + session_.spread * vector());
    }

    const Session& session_;
    std::mt19937 random_;
    TouchScene fast_;
    TouchScene slow_;
    std::vector<ObjectId> objects_;
};

/// A hand that goes with one object or another, over it and into it.
class HandOnObjects {
public:
    HandOnObjects(const Session& session, std::uint32_t seed) : at_(session.middle)
    {
        for (const std::string& name : session.meshes) meshes_.push_back(named_mesh(name));
        for (const TriangleMesh& mesh : meshes_) paths_.emplace_back(mesh, ++seed);
    }

    Vec3 next(TwinScenes& scenes)
    {
        if (left_ == 0) {
            left_ = 20 + scenes.random()() % 60;
            object_ = scenes.random()() % paths_.size();
        }
        --left_;
        const RigidTransform pose = scenes.slow().pose(scenes.objects()[object_]);
        at_ += 0.3 * (pose(paths_[object_].next()) - at_);
        return at_;
    }

private:
    std::vector<TriangleMesh> meshes_;
    std::vector<HandPath> paths_;
    Vec3 at_;
    std::size_t object_ = 0;
    std::uint64_t left_ = 0;
};

std::vector<Session> sessions()
{
    const std::vector<std::string> several = {"torus:12x8", "cube", "plate", "icosphere:1"};
    const Vec3 far(3e5, -2e5, 1e5);
    return {
        {.name = "slow", .meshes = {"torus:24x12", "cube"}, .seconds = 1, .friction = 0.4},
        {.name = "slow sphere", .meshes = several, .seconds = 1, .radius = 0.02, .friction = 0.4},
        {.name = "fast", .meshes = several, .words = Words::mixed, .friction = 0.5},
        {.name = "fast sphere", .meshes = several, .words = Words::mixed, .radius = 0.03},
        {.name = "jumps", .meshes = several, .words = Words::jumps, .spread = 1.5},
        {.name = "meeting", .meshes = {"sheet", "soup", "cube"}, .spread = 0.3, .radius = 0.01},
        {.name = "identical",
         .meshes = {"icosphere:2", "icosphere:2", "icosphere:2"},
         .seconds = 0.2,
         .friction = 0.4},
        {.name = "far away",
         .meshes = several,
         .words = Words::mixed,
         .seconds = 0.3,
         .middle = far,
         .friction = 0.4},
        {.name = "far sphere", .meshes = several, .seconds = 0.3, .middle = far, .radius = 0.02},
        {.name = "exchanged",
         .meshes = several,
         .seconds = 0.5,
         .radius = 0.01,
         .friction = 0.3,
         .exchanges = true},
        {.name = "many",
         .meshes = {"cube", "cube", "plate", "torus:12x8", "soup", "sheet", "cube", "cube", "plate",
                    "torus:12x8", "cube", "icosphere:1"},
         .words = Words::mixed,
         .spread = 1.6,
         .friction = 0.4},
    };
}

HapticRenderer renderer_of(TouchScene& scene, const Session& session)
{
    RenderOptions options;
    options.proxy_radius = session.radius;
    options.static_friction = session.friction;
    options.dynamic_friction = 0.75 * session.friction;
    options.max_jump = 100;
    return make_haptic_renderer(scene, WorkspaceMap{}, *find_device("omni"), options).value();
}

TEST(SceneCache, EveryTickEqualsThatOfASceneWithoutCache)
{
    const std::uint32_t first_seed = 700;
    std::uint32_t seed = first_seed;
    for (const Session& session : sessions()) {
        TwinScenes scenes(session, ++seed);
        SCOPED_TRACE(session.name + ", seed " + std::to_string(seed));
        HandOnObjects hand(session, seed);
        HapticRenderer fast = renderer_of(scenes.fast(), session);
        HapticRenderer slow = renderer_of(scenes.slow(), session);
        int touching = 0;
        int moving = 0;
        constexpr int ticks = 500;
        for (int tick = 0; tick < ticks; ++tick) {
            SCOPED_TRACE("tick " + std::to_string(tick));
            scenes.say();
            DeviceState state;
            state.pose.translation = hand.next(scenes);
            const std::size_t allocations = allocation_count();
            const RenderTick& is = fast.tick(state, tick_seconds);
            ASSERT_EQ(allocation_count(), allocations);
            const RenderTick& should = slow.tick(state, tick_seconds);
            ASSERT_EQ(is.proxy, should.proxy);
            ASSERT_EQ(is.anchor, should.anchor);
            ASSERT_EQ(parts_of(fast).proxy_tick().slide.center,
                      parts_of(slow).proxy_tick().slide.center);
            ASSERT_EQ(is.hold, should.hold);
            ASSERT_EQ(is.moves, should.moves);
            ASSERT_EQ(is.is_placed, should.is_placed);
            ASSERT_EQ(is.squeezed, should.squeezed);
            ASSERT_EQ(is.force, should.force);
            touching += is.hold != Hold::free ? 1 : 0;
            moving += moving_surface(scenes.fast()).object(scenes.objects()[0]).moved ? 1 : 0;
        }
        EXPECT_GT(touching, ticks / 10);
        EXPECT_GT(moving, ticks / 50);
        const ContactWork kept = moving_surface(scenes.fast()).work();
        EXPECT_GT(kept.scans, kept.gathers); // it was worth keeping
        EXPECT_EQ(moving_surface(scenes.slow()).work().scans, 0U);
    }
}

/// Of a scene's triangles where they stand, the least distance from a way, as near as steps tell,
/// and the triangles whose distance is less than `near`.
struct EveryDistance {
    double least = INFINITY;
    std::set<TriangleId> near;
};

EveryDistance every_distance(const TouchScene& scene, const Vec3& p, const Vec3& way, double near)
{
    EveryDistance all;
    constexpr int steps = 8;
    for (std::uint32_t i = 0; i < scene.object_count(); ++i) {
        const SceneObject object = moving_surface(scene).object(ObjectId{i});
        const TriangleMesh& mesh = object.body->mesh();
        for (std::uint32_t id = 0; id < mesh.triangle_count(); ++id) {
            const Triangle triangle = object.now(mesh.triangle(TriangleId{id}));
            for (int step = 0; step <= steps; ++step) {
                const Vec3 at = p + way * (static_cast<double>(step) / steps);
                const double distance = (closest_point(triangle, at).point - at).norm();
                all.least = std::min(all.least, distance);
                if (distance <= near) all.near.insert(scene_triangle(ObjectId{i}, TriangleId{id}));
            }
        }
    }
    return all;
}

/// All sessions, from tick to tick: `ask` in each of them, about what is near the hand. The seed is
/// traced.
template <class Ask>
void ask_in_every_session(std::uint32_t seed, int ticks, const Ask& ask)
{
    for (const Session& session : sessions()) {
        TwinScenes scenes(session, ++seed);
        SCOPED_TRACE(session.name + ", seed " + std::to_string(seed));
        HandOnObjects hand(session, seed);
        for (int tick = 0; tick < ticks; ++tick) {
            SCOPED_TRACE(tick);
            scenes.say();
            scenes.fast().advance(tick_seconds);
            scenes.slow().advance(tick_seconds);
            ask(scenes, hand.next(scenes));
            if (::testing::Test::HasFatalFailure()) return;
        }
    }
}

TEST(SceneCache, MissesNoNearTriangleWhileObjectsMove)
{
    std::size_t needed = 0;
    std::vector<ContactTriangle> buffer(4096);
    ask_in_every_session(900, 40, [&](TwinScenes& scenes, const Vec3& at) {
        const TouchScene& scene = scenes.fast();
        for (int question = 0; question < 4; ++question) {
            const Vec3 p = at + 0.02 * scenes.vector();
            const double distance = 0.05 * std::abs(scenes.number());
            const Vec3 way = question % 2 == 0 ? Vec3(Vec3::Zero()) : 0.1 * scenes.vector();
            const EveryDistance all = every_distance(scene, p, way, distance);
            const std::size_t count = moving_surface(scene).collect_along(p, way, distance, buffer);
            ASSERT_LE(count, buffer.size());
            std::set<TriangleId> given;
            for (const ContactTriangle& triangle : std::span(buffer).first(count))
                given.insert(triangle.id);
            EXPECT_EQ(given.size(), count);
            needed += all.near.size();
            for (const TriangleId id : all.near) ASSERT_TRUE(given.contains(id));
        }
    });
    EXPECT_GT(needed, 500U);
}

TEST(SceneCache, KnowsTheClearanceOfMovingObjects)
{
    int beyond = 0;
    int within = 0;
    ask_in_every_session(300, 150, [&](TwinScenes& scenes, const Vec3& at) {
        const TouchScene& scene = scenes.fast();
        for (int question = 0; question < 3; ++question) {
            const Vec3 p = at + 0.1 * scenes.vector();
            const double wanted = 0.2 * std::abs(scenes.number());
            const double exact = moving_surface(scene).clearance(p);
            const double said = moving_surface(scene).clearance_beyond(p, wanted);
            ASSERT_LE(said, exact);
            ASSERT_EQ(said > wanted, exact > wanted);
            if (said <= wanted) {
                ASSERT_EQ(said, exact);
            }
            (exact > wanted ? beyond : within) += 1;
        }
    });
    EXPECT_GT(beyond, 1000);
    EXPECT_GT(within, 1000);
}

/// Whether no triangle of the object is within the distance of the way, at five places of it.
void expect_clear(const SceneObject& object, const Vec3& from, const Vec3& to, double distance)
{
    const Vec3 begin = to_local(object.before, from);
    const Vec3 way = to_local(object.now, to) - begin;
    const TriangleMesh& mesh = object.body->mesh();
    for (std::uint32_t k = 0; k < mesh.triangle_count(); ++k) {
        for (const double part : {0.0, 0.25, 0.5, 0.75, 1.0}) {
            const Vec3 place = begin + part * way;
            const TrianglePoint closest = closest_point(mesh.triangle(TriangleId{k}), place);
            ASSERT_GT((closest.point - place).norm(), distance);
        }
    }
}

TEST(SceneCache, PathsReportedClearStayClear)
{
    int clear = 0;
    int not_clear = 0;
    ask_in_every_session(500, 40, [&](TwinScenes& scenes, const Vec3& at) {
        const TouchScene& scene = scenes.fast();
        (void)moving_surface(scene).clearance_beyond(at, 0.1);
        for (int question = 0; question < 4; ++question) {
            const Vec3 from = at + 0.1 * scenes.vector();
            const Vec3 to = from + 0.05 * scenes.vector();
            const double distance = 0.05 * std::abs(scenes.number());
            for (const ObjectId id : scenes.objects()) {
                const bool said = moving_surface(scene).keeps_clear(id, from, to, distance);
                (said ? clear : not_clear) += 1;
                if (said) expect_clear(moving_surface(scene).object(id), from, to, distance);
            }
        }
    });
    EXPECT_GT(clear, 1000);
    EXPECT_GT(not_clear, 1000);
}

// At rest all is kept from tick to tick, until another body stands there.
TEST(SceneCache, AsksAnExchangedBodyAgain)
{
    const auto ball = [](double size) {
        return body_of(
            moved(*sample_mesh("icosphere:2"), [size](const Vec3& p) { return Vec3(size * p); }));
    };
    TouchScene scene(wide_room);
    const auto object = scene.add(ball(1), at_place(Vec3(3, 0, 0)));
    std::vector<ContactTriangle> buffer(4096);
    const Vec3 p(3, 0, 1.3);
    double size = 1;
    for (int round = 0; round < 6; ++round) {
        for (int tick = 0; tick < 3; ++tick) {
            scene.advance(tick_seconds);
            const bool is_larger = size > 1;
            // Each of them first, in one round or another.
            for (int question = 0; question < 3; ++question) {
                bool is_near = false;
                switch ((question + round / 2) % 3) {
                case 0:
                    is_near = !(moving_surface(scene).clearance_beyond(p, 0.2) > 0.2);
                    break;
                case 1:
                    is_near = moving_surface(scene).collect(p, 0.2, buffer) > 0;
                    break;
                default:
                    is_near = !moving_surface(scene).keeps_clear(*object, p, p, 0.2);
                }
                EXPECT_EQ(is_near, is_larger) << round << ' ' << tick << ' ' << question;
            }
        }
        size = size > 1 ? 1 : 1.25;
        EXPECT_TRUE(scene.exchange(*object, ball(size)));
    }
}

// A proxy that lags behind by friction and the place that it would have without are asked about in
// turn, each in a ball of its own.
TEST(ObjectCache, KeepsTwoAlternatingPositions)
{
    const TriangleMesh mesh = *sample_mesh("torus:100x50");
    const auto listed = testing::listed_index(mesh);
    const IndexContactSurface surface(*listed);
    const double edge = surface.scale().mean_edge;
    ObjectCache cache;
    std::vector<ContactTriangle> buffer(4096);
    Vec3 p = mesh.positions()[0];
    constexpr std::uint64_t questions = 1000;
    for (std::uint64_t question = 0; question < questions; ++question) {
        p += Vec3(0, 0.02 * edge, 0);
        const Vec3 aside(0, question % 2 == 0 ? 0 : 30 * edge, 0);
        const Vec3 way(0, 0, 0.1 * edge);
        const std::size_t count = cache.collect_along(surface, p + aside, way, 0.1 * edge, buffer);
        ASSERT_GE(count, surface.collect(p + aside, 0.1 * edge, buffer));
    }
    // Both paths are 20 edges long, and a ball reaches at least two edges beyond what is asked for.
    EXPECT_LE(cache.work().gathers, 2U * (1U + 10U));
    EXPECT_EQ(cache.work().scans, questions);
}

} // namespace
} // namespace proxima::scene_cache_test
