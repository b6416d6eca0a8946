#include "cli/touch_tool.h"

#include "base/file_extension.h"
#include "base/output_file.h"
#include "base/text.h"
#include "cli/model_options.h"
#include "cli/names.h"
#include "cli/touch_device.h"
#include "cli/touch_options.h"
#include "cli/touch_report.h"
#include "haptics/loop/recording.h"
#include "haptics/tool/rigid_motion.h"
#include "haptics/tool/tool_guard.h"
#include "haptics/tool/tool_recording.h"
#include "proxima/device.h"
#include "proxima/intersect_meshes.h"
#include "proxima/tool_renderer.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>
#include <fmt/core.h>
#include <nlohmann/json.hpp>
#include <numbers>
#include <optional>
#include <span>
#include <utility>
#include <vector>

namespace proxima {

namespace {

using Json = nlohmann::ordered_json;

/// Periods of the wrist's turns about the three axes, s.
constexpr std::array<double, 3> turn_periods = {1.9, 2.7, 3.1};

/// How a simulated wrist has turned the tool.
Mat3 turned_by_wrist(double degrees, double seconds)
{
    Vec3 turn;
    for (int axis = 0; axis < 3; ++axis) {
        const double period = turn_periods[static_cast<std::size_t>(axis)];
        turn[axis] = std::sin(2 * std::numbers::pi * seconds / period);
    }
    return moved_by({}, {Vec3::Zero(), Vec3(degrees * std::numbers::pi / 180 * turn)}, 1).rotation;
}

/// Processor time of this thread, ns: unlike a clock it leaves out what other programs take.
std::int64_t thread_nanoseconds() noexcept
{
    timespec now = {};
    (void)clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return now.tv_sec * 1'000'000'000LL + now.tv_nsec;
}

std::int64_t clock_nanoseconds() noexcept
{
    return std::chrono::steady_clock::now().time_since_epoch() / std::chrono::nanoseconds(1);
}

constexpr std::string_view replay_name = "replay:";

/// What a session with a tool showed.
struct ToolAccount {
    std::uint64_t ticks = 0;
    std::uint64_t touching = 0;
    std::uint64_t limited = 0;
    std::uint64_t cut_short = 0;
    std::uint64_t overloaded = 0;
    std::uint64_t unplaced = 0;
    std::uint64_t entered = 0;
    double max_force = 0;
    double max_torque = 0;
    double max_spring_torque = 0;
    double max_stretch = 0;
    std::size_t max_near = 0;
    LatencyHistogram tick;      ///< by the clock
    LatencyHistogram processor; ///< by the thread's processor time
    std::uint64_t missed = 0;   ///< deadlines
    bool interrupted = false;
    SwingReport swings;                            ///< what the passivity guard saw and did
    std::optional<std::uint64_t> differences = {}; ///< ticks of a replay with other bits

    /// One tick of the renderer, timed.
    const ToolTick& add(ToolRenderer& renderer, const DeviceState& state, double seconds) noexcept;
};

const ToolTick& ToolAccount::add(ToolRenderer& renderer, const DeviceState& state,
                                 double seconds) noexcept
{
    const std::int64_t clock = clock_nanoseconds();
    const std::int64_t begin = thread_nanoseconds();
    const ToolTick& felt = renderer.tick(state, seconds);
    processor.add(thread_nanoseconds() - begin);
    tick.add(clock_nanoseconds() - clock);
    ++ticks;
    touching += felt.contact_count > 0 ? 1U : 0U;
    limited += felt.end == ToolEnd::limited ? 1U : 0U;
    cut_short += felt.end == ToolEnd::cut_short ? 1U : 0U;
    overloaded += felt.end == ToolEnd::overloaded ? 1U : 0U;
    unplaced += felt.is_placed ? 0U : 1U;
    max_force = std::max(max_force, felt.force.norm());
    max_torque = std::max(max_torque, felt.torque.norm());
    max_spring_torque = std::max(max_spring_torque, felt.spring_torque.norm());
    const Vec3 stretch = renderer.map().to_device(felt.proxy.translation) - felt.device.translation;
    max_stretch = std::max(max_stretch, stretch.norm());
    max_near = std::max(max_near, felt.near_triangles);
    return felt;
}

Json json_of(const LatencyHistogram& tick)
{
    const auto at = [&](double part) { return 1e-3 * static_cast<double>(tick.quantile(part)); };
    return {{"p50_us", at(0.5)},
            {"p99_us", at(0.99)},
            {"p999_us", at(0.999)},
            {"p9999_us", at(0.9999)},
            {"max_us", 1e-3 * static_cast<double>(tick.max())}};
}

std::string times_text(const char* what, const LatencyHistogram& tick)
{
    const auto at = [&](double part) { return 1e-3 * static_cast<double>(tick.quantile(part)); };
    return fmt::format("{}: {:.1f} us median, {:.1f} at 99 %, {:.1f} at 99.9 %, {:.1f} at 99.99 %, "
                       "{:.1f} at most\n",
                       what, at(0.5), at(0.99), at(0.999), at(0.9999),
                       1e-3 * static_cast<double>(tick.max()));
}

Result<MeshIndex> load_tool(const ToolCommandOptions& options, Session& session)
{
    const auto mesh = session.load_model(options.tool);
    if (!mesh) return tl::unexpected(mesh.error());
    std::vector<Vec3> positions(mesh->positions().begin(), mesh->positions().end());
    for (Vec3& position : positions) position *= options.tool_scale;
    auto scaled = make_triangle_mesh(std::move(positions),
                                     {mesh->triangles().begin(), mesh->triangles().end()});
    if (!scaled) return at_model(scaled.error(), options.tool);
    auto index = build_mesh_index(*scaled, {.execution = session.execution()});
    if (!index) return at_model(index.error(), options.tool);
    return index;
}

std::string row_of(double seconds, const ToolTick& tick)
{
    const auto text = [](const Vec3& v) {
        return fmt::format(",{:.9g},{:.9g},{:.9g}", v.x(), v.y(), v.z());
    };
    return fmt::format("{:.9g}{}{}{}{}{}{},{}\n", seconds, text(tick.device.translation),
                       text(rotation_vector(tick.device.rotation)), text(tick.proxy.translation),
                       text(rotation_vector(tick.proxy.rotation)), text(tick.force),
                       text(tick.torque), tick.contact_count);
}

/// A session, for its report.
struct ToolSession {
    const ToolCommandOptions& options;
    const std::string& model_name;
    const std::string& device;
    std::string_view record; ///< empty where nothing was recorded
    const MeshIndex& model;
    const MeshIndex& tool;
    double tick_seconds = 1e-3;
    double max_torque = 0; ///< of the device
    Guard guard = Guard::on;
};

constexpr std::string_view row_header =
    "seconds,x,y,z,turn_x,turn_y,turn_z,proxy_x,proxy_y,proxy_z,proxy_turn_x,proxy_turn_y,"
    "proxy_turn_z,force_x,force_y,force_z,torque_x,torque_y,torque_z,contacts\n";

/// Prints a session, and writes its table of ticks.
Status report_tool(const ToolSession& of, const ToolAccount& account,
                   std::span<const ToolTick> kept, Session& session)
{
    std::string text = fmt::format(
        "{} ticks with a tool of {} triangles on {}: {} in contact, {} in which tool and model "
        "met\n"
        "force: at most {:.3f} N, {:.2f} mm of stretch\n"
        "torque: at most {:.4f} N m{}\n"
        "{} ticks left motion to the next, {} others ended at their work, {} had too many "
        "triangles "
        "near (at most {} pairs)\n",
        account.ticks, of.tool.triangle_count(), of.model_name, account.touching, account.entered,
        account.max_force, 1e3 * account.max_stretch, account.max_torque,
        of.max_torque > 0 ? std::string()
                          : fmt::format(": the device gives none; its spring asked for {:.4f}",
                                        account.max_spring_torque),
        account.limited, account.cut_short, account.overloaded, account.max_near);
    if (account.unplaced > 0) {
        text += fmt::format("{} ticks felt nothing: the tool began inside and was not out yet\n",
                            account.unplaced);
    }
    const double seconds = of.tick_seconds * static_cast<double>(account.ticks);
    text += swings_text(account.swings, of.guard, account.ticks, seconds);
    if (account.differences)
        text += fmt::format("{} ticks have other forces than recorded\n", *account.differences);
    text += times_text("a tick by the clock", account.tick);
    text += times_text("a tick's processor time", account.processor);
    session.print(text);
    if (!of.record.empty()) session.print(fmt::format("wrote {}\n", of.record));
    if (!of.options.ticks.empty()) {
        auto file = OutputFile::create(of.options.ticks);
        if (!file) return tl::unexpected(file.error());
        Status written = file->write(row_header);
        for (std::size_t i = 0; i < kept.size() && written; ++i)
            written = file->write(row_of(static_cast<double>(i) * of.tick_seconds, kept[i]));
        if (written) written = file->commit();
        if (!written) return written;
        session.print(fmt::format("wrote {}\n", of.options.ticks));
    }
    Json json = {{"model", of.model_name},
                 {"triangles", of.model.triangle_count()},
                 {"tool", of.options.tool},
                 {"tool_triangles", of.tool.triangle_count()},
                 {"device", of.device},
                 {"ticks", account.ticks},
                 {"interrupted", account.interrupted},
                 {"replay_differences", account.differences ? Json(*account.differences) : Json()},
                 {"touching_ticks", account.touching},
                 {"entered_ticks", account.entered},
                 {"unplaced_ticks", account.unplaced},
                 {"limited_ticks", account.limited},
                 {"cut_short_ticks", account.cut_short},
                 {"overloaded_ticks", account.overloaded},
                 {"max_near_pairs", account.max_near},
                 {"max_force", account.max_force},
                 {"max_torque", account.max_torque},
                 {"max_spring_torque", account.max_spring_torque},
                 {"max_stretch", account.max_stretch}};
    add_swings_json(json, account.swings, of.guard);
    json["clock"] = json_of(account.tick);
    json["processor"] = json_of(account.processor);
    json["missed_deadlines"] = account.missed;
    return session.write_json(json);
}

/// Plays a recorded session again.
Status replay_tool(const ToolCommandOptions& options, const std::string& touched,
                   const std::string& device, Session& session)
{
    const std::string path = device.substr(replay_name.size());
    const auto recording = load_tool_recording(path, &session.progress());
    if (!recording) {
        if (recording.error().code == ErrorCode::unsupported_format && load_recording(path)) {
            return fail(ErrorCode::invalid_argument,
                        "is a recording of a point, not of a tool: leave --tool out", path);
        }
        return tl::unexpected(recording.error());
    }
    const auto model = load_touch_model(touched, false, session);
    if (!model) return tl::unexpected(model.error());
    const auto tool = load_tool(options, session);
    if (!tool) return tl::unexpected(tool.error());
    const MeshIndex& index = (*model)->index;
    const ToolRecordingSettings& settings = recording->settings;
    if (settings.model_fingerprint != index.mesh_fingerprint() ||
        settings.tool_fingerprint != tool->mesh_fingerprint()) {
        return fail(ErrorCode::invalid_argument,
                    "was recorded with another model, tool or --tool-scale: replay it with those "
                    "of the session",
                    path);
    }
    const ToolObject object = {index, {}};
    auto renderer = make_tool_renderer(*tool, std::span(&object, 1), settings.map,
                                       settings.device(), settings.render);
    if (!renderer) return tl::unexpected(renderer.error());
    ToolAccount account;
    account.differences = 0;
    std::vector<ToolTick> kept;
    kept.reserve(options.ticks.empty() ? 0 : recording->ticks.size());
    for (const RecordedToolTick& tick : recording->ticks) {
        if (Status status = session.check_running(); !status) return status;
        const DeviceState state = device_state(tick);
        const ToolTick& felt = account.add(*renderer, state, settings.tick_seconds);
        account.entered += felt.is_placed && meshes_intersect(index, *tool, felt.proxy) ? 1U : 0U;
        if (!same_response(recorded(state, felt), tick)) ++*account.differences;
        if (!options.ticks.empty()) kept.push_back(felt);
    }
    account.swings = guard_of(*renderer).passivity().report();
    return report_tool({options, touched, device, "", index, *tool, settings.tick_seconds,
                        settings.max_torque, settings.render.guard},
                       account, kept, session);
}

} // namespace

void add_tool_options(CLI::App& parser, ToolCommandOptions& options)
{
    parser
        .add_option("--tool", options.tool,
                    "Touch with this mesh in place of a point, its origin at the device's tip: a "
                    "file or a built-in model")
        ->type_name("TOOL");
    add_number(parser, "--tool-scale", options.tool_scale,
               "Scale of the tool's coordinates, to the model's unit", "F", 1e-9, 1e9);
    add_number(parser, "--turn", options.turn,
               "How far a simulated hand turns the tool to and fro about each axis, degrees",
               "DEGREES", 0, 170);
    add_number(parser, "--max-torque", options.max_torque,
               "Torque that the device can give, N m; 0 for a device without", "TAU", 0, 1e3);
    add_number(parser, "--clearance", options.clearance,
               "Distance at which a tool and the model touch, m; half of it is always kept", "M",
               1e-9, 1e-2);
    parser
        .add_option(
            "--max-work", options.max_work,
            "Most work in a tick of a tool, about a microsecond a unit; what is left is for the "
            "next tick. At least 100, or 0 for no bound")
        ->check([](const std::string& text) {
            const auto units = parse_whole(text);
            return units && (*units == 0 || *units >= 100)
                       ? std::string()
                       : concat(text, " is neither 0 nor a whole number from 100 up");
        })
        ->capture_default_str()
        ->type_name("N");
    parser
        .add_option("--ticks", options.ticks,
                    "Table of all ticks of a tool: poses of device and proxy, force and torque "
                    "(.csv)")
        ->type_name("FILE");
}

Status run_tool(const ToolCommandOptions& options, const std::string& model_name,
                const std::string& record, const TouchSettings& settings, Session& session)
{
    if (Status status = session.check_outputs({options.ticks, record}); !status) return status;
    if (!options.ticks.empty() && lower_case_extension(options.ticks) != ".csv")
        return fail(ErrorCode::invalid_argument, "must end in .csv", options.ticks);
    if (settings.device.device.starts_with(replay_name))
        return replay_tool(options, model_name, settings.device.device, session);
    if (!record.empty()) {
        if (Status status = check_extension(record, ".pxt"); !status) return status;
    }
    const auto bytes_per_tick =
        static_cast<double>((options.ticks.empty() ? 0 : sizeof(ToolTick)) +
                            (record.empty() ? 0 : sizeof(RecordedToolTick)));
    const double bytes = settings.seconds / settings.input.tick_seconds * bytes_per_tick;
    if (Status status = check_recorded_bytes(bytes, settings.seconds,
                                             options.ticks.empty() ? "--record" : "--ticks");
        !status)
        return status;
    const auto model = load_touch_model(model_name, false, session);
    if (!model) return tl::unexpected(model.error());
    const auto tool = load_tool(options, session);
    if (!tool) return tl::unexpected(tool.error());
    const TouchModel& touched = **model;
    auto opened = open_touch_device(settings.device, touched.reach, touched.surface.mesh,
                                    touched.surface.topology, touched.parts);
    if (!opened) return tl::unexpected(opened.error());
    opened->limits.max_torque = options.max_torque;
    const ToolObject object = {touched.index, {}};
    ToolRenderOptions render;
    render.force = settings.render.force;
    render.static_friction = settings.render.static_friction;
    render.dynamic_friction = settings.render.dynamic_friction;
    render.max_jump = settings.render.max_jump;
    render.guard = settings.render.guard;
    render.clearance = options.clearance;
    render.max_work = options.max_work;
    auto renderer =
        make_tool_renderer(*tool, std::span(&object, 1), opened->map, opened->limits, render);
    if (!renderer) return tl::unexpected(renderer.error());
    Device& device = *opened->device;
    auto input = make_device_input(device.info(), settings.input);
    if (!input) return tl::unexpected(input.error());

    const double tick_seconds = settings.input.tick_seconds;
    const auto ticks = static_cast<std::uint64_t>(std::llround(settings.seconds / tick_seconds));
    const std::uint64_t release_ticks = ticks_to_release(device.info(), settings);
    const bool scripted = settings.device.device.starts_with("hand:");
    std::vector<ToolTick> kept(options.ticks.empty() ? 0 : ticks + release_ticks);
    ToolRecording recording;
    recording.settings = {.model_fingerprint = touched.index.mesh_fingerprint(),
                          .tool_fingerprint = tool->mesh_fingerprint(),
                          .tick_seconds = tick_seconds,
                          .map = opened->map,
                          .render = render,
                          .max_force = opened->limits.max_force,
                          .max_stiffness = opened->limits.max_stiffness,
                          .max_damping = opened->limits.max_damping,
                          .max_torque = options.max_torque};
    if (!record.empty()) {
        if (Status status = check_recordable(check_settings(recording.settings)); !status)
            return status;
    }
    recording.ticks.resize(record.empty() ? 0 : ticks + release_ticks);
    std::uint64_t last = ticks; // the session ends before this tick, and then lets go
    ToolAccount account;
    const ServoStatistics servo = device.run(
        {.rate = 1 / tick_seconds, .ticks = ticks + release_ticks, .pace = settings.pace},
        [&](std::uint64_t number) noexcept {
            if (number < last && session.progress().cancelled()) last = number;
            if (number >= last) input->release();
            DeviceReading reading = device.read();
            const double seconds = static_cast<double>(number) * tick_seconds;
            if (scripted) reading.state.pose.rotation = turned_by_wrist(options.turn, seconds);
            const DeviceState& state = input->accept(reading);
            const ToolTick& tick = account.add(*renderer, state, tick_seconds);
            device.write(input->command(*renderer));
            // A simulated hand waits for the exact test; a device would miss ticks.
            account.entered +=
                scripted && tick.is_placed && meshes_intersect(touched.index, *tool, tick.proxy)
                    ? 1U
                    : 0U;
            if (!recording.ticks.empty()) recording.ticks[number] = recorded(state, tick);
            if (!kept.empty()) kept[number] = tick;
            return account.ticks >= last + release_ticks ? Flow::stop : Flow::proceed;
        });
    account.missed = servo.missed;
    account.swings = guard_of(*renderer).passivity().report();
    account.interrupted = last < ticks;
    kept.resize(std::min<std::size_t>(kept.size(), account.ticks));
    recording.ticks.resize(std::min<std::size_t>(recording.ticks.size(), account.ticks));
    // The results are written even if the recording could not be.
    const Status saved =
        record.empty() ? Status() : save_tool_recording(recording, record, nullptr);
    const ToolSession of = {
        options,       model_name, settings.device.device, saved ? std::string_view(record) : "",
        touched.index, *tool,      tick_seconds,           options.max_torque,
        render.guard};
    const Status reported = report_tool(of, account, kept, session);
    return saved ? reported : saved;
}

} // namespace proxima
