// Numbers out of range give an error that names them, before anything is made.
#include "code_of.h"
#include "proxima/device.h"
#include "proxima/haptic_renderer.h"
#include "proxima/mesh_index.h"
#include "proxima/sample_meshes.h"
#include "proxima/touch_scene.h"

#include <gtest/gtest.h>

#include <array>
#include <functional>
#include <limits>
#include <string>

namespace proxima::wrong_options_test {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double infinity = std::numeric_limits<double>::infinity();

struct Settings {
    WorkspaceMap map;
    DeviceLimits device = *find_device("omni");
    RenderOptions render;
};

/// What both factories say of the settings: the name of an option, or "" where they are right.
std::string named_by(const Settings& settings)
{
    const auto index = build_mesh_index(*sample_mesh("cube"));
    TouchScene scene({Vec3(-5, -5, -5), Vec3(5, 5, 5)});
    const auto of_index =
        make_haptic_renderer(*index, settings.map, settings.device, settings.render);
    const auto of_scene =
        make_haptic_renderer(scene, settings.map, settings.device, settings.render);
    EXPECT_EQ(of_index.has_value(), of_scene.has_value());
    if (of_index) return {};
    EXPECT_EQ(code_of(of_index), ErrorCode::invalid_argument);
    EXPECT_EQ(of_index.error().where, of_scene.error().where);
    EXPECT_FALSE(of_index.error().message.empty());
    return of_index.error().where;
}

TEST(MakeHapticRenderer, NamesTheNumberThatIsOutOfRange)
{
    using Change = std::function<double&(Settings&)>;
    struct Number {
        const char* name;
        double least;
        Change number;
    };
    const double above = std::numeric_limits<double>::min();
    const std::array<Number, 13> numbers = {
        {{"units_per_metre", above, [](Settings& s) -> double& { return s.map.units_per_metre; }},
         {"max_force", above, [](Settings& s) -> double& { return s.device.max_force; }},
         {"max_stiffness", 0, [](Settings& s) -> double& { return s.device.max_stiffness; }},
         {"max_damping", 0, [](Settings& s) -> double& { return s.device.max_damping; }},
         {"stiffness", 0, [](Settings& s) -> double& { return s.render.force.stiffness; }},
         {"damping", 0, [](Settings& s) -> double& { return s.render.force.damping; }},
         {"max_slew", 0, [](Settings& s) -> double& { return s.render.force.max_slew; }},
         {"start_seconds", 0, [](Settings& s) -> double& { return s.render.force.start_seconds; }},
         {"loss_seconds", 0, [](Settings& s) -> double& { return s.render.force.loss_seconds; }},
         {"proxy_radius", 0, [](Settings& s) -> double& { return s.render.proxy_radius; }},
         {"static_friction", 0.3, [](Settings& s) -> double& { return s.render.static_friction; }},
         {"dynamic_friction", 0, [](Settings& s) -> double& { return s.render.dynamic_friction; }},
         {"max_jump", 0, [](Settings& s) -> double& { return s.render.max_jump; }}}};
    for (const auto& [name, least, number] : numbers) {
        for (const double wrong : {-1.0, nan, infinity, -infinity}) {
            Settings settings;
            number(settings) = wrong;
            EXPECT_EQ(named_by(settings), name) << wrong;
        }
        Settings settings;
        number(settings) = least;
        EXPECT_EQ(named_by(settings), "") << name;
    }
}

TEST(MakeHapticRenderer, RefusesOtherWrongSettings)
{
    const auto named = [](const std::function<void(Settings&)>& change) {
        Settings settings;
        change(settings);
        return named_by(settings);
    };
    EXPECT_EQ(named([](Settings&) {}), "");
    EXPECT_EQ(named([](Settings& s) { s.map.units_per_metre = 0; }), "units_per_metre");
    EXPECT_EQ(named([](Settings& s) { s.device.max_force = 0; }), "max_force");
    EXPECT_EQ(named([](Settings& s) { s.map.center.y() = nan; }), "center");
    EXPECT_EQ(named([](Settings& s) { s.render.dynamic_friction = 0.5; }), "dynamic_friction");
    EXPECT_EQ(named([](Settings& s) { s.render.max_moves = 3; }), "max_moves");
    EXPECT_EQ(named([](Settings& s) { s.render.max_moves = 4; }), "");
    EXPECT_EQ(named([](Settings& s) { s.render.max_moves = 48; }), "");
    EXPECT_EQ(named([](Settings& s) { s.render.max_moves = 49; }), "max_moves");
}

TEST(MakeHapticRenderer, RefusesAnEmptyIndex)
{
    const auto renderer = make_haptic_renderer(MeshIndex(), {}, *find_device("omni"));
    ASSERT_FALSE(renderer);
    EXPECT_EQ(code_of(renderer), ErrorCode::invalid_mesh);
}

TEST(MakeDeviceInput, NamesTheOptionThatIsOutOfRange)
{
    const auto named = [](const DeviceInfo& info, const InputOptions& options) {
        const auto input = make_device_input(info, options);
        if (input) return std::string();
        EXPECT_EQ(code_of(input), ErrorCode::invalid_argument);
        return input.error().where;
    };
    EXPECT_EQ(named({}, {}), "");
    EXPECT_EQ(named({.patience = -1}, {}), "patience");
    for (const double wrong : {-1.0, nan, infinity}) {
        EXPECT_EQ(named({}, {.tick_seconds = wrong}), "tick_seconds");
        EXPECT_EQ(named({}, {.max_jump = wrong}), "max_jump");
        EXPECT_EQ(named({}, {.max_distance = wrong}), "max_distance");
        EXPECT_EQ(named({}, {.settle_seconds = wrong}), "settle_seconds");
        EXPECT_EQ(named({}, {.frozen_seconds = wrong}), "frozen_seconds");
        EXPECT_EQ(named({}, {.frozen_force = wrong}), "frozen_force");
    }
    EXPECT_EQ(named({}, {.tick_seconds = 0}), "tick_seconds");
    EXPECT_EQ(named({}, {.rotation = 2 * Mat3::Identity()}), "rotation");
    EXPECT_EQ(named({}, {.rotation = -Mat3::Identity()}), "rotation");
    EXPECT_EQ(named({}, {.rotation = Mat3::Constant(nan)}), "rotation");
}

TEST(OpenDevice, TakesTheNamesOfTheManual)
{
    for (const char* const name : {"hd", "hd:Left", "dhd", "dhd:0", "dhd:63", "udp:4711",
                                   "udp:127.0.0.1:0", "udp:0.0.0.0:65535"})
        EXPECT_TRUE(is_device_name(name)) << name;
    for (const char* const name :
         {"", "hd:", "dhd:", "dhd:-1", "dhd:64", "dhd:1x", "udp", "udp:", "udp:x", "udp:65536",
          "udp:1.2.3:4", "hand:walk", "replay:x.pxt", "mouse", ":", "HD"}) {
        EXPECT_FALSE(is_device_name(name)) << name;
        const auto device = open_device(name);
        ASSERT_FALSE(device);
        EXPECT_EQ(code_of(device), ErrorCode::invalid_argument);
    }
}

TEST(OpenDevice, OpensByName)
{
    const auto udp = open_device("udp:127.0.0.1:0", {.limits = *find_device("falcon")});
    ASSERT_TRUE(udp) << describe(udp.error());
    EXPECT_EQ((*udp)->info().limits.name, "falcon");
    EXPECT_EQ((*udp)->read().sample, 0U);
    for (const char* const name : {"hd", "hd:Left", "dhd", "dhd:1"}) {
        const auto none = open_device(name, {.library = "/nowhere/lib.so"});
        ASSERT_FALSE(none);
        EXPECT_EQ(code_of(none), ErrorCode::file_not_found);
    }
    const auto hd = open_device("hd:Left", {.library = STUB_HD});
    ASSERT_TRUE(hd) << describe(hd.error());
    EXPECT_EQ((*hd)->info().name, "hd:Left");
    const auto second = open_device("dhd:1", {.library = STUB_DHD});
    ASSERT_FALSE(second);
    EXPECT_NE(second.error().message.find("no device dhd:1: devices found: 1"), std::string::npos);
}

} // namespace
} // namespace proxima::wrong_options_test
