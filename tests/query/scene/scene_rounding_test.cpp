// Scenes in which rounding decides: features exactly as far away as is wanted, and instances that are equally near
// but for the last bits. Every instance asked by itself is the oracle.
#include "proxima/scene.h"
#include "query/scene/scenes_one_by_one.h"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>

namespace proxima::scene_rounding_test {
namespace {

using namespace testing;

/// A triangle with these corners, as a shape.
MeshIndex triangle_shape(const Vec3& a, const Vec3& b, const Vec3& c)
{
    return build_mesh_index(mesh_of({a, b, c}, {{0, 1, 2}})).value();
}

TEST(Scene, FindsWhatIsExactlyAsFarAsTheRadius)
{
    constexpr std::uint64_t seed = 12;
    SCOPED_TRACE(::testing::Message() << "seed " << seed);
    SceneGenerator random(seed);
    std::size_t found = 0;
    const double size = 0x1p-30; // small beside where it is: there, 2^-53 is no small part of it
    for (int i = 0; i < 100; ++i) {
        RandomScene of;
        of.shapes.push_back(
            triangle_shape(size * random.vector(), size * random.vector(), size * random.vector()));
        of.instances.resize(1);
        of.instances[0].pose = {random.rotation(), random.vector()};
        const Scene scene = build_scene(of.shapes, of.instances).value();
        for (int k = 0; k < 30; ++k) {
            // Beside the box, where the box is as far away as the triangle.
            const double off = std::ldexp(random.unit(), -28 - static_cast<int>(random.below(20)));
            const Vec3 corner = of.shapes[0].parts().triangle(0)[static_cast<int>(random.below(3))];
            const Vec3 p =
                of.instances[0].pose(corner) + off * Vec3::Unit(static_cast<int>(random.below(3)));
            const auto nearest = closest_one_by_one(of, p, {});
            ASSERT_TRUE(nearest);
            const SceneFeatureOptions just = {.radius = nearest->distance};
            const auto truth = closest_one_by_one(of, p, just);
            ASSERT_TRUE(same(closest_feature(scene, p, just), truth)) << i << ' ' << just.radius;
            found += truth ? 1U : 0U;
        }
    }
    EXPECT_GT(found, 1500U);
}

TEST(Scene, FindsTheNearestOfManyThatDifferInTheLastBits)
{
    constexpr std::uint64_t seed = 13;
    SCOPED_TRACE(::testing::Message() << "seed " << seed);
    SceneGenerator random(seed);
    // Its steep edge is as far from its origin as the whole shape reaches, but for 2^-10.
    const double end = 0x1p-11;
    RandomScene of;
    of.shapes.push_back(triangle_shape(Vec3(1 - 0.3 * end, -end, 0.1 * end),
                                       Vec3(1 + 0.2 * end, end, -0.2 * end), Vec3(-1, 0, 0)));
    for (int i = 0; i < 200; ++i) {
        SCOPED_TRACE(i);
        of.instances.assign(24, {});
        const double off = std::ldexp(1.0, -14 - static_cast<int>(random.below(12)));
        for (Instance& instance : of.instances) {
            // Along the edge, which leaves the distance, but for rounding.
            instance.pose.translation =
                0.5 * end * random.unit() * Vec3(0.5 * end, 2 * end, -0.3 * end).normalized();
        }
        const Vec3 p = Vec3(1 + off, 0.1 * end * random.unit(), 0.1 * end * random.unit());
        const Scene scene = build_scene(of.shapes, of.instances).value();
        const auto truth = closest_one_by_one(of, p, {});
        ASSERT_TRUE(truth);
        ASSERT_TRUE(same(closest_feature(scene, p), truth)) << truth->distance;
    }
}

// Distances of a few of the smallest steps that doubles have: many are the same once they are rounded.
TEST(Scene, FindsTheFirstOfThoseThatAreAsNearWhereDoublesEnd)
{
    constexpr std::uint64_t seed = 14;
    SCOPED_TRACE(::testing::Message() << "seed " << seed);
    SceneGenerator random(seed);
    const auto place = [&] {
        const Vec3 steps = (3 * random.vector()).array().round();
        return Vec3(std::numeric_limits<double>::denorm_min() * steps);
    };
    for (int i = 0; i < 300; ++i) {
        RandomScene of;
        of.shapes.push_back(triangle_shape(place(), place(), place()));
        of.instances.resize(6);
        for (Instance& instance : of.instances) instance.pose.translation = place();
        const Scene scene = build_scene(of.shapes, of.instances).value();
        for (int k = 0; k < 10; ++k) {
            const Vec3 p = place();
            const auto truth = closest_one_by_one(of, p, {});
            ASSERT_TRUE(same(closest_feature(scene, p), truth)) << i << ' ' << k;
        }
    }
}

TEST(Scene, RaysFromFarAwayMeetWhatIsTiny)
{
    const double size = 1e-200;
    const TriangleMesh mesh = mesh_of(
        {size * Vec3(0, -1, -1), size * Vec3(0, 2, -1), size * Vec3(0, -1, 2)}, {{0, 1, 2}});
    const MeshIndex shape = build_mesh_index(mesh).value();
    std::vector<Instance> instances(20);
    for (std::size_t i = 0; i < instances.size(); ++i)
        instances[i].pose.translation = Vec3(3 * size * static_cast<double>(i), 0, 0);
    const Scene scene = build_scene({&shape, 1}, instances).value();
    for (const double length : {1.0, 1e100, 1e-100}) {
        for (const double from : {1e100, 1e107, 1e115}) {
            SCOPED_TRACE(::testing::Message() << from << ", " << length);
            const Ray ray{Vec3(from, 0, 0), Vec3(-length, 0, 0)};
            const auto hit = closest_hit(scene, ray);
            ASSERT_TRUE(hit);
            EXPECT_EQ(hit->instance, id_of(0));
            EXPECT_TRUE(any_hit(scene, ray));
            EXPECT_EQ(all_hits(scene, ray).size(), instances.size());
        }
    }
}

} // namespace
} // namespace proxima::scene_rounding_test
