// Recordings of forged files: refused with the field's name, or replayed without harm.
#include "base/binary_file.h"
#include "code_of.h"
#include "damaged_files.h"
#include "exact_copy.h"
#include "folder_test.h"
#include "haptics/force/surface_renderer.h"
#include "haptics/height_images.h"
#include "haptics/loop/recording.h"
#include "haptics/scene/scripted_scene.h"
#include "haptics/scenes_to_touch.h"
#include "lab/quality_report.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace proxima::check_recording_test {
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
    // Object 3 shares its image with the settings, object 2 has one of its own.
    const Bump image = {
        .shape = BumpShape::image, .amplitude = 1e-4, .image = random_image(1, 5, 3)};
    recording.settings.render.texture.bump = image;
    recording.settings.objects[2].texture = SurfaceTexture{
        .bump = {.shape = BumpShape::image, .amplitude = 1e-4, .image = random_image(2, 2, 7)}};
    recording.settings.objects[3].texture = SurfaceTexture{.bump = image};
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
               {-1.1e4, 1.1e4, endless, not_a_number});
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
            EXPECT_EQ(code_of(loaded), ErrorCode::malformed_file);
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

TEST_F(ForgedRecordingTest, KeepsImagesOnceEach)
{
    const Recording recording = scene_recording();
    const auto loaded = reloaded(recording);
    ASSERT_TRUE(loaded) << describe(loaded.error());
    const auto image_of = [](const std::optional<SurfaceTexture>& texture) {
        return texture ? texture->bump.image : std::nullopt;
    };
    const RecordingSettings& settings = loaded->settings;
    EXPECT_FALSE(image_of(settings.objects[0].texture));
    EXPECT_FALSE(image_of(settings.objects[1].texture));
    for (const std::size_t object : {2, 3}) {
        const HeightImage before = *image_of(recording.settings.objects[object].texture);
        const HeightImage after = *image_of(settings.objects[object].texture);
        EXPECT_EQ(after.columns(), before.columns());
        EXPECT_TRUE(std::ranges::equal(after.samples(), before.samples()));
    }
    EXPECT_EQ(&image_of(settings.objects[3].texture)->parts(),
              &settings.render.texture.bump.image->parts());
    // One that another shape ignores is not kept.
    Recording noise = recording;
    noise.settings.objects[2].texture->bump.shape = BumpShape::noise;
    const auto again = reloaded(noise);
    ASSERT_TRUE(again);
    EXPECT_FALSE(image_of(again->settings.objects[2].texture));
}

/// An entry of the table of a file of sections.
struct SectionEntry {
    std::uint32_t id;
    std::uint32_t element_bytes;
    std::uint64_t offset;
    std::uint64_t bytes;
    std::uint64_t checksum;
};

/// A file's bytes with others at a position within a section, and right checksums.
template <class T>
std::string forged(std::string bytes, std::uint32_t section, std::size_t element, T value)
{
    std::uint32_t count = 0;
    std::memcpy(&count, bytes.data() + 16, sizeof count);
    for (std::uint32_t i = 0; i < count; ++i) {
        SectionEntry entry;
        std::memcpy(&entry, bytes.data() + 40 + i * sizeof entry, sizeof entry);
        if (entry.id != section) continue;
        std::memcpy(&bytes[entry.offset + element * sizeof value], &value, sizeof value);
    }
    reseal_binary_file(std::as_writable_bytes(std::span(bytes)));
    return bytes;
}

Result<Recording> load_bytes(const std::string& bytes)
{
    const auto copy = exact_copy(bytes.data(), bytes.size());
    return load_recording({copy.get(), bytes.size()}, copy, "memory");
}

std::string file_bytes(const std::filesystem::path& path)
{
    std::ifstream stream(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
}

TEST_F(ForgedRecordingTest, ForgedImagesAreNamed)
{
    const auto file = folder() / "session.pxt";
    ASSERT_TRUE(save_recording(scene_recording(), file));
    const std::string bytes = file_bytes(file);
    const auto message = [](const std::string& some) {
        const auto loaded = load_bytes(some);
        if (loaded) return std::string();
        EXPECT_EQ(code_of(loaded), ErrorCode::malformed_file);
        return loaded.error().message;
    };
    constexpr std::uint32_t sizes = 10;
    constexpr std::uint32_t numbers = 11;
    constexpr std::uint32_t samples = 17; // of image 1
    ASSERT_EQ(message(forged<std::uint32_t>(bytes, numbers, 0, 0)), "");
    // Sizes that the file's bytes do not bear out, be they as many samples in another order or not.
    for (const std::uint32_t columns : {0U, 1U, 3U, 0xffffffffU}) {
        EXPECT_EQ(message(forged(bytes, sizes, 2, columns))
                      .find("image 1: there are 14 samples of " + std::to_string(columns) + " x 7"),
                  0U);
    }
    EXPECT_EQ(message(forged(bytes, sizes, 0, std::uint64_t{1} << 63U | 0x80000000U))
                  .find("image 0: there are 15 samples of 2147483648 x 2147483648"),
              0U);
    EXPECT_EQ(message(forged(bytes, sizes, 0, std::uint64_t{15})), // no rows
              "image 0: there are 15 samples of 15 x 0: record the session again");
    for (const float wrong : {-1e-9F, 1.1F, std::numeric_limits<float>::quiet_NaN()}) {
        EXPECT_EQ(message(forged(bytes, samples, 13, wrong))
                      .find("image 1: the sample in row 6, column 1"),
                  0U);
    }
    EXPECT_EQ(message(forged<std::uint32_t>(bytes, numbers, 3, 2)),
              "texture 3: its image is 2, and there are 2: record the session again");
    EXPECT_NE(message(forged<std::uint32_t>(bytes, numbers, 3, 0xffffffff))
                  .find("object 2: the bump of a texture is an image and has none"),
              std::string::npos);
}

TEST_F(ForgedRecordingTest, OlderVersionsAreReadWithoutImages)
{
    const std::filesystem::path corpus =
        std::filesystem::path(PROXIMA_SOURCE_DIR) / "fuzz/corpus/recording";
    for (const char* const name : {"cube.pxt", "penalty.pxt", "scene.pxt", "textured.pxt"}) {
        const std::string old = file_bytes(corpus / name);
        ASSERT_LT(old[12], 6) << name;
        const auto loaded = load_bytes(old);
        ASSERT_TRUE(loaded) << name << ": " << describe(loaded.error());
        const auto again = reloaded(*loaded);
        ASSERT_TRUE(again) << name;
        EXPECT_EQ(file_bytes(folder() / "session.pxt")[12], 6) << name;
        EXPECT_EQ(again->ticks, loaded->ticks);
        const bool penalty = std::string_view(name) == "penalty.pxt";
        const std::size_t objects = std::string_view(name) == "scene.pxt" ? 3 : 0;
        const bool textured = std::string_view(name) == "textured.pxt";
        for (const RecordingSettings& settings : {loaded->settings, again->settings}) {
            EXPECT_EQ(settings.law, penalty ? ForceLaw::penalty : ForceLaw::proxy) << name;
            EXPECT_EQ(settings.objects.size(), objects) << name;
            EXPECT_EQ(settings.render.texture.any(), textured) << name;
        }
    }
    // An image in a file that says it is older than images are.
    const auto file = folder() / "session.pxt";
    ASSERT_TRUE(save_recording(scene_recording(), file));
    std::string bytes = file_bytes(file);
    bytes[12] = 5;
    reseal_binary_file(std::as_writable_bytes(std::span(bytes)));
    const auto loaded = load_bytes(bytes);
    ASSERT_FALSE(loaded);
    EXPECT_NE(loaded.error().message.find("is an image and has none"), std::string::npos);
}

TEST_F(ForgedRecordingTest, VersionFiveHasMessagesAndARoom)
{
    Recording recording = scene_recording();
    recording.settings.room = 2;
    recording.settings.render.texture = {};
    for (ScriptedObject& object : recording.settings.objects) object.texture.reset();
    const auto file = folder() / "session.pxt";
    ASSERT_TRUE(save_recording(recording, file));
    std::string bytes = file_bytes(file);
    bytes[12] = 5;
    reseal_binary_file(std::as_writable_bytes(std::span(bytes)));
    const auto loaded = load_bytes(bytes);
    ASSERT_TRUE(loaded) << describe(loaded.error());
    EXPECT_EQ(loaded->settings.room, 2);
    EXPECT_EQ(loaded->settings.objects.size(), 4U);
    ASSERT_EQ(loaded->messages.size(), 2U);
    EXPECT_TRUE(loaded->messages[0].has_motion);
    EXPECT_TRUE(loaded->messages[1].has_material);
    EXPECT_EQ(loaded->messages[1].tick, 7U);
}

TEST(Recording, HasAllOfATick)
{
    DeviceState state;
    state.pose.translation = Vec3(1, 2, 3);
    state.velocity = Vec3(4, 5, 6);
    state.buttons = 5;
    state.condition = InputCondition::clutched;
    RenderTick tick;
    tick.force = Vec3(7, 8, 9);
    tick.proxy = Vec3(10, 11, 12);
    tick.hold = Hold::sticking;
    tick.fault = InputFault::jumped;
    const RecordedTick free = recorded(1.5, state, tick);
    const RecordedTick expected = {.seconds = 1.5,
                                   .position = {1, 2, 3},
                                   .velocity = {4, 5, 6},
                                   .force = {7, 8, 9},
                                   .proxy = {10, 11, 12},
                                   .buttons = 5,
                                   .triangle = 0xffffffff,
                                   .hold = 2,
                                   .fault = 2,
                                   .condition = 1};
    EXPECT_EQ(free, expected);
    tick.contacts[0].triangle = TriangleId{17};
    tick.contact_count = 1;
    EXPECT_EQ(recorded(1.5, state, tick).triangle, 17U);
    const DeviceState again = device_state(free);
    EXPECT_EQ(again.pose.translation, state.pose.translation);
    EXPECT_EQ(again.velocity, state.velocity);
    EXPECT_EQ(again.buttons, state.buttons);
    EXPECT_EQ(again.condition, state.condition);
}

/// Replays a scene of cubes; every force must be finite and within the limit.
void replay(const Recording& recording)
{
    const RecordingSettings& settings = recording.settings;
    std::vector<TouchBody> bodies;
    for (const ScriptedObject& object : settings.objects) {
        bodies.push_back(body_of(*sample_mesh("cube"),
                                 {.material = object.material, .texture = object.texture}));
    }
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
            r.messages[0].motion.spin.setConstant(1e4);
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
            r.messages[0].motion.spin.setConstant(-1e4);
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
} // namespace proxima::check_recording_test
