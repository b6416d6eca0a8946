// The guards of a tool's renderer, devices without torques, tools that begin inside, energy.
#include "counted_allocations.h"
#include "haptics/tool/rigid_motion.h"
#include "haptics/tool/tool_bench.h"
#include "haptics/tool/tool_guard.h"
#include "haptics/tool/tool_proxy.h"
#include "proxima/sample_meshes.h"
#include "proxima/tool_renderer.h"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <numbers>
#include <random>
#include <string>

namespace proxima::testing::tool_renderer_test {
namespace {

constexpr double half = 0.01;

MeshIndex ball_index(double radius)
{
    return index_of(
        moved(*sample_mesh("icosphere:3"), [&](const Vec3& p) { return Vec3(radius * p); }));
}

ToolRenderer renderer_for(const DeviceLimits& device, const ToolRenderOptions& options = {})
{
    const ToolObject table = {index_of(box_mesh({0.1, 0.1, 0.05}, {0, 0, -0.05})), {}};
    return make_tool_renderer(index_of(box_mesh(Vec3::Constant(half))), std::span(&table, 1),
                              WorkspaceMap{}, device, options)
        .value();
}

DeviceState state_at(const RigidTransform& pose)
{
    DeviceState state;
    state.pose = pose;
    return state;
}

TEST(ToolRenderer, DevicesWithoutTorquesGetTheForceAlone)
{
    DeviceLimits device = strong_device();
    for (const double torque : {0.0, 0.2}) {
        device.max_torque = torque;
        ToolRenderer renderer = renderer_for(device, plain_springs());
        for (int i = 0; i < 40; ++i) (void)renderer.tick(state_at(pose_at({0, 0, 0.011})), 1e-3);
        for (int i = 0; i < 40; ++i)
            (void)renderer.tick(state_at(pose_at({0, 0, 0.006}, {0, 0.3, 0})), 1e-3);
        const ToolTick& tick = renderer.last();
        EXPECT_GT(tick.force.z(), 1);
        EXPECT_GT(tick.spring_torque.norm(), 0.01);
        EXPECT_EQ(tick.torque.isZero(0), torque == 0);
    }
}

TEST(ToolRenderer, AModelInMillimetresFeelsAsInMetres)
{
    ToolRenderOptions options = plain_springs();
    options.torsional_stiffness = 0; // of the tool's reach
    ToolRenderer expected = renderer_for(strong_device(), options);
    const auto in_millimetres = [](const TriangleMesh& mesh) {
        return index_of(moved(mesh, [](const Vec3& p) { return Vec3(1000 * p); }));
    };
    const WorkspaceMap map{1000, Vec3(10, 20, 30)};
    const ToolObject table = {in_millimetres(box_mesh({0.1, 0.1, 0.05}, {0, 0, -0.05})),
                              pose_at(map.center)};
    ToolRenderer renderer = make_tool_renderer(in_millimetres(box_mesh(Vec3::Constant(half))),
                                               std::span(&table, 1), map, strong_device(), options)
                                .value();
    // At half the reach, which is half the diagonal of the box.
    const double arm = 0.5 * std::sqrt(3.0) * half;
    EXPECT_NEAR(expected.options().torsional_stiffness, 500 * arm * arm, 1e-12);
    EXPECT_NEAR(renderer.options().torsional_stiffness, 500 * arm * arm, 1e-12);
    for (int i = 0; i <= 400; ++i) {
        const DeviceState state = state_at(pose_at({0, 0, 0.02 - 3e-5 * i}, {0, 5e-4 * i, 0}));
        const ToolTick& should = expected.tick(state, 1e-3);
        const ToolTick& is = renderer.tick(state, 1e-3);
        ASSERT_LT((is.force - should.force).norm(), 1e-3) << i;
        ASSERT_LT((is.torque - should.torque).norm(), 1e-5) << i;
        double pushes = 0; // without friction, of a plane
        for (std::size_t k = 0; k < is.contact_count; ++k) pushes += is.contacts[k].force;
        EXPECT_NEAR(pushes, is.force.z(), 1e-2) << i;
    }
    EXPECT_GT(renderer.last().force.z(), 0.5);
    EXPECT_GT(renderer.last().torque.norm(), 1e-3);
}

/// A box on a table, pressed down by 4 mm and tilted by less than its edge could bear: it lies flat.
TEST(ToolRenderer, CommandsAreInTheAxesOfTheDevice)
{
    // Our y is the device's -z, and our z its y.
    Mat3 turn;
    turn << 1, 0, 0, 0, 0, -1, 0, 1, 0;
    constexpr double tilt = 0.02;
    ToolRenderer renderer = renderer_for(strong_device(), plain_springs());
    DeviceInput input = make_device_input({}, {.rotation = turn}).value();
    DeviceReading reading;
    DeviceCommand command;
    for (int i = 0; i < 200; ++i) {
        const Vec3 position(0.001, 0.002, std::max(0.02 - 2e-4 * i, half - 0.004));
        const RigidTransform ours = pose_at(position, {0, tilt, 0});
        ++reading.sample;
        reading.state.pose = {turn.transpose() * ours.rotation, turn.transpose() * position};
        renderer.tick(input.accept(reading), 1e-3);
        command = input.command(renderer);
    }
    EXPECT_NEAR(renderer.last().torque.y(), -0.5 * tilt, 1e-5);
    EXPECT_LT((command.torque - Vec3(0, 0, 0.5 * tilt)).norm(), 1e-5);
    EXPECT_LT((command.force - Vec3(0, 500 * (0.004 + 1e-5), 0)).norm(), 1e-4);
}

/// The bottom of a box as so many squares a side.
MeshIndex dense_face(std::uint32_t side)
{
    std::vector<Vec3> corners;
    std::vector<std::array<std::uint32_t, 3>> triangles;
    const auto at = [side](std::uint32_t i, std::uint32_t j) { return i * (side + 1) + j; };
    for (std::uint32_t i = 0; i <= side; ++i) {
        for (std::uint32_t j = 0; j <= side; ++j)
            corners.emplace_back(half * (2.0 * i / side - 1), half * (2.0 * j / side - 1), -half);
    }
    for (std::uint32_t i = 0; i < side; ++i) {
        for (std::uint32_t j = 0; j < side; ++j) {
            triangles.push_back({at(i, j), at(i, j + 1), at(i + 1, j)});
            triangles.push_back({at(i + 1, j), at(i, j + 1), at(i + 1, j + 1)});
        }
    }
    return index_of(*make_triangle_mesh(corners, triangles));
}

/// A face of a thousand triangles flat on a table slides as one of two does, within a tick's work.
TEST(ToolRenderer, ADenseFaceSlides)
{
    const ToolObject table = {index_of(box_mesh({0.1, 0.1, 0.05}, {0, 0, -0.05})), {}};
    for (const std::uint32_t side : {1U, 10U, 20U, 26U}) {
        SCOPED_TRACE("squares a side: " + std::to_string(side));
        ToolRenderer renderer = make_tool_renderer(dense_face(side), std::span(&table, 1),
                                                   WorkspaceMap{}, strong_device(), plain_springs())
                                    .value();
        for (int i = 0; i <= 500; ++i)
            (void)renderer.tick(state_at(pose_at({0, 0, 0.02 - 0.012 * i / 500})), 1e-3);
        double most = 0;
        for (int i = 1; i <= 400; ++i) {
            const ToolTick& tick =
                renderer.tick(state_at(pose_at({0.02 * i / 400, 0, 0.008})), 1e-3);
            most = std::max(most, std::abs(tick.force.x()));
            EXPECT_NEAR(tick.force.z(), renderer.options().force.stiffness * 0.002, 0.01);
        }
        // It lags by two ticks at most.
        EXPECT_LT(most, renderer.options().force.stiffness * 1.1e-4);
    }
}

/// A face of many triangles flat on a table is a crowd: it holds, and comes off.
TEST(ToolRenderer, ACrowdOfTrianglesLetsGo)
{
    const ToolObject table = {index_of(box_mesh({0.1, 0.1, 0.05}, {0, 0, -0.05})), {}};
    ToolRenderer renderer = make_tool_renderer(dense_face(60), std::span(&table, 1), WorkspaceMap{},
                                               strong_device(), plain_springs())
                                .value();
    int overloaded = 0;
    const auto go_to = [&](double height, int ticks) {
        const double from = renderer.last().device.translation.z();
        for (int i = 1; i <= ticks; ++i) {
            const double z = from + (height - from) * i / ticks;
            overloaded +=
                renderer.tick(state_at(pose_at({0, 0, z})), 1e-3).end == ToolEnd::overloaded ? 1
                                                                                             : 0;
        }
    };
    (void)renderer.tick(state_at(pose_at({0, 0, 0.02})), 1e-3);
    go_to(0.008, 400);
    go_to(0.008, 100);
    EXPECT_GT(overloaded, 100);
    EXPECT_NEAR(renderer.last().force.z(), renderer.options().force.stiffness * 0.002, 0.2);
    go_to(0.04, 1000);
    EXPECT_LT(renderer.last().force.norm(), 1e-9);
    EXPECT_TRUE(renderer.last().is_placed);
    EXPECT_EQ(renderer.last().end, ToolEnd::settled);
    overloaded = 0;
    go_to(0.02, 200);
    EXPECT_EQ(overloaded, 0);
}

/// Its edge is nearer to a table than four clearances, and so tilted that a list of what is within the usual
/// ten has no room for a third of its triangles, but one within five has. Then the first tick begins with five.
TEST(ToolProxy, PlacesADenseToolNearAnObjectByAShorterList)
{
    constexpr double clearance = 1e-5;
    constexpr double tilt = 8.3e-3;
    std::vector<SeenObject> objects;
    objects.push_back(
        {.body = RigidBody::build(index_of(box_mesh({0.1, 0.1, 0.05}, {0, 0, -0.05}))).value()});
    ToolProxy proxy(RigidBody::build(dense_face(60)).value(), std::move(objects),
                    {.clearance = clearance, .turning_length = 0.03, .max_work = 800});
    RigidTransform device = pose_at({0, 0, half * (1 + tilt) + 3.75 * clearance}, {0, tilt, 0});
    ASSERT_TRUE(proxy.place(device));
    device.translation.x() += 5 * clearance;
    proxy.follow(device);
    EXPECT_GT(proxy.work().pairs, 300U);
    EXPECT_LT(proxy.work().spent, 500U); // a list that finds no room adds 356
    EXPECT_EQ(proxy.end(), ToolEnd::settled);
    EXPECT_EQ(proxy.pose().translation, device.translation);
}

/// The passivity guard damps the force alone then, and a reset forgets what it did.
TEST(ToolRenderer, TheGuardGivesNoTorqueToADeviceWithoutAndForgetsByReset)
{
    DeviceLimits device = *find_device("omni");
    ToolRenderer renderer = renderer_for(device, {.force = {.stiffness = 700, .damping = 0}});
    const auto shake = [&] {
        double checksum = 0;
        for (int i = 0; i < 1000; ++i) {
            // It grows, as by forces that are late.
            const double size = std::min(1e-4 * std::exp(0.01 * i), 0.004);
            const double swing = size * std::sin(0.3 * i);
            const ToolTick& tick =
                renderer.tick(state_at(pose_at({0, 0, 0.0105 + swing}, {swing, 0, 0})), 1e-3);
            EXPECT_TRUE(tick.torque.isZero(0));
            checksum += tick.force.z() * (i + 1);
        }
        return checksum;
    };
    const double first = shake();
    EXPECT_GT(guard_of(renderer).passivity().added_damping(), 0.1);
    EXPECT_GT(guard_of(renderer).passivity().report().swings, 0U);
    renderer.reset();
    EXPECT_EQ(guard_of(renderer).passivity().added_damping(), 0);
    EXPECT_EQ(guard_of(renderer).passivity().report().damped_ticks, 0U);
    EXPECT_EQ(shake(), first);
}

TEST(ToolRenderer, ForceAndTorqueStayWithinTheirLimitsWhateverArrives)
{
    const DeviceLimits limits = {.name = "small",
                                 .max_force = 3.3,
                                 .max_stiffness = 700,
                                 .max_damping = 5,
                                 .workspace_radius = 0.1,
                                 .max_torque = 0.05};
    ToolRenderOptions options;
    options.max_torque_slew = 5;
    options.torsional_damping = 1e-3;
    ToolRenderer renderer = renderer_for(limits, options);
    const double nan = std::numeric_limits<double>::quiet_NaN();
    std::mt19937 random(7);
    const auto unit = [&] { return std::uniform_real_distribution<double>(-1, 1)(random); };
    Vec3 force = Vec3::Zero();
    Vec3 torque = Vec3::Zero();
    double most_torque = 0;
    for (int i = 0; i < 3000; ++i) {
        DeviceState state = state_at(pose_at(0.02 * Vec3(unit(), unit(), unit() + 0.7),
                                             Vec3(0.4 * unit(), 0.4 * unit(), unit())));
        switch (random() % 40) {
        case 0:
            state.pose.translation.x() = nan;
            break;
        case 1:
            state.pose.rotation(1, 1) = nan;
            break;
        case 2:
            state.pose.rotation *= 2;
            break;
        case 3:
            state.pose.translation.setConstant(1e200);
            break;
        case 4:
            state.pose.translation.setConstant(1e3);
            break;
        case 5:
            state.condition = InputCondition::silent;
            break;
        default:
            break;
        }
        const ToolTick& tick = renderer.tick(state, 1e-3);
        ASSERT_TRUE(tick.force.allFinite() && tick.torque.allFinite()) << i;
        ASSERT_TRUE(tick.proxy.translation.allFinite() && tick.proxy.rotation.allFinite()) << i;
        ASSERT_LE(tick.force.norm(), limits.max_force);
        ASSERT_LE(tick.torque.norm(), limits.max_torque);
        // A jump begins anew from zero; otherwise both change as fast as they may.
        if (tick.fault != InputFault::jumped) {
            ASSERT_LE((tick.force - force).norm(), 2.0 + 1e-12);
            ASSERT_LE((tick.torque - torque).norm(), 5e-3 + 1e-12);
        }
        force = tick.force;
        torque = tick.torque;
        most_torque = std::max(most_torque, torque.norm());
    }
    EXPECT_GT(most_torque, 1e-3);
}

TEST(ToolRenderer, AToolThatBeginsInsideFeelsNothingUntilItIsOut)
{
    // Across the surface, and wholly inside of it.
    for (const double begin : {0.001, -0.05}) {
        ToolRenderer renderer = renderer_for(strong_device(), plain_springs());
        bool was_out = false;
        for (double z = begin; z < 0.02; z += 1e-4) {
            const ToolTick& tick = renderer.tick(state_at(pose_at({0, 0, z})), 1e-3);
            was_out = was_out || tick.is_placed;
            // Half the clearance of 1e-5 m above the top is out.
            EXPECT_EQ(tick.is_placed, z - half > 0.5e-5) << z;
            EXPECT_TRUE(tick.is_placed || (tick.force.isZero(0) && tick.torque.isZero(0)));
        }
        EXPECT_TRUE(was_out);
        (void)renderer.tick(state_at(pose_at({0, 0, 0.009})), 1e-3);
        EXPECT_GT(renderer.tick(state_at(pose_at({0, 0, 0.009})), 1e-3).force.z(), 0.1);
    }
}

TEST(ToolRenderer, AfterAResetInsideNothingIsTouched)
{
    ToolRenderer renderer = renderer_for(strong_device(), plain_springs());
    for (int i = 0; i < 5; ++i) (void)renderer.tick(state_at(pose_at({0, 0, 0.02})), 1e-3);
    for (int i = 0; i < 20; ++i) (void)renderer.tick(state_at(pose_at({0, 0, 0.008})), 1e-3);
    ASSERT_GT(renderer.last().contact_count, 0U);
    renderer.reset();
    const ToolTick& tick = renderer.tick(state_at(pose_at({0, 0, 0.001})), 1e-3);
    EXPECT_FALSE(tick.is_placed);
    EXPECT_EQ(tick.contact_count, 0U);
    EXPECT_EQ(tick.moves, 0);
    EXPECT_TRUE(renderer.path().empty());
}

TEST(ToolRenderer, ADeviceThatIsFarAwayForSomeTicksLeadsTheToolIntoNothing)
{
    // Faults from 2^40 clearances on, 1e7 m.
    for (const auto& [far, ticks] : {std::pair{1e6, 50}, {1e12, 60}, {1e15, 80}, {1e100, 400}}) {
        ToolBench bench(box_mesh(Vec3::Constant(half)),
                        {{index_of(box_mesh({0.1, 0.1, 0.05}, {0, 0, -0.05})), {}}},
                        plain_springs());
        bench.start(pose_at({0, 0, 0.02}));
        for (int i = 0; i < ticks; ++i) (void)bench.tick(pose_at({0, 0, far}));
        EXPECT_EQ(bench.renderer().last().fault == InputFault::not_finite, far > 1e7) << far;
        for (int i = 0; i < 300; ++i) (void)bench.tick(pose_at({0, 0, 0.02}));
        EXPECT_LT((bench.renderer().last().proxy.translation - Vec3(0, 0, 0.02)).norm(), 1e-9)
            << far;
        for (int i = 0; i < 100; ++i) {
            (void)bench.tick(pose_at({0, 0, 0.02 - 0.012 * i / 100}));
            ASSERT_FALSE(bench.meets()) << far;
        }
    }
}

/// As rounded numbers make it: the box is not stretched by them.
TEST(ToolRenderer, PosesOfObjectsAreMadeRigid)
{
    const ToolObject box = {index_of(box_mesh({1, 1, 0.5}, {0, 0, -0.5})),
                            {(1 + 2e-4) * Mat3::Identity(), Vec3(0, 0, 0.5)}};
    auto renderer = make_tool_renderer(index_of(box_mesh(Vec3::Constant(half))), std::span(&box, 1),
                                       {}, strong_device(), plain_springs())
                        .value();
    for (int i = 0; i < 250; ++i)
        (void)renderer.tick(state_at(pose_at({1.02 - 0.012 * std::min(i, 199) / 199, 0, 0})), 1e-3);
    const ToolTick& tick = renderer.last();
    EXPECT_NEAR(tick.proxy.translation.x(), 1 + half + 1e-5, 1e-6);
    ASSERT_GT(tick.contact_count, 0U);
    EXPECT_NEAR(tick.contacts[0].normal.norm(), 1, 1e-12);
}

/// Led through a closed path in contact, the springs give back what they took: nothing is dissipated
/// without friction, and nothing is made.
TEST(ToolRenderer, ClosedPathsMakeNoEnergy)
{
    const ToolObject object = {ball_index(0.03), {}};
    ToolRenderOptions options = plain_springs();
    options.max_moves = 32;
    auto renderer =
        make_tool_renderer(index_of(box_mesh({0.01, 0.006, 0.004})), std::span(&object, 1),
                           WorkspaceMap{}, strong_device(), options)
            .value();
    // From above, round a small circle 2 mm deep while tilting, and up again.
    const int steps = 1500;
    const auto pose = [&](int step) {
        const double part = step / static_cast<double>(steps);
        const double down = 0.5 * (1 - std::cos(2 * std::numbers::pi * part));
        const double angle = 4 * std::numbers::pi * part;
        return pose_at(
            {0.004 * std::sin(angle), 0.004 * (1 - std::cos(angle)), 0.036 - 0.004 * down},
            Vec3(0.1 * std::sin(angle), 0.15 * std::sin(2 * angle), 0));
    };
    double work = 0; // of the springs on the device
    double most = 0;
    ToolTick before = renderer.tick(state_at(pose(0)), 1e-3);
    ASSERT_EQ(before.contact_count, 0U);
    int touching = 0;
    for (int step = 1; step <= steps; ++step) {
        const ToolTick tick = renderer.tick(state_at(pose(step)), 1e-3);
        const Twist moved = twist_between(before.device, tick.device);
        work += 0.5 * (before.spring_force + tick.spring_force).dot(moved.linear) +
                0.5 * (before.spring_torque + tick.spring_torque).dot(moved.angular);
        most = std::max(most, 0.5 * 500 * std::pow(tick.spring_force.norm() / 500, 2));
        touching += tick.contact_count > 0 ? 1 : 0;
        before = tick;
    }
    EXPECT_GT(touching, 500);
    std::cout << "work of a closed path: " << 1e6 * work << " uJ of at most " << 1e6 * most
              << " uJ stored\n";
    // A proxy that jumps from one rest to another loses energy; it must not make any.
    EXPECT_LT(work, 1e-3 * most);
    EXPECT_GT(work, -0.1 * most);
}

TEST(ToolRenderer, TicksAllocateNothing)
{
    ToolBench bench(box_mesh(Vec3::Constant(half)),
                    {{ball_index(0.03), {}}, {ball_index(0.02), pose_at({0.05, 0, 0})}});
    bench.start(pose_at({0, 0, 0.06}));
    const std::size_t before = allocation_count();
    (void)bench.lead(pose_at({0.02, 0, 0.02}, {0.5, 0.3, 0.1}), 100, 10);
    EXPECT_EQ(allocation_count(), before);
    EXPECT_GT(bench.renderer().last().contact_count, 0U);
}

/// However little work a tick may do, the tool enters nothing, and says where it had to stop.
TEST(ToolRenderer, TicksEndAtTheirWork)
{
    const TriangleMesh ball =
        moved(*sample_mesh("icosphere:4"), [](const Vec3& p) { return Vec3(0.02 * p); });
    const MeshIndex object =
        index_of(moved(*sample_mesh("torus:48x24"), [](const Vec3& p) { return Vec3(0.03 * p); }));
    double stretch = 0; // without a bound
    for (const std::size_t most : {0U, 1600U, 800U, 400U, 100U}) {
        SCOPED_TRACE(most);
        ToolRenderOptions options = plain_springs();
        options.max_work = most;
        ToolBench bench(ball, {{object, {}}}, options);
        bench.start(pose_at({0.03, 0, 0.05}));
        std::size_t largest = 0;
        int cut = 0;
        for (int i = 0; i < 300; ++i) {
            const double angle = 0.01 * i;
            const ToolTick& tick = bench.tick(
                pose_at({0.03 * std::cos(angle), 0.03 * std::sin(angle), 0.05 - 1e-4 * i},
                        {angle, 0, 2 * angle}));
            largest = std::max(largest, tick.work);
            cut += tick.end == ToolEnd::cut_short ? 1 : 0;
            ASSERT_FALSE(bench.meets()) << i;
        }
        // The tick finishes the lists that it has begun, here two of 2,048 pairs.
        if (most > 0) {
            EXPECT_LE(largest, most + 800);
        }
        EXPECT_EQ(cut > 0, most > 0);
        std::cout << "at most " << most << ": work " << largest << ", " << cut
                  << " ticks cut short\n";
        for (int i = 0; i < 200; ++i) bench.tick(pose_at({0.03, 0, 0.02}));
        const Vec3& rest = bench.renderer().last().spring_force;
        if (most == 0) stretch = rest.norm();
        if (most >= 400) {
            EXPECT_NEAR(rest.norm(), stretch, 0.02 * stretch);
        }
    }
}

TEST(ToolRenderer, SeveralObjectsAreTouchedWhereTheyStand)
{
    // Two slabs that lean on each other make a groove of 90 degrees for the box on its edge.
    const TriangleMesh slab = box_mesh({0.05, 0.05, 0.005}, {0, 0, -0.005});
    const double turn = std::numbers::pi / 4;
    ToolBench bench(box_mesh(Vec3::Constant(half)),
                    {{index_of(slab), pose_at(Vec3(-0.02, 0, 0.02), {0, turn, 0})},
                     {index_of(slab), pose_at(Vec3(0.02, 0, 0.02), {0, -turn, 0})}});
    bench.start(pose_at({0, 0, 0.06}, {0, turn, 0}));
    const double rest = half * std::numbers::sqrt2;
    const ToolTick& tick = bench.lead(pose_at({0, 0, rest - 0.003}, {0, turn, 0}), 200);
    EXPECT_NEAR(tick.force.z(), 500 * (0.003 + 1e-5 * std::numbers::sqrt2), 1e-4);
    double on[2] = {0, 0};
    for (std::size_t i = 0; i < tick.contact_count; ++i)
        on[tick.contacts[i].object] += tick.contacts[i].force;
    EXPECT_NEAR(on[0], tick.force.z() / std::numbers::sqrt2, 1e-3);
    EXPECT_NEAR(on[1], tick.force.z() / std::numbers::sqrt2, 1e-3);
}

TEST(ToolRenderer, WrongOptionsAreNamed)
{
    const MeshIndex tool = index_of(box_mesh(Vec3::Constant(half)));
    const ToolObject object = {tool, pose_at({0, 0, 1})};
    const auto error_of = [&](const ToolRenderOptions& options, const ToolObject& touched) {
        const auto made = make_tool_renderer(tool, std::span(&touched, 1), WorkspaceMap{},
                                             strong_device(), options);
        return made ? std::string("none") : made.error().where;
    };
    EXPECT_EQ(error_of({}, object), "none");
    EXPECT_EQ(error_of({.torsional_stiffness = -1}, object), "torsional_stiffness");
    EXPECT_EQ(error_of({.static_friction = -1, .dynamic_friction = -1}, object), "static_friction");
    EXPECT_EQ(error_of({.static_friction = 0.2}, object), "dynamic_friction");
    EXPECT_EQ(error_of({.clearance = 0}, object), "clearance");
    EXPECT_EQ(error_of({.clearance = 1e-12}, object), "clearance"); // lost in rounding
    EXPECT_EQ(error_of({.max_moves = 0}, object), "max_moves");
    EXPECT_EQ(error_of({.max_work = 99}, object), "max_work");
    EXPECT_EQ(error_of({.max_work = 0}, object), "none");
    EXPECT_EQ(error_of({}, {tool, {2 * Mat3::Identity(), Vec3::Zero()}}), "objects");
}

} // namespace
} // namespace proxima::testing::tool_renderer_test
