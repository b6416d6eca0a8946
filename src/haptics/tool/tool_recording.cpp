#include "haptics/tool/tool_recording.h"

#include "base/binary_file.h"
#include "base/text.h"
#include "geometry/pose_matrix.h"
#include "haptics/loop/recorded_numbers.h"

#include <bit>
#include <string_view>
#include <utility>

namespace proxima {

namespace {

constexpr FileFormat tool_format = {
    {'P', 'X', 'T', 'O', 'O', 'L', '\r', '\n'}, 2, "recording of a tool"};
constexpr std::uint32_t first_version_with_guard = 2;

enum ToolSection : std::uint32_t {
    meshes_section = 1, ///< fingerprints: model, tool
    numbers_section = 2,
    tool_ticks_section = 3
};

static_assert(sizeof(RecordedToolTick) == 30 * sizeof(double) + 2 * sizeof(std::uint32_t));

/// A number of the settings, in the order of the file, and what it may be.
struct SettingField {
    std::string_view name;
    double value;
    double least;
    double most;
};

constexpr std::size_t setting_count = 25;
constexpr std::size_t setting_count_without_guard = 24;

/// Coordinates and strengths are bounded so that no product of several overflows; what is narrower is
/// checked by make_tool_renderer.
std::array<SettingField, setting_count> fields_of(const ToolRecordingSettings& settings)
{
    constexpr double far = 1e100;
    constexpr double strong = 1e9;
    constexpr double day = 86400;
    const ToolRenderOptions& render = settings.render;
    const ForceOptions& force = render.force;
    const Vec3& center = settings.map.center;
    return {{{"tick_seconds", settings.tick_seconds, 1e-6, 1},
             {"units_per_metre", settings.map.units_per_metre, 1 / far, far},
             {"center x", center.x(), -far, far},
             {"center y", center.y(), -far, far},
             {"center z", center.z(), -far, far},
             {"max_force", settings.max_force, 1 / strong, strong},
             {"max_stiffness", settings.max_stiffness, 1 / strong, strong},
             {"max_damping", settings.max_damping, 0, strong},
             {"max_torque", settings.max_torque, 0, strong},
             {"stiffness", force.stiffness, 1 / strong, strong},
             {"damping", force.damping, 0, strong},
             {"max_slew", force.max_slew, 0, strong},
             {"start_seconds", force.start_seconds, 0, day},
             {"loss_seconds", force.loss_seconds, 0, day},
             {"torsional_stiffness", render.torsional_stiffness, 0, strong},
             {"torsional_damping", render.torsional_damping, 0, strong},
             {"static_friction", render.static_friction, 0, strong},
             {"dynamic_friction", render.dynamic_friction, 0, strong},
             {"max_torque_slew", render.max_torque_slew, 0, strong},
             {"clearance", render.clearance, 1 / strong, strong},
             {"max_jump", render.max_jump, 0, strong},
             {"max_turn", render.max_turn, 0, strong},
             {"max_moves", static_cast<double>(render.max_moves), 1, 32},
             {"max_work", static_cast<double>(render.max_work), 0, strong},
             {"guard", guard_number(render.guard), 0, last_guard}}};
}

Status check_fields(std::span<const SettingField> fields)
{
    for (const SettingField& field : fields) {
        if (field.value >= field.least && field.value <= field.most) continue;
        return fail(ErrorCode::malformed_file,
                    concat(field.name, " is ", field.value, " and must be ", field.least, " to ",
                           field.most));
    }
    return {};
}

ToolRecordingSettings settings_of(std::span<const double> n)
{
    ToolRecordingSettings settings;
    settings.tick_seconds = n[0];
    settings.map = {n[1], Vec3(n[2], n[3], n[4])};
    settings.max_force = n[5];
    settings.max_stiffness = n[6];
    settings.max_damping = n[7];
    settings.max_torque = n[8];
    settings.render.force = {.stiffness = n[9],
                             .damping = n[10],
                             .max_slew = n[11],
                             .start_seconds = n[12],
                             .loss_seconds = n[13]};
    settings.render.torsional_stiffness = n[14];
    settings.render.torsional_damping = n[15];
    settings.render.static_friction = n[16];
    settings.render.dynamic_friction = n[17];
    settings.render.max_torque_slew = n[18];
    settings.render.clearance = n[19];
    settings.render.max_jump = n[20];
    settings.render.max_turn = n[21];
    // Other numbers are no sizes: zero moves are refused, and what no number holds is.
    const auto size = [](double value) {
        return value >= 0 && value <= 1e9 ? static_cast<std::size_t>(value) : 0;
    };
    settings.render.max_moves = size(n[22]);
    settings.render.max_work = size(n[23]);
    settings.render.guard = n.size() > 24 ? guard_of_number(n[24]) : Guard::off;
    return settings;
}

template <std::size_t Count>
bool equal_bits(const std::array<double, Count>& a, const std::array<double, Count>& b) noexcept
{
    for (std::size_t i = 0; i < Count; ++i)
        if (std::bit_cast<std::uint64_t>(a[i]) != std::bit_cast<std::uint64_t>(b[i])) return false;
    return true;
}

tl::unexpected<Error> malformed(const std::string& what)
{
    return fail(ErrorCode::malformed_file, concat(what, ": record the session again"));
}

Result<ToolRecording> tool_recording_of(const BinaryFile& file, Progress* progress)
{
    const auto meshes = file.section<std::uint64_t>(meshes_section);
    if (!meshes) return tl::unexpected(meshes.error());
    const auto numbers = file.section<double>(numbers_section);
    if (!numbers) return tl::unexpected(numbers.error());
    const auto ticks = file.section<RecordedToolTick>(tool_ticks_section);
    if (!ticks) return tl::unexpected(ticks.error());
    const std::size_t count =
        file.version() < first_version_with_guard ? setting_count_without_guard : setting_count;
    if (meshes->size() != 2 || numbers->size() != count)
        return malformed("the settings of the recording are missing");
    if (count == setting_count) {
        Status guard = check_choice("guard", numbers->back(), last_guard);
        if (!guard) return tl::unexpected(guard.error());
    }
    ToolRecording recording;
    recording.settings = settings_of(*numbers);
    recording.settings.model_fingerprint = meshes->front();
    recording.settings.tool_fingerprint = meshes->back();
    // The file's own numbers, some of which the settings cannot hold.
    auto fields = fields_of(recording.settings);
    for (std::size_t i = 0; i < count; ++i) fields[i].value = (*numbers)[i];
    if (const Status status = check_fields(fields); !status)
        return malformed(status.error().message);
    auto checked = checked_ticks(*ticks, progress, [](const RecordedToolTick& tick, std::size_t i) {
        if (tick.condition < input_conditions) return Status();
        return Status(malformed(concat("tick ", i, ": condition is ", tick.condition,
                                       " and must be less than ", input_conditions)));
    });
    if (!checked) return tl::unexpected(std::move(checked).error());
    recording.ticks = std::move(*checked);
    return recording;
}

} // namespace

Status check_settings(const ToolRecordingSettings& settings)
{
    return check_fields(fields_of(settings));
}

DeviceLimits ToolRecordingSettings::device() const
{
    return {.name = "recorded",
            .max_force = max_force,
            .max_stiffness = max_stiffness,
            .max_damping = max_damping,
            .max_torque = max_torque};
}

RecordedToolTick recorded(const DeviceState& state, const ToolTick& tick) noexcept
{
    RecordedToolTick result;
    result.device = pose_matrix(state.pose);
    result.proxy = pose_matrix(tick.proxy);
    result.force = {tick.force.x(), tick.force.y(), tick.force.z()};
    result.torque = {tick.torque.x(), tick.torque.y(), tick.torque.z()};
    result.condition = static_cast<std::uint32_t>(state.condition);
    result.buttons = state.buttons;
    return result;
}

DeviceState device_state(const RecordedToolTick& tick) noexcept
{
    DeviceState state;
    for (std::size_t row = 0; row < 3; ++row) {
        const auto at = static_cast<Eigen::Index>(row);
        for (std::size_t column = 0; column < 3; ++column) {
            const auto across = static_cast<Eigen::Index>(column);
            state.pose.rotation(at, across) = tick.device[4 * row + column];
        }
        state.pose.translation[at] = tick.device[4 * row + 3];
    }
    state.buttons = tick.buttons;
    state.condition = tick.condition < input_conditions
                          ? static_cast<InputCondition>(tick.condition)
                          : InputCondition::unsure;
    return state;
}

bool same_response(const RecordedToolTick& a, const RecordedToolTick& b) noexcept
{
    return equal_bits(a.force, b.force) && equal_bits(a.torque, b.torque) &&
           equal_bits(a.proxy, b.proxy);
}

Status save_tool_recording(const ToolRecording& recording, const std::filesystem::path& path,
                           Progress* progress)
{
    const ToolRecordingSettings& settings = recording.settings;
    const std::array<std::uint64_t, 2> meshes = {settings.model_fingerprint,
                                                 settings.tool_fingerprint};
    std::array<double, setting_count> numbers{};
    const auto fields = fields_of(settings);
    for (std::size_t i = 0; i < setting_count; ++i) numbers[i] = fields[i].value;
    const std::array<BinarySection, 3> sections = {
        {{meshes_section, sizeof(std::uint64_t), std::as_bytes(std::span(meshes))},
         {numbers_section, sizeof(double), std::as_bytes(std::span(numbers))},
         {tool_ticks_section, sizeof(RecordedToolTick),
          std::as_bytes(std::span(recording.ticks))}}};
    return write_binary_file(path, tool_format, sections, progress);
}

Result<ToolRecording> load_tool_recording(const std::filesystem::path& path, Progress* progress)
{
    return parsed(BinaryFile::open(path, tool_format, {.progress = progress}), path.string(),
                  [=](const BinaryFile& file) { return tool_recording_of(file, progress); });
}

Result<ToolRecording> load_tool_recording(std::span<const std::byte> bytes,
                                          std::shared_ptr<const void> storage,
                                          const std::string& name)
{
    return parsed(
        BinaryFile::read(bytes, std::move(storage), name, tool_format, Verification::full), name,
        [](const BinaryFile& file) { return tool_recording_of(file, nullptr); });
}

} // namespace proxima
