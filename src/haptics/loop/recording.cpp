#include "haptics/loop/recording.h"

#include "base/binary_file.h"
#include "base/text.h"
#include "haptics/loop/check_recording.h"
#include "haptics/loop/recorded_images.h"
#include "haptics/loop/recorded_numbers.h"
#include "haptics/loop/recording_rows.h"
#include "proxima/touch_scene.h"

#include <bit>
#include <optional>
#include <utility>
#include <vector>

namespace proxima {

namespace {

constexpr FileFormat format = {{'P', 'X', 'T', 'O', 'U', 'C', 'H', '\n'}, 6, "recording"};

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
    // Since version 6 those of recorded_images.h.
};
constexpr std::uint32_t first_version_with_objects = 3;
constexpr std::uint32_t first_version_with_force_laws = 4;
constexpr std::uint32_t first_version_with_messages = 5;
constexpr std::uint32_t first_version_with_textures = 5;
constexpr std::uint32_t first_version_with_images = 6;

static_assert(sizeof(RecordedTick) == 13 * sizeof(double) + 4 * sizeof(std::uint32_t));

std::array<double, 3> numbers(const Vec3& v) noexcept
{
    return {v.x(), v.y(), v.z()};
}
Vec3 vector(const std::array<double, 3>& v) noexcept
{
    return {v[0], v[1], v[2]};
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
    std::optional<RecordedImages> images;
    if (file.version() >= first_version_with_images) {
        auto read = RecordedImages::read(file, rows->size());
        if (!read) return tl::unexpected(read.error());
        images = std::move(*read);
    }
    for (std::size_t i = 0; i < rows->size(); ++i) {
        const TextureNumbers& row = (*rows)[i];
        const std::string of = concat("texture ", i, ": ");
        constexpr auto last_shape = static_cast<int>(BumpShape::image);
        Status status = check_choice(of + "shape", row.shape, last_shape);
        if (status) status = check_choice(of + "is_there", row.is_there, 1);
        if (!status) return status;
        if (row.is_there == 0) continue;
        SurfaceTexture texture = texture_of(row);
        if (images) texture.bump.image = images->image_of(i);
        if (i == 0) {
            settings.render.texture = std::move(texture);
        } else {
            settings.objects[i - 1].texture = std::move(texture);
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

/// The error of a check, with advice.
tl::unexpected<Error> advised(const Error& error)
{
    return fail(error.code, concat(error.message, ": record the session again"));
}

/// What a file holds, checked. Errors malformed_file and cancelled, some without a place.
Result<Recording> recording_of(const BinaryFile& file, Progress* progress)
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
    if (Status status = read_messages(file, recording); !status)
        return tl::unexpected(status.error());
    if (const Status status = check_recording(recording); !status) return advised(status.error());
    auto checked = checked_ticks(*ticks, progress, [](const RecordedTick& tick, std::size_t i) {
        Status status = check_tick(tick, i);
        return status ? status : Status(advised(status.error()));
    });
    if (!checked) return tl::unexpected(std::move(checked).error());
    recording.ticks = std::move(*checked);
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
    const SettingNumbers settings = recording_row(recording.settings);
    const std::uint64_t fingerprint = recording.settings.mesh_fingerprint;
    std::vector<ObjectNumbers> objects;
    std::vector<std::uint64_t> fingerprints;
    std::vector<TextureNumbers> textures = {
        recording_row(std::optional(recording.settings.render.texture))};
    for (const ScriptedObject& object : recording.settings.objects) {
        objects.push_back(recording_row(object));
        fingerprints.push_back(object.mesh_fingerprint);
        textures.push_back(recording_row(object.texture));
    }
    std::vector<MessageNumbers> messages;
    messages.reserve(recording.messages.size());
    for (const SceneMessage& message : recording.messages)
        messages.push_back(recording_row(message));
    const auto law = static_cast<std::uint32_t>(recording.settings.law);
    const double room = recording.settings.room;
    std::vector<BinarySection> sections = {
        {fingerprint_section, sizeof fingerprint, std::as_bytes(std::span(&fingerprint, 1))},
        {settings_section, sizeof settings, std::as_bytes(std::span(&settings, 1))},
        {ticks_section, sizeof(RecordedTick), std::as_bytes(std::span(recording.ticks))},
        {objects_section, sizeof(ObjectNumbers), std::as_bytes(std::span(objects))},
        {fingerprints_of_objects_section, sizeof(std::uint64_t),
         std::as_bytes(std::span(fingerprints))},
        {force_law_section, sizeof law, std::as_bytes(std::span(&law, 1))},
        {room_section, sizeof room, std::as_bytes(std::span(&room, 1))},
        {messages_section, sizeof(MessageNumbers), std::as_bytes(std::span(messages))},
        {textures_section, sizeof(TextureNumbers), std::as_bytes(std::span(textures))}};
    const RecordedImages images(recording.settings);
    images.append_sections(sections);
    return write_binary_file(path, format, sections, progress);
}

Result<Recording> load_recording(const std::filesystem::path& path, Progress* progress)
{
    return parsed(BinaryFile::open(path, format, {.progress = progress}), path.string(),
                  [=](const BinaryFile& file) { return recording_of(file, progress); });
}

Result<Recording> load_recording(std::span<const std::byte> bytes,
                                 std::shared_ptr<const void> storage, const std::string& name)
{
    return parsed(BinaryFile::read(bytes, std::move(storage), name, format, Verification::full),
                  name, [](const BinaryFile& file) { return recording_of(file, nullptr); });
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
