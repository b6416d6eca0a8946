// proxima touch: feels a model with a simulated hand or a recording, and reports how good it was
// (thesis section 5.1).
#include "base/text.h"
#include "cli/commands.h"
#include "cli/model_options.h"
#include "cli/names.h"
#include "cli/plot.h"
#include "cli/poses.h"
#include "cli/touch_engine.h"
#include "cli/touch_input_report.h"
#include "cli/touch_objects.h"
#include "cli/touch_options.h"
#include "cli/touch_plot.h"
#include "cli/touch_report.h"
#include "cli/touch_self_test.h"
#include "cli/touch_session.h"
#include "cli/touch_tool.h"
#include "haptics/tool/tool_recording.h"

#include <CLI/CLI.hpp>
#include <csignal>
#include <fmt/core.h>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace proxima {

namespace {

using Json = nlohmann::ordered_json;

constexpr std::string_view replay_prefix = "replay:";

/// Plots the session where that was asked for.
Status write_picture(const TouchCommandOptions& options, const TouchTrace& trace,
                     Progress* progress, Session& session)
{
    if (options.picture.empty()) return {};
    if (trace.ticks.empty()) {
        return fail(ErrorCode::invalid_argument, "the session has no tick that could be plotted",
                    "--picture");
    }
    const std::string note = fmt::format("{}, {} ticks of {:g} ms", options.device,
                                         trace.ticks.size(), 1e3 * trace.tick_seconds);
    if (Status status =
            write_touch_plot(trace, "Touching " + options.model, note, options.picture, progress);
        !status)
        return status;
    session.print(fmt::format("wrote {}\n", options.picture));
    return {};
}

Status check_files(const TouchCommandOptions& options, Session& session)
{
    if (Status status = session.check_outputs({options.picture, options.record}); !status)
        return status;
    if (!options.record.empty()) {
        if (Status status = check_extension(options.record, ".pxt"); !status) return status;
    }
    return options.picture.empty() ? Status() : check_plot_format(options.picture);
}

Status run_replay(const TouchCommandOptions& options, Session& session)
{
    const std::string path = options.device.substr(replay_prefix.size());
    const auto recording = load_recording(path, &session.progress());
    if (!recording) {
        if (recording.error().code == ErrorCode::unsupported_format && load_tool_recording(path)) {
            return fail(ErrorCode::invalid_argument,
                        "is a recording of a tool: give --tool, the mesh that touched", path);
        }
        return tl::unexpected(recording.error());
    }
    const auto plan = plan_scene(options.model, options.objects, *recording, path);
    if (!plan) return tl::unexpected(plan.error());
    const auto model = plan->objects.empty()
                           ? load_touch_model(options.model, options.lists, session)
                           : load_touch_scene(*plan, recording->settings.render.shading,
                                              options.lists, path, session);
    if (!model) return tl::unexpected(model.error());
    const auto result = replay_touch(**model, *recording, path, !options.picture.empty(), session);
    if (!result) return tl::unexpected(result.error());
    const TouchReportOf of = {options.model,
                              options.device,
                              false,
                              result->differences,
                              result->touch.render_options.force,
                              options.verbose};
    session.print(touch_text(of, **model, result->touch));
    if (Status status = write_picture(options, result->touch.trace, &session.progress(), session);
        !status)
        return status;
    return session.write_json(touch_json(of, **model, result->touch));
}

/// MODEL at rest, or the scene that options ask for.
Result<std::unique_ptr<TouchModel>> load_what_is_touched(const TouchCommandOptions& options,
                                                         Session& session)
{
    const bool is_driven = !options.engine.empty();
    if (!options.objects.any() && !is_driven)
        return load_touch_model(options.model, options.lists, session);
    auto plan = plan_scene(options.model, options.objects, usual_material(options));
    if (!plan) return tl::unexpected(plan.error());
    if (is_driven) {
        plan->room = engine_room;
        for (ScriptedObject& object : plan->objects)
            if (!object.material) object.material = usual_material(options);
    }
    session.print(rotation_text(plan->rotation_error, true, session));
    return load_touch_scene(*plan, settings_of(options).render.shading, options.lists, {}, session);
}

constexpr std::string_view usual_thesis_patch = "3"; ///< adjacency depth

/// The thesis's proximity octree of the model. Errors: invalid_mesh for one that is not convex.
Status build_thesis_octree(const std::string& name, TouchModel& model, Session& session)
{
    const ProgressBar shown(session.progress(), session.bar());
    auto octree = build_thesis_proximity_octree(model.surface.mesh, model.surface.topology,
                                                {.execution = session.execution()});
    if (!octree) return at_model(octree.error(), name);
    model.thesis = std::move(*octree);
    return {};
}

/// Feels the model once, or once with each kind of patch; the first is the one that is reported.
Result<TouchResult> touch_with_patches(const TouchCommandOptions& options, const TouchModel& model,
                                       std::vector<PatchAccount>& patches, Session& session)
{
    TouchSettings settings = settings_of(options);
    if (options.patches.empty()) return touch_by_device(model, settings, session);
    const auto kinds = parse_patch_kinds(options.patches);
    if (!kinds) return tl::unexpected(kinds.error());
    std::optional<TouchResult> first;
    for (PatchSettings kind : *kinds) {
        kind.collision_rate = options.collision_rate;
        kind.method = options.method;
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

Status run_device(const TouchCommandOptions& options, Session& session)
{
    const double bytes = recorded_bytes(settings_of(options));
    if (Status status = check_recorded_bytes(bytes, options.seconds,
                                             options.record.empty() ? "--picture" : "--record");
        !status)
        return status;
    const auto model = load_what_is_touched(options, session);
    if (!model) return tl::unexpected(model.error());
    if (options.method == QueryMethod::thesis) {
        if (Status status = build_thesis_octree(options.model, **model, session); !status)
            return status;
    }
    std::vector<PatchAccount> patches;
    const auto result = touch_with_patches(options, **model, patches, session);
    if (!result && result.error().code == ErrorCode::invalid_mesh)
        return at_model(result.error(), options.model);
    if (!result) return tl::unexpected(result.error());
    Status recorded;
    if (!options.record.empty()) {
        // An interrupted session is as good as any: its recording is written all the same.
        Progress* const progress = result->device->interrupted ? nullptr : &session.progress();
        recorded = result->engine && result->engine->dropped > 0
                       ? fail(ErrorCode::limit_exceeded,
                              fmt::format("the engine sent {} more messages than could be "
                                          "recorded: send poses less often, or a higher "
                                          "--graphics-rate",
                                          result->engine->dropped),
                              "--record")
                       : save_recording(result->recording, options.record, progress);
    }
    const TouchReportOf of = {options.model,
                              options.device,
                              !options.free_running,
                              std::nullopt,
                              settings_of(options).render.force,
                              options.verbose};
    session.print(touch_text(of, **model, *result));
    if (!patches.empty()) session.print(patch_table(patches));
    if (!options.record.empty() && recorded)
        session.print(fmt::format("wrote {}\n", options.record));
    // An interrupted session is plotted like any other.
    const Status plotted =
        write_picture(options, result->trace,
                      result->device->interrupted ? nullptr : &session.progress(), session);
    Json json = touch_json(of, **model, *result);
    if (!patches.empty()) json["patches"] = patch_json(patches);
    // The results are written even if the recording could not be.
    const Status written = session.write_json(json);
    if (!recorded) return recorded;
    return plotted ? written : plotted;
}

Status check_list_options(const TouchCommandOptions& options)
{
    for (const std::string& option : options.given) {
        if (option != "--list-devices" && option != "--device-library") {
            return fail(ErrorCode::invalid_argument,
                        "has no effect with --list-devices, which touches nothing", option);
        }
    }
    return {};
}

Status check_usage(const TouchCommandOptions& options)
{
    if (options.list) return check_list_options(options);
    if (Status status = check_options(options); !status) return status;
    if (Status status = check_engine_options(options); !status) return status;
    return check_self_test_options(options);
}

Status list_devices(const TouchCommandOptions& options, Session& session)
{
    const std::vector<FoundDevice> devices = look_for_devices(options.library);
    session.print(device_list_text(devices));
    return session.write_json(device_list_json(devices));
}

Status run_touch(TouchCommandOptions options, Session& session)
{
    if (options.list) return list_devices(options, session);
    // Whoever reads our words may end before the session does: its forces then fade all the same.
    std::signal(SIGPIPE, SIG_IGN);
    const bool replays = options.device.starts_with(replay_prefix);
    if (!replays) {
        auto images = read_texture_images(options.objects.textures, &session.progress());
        if (!images) return tl::unexpected(images.error());
        options.objects.images = std::move(*images);
    }
    if (options.self_test) return run_self_test(options, session);
    if (!options.tool.tool.empty())
        return run_tool(options.tool, options.model, options.record, settings_of(options), session);
    if (Status status = check_files(options, session); !status) return status;
    return replays ? run_replay(options, session) : run_device(options, session);
}

} // namespace

Command add_touch_command(CLI::App& app)
{
    CLI::App* const parser = app.add_subcommand(
        "touch", "Touch models at 1,000 Hz with a haptic device or a simulated hand");
    const auto options = std::make_shared<TouchCommandOptions>();
    add_model_option(*parser, options->model, ModelKinds::meshes_and_indexes);
    parser->add_option("--device", options->device, touch_device_names())
        ->required()
        ->check(touch_device_problem)
        ->type_name("NAME:ARGS");
    add_object_options(*parser, options->objects);
    add_touch_options(*parser, *options);
    add_engine_option(*parser, *options);
    add_tool_options(*parser, options->tool);
    add_self_test_options(*parser, *options);
    // Neither model nor device is needed then.
    parser->add_flag_callback(
        "--list-devices",
        [parser, options] {
            options->list = true;
            for (const char* const name : {"MODEL", "--device"})
                parser->get_option(name)->required(false);
        },
        "List the devices that were found, and why the others cannot be opened");
    // Not those that all commands have, which are added later.
    const std::vector<CLI::Option*> own = parser->get_options();
    parser->callback([own, options] {
        for (const CLI::Option* const option : own)
            if (option->count() > 0) options->given.push_back(option->get_name());
        if (options->method == QueryMethod::thesis && options->patches.empty())
            options->patches = usual_thesis_patch;
        if (const Status status = check_usage(*options); !status)
            throw CLI::ValidationError(status.error().where, status.error().message);
    });
    return {parser, [options](Session& session) { return run_touch(*options, session); }};
}

} // namespace proxima
