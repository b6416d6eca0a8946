#include "cli/touch_options.h"

#include "base/text.h"
#include "cli/index_file_model.h"
#include "cli/names.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <fmt/core.h>
#include <optional>
#include <span>
#include <string_view>
#include <utility>

namespace proxima {

namespace {

/// Of the hand:SCRIPT itself, and of the device that it holds.
constexpr std::array hand_options = {
    "--seed",           "--free-running",    "--hand-mass",    "--hand-stiffness", "--hand-damping",
    "--device-damping", "--device-friction", "--encoder-step", "--delay"};

/// What a recording says of its own session, beside these.
constexpr std::array recorded_options = {
    "--seconds",       "--limits",         "--stiffness", "--damping", "--radius",
    "--friction",      "--shading",        "--force",     "--scale",   "--axes",
    "--clutch",        "--device-library", "--stillness", "--patch",   "--collision-rate",
    "--graphics-rate", "--record",         "--method",    "--guard",   "--engine",
    "--pose",          "--motion",         "--material",  "--texture"};
/// What a tool has no use for yet, and what is for a tool alone.
constexpr std::array unfit_for_a_tool = {
    "--radius", "--shading",       "--force",          "--lists",    "--patch",   "--picture",
    "--object", "--pose",          "--motion",         "--material", "--texture", "--engine",
    "--method", "--graphics-rate", "--collision-rate", "--verbose"};
constexpr std::array tool_options = {"--tool-scale", "--turn",     "--max-torque",
                                     "--clearance",  "--max-work", "--ticks"};
constexpr std::array recorded_tool_options = {"--turn", "--max-torque", "--clearance",
                                              "--max-work"};
constexpr std::array driver_options = {"--device-library"};

std::string names_of_devices()
{
    std::string names;
    for (const DeviceLimits& device : known_devices())
        names += (names.empty() ? "" : ", ") + std::string(device.name);
    return names;
}

constexpr std::array<std::pair<std::string_view, Guard>, 3> guard_names = {
    {{"off", Guard::off}, {"observe", Guard::observe}, {"on", Guard::on}}};

constexpr std::array<std::pair<std::string_view, Stillness>, 3> stillness_names = {
    {{"usual", Stillness::usual},
     {"suspicious", Stillness::suspicious},
     {"impossible", Stillness::impossible}}};

std::optional<Stillness> find_stillness(std::string_view name)
{
    for (const auto& [known, stillness] : stillness_names)
        if (name == known) return stillness;
    return std::nullopt;
}

/// Penalty forces have no proxy that any of this could be of.
Status check_penalty(const TouchCommandOptions& options)
{
    if (options.force != "penalty") return {};
    const char* const patches = option_of_patches(options);
    const std::array<std::pair<const char*, bool>, 6> unfit = {
        {{"--radius", options.radius > 0},
         {"--friction", options.is_given("--friction") && options.friction > 0},
         {"--shading", options.shading},
         {patches, !options.patches.empty()},
         {"--texture", !options.objects.textures.empty()},
         {"--object, --pose, --motion and --material", options.objects.any()}}};
    for (const auto& [option, is_there] : unfit) {
        if (!is_there) continue;
        return fail(ErrorCode::invalid_argument,
                    concat("penalty is of a point and one model at rest: leave out ", option),
                    "--force");
    }
    return {};
}

/// The simulated hand and the device that it holds.
void add_hand_options(CLI::App& parser, HandModel& hand)
{
    add_number(parser, "--hand-mass", hand.mass,
               "Mass of a simulated hand and its device together, kg", "M", 1e-3, 1e3);
    add_number(
        parser, "--hand-stiffness", hand.hand_stiffness,
        "Stiffness of the spring that pulls a simulated hand along its script, N/m; 0 for none",
        "K", 0, 1e5);
    add_number(parser, "--hand-damping", hand.hand_damping, "Damping of that spring, N s/m", "B", 0,
               1e3);
    add_number(parser, "--device-damping", hand.device_damping,
               "Viscous damping of a simulated hand's device, N s/m", "B", 0, 1e3);
    add_number(parser, "--device-friction", hand.coulomb_friction,
               "Dry friction of a simulated hand's device, N", "F", 0, 1e2);
    add_number(parser, "--encoder-step", hand.encoder_step,
               "Encoder step of a simulated hand's device, m; 0 for none", "M", 0, 1e-4);
    parser
        .add_option("--delay", hand.delay_ticks,
                    "Ticks by which forces reach a simulated hand late")
        ->check(CLI::Range(0, max_hand_delay))
        ->capture_default_str()
        ->type_name("TICKS");
}

} // namespace

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

bool TouchCommandOptions::is_given(std::string_view name) const
{
    return std::ranges::find(given, name) != given.end();
}

const char* option_of_patches(const TouchCommandOptions& options)
{
    return options.is_given("--patch") ? "--patch" : "--method";
}

std::string_view guard_name(Guard guard) noexcept
{
    for (const auto& [name, known] : guard_names)
        if (known == guard) return name;
    return "on";
}

TouchSettings settings_of(const TouchCommandOptions& options)
{
    TouchSettings settings;
    settings.device.device = options.device;
    settings.engine = options.engine;
    settings.device.library = options.library;
    settings.device.limits = find_device(options.limits);
    settings.device.scale = options.scale;
    settings.device.seed = options.seed;
    settings.device.hand = options.hand;
    settings.input.clutch_buttons = options.clutch > 0 ? 1U << (options.clutch - 1) : 0U;
    settings.input.tick_seconds = settings.device.hand.tick_seconds;
    settings.input.stillness = find_stillness(options.stillness);
    if (!options.axes.empty()) settings.input.rotation = *parse_axes(options.axes);
    settings.seconds = options.seconds;
    settings.render.force.stiffness = options.stiffness;
    settings.render.force.damping = options.damping;
    settings.render.proxy_radius = options.radius;
    settings.render.static_friction = options.friction;
    settings.render.dynamic_friction = 0.75 * options.friction;
    for (const auto& [name, guard] : guard_names)
        if (options.guard == name) settings.render.guard = guard;
    settings.render.shading = options.shading ? ForceShading::on : ForceShading::off;
    if (options.force == "penalty") {
        settings.law = ForceLaw::penalty;
        settings.render.static_friction = settings.render.dynamic_friction = 0;
    }
    settings.render.texture = common_texture(options.objects.textures, options.objects.images);
    settings.pace = options.free_running ? Pace::unpaced : Pace::real_time;
    settings.record = !options.record.empty();
    settings.trace = !options.picture.empty();
    settings.graphics_rate = options.graphics_rate;
    return settings;
}

SurfaceMaterial usual_material(const TouchCommandOptions& options)
{
    return {.stiffness = options.stiffness,
            .damping = options.damping,
            .static_friction = options.friction,
            .dynamic_friction = 0.75 * options.friction};
}

Status check_options(const TouchCommandOptions& options)
{
    if (Status status = check_effects_differ(options.objects.textures); !status) return status;
    const auto refuse = [&](std::span<const char* const> names, const char* why) -> Status {
        const auto found =
            std::ranges::find_if(names, [&](const char* name) { return options.is_given(name); });
        if (found == names.end()) return {};
        return fail(ErrorCode::invalid_argument, why, *found);
    };
    if (options.lists && is_index_file(options.model) && !options.objects.any()) {
        return fail(ErrorCode::invalid_argument,
                    "a saved index is built already: leave it out, or give a mesh", "--lists");
    }
    Status tool = options.tool.tool.empty()
                      ? refuse(tool_options, "is of a tool: give --tool, or leave it out")
                      : refuse(unfit_for_a_tool, "is not for a tool: leave it or --tool out");
    if (!tool) return tool;
    const std::string kind = options.device.substr(0, options.device.find(':'));
    Status status;
    if (kind == "replay") {
        const char* const why = "a replay repeats the session as it was recorded: leave it out";
        status = refuse(recorded_options, why);
        if (status) status = refuse(recorded_tool_options, why);
        return status ? refuse(hand_options, why) : status;
    }
    if (kind != "hand") {
        status =
            refuse(hand_options, "is for a simulated hand, not for other devices: leave it out");
        if (status && options.is_given("--turn")) {
            return fail(ErrorCode::invalid_argument,
                        "turns a simulated hand, not other devices: leave it out", "--turn");
        }
    }
    if (kind == "hand" && options.is_given("--clutch")) {
        return fail(ErrorCode::invalid_argument, "a simulated hand has no buttons: leave it out",
                    "--clutch");
    }
    if (status && kind != "hd" && kind != "dhd")
        status = refuse(driver_options, "is for hd and dhd: leave it out");
    if (!status) return status;
    if (options.is_given("--collision-rate") && options.patches.empty()) {
        return fail(ErrorCode::invalid_argument, "is of patches: give --patch, or leave it out",
                    "--collision-rate");
    }
    if (options.is_given("--record") && !options.patches.empty()) {
        return fail(ErrorCode::invalid_argument,
                    concat("is for sessions that touch the whole model: a replay cannot know which "
                           "patch came when. Leave it or ",
                           option_of_patches(options), " out"),
                    "--record");
    }
    if (!options.patches.empty() && options.objects.any()) {
        return fail(ErrorCode::invalid_argument,
                    "is for one model at rest: leave it out, or --object, --pose, --motion and "
                    "--material",
                    option_of_patches(options));
    }
    return check_penalty(options);
}

void add_touch_options(CLI::App& parser, TouchCommandOptions& options)
{
    parser.add_option("--seconds", options.seconds, "Length of the session, s")
        ->check(number_from(0.001, 86400.0))
        ->capture_default_str()
        ->type_name("S");
    parser.add_option("--seed", options.seed, "Seed of the hand's script")
        ->check([](const std::string& text) {
            return parse_whole(text) ? std::string()
                                     : concat(text, " is no whole number from 0 to 2^64 - 1");
        })
        ->capture_default_str()
        ->type_name("N");
    add_hand_options(parser, options.hand);
    parser
        .add_option(
            "--limits", options.limits,
            "Limits of force, stiffness, damping and workspace, by device: " + names_of_devices() +
                "; those of hd and dhd are only lowered by it; default: the device's own, and an "
                "omni's for a simulated hand and over UDP")
        ->check([](const std::string& name) {
            return find_device(name)
                       ? std::string()
                       : concat(name, " is not a device: the devices are ", names_of_devices());
        })
        ->type_name("NAME");
    parser.add_option("--stiffness", options.stiffness, "Stiffness of the surface, N/m")
        ->check(number_from(0.0, 1e5))
        ->capture_default_str()
        ->type_name("K");
    parser.add_option("--damping", options.damping, "Damping of the surface, N s/m")
        ->check(number_from(0.0, 1e3))
        ->capture_default_str()
        ->type_name("B");
    parser.add_option("--radius", options.radius, "Radius of the proxy, m; 0 is a point")
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
                    "Let forces follow smooth normals across edges that are not sharp");
    parser
        .add_option("--force", options.force,
                    "What the spring pulls towards: a proxy that stays outside, or, as a baseline, "
                    "the nearest point of the surface (penalty)")
        ->check(CLI::IsMember({"proxy", "penalty"}))
        ->capture_default_str()
        ->type_name("LAW");
    parser
        .add_option("--guard", options.guard,
                    "Whether walls that are too stiff for the device are damped and softened: on; "
                    "observe, which only reports what it would do; or off")
        ->check(CLI::IsMember({"off", "observe", "on"}))
        ->capture_default_str()
        ->type_name("MODE");
    parser.add_flag("--free-running", options.free_running,
                    "Run the ticks without waiting between them; forces do not change");
    parser.add_flag("--verbose", options.verbose,
                    "Report every counter, the device and the times of the servo loop");
    parser.add_flag("--lists", options.lists,
                    "Build closest-feature lists: the same forces, shorter ticks for some motions, "
                    "a much later first tick");
    parser
        .add_option("--scale", options.scale,
                    "Scale of motions in the model; 1 fits the model into the workspace")
        ->check(number_from(1e-3, 1e3))
        ->capture_default_str()
        ->type_name("F");
    parser
        .add_option("--axes", options.axes,
                    "The model's x, y and z in the device's axes, such as x,-z,y")
        ->check([](const std::string& text) {
            const auto axes = parse_axes(text);
            return axes ? std::string() : axes.error().message;
        })
        ->type_name("AXES");
    parser
        .add_option("--clutch", options.clutch,
                    "While this button (counted from 1) is pressed, the device moves without its "
                    "position in the model")
        ->check(CLI::Range(1, 32))
        ->type_name("BUTTON");
    parser
        .add_option("--stillness", options.stillness,
                    "What it means when a device repeats the same position for half a second while "
                    "it is pushed: nothing (usual), a line in the report (suspicious), or a fault "
                    "that fades the force (impossible); default: what the device declares")
        ->check(CLI::IsMember({"usual", "suspicious", "impossible"}))
        ->type_name("MEANING");
    parser
        .add_option("--device-library", options.library,
                    "The file of libHD.so or libdhd.so, for hd and dhd")
        ->type_name("FILE");
    parser
        .add_option("--patch", options.patches,
                    "Touch patches of a collision loop, of the thesis's adjacency depth; "
                    "several to compare: 1,2,3")
        ->check([](const std::string& text) {
            const auto kinds = parse_patch_kinds(text);
            return kinds ? std::string() : kinds.error().message;
        })
        ->type_name("DEPTHS");
    add_query_method_option(parser, options.method,
                            "patches of adjacency depth 3, or as --patch says, around the feature "
                            "that its proximity octree finds; convex meshes");
    parser.add_option("--collision-rate", options.collision_rate, "Patches per second")
        ->check(number_from(1.0, 1000.0))
        ->capture_default_str()
        ->type_name("HZ");
    parser
        .add_option("--graphics-rate", options.graphics_rate,
                    "How often a terminal shows force and rate, Hz")
        ->check(number_from(1.0, 1000.0))
        ->capture_default_str()
        ->type_name("HZ");
    parser.add_option("--record", options.record, "Write the session, to be replayed (.pxt)")
        ->type_name("FILE");
    parser
        .add_option(
            "--picture", options.picture,
            "Plot force, depth and guards over time (.png, .svg or .pdf), or write a row for "
            "each tick (.csv)")
        ->type_name("FILE");
}

void add_number(CLI::App& parser, const char* name, double& value, const char* what,
                const char* unit, double least, double most)
{
    parser.add_option(name, value, what)
        ->check(number_from(least, most))
        ->capture_default_str()
        ->type_name(unit);
}

} // namespace proxima
