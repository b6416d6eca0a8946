#include "proxima/touch_scene.h"

#include "code_of.h"
#include "haptics/proxy/proxy.h"
#include "haptics/scene/scene_input.h"
#include "haptics/scene/touch_access.h"
#include "haptics/scenes_to_touch.h"
#include "haptics/surface/contact_surface.h"
#include "index/listed_index.h"
#include "proxima/haptic_renderer.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

namespace proxima::touch_scene_test {
namespace {

using namespace testing;

/// A scene's triangles where they stand, each looked at every time: the oracle.
class EveryTriangleOf final : public ContactSurface {
public:
    explicit EveryTriangleOf(const TouchScene& scene) : scale_(moving_surface(scene).scale())
    {
        for (std::uint32_t i = 0; i < scene.object_count(); ++i) {
            const SceneObject object = moving_surface(scene).object(ObjectId{i});
            const TriangleMesh& mesh = object.body->mesh();
            for (std::uint32_t id = 0; id < mesh.triangle_count(); ++id) {
                triangles_.push_back({object.now(mesh.triangle(TriangleId{id})),
                                      scene_triangle(ObjectId{i}, TriangleId{id})});
            }
        }
    }
    [[nodiscard]] const SurfaceScale& scale() const noexcept override { return scale_; }
    [[nodiscard]] std::size_t collect(const Vec3& /*p*/, double /*distance*/,
                                      std::span<ContactTriangle> buffer) const noexcept override
    {
        std::copy_n(triangles_.begin(), std::min(triangles_.size(), buffer.size()), buffer.begin());
        return triangles_.size();
    }
    [[nodiscard]] double clearance(const Vec3& p) const noexcept override
    {
        double least = std::numeric_limits<double>::infinity();
        for (const ContactTriangle& each : triangles_)
            least = std::min(least, (closest_point(each.corners, p).point - p).norm());
        return least - 0x1p-44 * scale_.reach;
    }

private:
    SurfaceScale scale_;
    std::vector<ContactTriangle> triangles_;
};

TEST(TouchScene, IsTheSurfaceOfAllItsObjects)
{
    TouchScene scene(wide_room);
    ASSERT_TRUE(scene.add(body_of(*sample_mesh("torus:24x12")),
                          posed(0.7, Vec3(1, 2, 0), Vec3(0.2, 0.1, 0))));
    ASSERT_TRUE(
        scene.add(body_of(*sample_mesh("cube")), posed(2.1, Vec3(0, 1, 1), Vec3(1.1, 0.3, 0.4))));
    ASSERT_TRUE(scene.add(body_of(thin_plate()), posed(-0.4, Vec3(3, 1, 1), Vec3(-0.5, 0.2, 0.1))));
    const EveryTriangleOf all(scene);
    // The path goes over the cube and what stands about it.
    const TriangleMesh about = moved(*sample_mesh("sphere:12x12"), [](const Vec3& p) {
        return Vec3(1.2 * p + Vec3(0.4, 0.2, 0.1));
    });
    for (const double radius : {0.0, 0.03}) {
        for (const double friction : {0.0, 0.4}) {
            const ProxyOptions options = {
                .radius = radius, .static_friction = friction, .dynamic_friction = 0.75 * friction};
            Proxy proxy(moving_surface(scene), options);
            Proxy expected(all, options);
            HandPath path(about, 17);
            const Vec3 begin(0, 0, 5);
            proxy.place(begin);
            expected.place(begin);
            int touching = 0;
            int of_several = 0;
            for (int tick = 0; tick < 600; ++tick) {
                const Vec3 device = path.next();
                const ProxyTick& is = proxy.follow(device);
                const ProxyTick& should = expected.follow(device);
                ASSERT_EQ(is.proxy, should.proxy) << radius << ' ' << friction << ' ' << tick;
                ASSERT_EQ(is.anchor, should.anchor) << radius << ' ' << friction << ' ' << tick;
                for (std::size_t i = 1; i < proxy.path().size(); ++i)
                    ASSERT_FALSE(passes_standing(scene, proxy.path()[i - 1], proxy.path()[i]));
                touching += is.hold != Hold::free ? 1 : 0;
                const auto contacts = std::span(is.slide.contacts).first(is.slide.contact_count);
                for (const Contact& contact : contacts) {
                    if (object_of(contact.triangle) != object_of(contacts[0].triangle)) {
                        ++of_several;
                        break;
                    }
                }
            }
            EXPECT_GT(touching, 100);
            EXPECT_GT(of_several, 3) << radius;
        }
    }
}

TEST(TouchScene, CornersOfSeveralObjectsHoldInOneTick)
{
    TouchScene scene(wide_room);
    for (int axis = 0; axis < 3; ++axis) {
        Vec3 half(2, 2, 2);
        half[axis] = 0.25;
        Vec3 to = Vec3::Zero();
        to[axis] = -0.25;
        ASSERT_TRUE(scene.add(body_of(box_mesh(half)), at_place(to)));
    }
    for (const double radius : {0.0, 0.1}) {
        Proxy proxy(moving_surface(scene), {.radius = radius});
        proxy.place(Vec3(1.0, 0.8, 0.9));
        const ProxyTick& tick = proxy.follow(Vec3(-0.1, -0.15, -0.2));
        EXPECT_EQ(tick.slide.contact_count, 3U);
        EXPECT_LT((tick.anchor - Vec3(radius, radius, radius)).norm(), 1e-10);
        std::array<bool, 3> held{};
        for (const Contact& contact : tick.slide.contacts)
            held[to_index(object_of(contact.triangle))] = true;
        EXPECT_TRUE(held[0] && held[1] && held[2]);
    }
}

TEST(TouchScene, RefusesInvalidObjectsAndMotions)
{
    TouchScene scene(wide_room);
    const auto cube = scene.add(body_of(*sample_mesh("cube")), at_place(Vec3::Zero()));
    ASSERT_TRUE(cube);
    EXPECT_FALSE(scene.add(body_of(*sample_mesh("cube")), at_place(Vec3(19.5, 0, 0))));
    const double nan = std::numeric_limits<double>::quiet_NaN();
    EXPECT_FALSE(scene.move(*cube, {.pose = at_place(Vec3(nan, 0, 0))}));
    EXPECT_FALSE(scene.move(*cube, {.pose = {Mat3(2 * Mat3::Identity()), Vec3::Zero()}}));
    EXPECT_FALSE(scene.move(*cube, {.pose = {Mat3(-Mat3::Identity()), Vec3::Zero()}}));
    EXPECT_FALSE(scene.move(*cube, {.seconds = -1}));
    EXPECT_FALSE(scene.move(*cube, {.spin = Vec3(0, nan, 0)}));
    EXPECT_FALSE(scene.move(*cube, {.velocity = Vec3(30, 0, 0), .coast_seconds = 1}));
    EXPECT_FALSE(scene.move(*cube, {.coast_seconds = std::numeric_limits<double>::infinity()}));
    EXPECT_FALSE(scene.exchange(*cube, body_of(box_mesh(Vec3(30, 1, 1)))));
    EXPECT_TRUE(scene.move(*cube, {.pose = at_place(Vec3(3, 0, 0)), .seconds = 0.1}));
    EXPECT_FALSE(
        build_touch_body(*sample_mesh("cube"), {.material = SurfaceMaterial{.stiffness = nan}}));
    EXPECT_FALSE(build_touch_body(
        *sample_mesh("cube"),
        {.material = SurfaceMaterial{.static_friction = 0.1, .dynamic_friction = 0.2}}));
}

TEST(TouchScene, RefusesSpinsThatAreTooFast)
{
    TouchScene scene(wide_room);
    const ObjectId cube = scene.add(body_of(*sample_mesh("cube")), {}).value();
    for (const double spin : {1.001e4, 1e154, 1e200, 1e308}) {
        const Status status = scene.move(cube, {.spin = Vec3(0, -spin, 0), .coast_seconds = 1});
        ASSERT_FALSE(status) << spin;
        EXPECT_NE(status.error().message.find("spin"), std::string::npos);
    }
    // However long it lasts.
    ASSERT_TRUE(scene.move(cube, {.spin = Vec3::Constant(1e4), .coast_seconds = 1e308}));
    for (int tick = 0; tick < 10; ++tick) (void)scene.advance(1e6);
    const Mat3 turned = scene.pose(cube).rotation;
    EXPECT_LT((turned * turned.transpose() - Mat3::Identity()).norm(), 1e-12);
}

TEST(TouchScene, ObjectsStayWithinTheBoundsWhileTheyTurn)
{
    TouchScene scene(wide_room);
    const TouchBody body = body_of(*sample_mesh("cube"));
    const auto spins = [&](ObjectId object, const Vec3& velocity, const Vec3& turn) {
        return scene
            .move(object, {.pose = scene.pose(object),
                           .velocity = velocity / 2,
                           .spin = turn / 2,
                           .coast_seconds = 2})
            .has_value();
    };
    // A quarter of a turn ends where it began, and corners go out meanwhile.
    const double quarter = std::numbers::pi / 2;
    const ObjectId beside = scene.add(body, at_place(Vec3(18.9, 0, 0))).value();
    EXPECT_FALSE(spins(beside, Vec3::Zero(), Vec3(0, 0, quarter)));
    EXPECT_FALSE(spins(beside, Vec3::Zero(), Vec3(0, 0, 1000)));
    EXPECT_TRUE(spins(beside, Vec3::Zero(), Vec3(0, 0, 0.05)));
    // One that lies on the wall may turn upon it, and not tilt.
    const ObjectId upon = scene.add(body, at_place(Vec3(0, 0, 19))).value();
    EXPECT_TRUE(spins(upon, Vec3(1, -2, 0), Vec3(0, 0, 0.5)));
    EXPECT_FALSE(spins(upon, Vec3(1, -2, 0), Vec3(0.01, 0, 0.5)));
    // Its ball is within the bounds, but not where it coasts to.
    const ObjectId middle = scene.add(body, {}).value();
    EXPECT_TRUE(spins(middle, Vec3(18.2, 0, 0), Vec3(0, 0, 1000)));
    EXPECT_FALSE(spins(middle, Vec3(18.3, 0, 0), Vec3(0, 0, 1000)));
    // An origin far away swings it out, though both ends are within.
    const ObjectId far =
        scene
            .add(body_of(moved(*sample_mesh("cube"),
                               [](const Vec3& p) { return Vec3(p + Vec3(100, 0, 0)); })),
                 at_place(Vec3(-100, 0, 0)))
            .value();
    EXPECT_FALSE(spins(far, Vec3::Zero(), Vec3(0, 0, 4 * quarter)));
    EXPECT_TRUE(spins(far, Vec3::Zero(), Vec3(0, 0, 0.05)));
}

TEST(TouchScene, NewBodiesFitWhereverTheObjectGoes)
{
    TouchScene scene(wide_room);
    const TouchBody body = body_of(*sample_mesh("cube"));
    std::vector<Vec3> positions;
    for (const Vec3& p : body.mesh().positions()) positions.emplace_back(5 * p);
    const TouchBody large = *refit_touch_body(body, positions);
    const ObjectId object = scene.add(body, {}).value();
    const auto fits = [&] {
        const bool exchanges = scene.exchange(object, large).has_value();
        EXPECT_TRUE(scene.exchange(object, body));
        const bool deforms = scene.deform(object, large, 0.01).has_value();
        EXPECT_TRUE(scene.exchange(object, body));
        EXPECT_EQ(exchanges, deforms);
        return exchanges;
    };
    const auto wait = [&](double seconds) { (void)scene.advance(seconds); };
    EXPECT_TRUE(fits());
    // Where it will coast to, and has coasted to.
    ASSERT_TRUE(scene.move(object, {.velocity = Vec3(18, 0, 0), .coast_seconds = 1}));
    EXPECT_FALSE(fits());
    wait(2);
    EXPECT_FALSE(fits());
    // Where it still is.
    ASSERT_TRUE(scene.move(object, {.seconds = 10}));
    EXPECT_FALSE(fits());
    wait(6);
    EXPECT_TRUE(fits());
    wait(6);
    // A turn by its spin, until it rests.
    const Vec3 edge(0, 0, 14);
    const double half_turn = std::numbers::pi;
    ASSERT_TRUE(scene.move(
        object, {.pose = at_place(edge), .spin = Vec3(half_turn, 0, 0), .coast_seconds = 1}));
    wait(0.1);
    EXPECT_FALSE(fits());
    wait(1);
    EXPECT_TRUE(fits());
}

// Too many to build here: their number alone.
TEST(TouchScene, RefusesMoreTrianglesThanItsIdsName)
{
    EXPECT_TRUE(check_scene_triangles(std::size_t{1} << scene_triangle_bits));
    const Status status = check_scene_triangles((std::size_t{1} << scene_triangle_bits) + 1);
    ASSERT_FALSE(status);
    EXPECT_EQ(code_of(status), ErrorCode::invalid_argument);
    EXPECT_NE(status.error().message.find("67108864 triangles, not 67108865"), std::string::npos);
}

TEST(TouchScene, RefusesObjectsThatWereNotAdded)
{
    TouchScene scene(wide_room);
    const TouchBody body = body_of(*sample_mesh("cube"));
    ASSERT_TRUE(scene.add(body, at_place(Vec3::Zero())));
    for (const std::uint32_t id : {1U, 7U, 0xffffffffU}) {
        const ObjectId none{id};
        for (const Status& status :
             {scene.move(none, {}), scene.exchange(none, body), scene.deform(none, body, 0.01),
              scene.set_material(none, {}, 0)}) {
            ASSERT_FALSE(status);
            EXPECT_EQ(code_of(status), ErrorCode::invalid_argument);
            EXPECT_EQ(status.error().message,
                      "no object has the id " + std::to_string(id) + ": the scene has 1 object");
        }
    }
}

TEST(TouchScene, ReportsPosesAndVelocitiesOfObjects)
{
    const TriangleMesh mesh = *sample_mesh("cube");
    const auto index = listed_index(mesh);
    ASSERT_TRUE(index);
    auto body = build_touch_body(*index);
    ASSERT_TRUE(body);
    EXPECT_EQ(body->mesh().triangle_count(), mesh.triangle_count());
    TouchScene first(wide_room);
    const auto cube = first.add(*body, at_place(Vec3(1, 2, 3)));
    ASSERT_TRUE(cube);
    TouchScene scene = std::move(first);
    EXPECT_EQ(scene.object_count(), 1U);
    EXPECT_EQ(scene.pose(*cube).translation, Vec3(1, 2, 3));
    EXPECT_EQ(scene.velocity(*cube, Vec3::Zero()), Vec3(Vec3::Zero()));
    EXPECT_TRUE(scene.move(*cube, {.pose = at_place(Vec3(1.5, 2, 3)), .seconds = 0.1}));
    for (int tick = 0; tick < 50; ++tick) EXPECT_TRUE(scene.advance(1e-3).moved);
    EXPECT_NEAR(scene.pose(*cube).translation.x(), 1.25, 1e-12);
    EXPECT_NEAR((scene.velocity(*cube, Vec3(7, 0, 0)) - Vec3(5, 0, 0)).norm(), 0, 1e-9);
    for (int tick = 0; tick < 50; ++tick) (void)scene.advance(1e-3);
    EXPECT_FALSE(scene.advance(1e-3).moved);
    EXPECT_NEAR(scene.pose(*cube).translation.x(), 1.5, 1e-12);
}

TEST(TouchBody, HasTheListsOfItsIndexAndBuildsNone)
{
    const TriangleMesh mesh = *sample_mesh("cube");
    EXPECT_FALSE(contact_body(*build_touch_body(mesh)).mesh_index().has_lists());
    EXPECT_FALSE(contact_body(*build_touch_body(*build_mesh_index(mesh))).mesh_index().has_lists());
    EXPECT_TRUE(contact_body(*build_touch_body(*listed_index(mesh))).mesh_index().has_lists());
}

TEST(TouchBody, CopiesShareTheirStorageAndOutliveTheScene)
{
    const TouchBody body = body_of(*sample_mesh("cube"));
    const TouchBody copy = body;
    EXPECT_EQ(&copy.mesh(), &body.mesh());
    {
        TouchScene scene(wide_room);
        const auto first = scene.add(body, at_place(Vec3(-3, 0, 0)));
        const auto second = scene.add(copy, at_place(Vec3(3, 0, 0)));
        ASSERT_TRUE(first && second);
        EXPECT_TRUE(scene.exchange(*first, body_of(*sample_mesh("torus:8x6"))));
        EXPECT_TRUE(scene.advance(1e-3).exchanged);
        EXPECT_EQ(moving_surface(scene).object(*second).body, &contact_body(body));
    }
    EXPECT_EQ(body.mesh().triangle_count(), 12U);
}

} // namespace
} // namespace proxima::touch_scene_test
