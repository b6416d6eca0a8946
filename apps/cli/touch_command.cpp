// proxima touch: feels a model with a simulated hand or a recording, and reports how good it was
// (thesis section 5.1).
#include "cli/commands.h"
#include "cli/model_options.h"
#include "cli/names.h"
#include "cli/touch_input_report.h"
#include "cli/touch_objects.h"
#include "cli/touch_report.h"
#include "cli/touch_session.h"
#include "proxima/base/text.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/core.h>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace proxima {

namespace {

using Json = nlohmann::ordered_json;

constexpr std::string_view replay_prefix = "replay:";

struct TouchOptions {
    std::string model;
    ObjectOptions objects;
    std::string device;
    std::string library; ///< of hd and dhd
    std::string limits;  ///< "" for the device's own
    std::string axes;    ///< "" for the device's own
    double scale = 1;
    int clutch = 0; ///< button from 1; 0 for none
    bool list = false;
    double seconds = 5;
    std::uint64_t seed = 1;
    double stiffness = ForceOptions{}.stiffness;
    double damping = ForceOptions{}.damping;
    double radius = 0; ///< m
    double friction = RenderOptions{}.static_friction;
    bool shading = false;
    std::string force = "proxy";
    bool free_running = false;
    std::string record;
    std::string patches; ///< kinds; "" for the direct mode
    double collision_rate = PatchSettings{}.collision_rate;
    double graphics_rate = TouchSettings{}.graphics_rate;
    std::vector<std::string> given; ///< names of the options that were given
};

/// What a recording says of its own session.
constexpr std::array recorded_options = {
    "--seconds",        "--seed",          "--limits",  "--stiffness",      "--damping",
    "--radius",         "--friction",      "--shading", "--force",          "--free-running",
    "--scale",          "--axes",          "--clutch",  "--device-library", "--patch",
    "--collision-rate", "--graphics-rate", "--record"};
constexpr std::array hand_options = {"--seed", "--free-running"};
constexpr std::array driver_options = {"--device-library"};

std::string names_of_devices()
{
    std::string names;
    for (const DeviceLimits& device : known_devices())
        names += (names.empty() ? "" : ", ") + std::string(device.name);
    return names;
}

TouchSettings settings_of(const TouchOptions& options)
{
    TouchSettings settings;
    settings.device.device = options.device;
    settings.device.library = options.library;
    settings.device.limits = find_device(options.limits);
    settings.device.scale = options.scale;
    settings.device.seed = options.seed;
    settings.input.clutch_buttons = options.clutch > 0 ? 1U << (options.clutch - 1) : 0U;
    settings.input.tick_seconds = settings.device.hand.tick_seconds;
    if (!options.axes.empty()) settings.input.rotation = *parse_axes(options.axes);
    settings.seconds = options.seconds;
    settings.render.force.stiffness = options.stiffness;
    settings.render.force.damping = options.damping;
    settings.render.proxy_radius = options.radius;
    settings.render.static_friction = options.friction;
    settings.render.dynamic_friction = 0.75 * options.friction;
    settings.render.shading = options.shading ? ForceShading::on : ForceShading::off;
    if (options.force == "penalty") {
        settings.render.law = ForceLaw::penalty;
        settings.render.static_friction = settings.render.dynamic_friction = 0;
    }
    settings.pace = options.free_running ? Pace::unpaced : Pace::real_time;
    settings.record = !options.record.empty();
    settings.graphics_rate = options.graphics_rate;
    return settings;
}

/// What a material has that says less of itself.
SurfaceMaterial usual_material(const TouchOptions& options)
{
    return {.stiffness = options.stiffness,
            .damping = options.damping,
            .static_friction = options.friction,
            .dynamic_friction = 0.75 * options.friction};
}

/// Error invalid_argument for an option that would be without any effect.
Status check_options(const TouchOptions& options)
{
    const auto is_given = [&](std::string_view name) {
        return std::ranges::find(options.given, name) != options.given.end();
    };
    const auto refuse = [&](std::span<const char* const> names, const char* why) -> Status {
        const auto found = std::ranges::find_if(names, is_given);
        if (found == names.end()) return {};
        return fail(ErrorCode::invalid_argument, why, *found);
    };
    const std::string kind = options.device.substr(0, options.device.find(':'));
    Status status;
    if (kind == "replay")
        return refuse(recorded_options, "a replay is felt as it was recorded: leave it out");
    if (kind != "hand") {
        status = refuse(hand_options,
                        "is for a simulated hand: other devices go their own ways and keep time");
    }
    if (status && kind != "hd" && kind != "dhd")
        status = refuse(driver_options, "is for hd and dhd: leave it out");
    if (!status) return status;
    if (is_given("--collision-rate") && !is_given("--patch")) {
        return fail(ErrorCode::invalid_argument, "is of patches: give --patch, or leave it out",
                    "--collision-rate");
    }
    if (is_given("--record") && is_given("--patch")) {
        return fail(ErrorCode::invalid_argument,
                    "is for sessions that touch the whole model: a replay cannot know which patch "
                    "came when. Leave it or --patch out",
                    "--record");
    }
    return {};
}

Status run_replay(const TouchOptions& options, Session& session)
{
    const std::string path = options.device.substr(replay_prefix.size());
    const auto recording = load_recording(path, &session.progress());
    if (!recording) return tl::unexpected(recording.error());
    const auto plan = plan_scene(options.model, options.objects, *recording, path);
    if (!plan) return tl::unexpected(plan.error());
    const auto model =
        plan->objects.empty()
            ? load_touch_model(options.model, session)
            : load_touch_scene(*plan, recording->settings.render.shading, path, session);
    if (!model) return tl::unexpected(model.error());
    const auto result = replay_touch(**model, *recording, path);
    if (!result) return tl::unexpected(result.error());
    if (Status status = session.check_running(); !status) return status;
    const TouchReportOf of = {options.model, options.device, false, result->differences};
    session.print(touch_text(of, **model, result->touch));
    return session.write_json(touch_json(of, **model, result->touch));
}

/// Penalty forces have no proxy that any of this could be of.
Status check_penalty(const TouchOptions& options)
{
    if (options.force != "penalty") return {};
    const bool has_friction = std::ranges::find(options.given, "--friction") != options.given.end();
    const std::array<std::pair<const char*, bool>, 5> given = {
        {{"--radius", options.radius > 0},
         {"--friction", has_friction && options.friction > 0},
         {"--shading", options.shading},
         {"--patch", !options.patches.empty()},
         {"--object, --pose, --motion and --material", options.objects.any()}}};
    for (const auto& [option, is_given] : given) {
        if (!is_given) continue;
        return fail(ErrorCode::invalid_argument,
                    concat("penalty is of a point and one model at rest: leave out ", option),
                    "--force");
    }
    return {};
}

/// MODEL at rest, or the scene that options ask for.
Result<std::unique_ptr<TouchModel>> load_what_is_touched(const TouchOptions& options,
                                                         Session& session)
{
    if (!options.objects.any()) return load_touch_model(options.model, session);
    if (!options.patches.empty()) {
        return fail(ErrorCode::invalid_argument,
                    "is for one model at rest: leave it out, or --object, --pose, --motion and "
                    "--material",
                    "--patch");
    }
    const auto plan = plan_scene(options.model, options.objects, usual_material(options));
    if (!plan) return tl::unexpected(plan.error());
    return load_touch_scene(*plan, settings_of(options).render.shading, {}, session);
}

/// Feels the model once, or once with each kind of patch; the first is the one that is reported.
Result<TouchResult> touch_with_patches(const TouchOptions& options, const TouchModel& model,
                                       std::vector<PatchAccount>& patches, Session& session)
{
    TouchSettings settings = settings_of(options);
    if (options.patches.empty()) return touch_by_device(model, settings, session);
    const auto kinds = parse_patch_kinds(options.patches);
    if (!kinds) return tl::unexpected(kinds.error());
    std::optional<TouchResult> first;
    for (PatchSettings kind : *kinds) {
        kind.collision_rate = options.collision_rate;
        settings.patches = kind;
        auto result = touch_by_device(model, settings, session);
        if (!result) return tl::unexpected(result.error());
        patches.push_back(*result->patches);
        const bool interrupted = result->device->interrupted;
        if (!first) first = std::move(*result);
        if (interrupted) break;
    }
    return std::move(*first);
}

Status run_device(const TouchOptions& options, Session& session)
{
    if (Status status = check_penalty(options); !status) return status;
    if (!options.record.empty()) {
        if (Status status = session.check_outputs({options.record}); !status) return status;
        if (Status status = check_extension(options.record, ".pxt"); !status) return status;
        const double bytes = recorded_bytes(settings_of(options));
        if (bytes > most_recorded_bytes) {
            return fail(ErrorCode::budget_exceeded,
                        fmt::format("{:g} s would hold {:.1f} GB in memory, and a recording may "
                                    "hold {:.1f}: give at most --seconds {:.0f}, or no --record",
                                    options.seconds, 1e-9 * bytes, 1e-9 * most_recorded_bytes,
                                    std::floor(options.seconds * most_recorded_bytes / bytes)),
                        "--record");
        }
    }
    const auto model = load_what_is_touched(options, session);
    if (!model) return tl::unexpected(model.error());
    std::vector<PatchAccount> patches;
    const auto result = touch_with_patches(options, **model, patches, session);
    if (!result) return tl::unexpected(result.error());
    Status recorded;
    if (!options.record.empty()) {
        // An interrupted session is as good as any: its recording is written all the same.
        Progress* const progress = result->device->interrupted ? nullptr : &session.progress();
        recorded = save_recording(result->recording, options.record, progress);
    }
    const TouchReportOf of = {options.model, options.device, !options.free_running, std::nullopt};
    session.print(touch_text(of, **model, *result));
    if (!patches.empty()) session.print(patch_table(patches));
    if (!options.record.empty() && recorded)
        session.print(fmt::format("wrote {}\n", options.record));
    Json json = touch_json(of, **model, *result);
    if (!patches.empty()) json["patches"] = patch_json(patches);
    // What was felt is said, whether it could be kept or not.
    const Status written = session.write_json(json);
    return recorded ? written : recorded;
}

Status list_devices(const TouchOptions& options, Session& session)
{
    const std::vector<FoundDevice> devices = look_for_devices(options.library);
    session.print(device_list_text(devices));
    return session.write_json(device_list_json(devices));
}

Status run_touch(const TouchOptions& options, Session& session)
{
    if (options.list) return list_devices(options, session);
    if (Status status = check_options(options); !status) return status;
    return options.device.starts_with(replay_prefix) ? run_replay(options, session)
                                                     : run_device(options, session);
}

/// A finite number of a range: CLI::Range lets through what is no number.
CLI::Validator number_from(double least, double most)
{
    const auto problem = [least, most](const std::string& text) {
        const auto numbers = parse_finite_numbers(text);
        const bool right = numbers && numbers->size() == 1 && numbers->front() >= least &&
                           numbers->front() <= most;
        return right ? std::string()
                     : fmt::format("{} is no number from {:g} to {:g}", text, least, most);
    };
    return {problem, fmt::format("in [{:g} - {:g}]", least, most)};
}

void add_settings(CLI::App& parser, TouchOptions& options)
{
    parser.add_option("--seconds", options.seconds, "How long the device touches")
        ->check(number_from(0.001, 86400.0))
        ->capture_default_str()
        ->type_name("S");
    parser.add_option("--seed", options.seed, "Of the hand's script")
        ->check([](const std::string& text) {
            return parse_whole(text) ? std::string()
                                     : concat(text, " is no whole number from 0 to 2^64 - 1");
        })
        ->capture_default_str()
        ->type_name("N");
    parser
        .add_option("--limits", options.limits,
                    "Whose force, stiffness, damping and workspace are the most: " +
                        names_of_devices() + "; the device's own without it, an omni's of a hand")
        ->check([](const std::string& name) {
            return find_device(name) ? std::string()
                                     : concat(name, " is no device: they are ", names_of_devices());
        })
        ->type_name("NAME");
    parser.add_option("--stiffness", options.stiffness, "Of the surface, N/m")
        ->check(number_from(0.0, 1e5))
        ->capture_default_str()
        ->type_name("K");
    parser.add_option("--damping", options.damping, "Of the surface, N s/m")
        ->check(number_from(0.0, 1e3))
        ->capture_default_str()
        ->type_name("B");
    parser.add_option("--radius", options.radius, "Of the proxy, m; 0 is a point")
        ->check(number_from(0.0, 0.1))
        ->capture_default_str()
        ->type_name("R");
    parser
        .add_option("--friction", options.friction,
                    "Static friction; the dynamic one is three quarters of it")
        ->check(number_from(0.0, 10.0))
        ->capture_default_str()
        ->type_name("MU");
    parser.add_flag("--shading", options.shading,
                    "Let forces lean along smooth normals, over edges that are not sharp");
    parser
        .add_option("--force", options.force,
                    "What a spring pulls towards: a proxy that stays outside, or penalty, the "
                    "baseline: the nearest place of the surface")
        ->check(CLI::IsMember({"proxy", "penalty"}))
        ->capture_default_str()
        ->type_name("LAW");
    parser.add_flag("--free-running", options.free_running,
                    "Tick after tick without waiting: the same forces, sooner");
    parser
        .add_option("--scale", options.scale,
                    "Motions in the model, over those that fit it into the workspace")
        ->check(number_from(1e-3, 1e3))
        ->capture_default_str()
        ->type_name("F");
    parser.add_option("--axes", options.axes, "What x, y and z are of the device's axes: x,-z,y")
        ->check([](const std::string& text) {
            const auto axes = parse_axes(text);
            return axes ? std::string() : axes.error().message;
        })
        ->type_name("AXES");
    parser
        .add_option("--clutch", options.clutch,
                    "The button (from 1) that lets the device move without what it holds")
        ->check(CLI::Range(1, 32))
        ->type_name("BUTTON");
    parser
        .add_option("--device-library", options.library,
                    "The file of libHD.so or libdhd.so, for hd and dhd")
        ->type_name("FILE");
    parser
        .add_option("--patch", options.patches,
                    "Touch patches of a collision loop: metric, or the thesis's adjacency depth; "
                    "several to compare: metric,1,2,3")
        ->check([](const std::string& text) {
            const auto kinds = parse_patch_kinds(text);
            return kinds ? std::string() : kinds.error().message;
        })
        ->type_name("KINDS");
    parser.add_option("--collision-rate", options.collision_rate, "Patches per second")
        ->check(number_from(1.0, 1000.0))
        ->capture_default_str()
        ->type_name("HZ");
    parser.add_option("--graphics-rate", options.graphics_rate, "Of what a terminal shows")
        ->check(number_from(1.0, 1000.0))
        ->capture_default_str()
        ->type_name("HZ");
    parser.add_option("--record", options.record, "Write the session, to be replayed (.pxt)")
        ->type_name("FILE");
}

} // namespace

Command add_touch_command(CLI::App& app)
{
    CLI::App* const parser = app.add_subcommand(
        "touch", "Feel models at 1,000 Hz with a haptic device or a simulated hand");
    const auto options = std::make_shared<TouchOptions>();
    add_model_option(*parser, options->model, ModelKinds::meshes_and_proximity_octrees);
    parser->add_option("--device", options->device, touch_device_names())
        ->required()
        ->check(touch_device_problem)
        ->type_name("NAME:ARGS");
    add_object_options(*parser, options->objects);
    add_settings(*parser, *options);
    // Neither model nor device is needed then.
    parser->add_flag_callback(
        "--list-devices",
        [parser, options] {
            options->list = true;
            for (const char* const name : {"MODEL", "--device"})
                parser->get_option(name)->required(false);
        },
        "Print the devices that are there, and what is wrong with the others");
    return {parser, [parser, options](Session& session) {
                for (const CLI::Option* const option : parser->get_options())
                    if (option->count() > 0) options->given.push_back(option->get_name());
                return run_touch(*options, session);
            }};
}

} // namespace proxima
