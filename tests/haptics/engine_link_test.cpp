#include "haptics/channel/engine_link.h"

#include "counted_allocations.h"
#include "haptics/engine_side.h"
#include "haptics/force/surface_renderer.h"
#include "haptics/loop/recording.h"
#include "haptics/scenes_to_touch.h"
#include "lab/hand_device.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <random>

namespace proxima::engine_link_test {
namespace {

using namespace testing;

constexpr double tick_seconds = 1e-3;
constexpr std::int64_t ms = 1'000'000;
constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();
constexpr double endless = std::numeric_limits<double>::infinity();

/// ns: when a tick begins by the clock of the tests.
constexpr std::int64_t time_of(std::uint64_t tick)
{
    return 5'000'000'000 + static_cast<std::int64_t>(tick) * ms;
}

/// Two cubes, one above the other, within a box of +-20.
struct TwoCubes {
    TwoCubes() : scene(wide_room)
    {
        const TouchBody body = body_of(*sample_mesh("cube"), {.material = SurfaceMaterial{}});
        EXPECT_TRUE(scene.add(body, at_place({0, 0, -1})));
        EXPECT_TRUE(scene.add(body, at_place({0, 0, 5})));
    }
    TouchScene scene;
};

std::unique_ptr<EngineLink> link_at(const std::string& name)
{
    auto transport = open_engine_transport(name);
    EXPECT_TRUE(transport) << describe(transport.error());
    return std::make_unique<EngineLink>(std::move(*transport));
}

/// What a session felt.
struct Felt {
    std::vector<RecordedTick> ticks;
    std::vector<SceneMessage> messages;
    std::vector<TouchPacket> heard;
    RecordingSettings settings;
    EngineReport report;
};

const WorkspaceMap map{20, Vec3::Zero()};
const DeviceLimits omni = *find_device("omni");

/// A simulated hand presses on the first cube, which an engine lifts, turns and softens 60 times a
/// second: the packets come at the same ticks by any transport.
Felt push_session(const std::string& name, std::uint64_t ticks)
{
    auto opened = open_engine_transport(name);
    EXPECT_TRUE(opened) << describe(opened.error());
    auto patient = std::make_unique<PatientTransport>(std::move(*opened));
    PatientTransport& transport = *patient;
    EngineLink link(std::move(patient));
    std::unique_ptr<EngineSide> engine;
    if (name.starts_with("udp:")) {
        engine = std::make_unique<UdpEngineSide>(link);
    } else {
        engine = std::make_unique<SharedEngineSide>(link);
    }
    TwoCubes cubes;
    auto renderer = make_haptic_renderer(cubes.scene, map, omni);
    EXPECT_TRUE(renderer);
    HandDevice device(
        "hand", {}, [](double seconds) { return Vec3(0.003 * std::sin(3 * seconds), 0, -0.01); },
        Vec3(0, 0, 0.01), omni);
    Felt felt;
    std::size_t allocated = 0;
    std::uint64_t sequence = 0;
    for (std::uint64_t tick = 0; tick < ticks; ++tick) {
        if (tick % 17 == 3) {
            const double seconds = 1e-3 * static_cast<double>(tick);
            ScenePacket packet = scene_packet(++sequence, time_of(tick));
            packet.material_seconds = 0.1;
            add_pose(packet, 0, {0, 0, -1 + 0.05 * std::sin(5 * seconds)},
                     posed(0.1 * seconds, {1, 2, 3}, Vec3::Zero()).rotation);
            if (sequence == 20) {
                PacketObject& object = add_pose(packet, 1, {0, 0.5, 5});
                object.flags |= PacketObject::has_material | PacketObject::has_velocity;
                object.velocity = {0, 0, 0.1};
                object.material = {200, 2, 0.8, 0.5};
            }
            if (sequence == 30) {
                packet.objects[0].flags |= PacketObject::has_material;
                packet.objects[0].material = {300, 1, 0.1, 0.05};
            }
            engine->send(bytes_of(packet));
            transport.expect();
        }
        const std::size_t before = allocation_count();
        const auto messages = link.receive(cubes.scene, tick, tick_seconds, time_of(tick));
        const DeviceState state = device.read().state;
        const RenderTick& rendered = renderer->tick(state, tick_seconds);
        device.write({.force = rendered.force});
        link.send(*renderer, state, time_of(tick));
        allocated += allocation_count() - before;
        felt.messages.insert(felt.messages.end(), messages.begin(), messages.end());
        felt.ticks.push_back(recorded(1e-3 * static_cast<double>(tick), state, rendered));
        const auto heard = engine->hear();
        felt.heard.insert(felt.heard.end(), heard.begin(), heard.end());
    }
    EXPECT_EQ(allocated, 0U);
    felt.report = link.report();
    return felt;
}

bool same_ticks(const Felt& a, const Felt& b)
{
    if (a.ticks.size() != b.ticks.size()) return false;
    for (std::size_t i = 0; i < a.ticks.size(); ++i)
        if (!same_response(a.ticks[i], b.ticks[i])) return false;
    return true;
}

TEST(EngineLink, BothTransportsGiveTheSameForces)
{
    const Felt udp = push_session("udp:0", 1500);
    const Felt shared = push_session("shm:" + segment_name("push"), 1500);
    EXPECT_TRUE(same_ticks(udp, shared));
    for (const Felt* const felt : {&udp, &shared}) {
        EXPECT_EQ(felt->report.accepted, 89U);
        EXPECT_EQ(felt->report.motions, 90U);
        EXPECT_EQ(felt->report.materials, 2U);
        EXPECT_EQ(felt->report.lost + felt->report.refused_objects, 0U);
        ASSERT_FALSE(felt->heard.empty());
        double most = 0;
        for (const TouchPacket& packet : felt->heard) {
            const RecordedTick& tick = felt->ticks[packet.sequence - 1];
            EXPECT_EQ(packet.force, Vec3(tick.force[0], tick.force[1], tick.force[2]));
            EXPECT_EQ(packet.proxy, Vec3(tick.proxy[0], tick.proxy[1], tick.proxy[2]));
            EXPECT_EQ(packet.torque, Vec3(0, 0, 0));
            most = std::max(most, packet.force.norm());
            if (packet.contact_count > 0) {
                EXPECT_EQ(packet.contacts[0].object, 0U);
                EXPECT_EQ(packet.contacts[0].triangle, tick.triangle);
            }
        }
        EXPECT_GT(most, 0.5);
    }
    EXPECT_EQ(shared.heard.size(), 1500U);
    EXPECT_EQ(udp.heard.size(), 1500U - 3U); // from the first packet on
    EXPECT_EQ(udp.heard.back().engine_sequence, 89U);
}

// What came is enough to feel the session again, without an engine.
TEST(EngineLink, MessagesReplayTheSession)
{
    const Felt felt = push_session("udp:0", 1000);
    TwoCubes cubes;
    auto renderer = make_haptic_renderer(cubes.scene, map, omni);
    ASSERT_TRUE(renderer);
    std::size_t next = 0;
    std::uint64_t differences = 0;
    for (std::uint64_t tick = 0; tick < felt.ticks.size(); ++tick) {
        for (; next < felt.messages.size() && felt.messages[next].tick == tick; ++next)
            ASSERT_TRUE(apply(felt.messages[next], cubes.scene));
        const DeviceState state = device_state(felt.ticks[tick]);
        const RenderTick& rendered = renderer->tick(state, tick_seconds);
        differences += same_response(recorded(0, state, rendered), felt.ticks[tick]) ? 0U : 1U;
    }
    EXPECT_EQ(next, felt.messages.size());
    EXPECT_EQ(differences, 0U);
}

/// Gives the link a packet in a tick, and applies it.
void give(EngineLink& link, TouchScene& scene, const ScenePacket& packet, std::uint64_t tick)
{
    link.take(bytes_of(packet), {}, time_of(tick));
    (void)link.receive(scene, tick, tick_seconds, time_of(tick));
}

// An engine without velocities: the object arrives evenly, one period after its pose came.
TEST(EngineLink, AnObjectArrivesAfterAPeriod)
{
    TwoCubes cubes;
    const auto link = link_at("udp:0");
    for (std::uint64_t n = 0; n < 3; ++n) {
        ScenePacket packet = scene_packet(n + 1, time_of(10 * n));
        add_pose(packet, 0, {0.1 * static_cast<double>(n), 0, -1});
        give(*link, cubes.scene, packet, 10 * n);
        if (n == 0) (void)cubes.scene.advance(tick_seconds); // the first period is not known yet
        if (n == 0) continue;
        for (int i = 1; i <= 10; ++i) {
            (void)cubes.scene.advance(tick_seconds);
            const double expected = 0.1 * static_cast<double>(n - 1) + 0.01 * i;
            EXPECT_NEAR(cubes.scene.pose(ObjectId{0}).translation.x(), expected, 1e-12);
        }
    }
    // One that is late by 4 ms has 6 ms left.
    ScenePacket packet = scene_packet(4, time_of(30));
    add_pose(packet, 0, {0.3, 0, -1});
    give(*link, cubes.scene, packet, 34);
    for (int i = 0; i < 6; ++i) (void)cubes.scene.advance(tick_seconds);
    EXPECT_NEAR(cubes.scene.pose(ObjectId{0}).translation.x(), 0.3, 1e-12);
}

// Two objects, each with a pose every 16 ms, and packets without poses just before: each motion takes 16 ms.
TEST(EngineLink, PeriodsAreThoseOfTheObjectsPoses)
{
    TwoCubes cubes;
    const auto link = link_at("udp:0");
    std::uint64_t sequence = 0;
    const auto give_at = [&](ScenePacket packet, std::uint64_t tick, std::int64_t earlier) {
        packet.sequence = ++sequence;
        packet.nanoseconds -= static_cast<std::uint64_t>(earlier);
        link->take(bytes_of(packet), {}, time_of(tick) - earlier);
    };
    constexpr std::uint64_t period = 16;
    std::array<double, 2> from{};
    for (std::uint64_t tick = 0; tick < 160; ++tick) {
        const std::uint64_t object = tick % period == 0 ? 0 : 1;
        if (tick % 8 == 0) {
            // One that keeps the session alive, and one with a material.
            give_at(scene_packet(0, time_of(tick)), tick, 100'000);
            ScenePacket material = scene_packet(0, time_of(tick));
            add_pose(material, 0, {}).flags = PacketObject::has_material;
            give_at(material, tick, 50'000);
            ScenePacket packet = scene_packet(0, time_of(tick));
            add_pose(packet, static_cast<std::uint32_t>(object),
                     {0.01 * static_cast<double>(tick), 0, object == 0 ? -1.0 : 5.0});
            // A lost packet between two poses makes the time between packets half as long.
            if (tick == 144) ++sequence;
            give_at(packet, tick, 0);
            from[object] =
                cubes.scene.pose(ObjectId{static_cast<std::uint32_t>(object)}).translation.x();
        }
        (void)link->receive(cubes.scene, tick, tick_seconds, time_of(tick));
        (void)cubes.scene.advance(tick_seconds);
        if (tick < 48) continue; // the first motions take a period that is not known yet
        for (const std::uint32_t moved : {0U, 1U}) {
            const std::uint64_t since = (tick + 8 * moved) % period + 1;
            const std::uint64_t told = tick + 1 - since;
            const double takes = told >= 144 ? 8 : 16;
            const double part = std::min(1.0, static_cast<double>(since) / takes);
            const double to = 0.01 * static_cast<double>(told);
            ASSERT_NEAR(cubes.scene.pose(ObjectId{moved}).translation.x(),
                        from[moved] + part * (to - from[moved]), 1e-9)
                << "object " << moved << ", tick " << tick;
        }
    }
    EXPECT_EQ(link->report().lost, 1U);
}

// With velocities it goes on when a packet is lost, and rests when the engine is silent.
TEST(EngineLink, AnObjectCoastsForTwoPeriods)
{
    TwoCubes cubes;
    const auto link = link_at("udp:0");
    ScenePacket packet = scene_packet(1, time_of(0));
    packet.period = 0.01;
    PacketObject& object = add_pose(packet, 0, {0.1, 0, -1});
    object.flags |= PacketObject::has_velocity;
    object.velocity = {1, 0, 0};
    give(*link, cubes.scene, packet, 0);
    for (int i = 0; i < 20; ++i) (void)cubes.scene.advance(tick_seconds);
    EXPECT_NEAR(cubes.scene.pose(ObjectId{0}).translation.x(), 0.11, 1e-9);
    for (int i = 0; i < 100; ++i) (void)cubes.scene.advance(tick_seconds);
    EXPECT_NEAR(cubes.scene.pose(ObjectId{0}).translation.x(), 0.12, 1e-9);
    // At the edge of the scene it stops instead.
    packet = scene_packet(2, time_of(200));
    packet.period = 0.01;
    PacketObject& far = add_pose(packet, 0, {18.99, 0, -1});
    far.flags |= PacketObject::has_velocity;
    far.velocity = {1, 0, 0};
    give(*link, cubes.scene, packet, 200);
    for (int i = 0; i < 100; ++i) (void)cubes.scene.advance(tick_seconds);
    EXPECT_EQ(cubes.scene.pose(ObjectId{0}).translation.x(), 18.99);
    EXPECT_EQ(link->report().refused_objects, 0U);
}

// A network that loses, repeats, delays and reorders: the object moves on, never back, never in jumps.
TEST(EngineLink, ABadNetworkMakesNoJumps)
{
    for (const std::uint64_t seed : {1U, 2U, 3U}) {
        SCOPED_TRACE(seed);
        std::mt19937_64 random(seed);
        const auto chance = [&](double part) {
            return std::uniform_real_distribution<double>(0, 1)(random) < part;
        };
        constexpr double speed = 0.5; // per second
        constexpr std::uint64_t period = 10;
        std::multimap<std::uint64_t, ScenePacket> under_way; // by the tick of arrival
        constexpr std::uint64_t packets = 300;
        for (std::uint64_t n = 0; n < packets; ++n) {
            ScenePacket packet = scene_packet(n + 1, time_of(n * period));
            add_pose(packet, 0, {speed * 1e-3 * static_cast<double>(n * period), 0, -1});
            const bool is_needed = n < 2 || n + 1 == packets;
            if (!is_needed && chance(0.1)) continue;
            const std::uint64_t delay = is_needed ? 0 : random() % 25;
            under_way.emplace(n * period + delay, packet);
            if (chance(0.1)) under_way.emplace(n * period + delay + random() % 25, packet);
        }
        TwoCubes cubes;
        const auto link = link_at("udp:0");
        double last = 0;
        double fastest = 0;
        for (std::uint64_t tick = 0; tick < packets * period + 100; ++tick) {
            const auto [begin, end] = under_way.equal_range(tick);
            for (auto it = begin; it != end; ++it)
                link->take(bytes_of(it->second), {}, time_of(tick));
            (void)link->receive(cubes.scene, tick, tick_seconds, time_of(tick));
            (void)cubes.scene.advance(tick_seconds);
            const double x = cubes.scene.pose(ObjectId{0}).translation.x();
            ASSERT_GE(x, last - 1e-12) << tick;
            fastest = std::max(fastest, x - last);
            last = x;
        }
        EXPECT_NEAR(last, speed * 1e-3 * (packets - 1) * period, 1e-9);
        // A pose is at least half a period under way; without a rule it would be there in one tick.
        const EngineReport& report = link->report();
        const double periods_missed = fastest / (speed * 1e-3) / 2;
        EXPECT_LE(periods_missed, 8) << "in one tick: " << 2 * periods_missed << " ticks' motion";
        EXPECT_GT(report.duplicated + report.reordered, 20U);
        EXPECT_GT(report.lost, 20U);
        EXPECT_EQ(report.received, under_way.size());
        EXPECT_EQ(report.accepted + report.duplicated + report.reordered, report.received);
    }
}

TEST(EngineLink, WhatCannotBeIsRefusedAndCounted)
{
    TwoCubes cubes;
    const auto link = link_at("udp:0");
    std::uint64_t sequence = 0;
    std::uint64_t tick = 0;
    const auto give_object = [&](const std::function<void(PacketObject&)>& change) {
        ScenePacket packet = scene_packet(++sequence, time_of(tick += 10));
        PacketObject& object = add_pose(packet, 0, {1, 1, 1});
        object.flags =
            PacketObject::has_pose | PacketObject::has_velocity | PacketObject::has_material;
        object.material = {400, 1, 0.4, 0.3};
        change(object);
        give(*link, cubes.scene, packet, tick);
        // As long as the motion of an object takes whose last pose came long ago.
        for (int i = 0; i < 100; ++i) (void)cubes.scene.advance(tick_seconds);
    };
    const std::vector<std::function<void(PacketObject&)>> wrong = {
        [](PacketObject& o) { o.object = 2; },
        [](PacketObject& o) { o.object = 64; },
        [](PacketObject& o) { o.object = ~0U; },
        [](PacketObject& o) { o.flags |= 8; },
        [](PacketObject& o) { o.flags = PacketObject::has_velocity; },
        [](PacketObject& o) { o.position.y() = not_a_number; },
        [](PacketObject& o) { o.position.y() = endless; },
        [](PacketObject& o) { o.position.y() = 1e308; },
        [](PacketObject& o) { o.position.y() = 19.5; },
        [](PacketObject& o) {
            o.quaternion = {0, 0, 0, 0};
        },
        [](PacketObject& o) {
            o.quaternion = {1.01, 0, 0, 0};
        },
        [](PacketObject& o) {
            o.quaternion = {1e308, 1e308, 0, 0};
        },
        [](PacketObject& o) {
            o.quaternion = {not_a_number, 0, 0, 0};
        },
        [](PacketObject& o) { o.velocity.x() = not_a_number; },
        [](PacketObject& o) { o.velocity.x() = -endless; },
        [](PacketObject& o) { o.spin.x() = not_a_number; },
        [](PacketObject& o) { o.spin.x() = 1e300; },
        [](PacketObject& o) { o.material.stiffness = -1; },
        [](PacketObject& o) { o.material.stiffness = endless; },
        [](PacketObject& o) { o.material.stiffness = 1e10; },
        [](PacketObject& o) { o.material.damping = not_a_number; },
        [](PacketObject& o) { o.material.dynamic_friction = 0.5; },
    };
    for (std::size_t i = 0; i < wrong.size(); ++i) {
        give_object(wrong[i]);
        EXPECT_EQ(link->report().refused_objects, i + 1) << i;
        EXPECT_EQ(cubes.scene.pose(ObjectId{0}).translation, Vec3(0, 0, -1)) << i;
    }
    EXPECT_EQ(link->report().accepted, wrong.size());
    give_object([](PacketObject&) {});
    EXPECT_EQ(link->report().refused_objects, wrong.size());
    EXPECT_NEAR((cubes.scene.pose(ObjectId{0}).translation - Vec3(1, 1, 1)).norm(), 0, 1e-15);
    // Nothing counts of a packet whose own numbers are out of range.
    for (const double number : {-1e-9, 11.0, endless, not_a_number}) {
        for (double ScenePacket::*const field :
             {&ScenePacket::period, &ScenePacket::material_seconds}) {
            ScenePacket packet = scene_packet(++sequence, time_of(tick));
            packet.*field = number;
            link->take(bytes_of(packet), {}, time_of(tick));
        }
    }
    ScenePacket packet = scene_packet(++sequence, time_of(tick));
    packet.reply_every = 1001;
    link->take(bytes_of(packet), {}, time_of(tick));
    EXPECT_EQ(link->report().malformed, 9U);
    EXPECT_EQ(link->report().accepted, wrong.size() + 1);
    // Another version is named.
    auto bytes = bytes_of(scene_packet(++sequence, time_of(tick)));
    bytes[4] = std::byte{7};
    link->take(bytes, {}, time_of(tick));
    EXPECT_NE(link->trouble().find("have version 7 of the protocol, and this program has 2"),
              std::string::npos)
        << link->trouble();
}

TEST(EngineLink, AMaterialCountsBesideAPoseOutOfBounds)
{
    TwoCubes cubes;
    const auto link = link_at("udp:0");
    ScenePacket packet = scene_packet(1, time_of(0));
    for (const std::uint32_t object : {0U, 2U}) { // the second is not in the scene
        PacketObject& added = add_pose(packet, object, {0, 19.5, 0});
        added.flags |= PacketObject::has_material;
        added.material = {200, 2, 0.8, 0.5};
    }
    link->take(bytes_of(packet), {}, time_of(0));
    const auto messages = link->receive(cubes.scene, 0, tick_seconds, time_of(0));
    ASSERT_EQ(messages.size(), 1U);
    EXPECT_TRUE(messages[0].has_material);
    EXPECT_FALSE(messages[0].has_motion);
    EXPECT_EQ(messages[0].material.stiffness, 200);
    EXPECT_EQ(link->report().refused_objects, 2U);
    EXPECT_EQ(link->report().motions, 0U);
    EXPECT_EQ(link->report().materials, 1U);
}

TEST(EngineLink, OneEngineAtATimeAndOnlyWhileItIsThere)
{
    TwoCubes cubes;
    auto renderer = make_haptic_renderer(cubes.scene, map, omni);
    ASSERT_TRUE(renderer);
    const auto link = link_at("udp:0");
    const UdpAddress first{0x7f000001, 4000};
    const UdpAddress second{0x7f000001, 4001};
    const auto sent_in = [&](std::uint64_t begin, std::uint64_t end) {
        const std::uint64_t before = link->report().sent;
        for (std::uint64_t tick = begin; tick < end; ++tick)
            link->send(*renderer, {}, time_of(tick));
        return link->report().sent - before;
    };
    EXPECT_EQ(sent_in(0, 10), 0U); // there is nobody
    link->take(bytes_of(scene_packet(5, time_of(10))), first, time_of(10));
    ScenePacket other = scene_packet(1, time_of(11));
    other.session = 1;
    link->take(bytes_of(other), second, time_of(11));
    EXPECT_EQ(link->report().foreign, 1U);
    EXPECT_EQ(sent_in(10, 20), 10U);
    EXPECT_EQ(sent_in(1011, 1020), 0U); // silent for a second
    link->take(bytes_of(other), second, time_of(1011));
    EXPECT_EQ(link->report().sessions, 2U);
    ScenePacket rare = scene_packet(2, time_of(1020));
    rare.session = 1;
    rare.reply_every = 10;
    link->take(bytes_of(rare), second, time_of(1020));
    EXPECT_EQ(sent_in(1020, 1120), 10U);
    rare.sequence = 3;
    rare.reply_every = 0; // an answer to each packet
    link->take(bytes_of(rare), second, time_of(1120));
    EXPECT_EQ(sent_in(1120, 1220), 1U);
    rare.sequence = 4;
    rare.flags = ScenePacket::leaving;
    link->take(bytes_of(rare), second, time_of(1220));
    EXPECT_EQ(sent_in(1220, 1230), 0U);
    // It left: the next one need not wait.
    link->take(bytes_of(scene_packet(6, time_of(1231))), first, time_of(1231));
    EXPECT_EQ(link->report().sessions, 3U);
    EXPECT_EQ(sent_in(1231, 1241), 10U);
}

/// Runs a renderer beside a link for a tick: the device comes from above, and goes into the first cube
/// again and again. What it gets must be what a device may get.
void feel(HapticRenderer& renderer, EngineLink& link, TouchScene& scene, std::uint64_t tick)
{
    const std::size_t before = allocation_count();
    (void)link.receive(scene, tick, tick_seconds, time_of(tick));
    DeviceState state;
    state.pose.translation = {0, 0, 0.005 * std::cos(0.02 * static_cast<double>(tick))};
    const RenderTick& rendered = renderer.tick(state, tick_seconds);
    link.send(renderer, state, time_of(tick));
    ASSERT_EQ(allocation_count(), before);
    ASSERT_TRUE(rendered.force.allFinite());
    ASSERT_LE(rendered.force.norm(), omni.max_force);
}

// Any bytes, behind right headers or not, as datagrams. They may have moved the cubes anywhere, even round the
// hand; an engine that comes after them puts them back, and one is felt.
TEST(EngineLink, RandomPacketsDoNoHarm)
{
    const std::uint64_t seed = std::random_device()();
    SCOPED_TRACE(seed);
    std::mt19937_64 random(seed);
    TwoCubes cubes;
    auto renderer = make_haptic_renderer(cubes.scene, map, omni);
    ASSERT_TRUE(renderer);
    const auto link = link_at("udp:0");
    constexpr std::uint64_t random_ticks = 3000;
    for (std::uint64_t tick = 0; tick < random_ticks; ++tick) {
        ScenePacket packet = scene_packet(tick + 1, time_of(tick));
        packet.count = random() % 4;
        for (PacketObject& object : std::span(packet.objects).first(packet.count)) {
            add_pose(packet, 0, Vec3::Zero());
            --packet.count;
            object.object = static_cast<std::uint32_t>(random() % 3);
            object.flags = static_cast<std::uint32_t>(random() % 8);
        }
        auto bytes = bytes_of(packet);
        // Some bytes beyond the header are anything, and some packets end early.
        const std::size_t changes = random() % 8;
        for (std::size_t i = 0; i < changes; ++i) {
            const std::size_t from = random() % 4 == 0 ? 0 : 40;
            bytes[from + random() % (bytes.size() - from)] = static_cast<std::byte>(random());
        }
        if (random() % 8 == 0) bytes.resize(random() % bytes.size());
        link->take(bytes, {}, time_of(tick));
        feel(*renderer, *link, cubes.scene, tick);
        if (HasFatalFailure()) return;
    }
    EXPECT_GT(link->report().accepted, 500U);
    EXPECT_GT(link->report().malformed, 50U);
    // What was accepted last is forgotten after a while without packets.
    const std::uint64_t silence = 5000;
    std::uint64_t touching = 0;
    for (std::uint64_t tick = random_ticks + silence; tick < random_ticks + silence + 2000;
         ++tick) {
        ScenePacket packet = scene_packet(tick + 1, time_of(tick));
        packet.session = engine_session + 1;
        add_pose(packet, 0, {0, 0, -1});
        add_pose(packet, 1, {0, 0, 5});
        link->take(bytes_of(packet), {}, time_of(tick));
        feel(*renderer, *link, cubes.scene, tick);
        if (HasFatalFailure()) return;
        touching += renderer->last().contact_count > 0 ? 1U : 0U;
    }
    EXPECT_GT(touching, 500U);
}

// Somebody who may write anywhere in the shared memory, at any time.
TEST(EngineLink, AnythingInSharedMemoryDoesNoHarm)
{
    const std::uint64_t seed = std::random_device()();
    SCOPED_TRACE(seed);
    std::mt19937_64 random(seed);
    TwoCubes cubes;
    auto renderer = make_haptic_renderer(cubes.scene, map, omni);
    ASSERT_TRUE(renderer);
    const std::string name = segment_name("scribble");
    const auto link = link_at("shm:" + name);
    const MappedSegment memory(name);
    std::uint64_t written = 0;
    std::uint64_t touching = 0;
    const auto store = [&](std::size_t offset, std::uint64_t number) {
        std::memcpy(memory.bytes().data() + offset, &number, sizeof number);
    };
    for (std::uint64_t tick = 0; tick < 2000; ++tick) {
        // Packets that are right, so that there is something to spoil.
        ScenePacket packet = scene_packet(tick + 1, time_of(tick));
        add_pose(packet, 0, {0, 0, -1 + 0.01 * std::sin(0.05 * static_cast<double>(tick))});
        write_packet(memory.bytes(), scene_ring, written++, bytes_of(packet));
        const std::size_t changes = random() % 16;
        for (std::size_t i = 0; i < changes; ++i)
            store(8 * (random() % (segment_size / 8)), random());
        const std::size_t slot =
            scene_ring.offset + scene_ring.slot_size * ((written - 1) % scene_ring.slots);
        if (random() % 4 == 0) store(slot + 8 + 8 * (random() % 20), random());
        if (random() % 16 == 0) written = random();
        if (random() % 16 == 0) store(scene_ring.count_offset, random());
        feel(*renderer, *link, cubes.scene, tick);
        if (HasFatalFailure()) return;
        touching += renderer->last().contact_count > 0 ? 1U : 0U;
    }
    EXPECT_GT(link->report().accepted, 100U);
    EXPECT_GT(link->report().malformed + link->report().refused_objects, 10U);
    EXPECT_GT(touching, 100U);
}

TEST(EngineLink, SharedMemoryThatIsShortenedEndsTheChannelAlone)
{
    TwoCubes cubes;
    auto renderer = make_haptic_renderer(cubes.scene, map, omni);
    ASSERT_TRUE(renderer);
    const std::string name = segment_name("shortened");
    const auto link = link_at("shm:" + name);
    for (std::uint64_t tick = 0; tick < 10; ++tick) feel(*renderer, *link, cubes.scene, tick);
    EXPECT_EQ(truncate(("/dev/shm/proxima-" + name).c_str(), 0), 0);
    double most = 0;
    for (std::uint64_t tick = 10; tick < 2000; ++tick) {
        feel(*renderer, *link, cubes.scene, tick);
        most = std::max(most, renderer->last().force.norm());
    }
    EXPECT_NE(link->trouble().find("shortened the memory of shm:"), std::string::npos);
    EXPECT_GT(most, 0.5);
}

TEST(EngineChannel, IsOpenedByName)
{
    TwoCubes cubes;
    auto renderer = make_haptic_renderer(cubes.scene, map, omni);
    ASSERT_TRUE(renderer);
    for (const std::string& name : {std::string("udp:0"), "shm:" + segment_name("public")}) {
        auto channel = open_engine_channel(name);
        ASSERT_TRUE(channel) << describe(channel.error());
        channel->receive(cubes.scene, tick_seconds);
        channel->send(*renderer, {});
        EXPECT_EQ(channel->report().sent, name.starts_with("shm") ? 1U : 0U);
        EXPECT_NE(channel->trouble().find("no packet arrived at " + name.substr(0, 4)),
                  std::string::npos);
    }
    for (const char* const wrong : {"", "udp:", "udp:x", "shm:", "shm:a/b", "shm:../x", "tcp:1"})
        EXPECT_FALSE(open_engine_channel(wrong)) << wrong;
    EXPECT_FALSE(open_engine_channel("shm:" + std::string(65, 'a')));
}

/// Keeps the last packet that an engine gets.
class KeptTransport final : public EngineTransport {
public:
    explicit KeptTransport(TouchPacket& last) : last_(last) {}
    [[nodiscard]] std::string name() const override { return "kept"; }
    [[nodiscard]] std::optional<UdpSocket::Received>
    receive(std::span<std::byte> /*buffer*/) noexcept override
    {
        return {};
    }
    bool send(std::span<const std::byte, touch_packet_size> packet,
              const UdpAddress& /*to*/) noexcept override
    {
        return decode(packet, last_) == PacketFault::none;
    }
    [[nodiscard]] bool keeps_packets() const noexcept override { return true; }

private:
    TouchPacket& last_;
};

// A cube that slides aside, below a hand that shakes until the guard damps and softens the cube.
TEST(EngineLink, SaysAllOfATick)
{
    TwoCubes cubes;
    const WorkspaceMap lifted{20, {0.1, 0.2, 0.3}};
    auto renderer = make_haptic_renderer(cubes.scene, lifted, omni);
    ASSERT_TRUE(renderer);
    const SurfaceRenderer& parts = parts_of(*renderer);
    TouchPacket packet;
    EngineLink link(std::make_unique<KeptTransport>(packet));
    const double root = std::sqrt(0.5);
    std::size_t ramping = 0;
    std::size_t holds[3] = {0, 0, 0};
    for (std::uint64_t tick = 0; tick < 1200; ++tick) {
        const bool is_last = tick == 1199;
        const double swing = 1e-3 * std::sin(0.9 * static_cast<double>(tick));
        const double z = tick < 300 ? 0.002 : swing - 0.001; // m, from the cube's upper side
        if (tick == 300) {
            ASSERT_TRUE(cubes.scene.move(ObjectId{0}, {at_place({0.3, 0, -1}), 1}));
        }
        DeviceState state;
        state.pose = posed(std::acos(0), Vec3::UnitZ(), Vec3(0.0001, -0.01, z - 0.3 / 20));
        state.buttons = 5;
        state.condition = is_last ? InputCondition::frozen : InputCondition::well;
        const RenderTick& felt = renderer->tick(state, tick_seconds);
        link.send(*renderer, state, time_of(tick));
        ASSERT_EQ(packet.sequence, tick + 1);
        EXPECT_EQ(packet.nanoseconds, 5'000'000'000 + tick * 1'000'000);
        EXPECT_EQ(packet.condition, is_last ? 3U : 0U);
        EXPECT_EQ(packet.buttons, 5U);
        EXPECT_EQ(packet.units_per_metre, 20);
        EXPECT_EQ(packet.center, Vec3(0.1, 0.2, 0.3));
        EXPECT_NEAR((packet.device - Vec3(0.102, 0, 20 * z)).norm(), 0, 1e-15);
        const Eigen::Vector4d rotation(packet.rotation.data());
        EXPECT_NEAR((rotation - Eigen::Vector4d(root, 0, 0, root)).norm(), 0, 1e-15);
        EXPECT_EQ(packet.proxy, felt.proxy);
        EXPECT_EQ(packet.anchor, felt.anchor);
        EXPECT_EQ(packet.force, felt.force);
        EXPECT_EQ(packet.torque, Vec3::Zero());
        EXPECT_EQ(packet.force_scale, parts.guard().ramp());
        EXPECT_EQ(packet.softness, parts.passivity().softness());
        EXPECT_EQ(packet.added_damping, parts.passivity().added_damping());
        const bool touches = z < 0;
        ASSERT_EQ(packet.contact_count, touches ? 1U : 0U);
        EXPECT_EQ(packet.hold != 0, touches);
        EXPECT_EQ(packet.normal, Vec3(0, 0, touches ? 1 : 0));
        EXPECT_NEAR(packet.depth, touches ? -20 * z : 0, 1e-12);
        const Vec3 velocity(touches ? 0.3 / 20 : 0, 0, 0);
        EXPECT_NEAR((packet.surface_velocity - velocity).norm(), 0, 1e-12);
        for (std::size_t i = 0; i < packet.contact_count; ++i) {
            EXPECT_EQ(packet.contacts[i].position, felt.contacts[i].position);
            EXPECT_EQ(packet.contacts[i].normal, Vec3::UnitZ());
            EXPECT_EQ(packet.contacts[i].pressure, felt.contacts[i].pressure);
        }
        ramping += packet.force_scale > 0 && packet.force_scale < 1 ? 1U : 0U;
        ++holds[packet.hold];
    }
    EXPECT_GT(ramping, 200U);
    EXPECT_GT(holds[1], 50U);
    EXPECT_GT(holds[2], 50U);
    EXPECT_LT(packet.softness, 0.5);
    EXPECT_GT(packet.added_damping, 0.1);
    EXPECT_GT(packet.contacts[0].pressure, 0);
    EXPECT_GT((packet.anchor - packet.device).norm(), 0.005);
}

TEST(EngineLink, FlagsSayWhatBecameOfATick)
{
    TwoCubes cubes; // the upper side of the first one is z = 0
    auto renderer = make_haptic_renderer(cubes.scene, map, omni);
    ASSERT_TRUE(renderer);
    TouchPacket packet;
    EngineLink link(std::make_unique<KeptTransport>(packet));
    std::uint64_t tick = 0;
    const auto flags_at = [&](const Vec3& position) {
        DeviceState state;
        state.pose.translation = position;
        (void)renderer->tick(state, tick_seconds);
        link.send(*renderer, state, time_of(tick++));
        return packet.flags;
    };
    EXPECT_EQ(flags_at({0, 0, -0.02}), 0U); // within the cube the proxy has no position
    for (int i = 0; i < 300; ++i) EXPECT_EQ(flags_at({0, 0, 0.001}), 1U) << i;
    // At 500 N/m. At most 3.3 N are allowed, and changes of 2 N a tick.
    EXPECT_EQ(flags_at({0, 0, -0.002}), 1U);  // 1 N
    EXPECT_EQ(flags_at({0, 0, -0.0055}), 1U); // 2.75 N
    EXPECT_EQ(flags_at({0, 0, -0.0075}), 9U); // 3.75 N
    EXPECT_EQ(flags_at({0, 0, -0.0075}), 9U);
    EXPECT_EQ(flags_at({0, 0, -0.002}), 17U); // 1 N: 2.3 N less
    EXPECT_EQ(flags_at({0, 0, -0.002}), 1U);
    EXPECT_EQ(flags_at({0, 0, 0.001}), 1U);
    EXPECT_EQ(flags_at({0, 0, 0.061}), 5U); // 6 cm in a tick
    EXPECT_EQ(flags_at({0, 0, 0.061}), 1U);
    // Another device between the cubes, the upper of which comes down onto the lower one.
    renderer->reset();
    ASSERT_TRUE(cubes.scene.move(ObjectId{1}, {at_place({0, 0, 1}), 0.2}));
    std::uint32_t seen = 0;
    for (int i = 0; i < 300; ++i) seen |= flags_at({0, 0, 0.01});
    EXPECT_EQ(seen & 2U, 2U);
}

TEST(EngineLink, TheFirstPoseTakesTwentyMilliseconds)
{
    TwoCubes cubes;
    const auto link = link_at("udp:0");
    ScenePacket packet = scene_packet(1, time_of(0));
    add_pose(packet, 0, {1, 0, -1});
    give(*link, cubes.scene, packet, 0);
    for (int i = 1; i <= 20; ++i) {
        (void)cubes.scene.advance(tick_seconds);
        EXPECT_NEAR(cubes.scene.pose(ObjectId{0}).translation.x(), 0.05 * i, 1e-12);
    }
}

// A packet every 10 ms. From a second on each is under way 4 ms longer, and two seconds later this is no delay.
TEST(EngineLink, TheQuickestPacketIsForgottenAfterTwoSeconds)
{
    TwoCubes cubes;
    const auto link = link_at("udp:0");
    for (std::uint64_t n = 0; n < 360; ++n) {
        const bool is_late = n >= 100;
        ScenePacket packet = scene_packet(n + 1, time_of(10 * n));
        add_pose(packet, 0, {n % 2 == 0 ? 0.0 : 1.0, 0, -1});
        give(*link, cubes.scene, packet, is_late ? 10 * n + 4 : 10 * n);
        for (int i = 0; i < 6; ++i) (void)cubes.scene.advance(tick_seconds);
        const double x = cubes.scene.pose(ObjectId{0}).translation.x();
        const double gone = n % 2 == 0 ? 1 - x : x;
        if (n >= 2 && n < 100) {
            EXPECT_NEAR(gone, 0.6, 1e-9) << n;
        }
        if (n >= 100 && n < 190) {
            EXPECT_NEAR(gone, 1, 1e-9) << n;
        }
        if (n >= 300) {
            EXPECT_NEAR(gone, 0.6, 1e-9) << n;
        }
        for (int i = 0; i < 4; ++i) (void)cubes.scene.advance(tick_seconds);
    }
}

} // namespace
} // namespace proxima::engine_link_test
