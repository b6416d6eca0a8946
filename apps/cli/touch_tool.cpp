#include "cli/touch_tool.h"

#include "base/output_file.h"
#include "cli/touch_device.h"
#include "cli/touch_options.h"
#include "haptics/tool/rigid_motion.h"
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
};

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
    if (!scaled) return tl::unexpected(scaled.error());
    return build_mesh_index(*scaled, {.execution = session.execution()});
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

constexpr std::string_view row_header =
    "seconds,x,y,z,turn_x,turn_y,turn_z,proxy_x,proxy_y,proxy_z,proxy_turn_x,proxy_turn_y,"
    "proxy_turn_z,force_x,force_y,force_z,torque_x,torque_y,torque_z,contacts\n";

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
            "next tick. 0 for no bound")
        ->capture_default_str()
        ->type_name("N");
    parser
        .add_option("--ticks", options.ticks,
                    "Table of all ticks of a tool: poses of device and proxy, force and torque "
                    "(.csv)")
        ->type_name("FILE");
}

Status run_tool(const ToolCommandOptions& options, const std::string& model_name,
                const TouchSettings& settings, Session& session)
{
    if (!options.ticks.empty()) {
        if (Status status = session.check_outputs({options.ticks}); !status) return status;
        const double kept_ticks = settings.seconds / settings.input.tick_seconds;
        const double bytes = kept_ticks * static_cast<double>(sizeof(ToolTick));
        if (bytes > most_recorded_bytes) {
            return fail(ErrorCode::budget_exceeded,
                        fmt::format("{:g} s would hold {:.1f} GB in memory, and a session may hold "
                                    "{:.1f}: give at most --seconds {:.0f}, or no --ticks",
                                    settings.seconds, 1e-9 * bytes, 1e-9 * most_recorded_bytes,
                                    std::floor(settings.seconds * most_recorded_bytes / bytes)),
                        "--ticks");
        }
    }
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
            const std::int64_t clock = clock_nanoseconds();
            const std::int64_t begin = thread_nanoseconds();
            const ToolTick& tick = renderer->tick(state, tick_seconds);
            account.processor.add(thread_nanoseconds() - begin);
            account.tick.add(clock_nanoseconds() - clock);
            device.write(input->command(*renderer));
            ++account.ticks;
            account.touching += tick.contact_count > 0 ? 1U : 0U;
            account.limited += tick.end == ToolEnd::limited ? 1U : 0U;
            account.cut_short += tick.end == ToolEnd::cut_short ? 1U : 0U;
            account.overloaded += tick.end == ToolEnd::overloaded ? 1U : 0U;
            account.unplaced += tick.is_placed ? 0U : 1U;
            // A simulated hand waits for the exact test; a device would miss ticks.
            account.entered +=
                scripted && tick.is_placed && meshes_intersect(touched.index, *tool, tick.proxy)
                    ? 1U
                    : 0U;
            account.max_force = std::max(account.max_force, tick.force.norm());
            account.max_torque = std::max(account.max_torque, tick.torque.norm());
            account.max_spring_torque =
                std::max(account.max_spring_torque, tick.spring_torque.norm());
            const Vec3 stretch =
                opened->map.to_device(tick.proxy.translation) - tick.device.translation;
            account.max_stretch = std::max(account.max_stretch, stretch.norm());
            account.max_near = std::max(account.max_near, tick.near_triangles);
            if (!kept.empty()) kept[number] = tick;
            return account.ticks >= last + release_ticks ? Flow::stop : Flow::proceed;
        });
    kept.resize(std::min<std::size_t>(kept.size(), account.ticks));

    std::string text = fmt::format(
        "{} ticks with a tool of {} triangles on {}: {} in contact, {} in which tool and model "
        "met\n"
        "force: at most {:.3f} N, {:.2f} mm of stretch\n"
        "torque: at most {:.4f} N m{}\n"
        "{} ticks left motion to the next, {} others ended at their work, {} had too many "
        "triangles "
        "near (at most {} pairs)\n",
        account.ticks, tool->triangle_count(), model_name, account.touching, account.entered,
        account.max_force, 1e3 * account.max_stretch, account.max_torque,
        options.max_torque > 0 ? std::string()
                               : fmt::format(": the device gives none; its spring asked for {:.4f}",
                                             account.max_spring_torque),
        account.limited, account.cut_short, account.overloaded, account.max_near);
    if (account.unplaced > 0) {
        text += fmt::format("{} ticks felt nothing: the tool began inside and was not out yet\n",
                            account.unplaced);
    }
    text += times_text("a tick by the clock", account.tick);
    text += times_text("a tick's processor time", account.processor);
    session.print(text);
    if (!options.ticks.empty()) {
        auto file = OutputFile::create(options.ticks);
        if (!file) return tl::unexpected(file.error());
        Status written = file->write(row_header);
        for (std::size_t i = 0; i < kept.size() && written; ++i)
            written = file->write(row_of(static_cast<double>(i) * tick_seconds, kept[i]));
        if (written) written = file->commit();
        if (!written) return written;
        session.print(fmt::format("wrote {}\n", options.ticks));
    }
    return session.write_json({{"model", model_name},
                               {"triangles", touched.index.triangle_count()},
                               {"tool", options.tool},
                               {"tool_triangles", tool->triangle_count()},
                               {"device", settings.device.device},
                               {"ticks", account.ticks},
                               {"interrupted", last < ticks},
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
                               {"max_stretch", account.max_stretch},
                               {"clock", json_of(account.tick)},
                               {"processor", json_of(account.processor)},
                               {"missed_deadlines", servo.missed}});
}

} // namespace proxima
