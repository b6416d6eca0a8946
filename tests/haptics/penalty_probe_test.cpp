// Penalty forces are what they are said to be, and have the faults that they are known for; a proxy
// on the same ways has none of these.
#include "haptics/force/penalty_probe.h"

#include "counted_allocations.h"
#include "folder_test.h"
#include "geometry/closest_point.h"
#include "haptics/force/surface_renderer.h"
#include "haptics/loop/recording.h"
#include "haptics/spring_alone.h"
#include "haptics/surface/contact_surface.h"
#include "haptics/touch_meshes.h"
#include "index/listed_index.h"
#include "lab/quality_report.h"
#include "octree/winding_number.h"
#include "proxima/device.h"
#include "proxima/haptic_renderer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <limits>
#include <random>

namespace proxima::penalty_probe_test {
namespace {

constexpr double tick_seconds = 1e-3;
constexpr double stiffness = 500;

struct Inside {
    explicit Inside(TriangleMesh model)
        : mesh(std::move(model)), topology(*build_topology(mesh)),
          listed(*testing::listed_index(mesh)), surface(listed), with_sign(*with_signs(listed))
    {}

    TriangleMesh mesh;
    Topology topology;
    MeshIndex listed;
    IndexContactSurface surface;
    MeshIndex with_sign;
    WorkspaceMap map = {20, Vec3::Zero()}; ///< a cube of 2 is 0.1 m wide on the device
};

HapticRenderer renderer_of(const Inside& model, ForceLaw law)
{
    const DeviceLimits strong = {.name = "strong", .max_force = 1e3, .max_stiffness = 1e4};
    const RenderOptions options = testing::spring_alone(stiffness);
    if (law == ForceLaw::proxy)
        return make_surface_renderer(model.surface, model.map, strong, options);
    return make_penalty_renderer(model.surface, model.with_sign, model.map, strong, options);
}

DeviceState at(const Vec3& p)
{
    DeviceState state;
    state.pose.translation = p;
    return state;
}

/// A straight way, in metres of the device, a step a tick.
struct Outcome {
    QualityReport quality;
    Vec3 last = Vec3::Zero(); ///< force, N
    std::vector<RecordedTick> ticks;
};

Outcome go(const Inside& model, ForceLaw law, std::span<const Vec3> corners, double step)
{
    HapticRenderer renderer = renderer_of(model, law);
    QualityMeter meter(model.surface, model.map);
    Outcome outcome;
    Vec3 place = corners.front();
    for (const Vec3& corner : corners) {
        const int steps = static_cast<int>(std::ceil((corner - place).norm() / step));
        const Vec3 begin = place;
        for (int i = 1; i <= steps; ++i) {
            place = begin + (corner - begin) * (static_cast<double>(i) / steps);
            const RenderTick& tick = renderer.tick(at(place), tick_seconds);
            meter.add(tick, Vec3::Zero(), renderer.path());
            if (parts_of(renderer).popped()) meter.add_pass();
            outcome.last = tick.force;
            outcome.ticks.push_back(recorded(0, at(place), tick));
        }
    }
    outcome.quality = meter.report();
    return outcome;
}

void print(const char* what, ForceLaw law, const Outcome& outcome)
{
    std::printf("%-34s %-8s touching %5llu  passed through %llu  largest step %7.2f of K times the "
                "way, turn %5.1f degrees, at last %5.2f N\n",
                what, law == ForceLaw::proxy ? "proxy" : "penalty",
                static_cast<unsigned long long>(outcome.quality.touching_ticks),
                static_cast<unsigned long long>(outcome.quality.passes),
                outcome.quality.max_step_ratio, outcome.quality.max_turn_degrees,
                outcome.last.norm());
}

TEST(PenaltyProbe, PushesToTheNearestSurfacePointInsideAndNotAtAllOutside)
{
    std::uint64_t inside = 0;
    for (const std::string_view name : {"cube", "torus:24x12", "sphere:30x30"}) {
        const Inside model(*sample_mesh(name));
        HapticRenderer renderer = renderer_of(model, ForceLaw::penalty);
        std::mt19937 random(9);
        std::uniform_real_distribution<double> unit(-1, 1);
        for (int i = 0; i < 2000; ++i) {
            const Vec3 p = 1.2 * Vec3{unit(random), unit(random), unit(random)};
            double least = std::numeric_limits<double>::infinity();
            Vec3 nearest = p;
            for (std::uint32_t id = 0; id < model.mesh.triangle_count(); ++id) {
                const Vec3 point = closest_point(model.mesh.triangle(TriangleId{id}), p).point;
                if ((point - p).norm() >= least) continue;
                least = (point - p).norm();
                nearest = point;
            }
            const bool is_inside = brute_winding_number(model.mesh, p) >= 0.5;
            const Vec3 place = p / model.map.units_per_metre;
            const RenderTick& tick = renderer.tick(at(place), tick_seconds);
            inside += is_inside ? 1U : 0U;
            EXPECT_EQ(tick.hold != Hold::free, is_inside) << name << ' ' << i;
            const double wanted = is_inside ? stiffness * least / model.map.units_per_metre : 0;
            EXPECT_NEAR(tick.force.norm(), wanted, 1e-9) << name << ' ' << i;
            if (is_inside) {
                EXPECT_NEAR(tick.force.dot(nearest - p), wanted * least, 1e-9) << name << ' ' << i;
            }
        }
    }
    EXPECT_GT(inside, 300U);
}

// A plate of a millimetre, pressed slowly from above: in the middle the other skin is nearer.
TEST(PenaltyProbe, PopsThroughAThinPlateWhereAProxyDoesNot)
{
    const Inside model(testing::moved(testing::thin_plate(),
                                      [](const Vec3& p) { return Vec3(p[0], p[1], 20 * p[2]); }));
    const std::array<Vec3, 2> way = {Vec3(0.003, 0.001, 0.011), Vec3(0.003, 0.001, -0.011)};
    for (const double step : {5e-5, 2e-3}) {
        const char* const what = step < 1e-3 ? "plate of 1 mm, 0.05 m/s" : "plate of 1 mm, 2 m/s";
        const Outcome penalty = go(model, ForceLaw::penalty, way, step);
        const Outcome proxy = go(model, ForceLaw::proxy, way, step);
        print(what, ForceLaw::penalty, penalty);
        print(what, ForceLaw::proxy, proxy);
        EXPECT_EQ(penalty.quality.passes, 1U);
        EXPECT_EQ(penalty.last, Vec3::Zero());
        EXPECT_EQ(proxy.quality.passes, 0U);
        EXPECT_NEAR(proxy.last[2], stiffness * 0.0115, 1e-6);
    }
}

// Down into a cube beside its upper edge, and aside: another side becomes the nearest one.
TEST(PenaltyProbe, JumpsInsideACubeWhereAProxyDoesNot)
{
    const Inside model(*sample_mesh("cube"));
    const double half = bounding_box(model.mesh).extent().maxCoeff() / 2;
    const double edge = half / model.map.units_per_metre;
    const std::array<Vec3, 3> way = {Vec3(0, 0.001, 1.2 * edge), Vec3(0, 0.001, 0.7 * edge),
                                     Vec3(0.9 * edge, 0.001, 0.7 * edge)};
    const Outcome penalty = go(model, ForceLaw::penalty, way, 2e-5);
    const Outcome proxy = go(model, ForceLaw::proxy, way, 2e-5);
    print("cube, below its upper edge", ForceLaw::penalty, penalty);
    print("cube, below its upper edge", ForceLaw::proxy, proxy);
    EXPECT_GT(penalty.quality.max_turn_degrees, 89);
    EXPECT_GT(penalty.quality.max_step_ratio, 3);
    EXPECT_LT(proxy.quality.max_turn_degrees, 1);
    EXPECT_LE(proxy.quality.max_step_ratio, 1 + 1e-9);
    EXPECT_NEAR(proxy.last[2], stiffness * 0.3 * edge, 1e-6);
    EXPECT_NEAR(penalty.last[0], stiffness * 0.1 * edge, 1e-6);
}

TEST(PenaltyProbe, DoesNotAllocate)
{
    const Inside model(*sample_mesh("torus:24x12"));
    HapticRenderer renderer = renderer_of(model, ForceLaw::penalty);
    const std::size_t before = testing::allocation_count();
    std::uint64_t touching = 0;
    for (int i = 0; i < 1000; ++i) {
        const Vec3 p(0.1 * std::sin(0.01 * i), 0.1 * std::sin(0.017 * i), 0.002);
        touching += renderer.tick(at(p), tick_seconds).hold != Hold::free ? 1U : 0U;
    }
    EXPECT_EQ(testing::allocation_count(), before);
    EXPECT_GT(touching, 50U);
}

using PenaltyRecordingTest = FolderTest;

TEST_F(PenaltyRecordingTest, IsReplayedBitForBit)
{
    const Inside model(*sample_mesh("cube"));
    const std::array<Vec3, 3> way = {Vec3(0, 0.001, 0.1), Vec3(0.01, 0.02, 0.0),
                                     Vec3(-0.1, 0.001, 0.03)};
    for (const ForceLaw law : {ForceLaw::penalty, ForceLaw::proxy}) {
        Recording recording;
        recording.settings.map = model.map;
        recording.settings.render = testing::spring_alone(stiffness);
        recording.settings.law = law;
        recording.settings.max_force = 1e3;
        recording.settings.max_stiffness = 1e4;
        recording.ticks = go(model, law, way, 1e-3).ticks;
        ASSERT_TRUE(save_recording(recording, path("outcome.pxt")));
        const auto loaded = load_recording(path("outcome.pxt"));
        ASSERT_TRUE(loaded) << describe(loaded.error());
        EXPECT_EQ(loaded->settings.law, law);
        HapticRenderer again = renderer_of(model, loaded->settings.law);
        EXPECT_EQ(count_differences(*loaded, again), 0U);
        HapticRenderer other =
            renderer_of(model, law == ForceLaw::proxy ? ForceLaw::penalty : ForceLaw::proxy);
        EXPECT_GT(count_differences(*loaded, other), 0U);
        recording.settings.objects.resize(1);
        ASSERT_TRUE(save_recording(recording, path("scene.pxt")));
        EXPECT_EQ(load_recording(path("scene.pxt")).has_value(), law == ForceLaw::proxy);
    }
}

} // namespace
} // namespace proxima::penalty_probe_test
