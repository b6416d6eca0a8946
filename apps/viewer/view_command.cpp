// proxima view: models and what the library computes of them, in a window or as a picture.
#include "base/file_extension.h"
#include "cli/camera_options.h"
#include "cli/image.h"
#include "cli/legend.h"
#include "cli/model_options.h"
#include "cli/names.h"
#include "viewer/commands.h"
#include "viewer/facts_json.h"
#include "viewer/layers_glb.h"
#include "viewer/named_settings.h"
#include "viewer/renderer.h"
#include "viewer/viewer.h"
#include "viewer/window/view_window.h"

#include <CLI/CLI.hpp>
#include <fmt/core.h>
#include <memory>
#include <nlohmann/json.hpp>

namespace proxima {
namespace {

constexpr std::uint64_t bytes_per_megabyte = 1'000'000;

struct ViewOptions {
    std::vector<std::string> models;
    std::string panel = "model";
    std::vector<std::string> settings;
    std::string picture;
    std::string out;
    CameraChoice camera;
    bool opengl = false;
    bool list_controls = false;
    std::string state;
    bool debug = false;
    std::uint64_t budget_mb = 0; ///< 0: the machine's

    [[nodiscard]] bool needs_window() const { return picture.empty() && out.empty(); }
};

Status prepare(Viewer& viewer, const ViewOptions& options)
{
    if (Status status = viewer.choose_panel(options.panel); !status) return status;
    return apply_settings(options.settings, [&](Controls& controls) { viewer.offer(controls); });
}

/// What is wrong with panel and settings, found before anything is read.
void check_usage(const ViewOptions& options)
{
    Viewer viewer;
    if (const Status status = prepare(viewer, options); !status)
        throw CLI::ValidationError("view", describe(status.error()));
    if (options.list_controls && !(options.picture.empty() && options.out.empty())) {
        throw CLI::ValidationError(
            "--controls", "lists settings and draws nothing: leave --picture and --out out");
    }
    if (options.list_controls && !options.models.empty()) {
        throw CLI::ValidationError("--controls",
                                   "lists settings before there are models: leave the model out");
    }
    if (!options.list_controls && !options.needs_window() && options.models.empty())
        throw CLI::RequiredError("MODEL");
    if (options.opengl && options.picture.empty()) {
        throw CLI::ValidationError(
            "--opengl", "is about --picture: a window is drawn by OpenGL, and .glb not at all");
    }
    if (!options.needs_window() && !options.state.empty())
        throw CLI::ValidationError("--state", "is about the window: leave it or the output out");
    if (!options.needs_window() && options.debug)
        throw CLI::ValidationError("--gl-debug", "is about the window: leave it or the output out");
}

Status write_files(const Viewer& viewer, const ViewOptions& options, Session& session)
{
    Progress* const progress = &session.progress();
    const ProgressBar shown(*progress, session.bar());
    const DrawnScene scene = flattened(viewer.layers(), viewer.backdrop());
    if (!options.picture.empty()) {
        auto renderer = [&]() -> Result<std::unique_ptr<Renderer>> {
            if (options.opengl) return make_opengl_renderer();
            return make_software_renderer(progress);
        }();
        if (!renderer) return tl::unexpected(renderer.error());
        auto image = (*renderer)->render(scene, viewer.camera(), options.camera.size);
        if (!image) return tl::unexpected(image.error());
        draw_legend(*image, viewer.legend());
        if (Status status = write_png(*image, options.picture, progress); !status) return status;
        session.print(fmt::format("wrote {}\n", options.picture));
    }
    if (!options.out.empty()) {
        if (Status status = export_scene(scene, options.out, progress); !status) return status;
        session.print(fmt::format("wrote {}\n", options.out));
    }
    return {};
}

/// The picture without a window.
Status run_headless(const ViewOptions& options, Session& session)
{
    Viewer viewer({.camera = options.camera,
                   .primitives = session.primitives(),
                   .execution = {.threads = session.threads(),
                                 .budget = {options.budget_mb * bytes_per_megabyte}}});
    viewer.resize(options.camera.size);
    if (Status status = prepare(viewer, options); !status) return status;
    viewer.open(options.models);
    {
        const auto loading = viewer.progress();
        const ProgressBar shown(*loading, session.bar());
        if (Status status = viewer.finish_loading(&session.progress()); !status) return status;
    }
    // Before there were models any number of one would do.
    if (Status status =
            check_settings(options.settings, [&](Controls& controls) { viewer.offer(controls); });
        !status)
        return status;
    if (const auto working = viewer.progress(); working != nullptr) {
        const ProgressBar shown(*working, session.bar());
        if (Status status = viewer.finish(&session.progress()); !status) return status;
    }
    if (Status status = viewer.finish(&session.progress()); !status) return status;
    for (const PanelFact& fact : viewer.facts())
        session.print(fmt::format("{:<22} {}\n", fact.name, fact.value));
    if (Status status = write_files(viewer, options, session); !status) return status;
    return session.write_json({{"models", options.models},
                               {"panel", viewer.panel().name()},
                               {"facts", facts_json(viewer.facts())}});
}

Status list_controls(const ViewOptions& options, Session& session)
{
    Viewer viewer;
    if (Status status = prepare(viewer, options); !status) return status;
    auto json = nlohmann::ordered_json::array();
    for (const ControlDescription& control :
         describe_controls([&](Controls& controls) { viewer.offer(controls); })) {
        session.print(control.text() + '\n');
        json.push_back({{"name", control.name},
                        {"value", nullptr},
                        {"values", control.values},
                        {"needs", control.needs}});
        if (control.value) json.back()["value"] = *control.value;
    }
    return session.write_json({{"panel", viewer.panel().name()}, {"controls", json}});
}

Status run_view(const ViewOptions& options, Session& session)
{
    if (options.list_controls) return list_controls(options, session);
    if (Status status = session.check_outputs({options.picture, options.out, options.state});
        !status)
        return status;
    if (Status status = check_picture(options.picture, options.camera); !status) return status;
    if (!options.out.empty() && lower_case_extension(options.out) != ".glb") {
        return fail(ErrorCode::unsupported_format, "what is shown is written to a .glb file",
                    options.out);
    }
    if (!options.needs_window()) return run_headless(options, session);
    Viewer viewer({.pictures = Pictures::live,
                   .wake = wake_window,
                   .camera = options.camera,
                   .primitives = session.primitives(),
                   .execution = {.threads = session.threads(),
                                 .budget = {options.budget_mb * bytes_per_megabyte}}});
    if (Status status = prepare(viewer, options); !status) return status;
    if (Status status = run_window(viewer, {.models = options.models,
                                            .size = options.camera.size,
                                            .state = options.state,
                                            .debug = options.debug,
                                            .stop = &session.progress()});
        !status) {
        return status;
    }
    return session.write_json({{"models", options.models},
                               {"panel", viewer.panel().name()},
                               {"facts", facts_json(viewer.facts())}});
}

} // namespace

Command add_view_command(CLI::App& app)
{
    CLI::App* const parser = app.add_subcommand(
        "view", "Show models and what is computed from them, in a window or as a picture");
    const auto options = std::make_shared<ViewOptions>();
    parser
        ->add_option(
            "model", options->models,
            "Models: files or built-ins, see proxima octree; without any the window asks for one")
        ->type_name("MODEL");
    parser->add_option("--panel", options->panel, "Panel to begin with: model, octree, ...")
        ->capture_default_str()
        ->type_name("NAME");
    parser
        ->add_option("--set", options->settings,
                     "A setting of the panel or the view, as --controls lists them")
        ->expected(1)
        ->take_all()
        ->type_name("NAME=VALUE");
    parser->add_flag("--controls", options->list_controls,
                     "List the settings of the panel and the view, and do nothing else");
    parser->add_option("--picture", options->picture, "Write the picture, without a window: .png")
        ->type_name("FILE");
    parser->add_option("--out", options->out, "Write what is shown, without a window: .glb")
        ->type_name("FILE");
    options->camera.size = {.width = 1280, .height = 820};
    add_size_option(*parser, options->camera.size, "the window or the picture", most_canvas_pixels);
    add_camera_options(*parser, options->camera, "the model");
    add_budget_option(*parser, options->budget_mb,
                      "Memory for a model and for what is built of it, in 10^6 bytes (default: 3/4 "
                      "of the machine's)");
    parser->add_flag("--opengl", options->opengl,
                     "Draw the picture by OpenGL, without a display; by software otherwise");
    parser
        ->add_option("--state", options->state,
                     "Keep FILE up to date with what the window shows and where its controls are, "
                     "as JSON: for programs that drive it")
        ->type_name("FILE");
    parser->add_flag("--gl-debug", options->debug,
                     "Let OpenGL check every call, and fail at the end if one was wrong");
    parser->final_callback([options] { check_usage(*options); });
    return {parser, [options](Session& session) { return run_view(*options, session); }};
}

} // namespace proxima
