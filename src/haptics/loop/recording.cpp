#include "haptics/loop/recording.h"

#include "base/binary_file.h"
#include "base/text.h"
#include "haptics/loop/check_recording.h"
#include "haptics/loop/recorded_numbers.h"
#include "proxima/topology.h"
#include "proxima/touch_scene.h"

#include <bit>
#include <utility>

namespace proxima {

namespace {

constexpr FileFormat format = {{'P', 'X', 'T', 'O', 'U', 'C', 'H', '\n'}, 5, "recording"};

enum Section : std::uint32_t {
    fingerprint_section = 1,
    settings_section = 2,
    ticks_section = 3,
    objects_section = 4, ///< since version 3
    fingerprints_of_objects_section = 5,
    force_law_section = 6, ///< since version 4
    room_section = 7,      ///< since version 5
    messages_section = 8,
    textures_section = 9 ///< of the settings, then of each object
};
constexpr std::uint32_t first_version_with_objects = 3;
constexpr std::uint32_t first_version_with_force_laws = 4;
constexpr std::uint32_t first_version_with_messages = 5;
constexpr std::uint32_t first_version_with_textures = 5;

/// The settings as numbers, in the order of the file.
struct SettingNumbers {
    double tick_seconds;
    double units_per_metre;
    double center[3];
    double stiffness;
    double damping;
    double max_slew;
    double start_seconds;
    double loss_seconds;
    double proxy_radius;
    double static_friction;
    double dynamic_friction;
    double guard; ///< 0 off, 1 on, 2 observe
    double max_jump;
    double max_force;
    double max_stiffness;
    double max_damping;
    double shading;
};
static_assert(sizeof(SettingNumbers) == 19 * sizeof(double));
static_assert(sizeof(RecordedTick) == 13 * sizeof(double) + 4 * sizeof(std::uint32_t));

/// An object of a scene, in the order of the file.
struct ObjectNumbers {
    double pose[12]; ///< (R | t) row by row
    double kind;     ///< ObjectMotionKind
    double along[3];
    double angle;
    double seconds;
    double has_material; ///< 0 or 1
    double stiffness;
    double damping;
    double static_friction;
    double dynamic_friction;
};
static_assert(sizeof(ObjectNumbers) == 23 * sizeof(double));

/// What an engine changed of an object, in the order of the file.
struct MessageNumbers {
    std::uint64_t tick;
    std::uint32_t object;
    std::uint32_t parts; ///< 1: a motion, 2: a material, 3: both
    double pose[12];     ///< (R | t) row by row
    double seconds;
    double velocity[3];
    double spin[3];
    double coast_seconds;
    double stiffness;
    double damping;
    double static_friction;
    double dynamic_friction;
    double material_seconds;
};
static_assert(sizeof(MessageNumbers) == 27 * sizeof(double));
/// A texture, in the order of the file.
struct TextureNumbers {
    double is_there; ///< 0 or 1; without one the others are those of no texture
    double shape;    ///< BumpShape
    double amplitude;
    double wavelength;
    double direction[3];
    double viscosity;
    double stick_stiffness;
    double stick_max_force;
    double tap_gain;
    double tap_frequency;
    double tap_decay;
};
static_assert(sizeof(TextureNumbers) == 13 * sizeof(double));

std::array<double, 3> numbers(const Vec3& v) noexcept
{
    return {v.x(), v.y(), v.z()};
}
Vec3 vector(const std::array<double, 3>& v) noexcept
{
    return {v[0], v[1], v[2]};
}

SettingNumbers numbers(const RecordingSettings& settings)
{
    const RenderOptions& render = settings.render;
    const Vec3& center = settings.map.center;
    return {settings.tick_seconds,
            settings.map.units_per_metre,
            {center.x(), center.y(), center.z()},
            render.force.stiffness,
            render.force.damping,
            render.force.max_slew,
            render.force.start_seconds,
            render.force.loss_seconds,
            render.proxy_radius,
            render.static_friction,
            render.dynamic_friction,
            guard_number(render.guard),
            render.max_jump,
            settings.max_force,
            settings.max_stiffness,
            settings.max_damping,
            render.shading == ForceShading::on ? 1.0 : 0.0};
}

RecordingSettings settings_of(const SettingNumbers& numbers, std::uint64_t fingerprint)
{
    RecordingSettings settings;
    settings.mesh_fingerprint = fingerprint;
    settings.tick_seconds = numbers.tick_seconds;
    settings.map = {numbers.units_per_metre,
                    Vec3(numbers.center[0], numbers.center[1], numbers.center[2])};
    settings.render = {.force = {.stiffness = numbers.stiffness,
                                 .damping = numbers.damping,
                                 .max_slew = numbers.max_slew,
                                 .start_seconds = numbers.start_seconds,
                                 .loss_seconds = numbers.loss_seconds},
                       .proxy_radius = numbers.proxy_radius,
                       .static_friction = numbers.static_friction,
                       .dynamic_friction = numbers.dynamic_friction,
                       .guard = guard_of_number(numbers.guard),
                       .max_jump = numbers.max_jump,
                       .shading = numbers.shading != 0 ? ForceShading::on : ForceShading::off};
    settings.max_force = numbers.max_force;
    settings.max_stiffness = numbers.max_stiffness;
    settings.max_damping = numbers.max_damping;
    return settings;
}

void write_pose(const RigidTransform& pose, double (&numbers)[12])
{
    for (int row = 0; row < 3; ++row) {
        for (int column = 0; column < 3; ++column)
            numbers[4 * row + column] = pose.rotation(row, column);
        numbers[4 * row + 3] = pose.translation[row];
    }
}

MessageNumbers numbers(const SceneMessage& message)
{
    MessageNumbers result{};
    result.tick = message.tick;
    result.object = to_index(message.object);
    result.parts = (message.has_motion ? 1U : 0U) | (message.has_material ? 2U : 0U);
    const ObjectMotion& motion = message.motion;
    write_pose(motion.pose, result.pose);
    result.seconds = motion.seconds;
    for (int axis = 0; axis < 3; ++axis) {
        result.velocity[axis] = motion.velocity[axis];
        result.spin[axis] = motion.spin[axis];
    }
    result.coast_seconds = motion.coast_seconds;
    result.stiffness = message.material.stiffness;
    result.damping = message.material.damping;
    result.static_friction = message.material.static_friction;
    result.dynamic_friction = message.material.dynamic_friction;
    result.material_seconds = message.material_seconds;
    return result;
}

ObjectNumbers numbers(const ScriptedObject& object)
{
    ObjectNumbers result{};
    write_pose(object.pose, result.pose);
    for (int axis = 0; axis < 3; ++axis) result.along[axis] = object.script.along[axis];
    result.kind = static_cast<double>(object.script.kind);
    result.angle = object.script.angle;
    result.seconds = object.script.seconds;
    if (!object.material) return result;
    result.has_material = 1;
    result.stiffness = object.material->stiffness;
    result.damping = object.material->damping;
    result.static_friction = object.material->static_friction;
    result.dynamic_friction = object.material->dynamic_friction;
    return result;
}

/// Error where the numbers make no object of a scene.
Result<ScriptedObject> object_of(const ObjectNumbers& numbers, std::uint64_t fingerprint,
                                 std::size_t number)
{
    const std::string of = concat("object ", number, ": ");
    const auto pose = make_rigid_transform(numbers.pose);
    if (!pose) {
        return fail(ErrorCode::malformed_file,
                    concat(of, "pose: ", pose.error().message, ": record the session again"));
    }
    constexpr auto last_kind = static_cast<int>(ObjectMotionKind::swing);
    if (Status status = check_choice(of + "kind of motion", numbers.kind, last_kind); !status)
        return tl::unexpected(status.error());
    if (Status status = check_choice(of + "has_material", numbers.has_material, 1); !status)
        return tl::unexpected(status.error());
    ScriptedObject object;
    object.mesh_fingerprint = fingerprint;
    object.pose = *pose;
    object.script.kind = static_cast<ObjectMotionKind>(numbers.kind);
    object.script.along = Vec3(numbers.along[0], numbers.along[1], numbers.along[2]);
    object.script.angle = numbers.angle;
    object.script.seconds = numbers.seconds;
    if (numbers.has_material != 0) {
        object.material = SurfaceMaterial{.stiffness = numbers.stiffness,
                                          .damping = numbers.damping,
                                          .static_friction = numbers.static_friction,
                                          .dynamic_friction = numbers.dynamic_friction};
    }
    return object;
}

TextureNumbers numbers(const std::optional<SurfaceTexture>& given) noexcept
{
    const SurfaceTexture texture = given.value_or(SurfaceTexture{});
    const Bump& bump = texture.bump;
    return {given ? 1.0 : 0.0,
            static_cast<double>(bump.shape),
            bump.amplitude,
            bump.wavelength,
            {bump.direction.x(), bump.direction.y(), bump.direction.z()},
            texture.viscosity,
            texture.stick_slip.stiffness,
            texture.stick_slip.max_force,
            texture.tap.gain,
            texture.tap.frequency,
            texture.tap.decay};
}

SurfaceTexture texture_of(const TextureNumbers& numbers) noexcept
{
    return {
        .bump = {.shape = static_cast<BumpShape>(numbers.shape),
                 .amplitude = numbers.amplitude,
                 .wavelength = numbers.wavelength,
                 .direction =
                     Vec3(numbers.direction[0], numbers.direction[1], numbers.direction[2])},
        .viscosity = numbers.viscosity,
        .stick_slip = {.stiffness = numbers.stick_stiffness, .max_force = numbers.stick_max_force},
        .tap = {.gain = numbers.tap_gain,
                .frequency = numbers.tap_frequency,
                .decay = numbers.tap_decay}};
}

/// Gives settings and objects their textures; none for files that are older.
Status read_textures(const BinaryFile& file, RecordingSettings& settings)
{
    if (file.version() < first_version_with_textures) return {};
    const auto rows = file.section<TextureNumbers>(textures_section);
    if (!rows) return tl::unexpected(rows.error());
    if (rows->size() != settings.objects.size() + 1) {
        return fail(ErrorCode::malformed_file,
                    concat("there are ", rows->size(), " textures and must be ",
                           settings.objects.size() + 1, ": record the session again"));
    }
    for (std::size_t i = 0; i < rows->size(); ++i) {
        const TextureNumbers& row = (*rows)[i];
        const std::string of = concat("texture ", i, ": ");
        constexpr auto last_shape = static_cast<int>(BumpShape::noise);
        Status status = check_choice(of + "shape", row.shape, last_shape);
        if (status) status = check_choice(of + "is_there", row.is_there, 1);
        if (!status) return status;
        if (row.is_there == 0) continue;
        if (i == 0) {
            settings.render.texture = texture_of(row);
        } else {
            settings.objects[i - 1].texture = texture_of(row);
        }
    }
    return {};
}

/// Empty for files that are older.
Result<std::vector<ScriptedObject>> objects_of(const BinaryFile& file)
{
    std::vector<ScriptedObject> objects;
    if (file.version() < first_version_with_objects) return objects;
    const auto rows = file.section<ObjectNumbers>(objects_section);
    if (!rows) return tl::unexpected(rows.error());
    const auto fingerprints = file.section<std::uint64_t>(fingerprints_of_objects_section);
    if (!fingerprints) return tl::unexpected(fingerprints.error());
    if (rows->size() > max_scene_objects || fingerprints->size() != rows->size()) {
        return fail(ErrorCode::malformed_file,
                    concat("there are ", rows->size(), " objects and ", fingerprints->size(),
                           " fingerprints of objects, and must be as many, at most ",
                           max_scene_objects, ": record the session again"));
    }
    for (std::size_t i = 0; i < rows->size(); ++i) {
        auto object = object_of((*rows)[i], (*fingerprints)[i], i);
        if (!object) return tl::unexpected(object.error());
        objects.push_back(*object);
    }
    return objects;
}

/// Error where the numbers make no message; its ranges are for check_recording.
Result<SceneMessage> message_of(const MessageNumbers& numbers, std::size_t number)
{
    const std::string of = concat("message ", number, ": ");
    const auto pose = make_rigid_transform(numbers.pose);
    if (!pose) {
        return fail(ErrorCode::malformed_file,
                    concat(of, "pose: ", pose.error().message, ": record the session again"));
    }
    if (numbers.parts < 1 || numbers.parts > 3) {
        return fail(ErrorCode::malformed_file,
                    concat(of, "parts is ", numbers.parts,
                           " and must be 1 to 3: record the session again"));
    }
    SceneMessage message;
    message.tick = numbers.tick;
    message.object = ObjectId{numbers.object};
    message.has_motion = (numbers.parts & 1U) != 0;
    message.has_material = (numbers.parts & 2U) != 0;
    message.motion = {.pose = *pose,
                      .seconds = numbers.seconds,
                      .velocity =
                          Vec3(numbers.velocity[0], numbers.velocity[1], numbers.velocity[2]),
                      .spin = Vec3(numbers.spin[0], numbers.spin[1], numbers.spin[2]),
                      .coast_seconds = numbers.coast_seconds};
    message.material = {.stiffness = numbers.stiffness,
                        .damping = numbers.damping,
                        .static_friction = numbers.static_friction,
                        .dynamic_friction = numbers.dynamic_friction};
    message.material_seconds = numbers.material_seconds;
    return message;
}

/// Reads what an engine sent, and the room that it had. Nothing in files that are older.
Status read_messages(const BinaryFile& file, Recording& recording)
{
    if (file.version() < first_version_with_messages) return {};
    const auto room = file.section<double>(room_section);
    if (!room) return tl::unexpected(room.error());
    const auto rows = file.section<MessageNumbers>(messages_section);
    if (!rows) return tl::unexpected(rows.error());
    if (room->size() != 1) {
        return fail(ErrorCode::malformed_file,
                    "the room of the scene is missing: record the session again");
    }
    recording.settings.room = room->front();
    recording.messages.reserve(rows->size());
    for (std::size_t i = 0; i < rows->size(); ++i) {
        const auto message = message_of((*rows)[i], i);
        if (!message) return tl::unexpected(message.error());
        recording.messages.push_back(*message);
    }
    return {};
}

/// proxy for files that are older.
Result<ForceLaw> force_law_of(const BinaryFile& file)
{
    if (file.version() < first_version_with_force_laws) return ForceLaw::proxy;
    const auto law = file.section<std::uint32_t>(force_law_section);
    if (!law) return tl::unexpected(law.error());
    for (const ForceLaw known : {ForceLaw::proxy, ForceLaw::penalty}) {
        if (law->size() == 1 && law->front() == static_cast<std::uint32_t>(known)) return known;
    }
    return fail(ErrorCode::malformed_file, "unknown kind of forces: record the session again");
}

/// What a file holds, checked. Errors malformed_file, some without a place.
Result<Recording> recording_of(const BinaryFile& file)
{
    const auto fingerprint = file.section<std::uint64_t>(fingerprint_section);
    if (!fingerprint) return tl::unexpected(fingerprint.error());
    const auto settings = file.section<SettingNumbers>(settings_section);
    if (!settings) return tl::unexpected(settings.error());
    const auto ticks = file.section<RecordedTick>(ticks_section);
    if (!ticks) return tl::unexpected(ticks.error());
    if (fingerprint->size() != 1 || settings->size() != 1) {
        return fail(ErrorCode::malformed_file,
                    "the settings of the recording are missing: record the session again");
    }
    const SettingNumbers& numbers = settings->front();
    if (Status status = check_choice("guard", numbers.guard, last_guard); !status)
        return tl::unexpected(status.error());
    if (Status status = check_choice("shading", numbers.shading, 1); !status)
        return tl::unexpected(status.error());
    Recording recording;
    recording.settings = settings_of(numbers, fingerprint->front());
    const auto law = force_law_of(file);
    if (!law) return tl::unexpected(law.error());
    recording.settings.law = *law;
    auto objects = objects_of(file);
    if (!objects) return tl::unexpected(objects.error());
    if (*law == ForceLaw::penalty && !objects->empty()) {
        return fail(ErrorCode::malformed_file,
                    "penalty forces are not available for a scene: record the session again");
    }
    recording.settings.objects = std::move(*objects);
    if (Status status = read_textures(file, recording.settings); !status)
        return tl::unexpected(status.error());
    recording.ticks.assign(ticks->begin(), ticks->end());
    if (Status status = read_messages(file, recording); !status)
        return tl::unexpected(status.error());
    if (Status status = check_recording(recording); !status) return tl::unexpected(status.error());
    return recording;
}

bool same_bits(const std::array<double, 3>& a, const std::array<double, 3>& b) noexcept
{
    for (std::size_t i = 0; i < 3; ++i) {
        if (std::bit_cast<std::uint64_t>(a[i]) != std::bit_cast<std::uint64_t>(b[i])) return false;
    }
    return true;
}

} // namespace

RecordedTick recorded(double seconds, const DeviceState& state, const RenderTick& tick) noexcept
{
    RecordedTick result;
    result.seconds = seconds;
    result.position = numbers(state.pose.translation);
    result.velocity = numbers(state.velocity);
    result.force = numbers(tick.force);
    result.proxy = numbers(tick.proxy);
    result.buttons = state.buttons;
    result.triangle = to_index(tick.contact_count > 0 ? tick.contacts[0].triangle : no_triangle);
    result.hold = static_cast<std::uint32_t>(tick.hold);
    result.fault = static_cast<std::uint16_t>(tick.fault);
    result.condition = static_cast<std::uint16_t>(state.condition);
    return result;
}

DeviceState device_state(const RecordedTick& tick) noexcept
{
    DeviceState state;
    state.pose.translation = vector(tick.position);
    state.velocity = vector(tick.velocity);
    state.buttons = tick.buttons;
    state.condition = tick.condition < input_conditions
                          ? static_cast<InputCondition>(tick.condition)
                          : InputCondition::unsure;
    return state;
}

bool same_response(const RecordedTick& a, const RecordedTick& b) noexcept
{
    return same_bits(a.force, b.force) && same_bits(a.proxy, b.proxy);
}

Status save_recording(const Recording& recording, const std::filesystem::path& path,
                      Progress* progress)
{
    const SettingNumbers settings = numbers(recording.settings);
    const std::uint64_t fingerprint = recording.settings.mesh_fingerprint;
    std::vector<ObjectNumbers> objects;
    std::vector<std::uint64_t> fingerprints;
    std::vector<TextureNumbers> textures = {
        numbers(std::optional(recording.settings.render.texture))};
    for (const ScriptedObject& object : recording.settings.objects) {
        objects.push_back(numbers(object));
        fingerprints.push_back(object.mesh_fingerprint);
        textures.push_back(numbers(object.texture));
    }
    std::vector<MessageNumbers> messages;
    messages.reserve(recording.messages.size());
    for (const SceneMessage& message : recording.messages) messages.push_back(numbers(message));
    const auto law = static_cast<std::uint32_t>(recording.settings.law);
    const double room = recording.settings.room;
    const std::array<BinarySection, 9> sections = {
        {{fingerprint_section, sizeof fingerprint, std::as_bytes(std::span(&fingerprint, 1))},
         {settings_section, sizeof settings, std::as_bytes(std::span(&settings, 1))},
         {ticks_section, sizeof(RecordedTick), std::as_bytes(std::span(recording.ticks))},
         {objects_section, sizeof(ObjectNumbers), std::as_bytes(std::span(objects))},
         {fingerprints_of_objects_section, sizeof(std::uint64_t),
          std::as_bytes(std::span(fingerprints))},
         {force_law_section, sizeof law, std::as_bytes(std::span(&law, 1))},
         {room_section, sizeof room, std::as_bytes(std::span(&room, 1))},
         {messages_section, sizeof(MessageNumbers), std::as_bytes(std::span(messages))},

         {textures_section, sizeof(TextureNumbers), std::as_bytes(std::span(textures))}}};
    return write_binary_file(path, format, sections, progress);
}

Result<Recording> load_recording(const std::filesystem::path& path, Progress* progress)
{
    return parsed(BinaryFile::open(path, format, {.progress = progress}), path.string(),
                  recording_of);
}

Result<Recording> load_recording(std::span<const std::byte> bytes,
                                 std::shared_ptr<const void> storage, const std::string& name)
{
    return parsed(BinaryFile::read(bytes, std::move(storage), name, format, Verification::full),
                  name, recording_of);
}

std::uint64_t count_differences(const Recording& recording, HapticRenderer& renderer) noexcept
{
    std::uint64_t differences = 0;
    for (const RecordedTick& tick : recording.ticks) {
        const DeviceState state = device_state(tick);
        const RenderTick& rendered = renderer.tick(state, recording.settings.tick_seconds);
        if (!same_response(recorded(tick.seconds, state, rendered), tick)) ++differences;
    }
    return differences;
}

} // namespace proxima
