// Recordings of forged files: refused with the field's name, or replayed without harm.
#include "damaged_files.h"
#include "exact_copy.h"
#include "folder_test.h"
#include "haptics/force/surface_renderer.h"
#include "haptics/loop/recording.h"
#include "haptics/scene/scripted_scene.h"
#include "haptics/scenes_to_touch.h"
#include "lab/quality_report.h"

#include <gtest/gtest.h>

#include <fstream>
#include <functional>
#include <iterator>
#include <limits>
#include <string>
#include <vector>

namespace proxima {
namespace {

using namespace testing;

constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();
constexpr double endless = std::numeric_limits<double>::infinity();

/// A session with a scene of an object of each kind of motion.
Recording scene_recording()
{
    Recording recording;
    recording.settings.objects.resize(4);
    recording.settings.objects[1].script = {
        .kind = ObjectMotionKind::spin, .along = Vec3::UnitZ(), .angle = 1};
    recording.settings.objects[2].script = {
        .kind = ObjectMotionKind::rock, .along = Vec3::UnitX(), .angle = 0.5, .seconds = 1};
    recording.settings.objects[3].script = {
        .kind = ObjectMotionKind::swing, .along = Vec3::UnitX(), .seconds = 1};
    recording.settings.objects[3].material = SurfaceMaterial{};
    recording.settings.objects[3].texture = SurfaceTexture{};
    recording.ticks.resize(20);
    recording.messages.resize(2);
    recording.messages[0].has_motion = recording.messages[1].has_material = true;
    recording.messages[1].tick = 7;
    return recording;
}

/// A number of a recording, and numbers that it must not be.
struct Forgery {
    std::string field; ///< as the message names it
    std::function<double&(Recording&)> number;
    std::vector<double> wrong;
};

const std::vector<double> wrong_strengths = {-1e-9, 1.1e9, 1e308, endless, not_a_number};
const std::vector<double> wrong_coordinates = {-1.1e100, 1.1e100, 1e308, endless, not_a_number};

std::vector<Forgery> forgeries()
{
    const auto settings = [](double RecordingSettings::*field) {
        return [field](Recording& r) -> double& { return r.settings.*field; };
    };
    const auto render = [](double RenderOptions::*field) {
        return [field](Recording& r) -> double& { return r.settings.render.*field; };
    };
    const auto force = [](double ForceOptions::*field) {
        return [field](Recording& r) -> double& { return r.settings.render.force.*field; };
    };
    const auto script = [](std::size_t object, double ObjectScript::*field) {
        return [object, field](Recording& r) -> double& {
            return r.settings.objects[object].script.*field;
        };
    };
    const auto material = [](double SurfaceMaterial::*field) {
        return
            [field](Recording& r) -> double& { return (*r.settings.objects[3].material).*field; };
    };
    std::vector<Forgery> all = {
        {"tick_seconds",
         settings(&RecordingSettings::tick_seconds),
         {0, 9e-7, 1.1, 1e308, endless, not_a_number, -1e-3}},
        {"max_force",
         settings(&RecordingSettings::max_force),
         {0, 1e-10, -1, 1.1e9, endless, not_a_number}},
        {"max_stiffness", settings(&RecordingSettings::max_stiffness), wrong_strengths},
        {"max_damping", settings(&RecordingSettings::max_damping), wrong_strengths},
        {"stiffness", force(&ForceOptions::stiffness), wrong_strengths},
        {"damping", force(&ForceOptions::damping), wrong_strengths},
        {"max_slew", force(&ForceOptions::max_slew), wrong_strengths},
        {"start_seconds", force(&ForceOptions::start_seconds), {-1, 86401, endless, not_a_number}},
        {"loss_seconds", force(&ForceOptions::loss_seconds), {-1, 86401, endless, not_a_number}},
        {"proxy_radius", render(&RenderOptions::proxy_radius), {-1, 4.1e6, endless, not_a_number}},
        {"static_friction", render(&RenderOptions::static_friction), wrong_strengths},
        {"dynamic_friction", render(&RenderOptions::dynamic_friction), {0.41, -1, not_a_number}},
        {"max_jump", render(&RenderOptions::max_jump), {-1, 4.1e6, endless, not_a_number}},
        {"units_per_metre",
         [](Recording& r) -> double& { return r.settings.map.units_per_metre; },
         {0, -1, 1e-101, 1.1e100, 1e308, endless, not_a_number}},
        {"object 3: stiffness", material(&SurfaceMaterial::stiffness), wrong_strengths},
        {"object 3: damping", material(&SurfaceMaterial::damping), wrong_strengths},
        {"object 3: static_friction", material(&SurfaceMaterial::static_friction), wrong_strengths},
        {"object 3: dynamic_friction",
         material(&SurfaceMaterial::dynamic_friction),
         {0.41, -1, not_a_number}},
        {"the viscosity of a texture",
         [](Recording& r) -> double& { return r.settings.render.texture.viscosity; },
         wrong_strengths},
        {"the bump amplitude of a texture",
         [](Recording& r) -> double& { return r.settings.render.texture.bump.amplitude; },
         {-1, 0.011, 1e308, endless, not_a_number}},
        {"object 3: the bump wavelength of a texture",
         [](Recording& r) -> double& { return r.settings.objects[3].texture->bump.wavelength; },
         {0, -1, 9e-5, 1.1, 1e-308, endless, not_a_number}},
        {"object 3: the length of the bump direction",
         [](Recording& r) -> double& {
             Vec3& direction = r.settings.objects[3].texture->bump.direction;
             direction.setZero();
             return direction.y();
         },
         {0, 1e-160, 1e160, endless, not_a_number}},
        {"object 3: the stick-slip stiffness",
         [](Recording& r) -> double& {
             return r.settings.objects[3].texture->stick_slip.stiffness;
         },
         wrong_strengths},
        {"object 3: the stick-slip max_force",
         [](Recording& r) -> double& {
             return r.settings.objects[3].texture->stick_slip.max_force;
         },
         wrong_strengths},
        {"object 3: the tap gain",
         [](Recording& r) -> double& { return r.settings.objects[3].texture->tap.gain; },
         wrong_strengths},
        {"object 3: the tap frequency",
         [](Recording& r) -> double& { return r.settings.objects[3].texture->tap.frequency; },
         {0, 9, 401, endless, not_a_number}},
        {"object 3: the tap decay",
         [](Recording& r) -> double& { return r.settings.objects[3].texture->tap.decay; },
         {0, 9, 1001, endless, not_a_number}},
        {"object 1: an object must not rotate", script(1, &ObjectScript::angle), {26, -26, 1e308}},
        {"object 1: the numbers of a motion", script(1, &ObjectScript::angle), {endless}},
        {"object 2: the period of a motion",
         script(2, &ObjectScript::seconds),
         {0, -1, 9e-7, 1.1e9, 1e308}},
        {"object 3: the period of a motion",
         script(3, &ObjectScript::seconds),
         {0, -1, 5e-324, 1.1e9}},
        {"tick 19: position y",
         [](Recording& r) -> double& { return r.ticks[19].position[1]; },
         {-1.1e6, 1.1e6, 1e308, endless}}};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::string name = std::string("xyz").substr(axis, 1);
        all.push_back({"center " + name,
                       [axis](Recording& r) -> double& {
                           return r.settings.map.center[static_cast<Eigen::Index>(axis)];
                       },
                       wrong_coordinates});
        all.push_back(
            {"object 2: pose", // a pose that is not finite is no pose
             [axis](Recording& r) -> double& {
                 return r.settings.objects[2].pose.translation[static_cast<Eigen::Index>(axis)];
             },
             wrong_coordinates});
        all.push_back({"object 1: the axis",
                       [axis](Recording& r) -> double& {
                           Vec3& along = r.settings.objects[1].script.along;
                           along.setZero();
                           return along[static_cast<Eigen::Index>(axis)];
                       },
                       {0, 1e-160, 1e-101, 1.1e100, 1e308}});
        all.push_back({"object 3: the displacement",
                       [axis](Recording& r) -> double& {
                           Vec3& along = r.settings.objects[3].script.along;
                           along.setZero();
                           return along[static_cast<Eigen::Index>(axis)];
                       },
                       {0, 1e-160, 1.1e100}});
    }
    all.push_back({"room",
                   [](Recording& r) -> double& { return r.settings.room; },
                   {-1e-9, 1.1e6, endless, not_a_number}});
    const auto of_message = [&](const std::string& name, auto number, std::vector<double> wrong) {
        all.push_back({"message 1: " + name,
                       [number](Recording& r) -> double& { return number(r.messages[1]); },
                       std::move(wrong)});
    };
    const std::vector<double> wrong_times = {-1e-9, 86401, 1e308, endless, not_a_number};
    of_message(
        "pose", [](SceneMessage& m) -> double& { return m.motion.pose.translation.z(); },
        wrong_coordinates);
    of_message(
        "velocity y", [](SceneMessage& m) -> double& { return m.motion.velocity.y(); },
        wrong_coordinates);
    of_message("spin x", [](SceneMessage& m) -> double& { return m.motion.spin.x(); },
               {-1.1e6, 1.1e6, endless, not_a_number});
    of_message(
        "seconds", [](SceneMessage& m) -> double& { return m.motion.seconds; }, wrong_times);
    of_message(
        "coast_seconds", [](SceneMessage& m) -> double& { return m.motion.coast_seconds; },
        wrong_times);
    of_message(
        "material_seconds", [](SceneMessage& m) -> double& { return m.material_seconds; },
        wrong_times);
    of_message(
        "stiffness", [](SceneMessage& m) -> double& { return m.material.stiffness; },
        wrong_strengths);
    of_message("dynamic_friction",
               [](SceneMessage& m) -> double& { return m.material.dynamic_friction; },
               {-1e-9, 0.5, 1e308, endless, not_a_number});
    return all;
}

class ForgedRecordingTest : public FolderTest {
protected:
    /// The recording as it comes back from a file.
    [[nodiscard]] Result<Recording> reloaded(const Recording& recording) const
    {
        const auto file = folder() / "session.pxt";
        EXPECT_TRUE(save_recording(recording, file));
        return load_recording(file);
    }
};

TEST_F(ForgedRecordingTest, NamesTheFieldThatIsOutOfRange)
{
    ASSERT_TRUE(reloaded(scene_recording()));
    for (const Forgery& forgery : forgeries()) {
        for (const double wrong : forgery.wrong) {
            Recording recording = scene_recording();
            forgery.number(recording) = wrong;
            const auto loaded = reloaded(recording);
            ASSERT_FALSE(loaded) << forgery.field << ' ' << wrong;
            EXPECT_EQ(loaded.error().code, ErrorCode::malformed_file);
            EXPECT_EQ(loaded.error().message.find(forgery.field), 0U)
                << wrong << ": " << loaded.error().message;
            EXPECT_NE(loaded.error().message.find("record the session again"), std::string::npos)
                << loaded.error().message;
            EXPECT_NE(loaded.error().where.find("session.pxt"), std::string::npos);
        }
    }
    Recording recording = scene_recording();
    recording.ticks[3].condition = input_conditions;
    const auto loaded = reloaded(recording);
    ASSERT_FALSE(loaded);
    EXPECT_EQ(loaded.error().message.find("tick 3: condition is 7 and must be 0 to 6"), 0U);
    recording = scene_recording();
    recording.settings.objects[2].pose.rotation(0, 0) = 2;
    EXPECT_EQ(reloaded(recording).error().message.find("object 2: pose"), 0U);
    recording = scene_recording();
    recording.messages[1].motion.pose.rotation(0, 0) = 2;
    EXPECT_EQ(reloaded(recording).error().message.find("message 1: pose"), 0U);
    recording = scene_recording();
    recording.messages[1].object = ObjectId{4};
    EXPECT_EQ(reloaded(recording).error().message.find("message 1: object is 4"), 0U);
    recording = scene_recording();
    recording.messages[0].tick = 8;
    EXPECT_EQ(reloaded(recording).error().message.find("message 1: its tick"), 0U);
    recording = scene_recording();
    recording.messages[0].has_motion = false;
    EXPECT_EQ(reloaded(recording).error().message.find("message 0: parts is 0"), 0U);
}

TEST_F(ForgedRecordingTest, RefusesEveryTruncationAndExtension)
{
    const auto file = folder() / "session.pxt";
    ASSERT_TRUE(save_recording(scene_recording(), file));
    std::ifstream stream(file, std::ios::binary);
    const std::string bytes(std::istreambuf_iterator<char>(stream), {});
    refuses_every_truncation_and_extension(bytes, [](const std::string& some, Verification) {
        const auto copy = exact_copy(some.data(), some.size());
        return load_recording({copy.get(), some.size()}, copy, "memory");
    });
}

/// Replays a scene of cubes; every force must be finite and within the limit.
void replay(const Recording& recording)
{
    const RecordingSettings& settings = recording.settings;
    std::vector<TouchBody> bodies;
    for (const ScriptedObject& object : settings.objects)
        bodies.push_back(body_of(*sample_mesh("cube"), {.material = object.material}));
    auto scene = ScriptedScene::make(bodies, settings.objects, settings.room);
    ASSERT_TRUE(scene) << describe(scene.error());
    const DeviceLimits device = {.max_force = settings.max_force,
                                 .max_stiffness = settings.max_stiffness,
                                 .max_damping = settings.max_damping};
    auto renderer = make_haptic_renderer((*scene)->scene(), settings.map, device, settings.render);
    ASSERT_TRUE(renderer) << describe(renderer.error());
    QualityMeter meter((*scene)->scene(), settings.map);
    for (std::size_t i = 0; i < recording.ticks.size(); ++i) {
        for (const SceneMessage& message : recording.messages)
            if (message.tick == i) (void)apply(message, (*scene)->scene());
        (*scene)->send_motions(i, settings.tick_seconds);
        const DeviceState state = device_state(recording.ticks[i]);
        const RenderTick& tick = renderer->tick(state, settings.tick_seconds);
        ASSERT_TRUE(tick.force.allFinite());
        ASSERT_LE(tick.force.norm(), settings.max_force);
        meter.add(tick, state.velocity, renderer->path());
    }
}

// Each number at both ends of its range, alone and all at once.
TEST_F(ForgedRecordingTest, EverythingInRangeIsReplayed)
{
    const std::vector<std::function<void(Recording&)>> ends = {
        [](Recording& r) {
            r.settings.room = 1e6;
            r.messages[0].motion.pose.translation.setConstant(1e100);
            r.messages[0].motion.velocity.setConstant(-1e100);
            r.messages[0].motion.spin.setConstant(1e6);
            r.messages[0].motion.seconds = r.messages[0].motion.coast_seconds = 86400;
        },
        [](Recording& r) { r.settings.tick_seconds = 1; },
        [](Recording& r) { r.settings.tick_seconds = 1e-6; },
        [](Recording& r) { r.settings.map.units_per_metre = 1e100; },
        [](Recording& r) { r.settings.map.units_per_metre = 1e-100; },
        [](Recording& r) { r.settings.map.center.setConstant(1e100); },
        [](Recording& r) {
            r.settings.max_force = r.settings.max_stiffness = r.settings.max_damping = 1e9;
            r.settings.render.force = {.stiffness = 1e9, .damping = 1e9, .max_slew = 1e9};
        },
        [](Recording& r) { r.settings.max_force = 1e-9; },
        [](Recording& r) { r.settings.render.proxy_radius = 4e6; },
        [](Recording& r) { r.settings.render.max_jump = 4e6; },
        [](Recording& r) { r.settings.objects[1].script.along.setConstant(1e-100); },
        [](Recording& r) { r.settings.objects[1].script.along = Vec3(1e100, 0, 0); },
        [](Recording& r) { r.settings.objects[2].script.seconds = 1e9; },
        [](Recording& r) { r.settings.objects[3].script.seconds = 1e-6; },
        [](Recording& r) {
            r.settings.objects[3].script.along = Vec3(0, 0.99e100, 0);
            r.settings.room = 0; // so large a scene has none
        },
        [](Recording& r) {
            for (std::size_t i = 0; i < r.ticks.size(); ++i)
                r.ticks[i].position = {i % 2 == 0 ? 1e6 : -1e6, -1e6, 0.1 * static_cast<double>(i)};
        },
        [](Recording& r) {
            r.messages[0].motion.spin.setConstant(-1e6);
            r.messages[0].motion.coast_seconds = 86400;
            r.messages[1].material = {1e9, 1e9, 1e9, 1e9};
            r.messages[1].material_seconds = 86400;
        },
        [](Recording& r) {
            for (RecordedTick& tick : r.ticks) tick.velocity = {1e308, endless, not_a_number};
        },
        [](Recording& r) {
            r.ticks[0].position.fill(not_a_number);
            r.ticks[9].position[1] = not_a_number;
        }};
    Recording all = scene_recording();
    for (const auto& set : ends) {
        Recording alone = scene_recording();
        for (Recording* const recording : {&alone, &all}) {
            set(*recording);
            const auto loaded = reloaded(*recording);
            ASSERT_TRUE(loaded) << describe(loaded.error());
            replay(*loaded);
        }
    }
}

} // namespace
} // namespace proxima
