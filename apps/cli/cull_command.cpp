// proxima cull: the triangles and cells within a view volume (thesis section 5.4).
#include "base/text.h"
#include "cli/camera_options.h"
#include "cli/commands.h"
#include "cli/index_file_model.h"
#include "cli/model_options.h"
#include "cli/number_table.h"
#include "cli/octree_picture.h"
#include "cli/query_method.h"
#include "cli/row_writer.h"
#include "cli/stopwatch.h"
#include "cli/triangle_file.h"
#include "proxima/cull.h"
#include "proxima/octree.h"
#include "proxima/thesis.h"

#include <CLI/CLI.hpp>
#include <array>
#include <cmath>
#include <fmt/core.h>
#include <memory>
#include <nlohmann/json.hpp>
#include <span>
#include <string_view>

namespace proxima {

namespace {

struct CullOptions {
    std::string model;
    std::string frustum;
    std::vector<std::string> planes; ///< instead, a row each
    CameraChoice camera;             ///< without either

    [[nodiscard]] bool has_planes() const { return !frustum.empty() || !planes.empty(); }
    std::string out; ///< "-" for stdout, empty for none
    std::string picture;
    std::optional<Vec2> picture_angles;
    bool exact = false;
    QueryMethod method = QueryMethod::index;
    int depth = 5;
    std::uint32_t threshold = 1;
};

CullMode mode_of(const CullOptions& options)
{
    return options.exact ? CullMode::exact : CullMode::conservative;
}

/// A row a,b,c,d per plane.
Result<ViewVolume> volume_of_planes(const CullOptions& options, Session& session)
{
    constexpr std::array<std::string_view, 1> layouts = {"a,b,c,d"};
    constexpr const char* option = "--plane";
    const auto table = options.planes.empty()
                           ? session.load_table(options.frustum, {layouts})
                           : parse_number_rows(options.planes, {layouts}, option);
    if (!table) return tl::unexpected(table.error());
    std::vector<ViewPlane> planes(table->rows());
    for (std::size_t i = 0; i < planes.size(); ++i) {
        const std::span<const double> row = table->row(i);
        planes[i] = {{row[0], row[1], row[2]}, row[3]};
    }
    auto volume = make_view_volume(planes);
    if (!volume) {
        return fail(volume.error().code, volume.error().message,
                    options.planes.empty() ? options.frustum : option);
    }
    return volume;
}

/// What the camera sees: its picture's sides, and what is not right at the eye.
Result<ViewVolume> volume_of_camera(const CullOptions& options, const TriangleMesh& mesh)
{
    const CameraChoice choice = for_model(options.camera, options.model);
    const auto camera = placed_camera(choice, points_to_frame(mesh));
    if (!camera) return at_model(camera.error(), options.model);
    const View view(*camera, choice.size);
    return make_perspective_volume(
        {.eye = view.eye(),
         .forward = -view.back(),
         .up = view.up(),
         .field_of_view = 2.0 * std::atan(1.0 / camera->zoom),
         .aspect = static_cast<double>(choice.size.width) / choice.size.height,
         .near = view.near()});
}

void check_usage(const CLI::App& parser, const CullOptions& options)
{
    // With planes, --up and --size are for the picture.
    CameraChoice camera = options.camera;
    if (options.has_planes()) camera.up = {};
    const bool has_camera =
        camera.has_any() || (!options.has_planes() && parser.count("--size") > 0);
    if (options.has_planes() == has_camera) {
        throw CLI::ValidationError("cull",
                                   "give either planes, by --plane or --frustum, or a camera: "
                                   "--view, --eye, --target, --fov, --up, --size");
    }
    for (const char* const name : {"--up", "--size"}) {
        if (!options.has_planes() || !options.picture.empty() || parser.count(name) == 0) continue;
        throw CLI::ValidationError(name, "with planes it is of the picture: give --picture, too");
    }
    if (options.exact && options.method == QueryMethod::thesis) {
        throw CLI::ValidationError(
            "--exact",
            "is of --method index: the thesis's method draws all that visible cells list");
    }
}

Status check_outputs(const CullOptions& options, Session& session)
{
    if (Status status = check_picture(options.picture, options.camera); !status) return status;
    if (!options.out.empty())
        if (Status status = check_triangle_file_format(options.out); !status) return status;
    return check_outputs_or_stdout(options.out, session, {options.picture});
}

/// What is culled, and what is left.
struct Culled {
    TriangleMesh mesh;
    Octree octree;
    MeshIndex index;
    ViewVolume volume;
    double build_seconds = 0; ///< of the octree where it answers, else of the index
    std::vector<TriangleRange> ranges;
    std::vector<TriangleId> triangles; ///< ascending
    double seconds = 0;                ///< of the ranges
    double id_seconds = 0;             ///< of the ids
    std::uint64_t cells = 0;           ///< visible leaves that hold triangles
    std::uint64_t all_cells = 0;       ///< all leaves that hold triangles
};

Result<std::unique_ptr<Culled>> prepare(const CullOptions& options, Session& session)
{
    auto culled = std::make_unique<Culled>();
    auto mesh = session.load_model(options.model);
    if (!mesh) return tl::unexpected(mesh.error());
    culled->mesh = std::move(*mesh);
    const ProgressBar shown(session.progress(), session.bar());
    auto volume = options.has_planes() ? volume_of_planes(options, session)
                                       : volume_of_camera(options, culled->mesh);
    if (!volume) return tl::unexpected(volume.error());
    culled->volume = std::move(*volume);
    const Stopwatch octree_watch;
    auto octree = build_octree(culled->mesh, {.max_depth = options.depth,
                                              .threshold = options.threshold,
                                              .classification = Classification::none,
                                              .execution = session.execution()});
    if (!octree) return at_model(octree.error(), options.model);
    culled->octree = std::move(*octree);
    culled->build_seconds = octree_watch.seconds();
    if (options.method == QueryMethod::thesis) return culled;
    const Stopwatch watch;
    auto index = index_of_model(options.model, culled->mesh, session);
    if (!index) return tl::unexpected(index.error());
    culled->index = *index;
    culled->build_seconds = watch.seconds();
    return culled;
}

void count_all_cells(Culled& culled)
{
    for (const OctreeNode& node : culled.octree.nodes())
        culled.all_cells += node.is_leaf() && !node.is_empty() ? 1 : 0;
}

void cull_as_thesis(Culled& culled)
{
    const Stopwatch watch;
    CellCulling found = cull_by_cells(culled.octree, culled.volume);
    culled.id_seconds = watch.seconds();
    culled.seconds = culled.id_seconds;
    culled.triangles = std::move(found.triangles);
    culled.cells = found.cells;
    count_all_cells(culled);
}

void cull(Culled& culled, CullMode mode)
{
    culled.ranges.resize(culled.index.triangle_count() / 2 + 1);
    const Stopwatch watch;
    culled.ranges.resize(visible_ranges(culled.index, culled.volume, culled.ranges, mode));
    culled.seconds = watch.seconds();
    const Stopwatch id_watch;
    visible_triangles(culled.index, culled.volume, mode, culled.triangles);
    culled.id_seconds = id_watch.seconds();
    visible_cells(culled.octree, culled.volume, mode, [&](const VisibleCell& at) {
        culled.cells += culled.octree.triangles(at.cell).empty() ? 0 : 1;
        return Flow::proceed;
    });
    count_all_cells(culled);
}

constexpr std::string_view nothing_inside =
    "the planes contradict each other: no point is inside all";

std::string text_of(const CullOptions& options, const Culled& culled)
{
    const bool by_cells = options.method == QueryMethod::thesis;
    const auto bytes = static_cast<double>(by_cells ? culled.octree.bytes() : culled.index.bytes());
    const double percent = 100 * static_cast<double>(culled.triangles.size()) /
                           static_cast<double>(culled.mesh.triangle_count());
    std::string text =
        fmt::format("{}: {} triangles, {} of {:.2f} MB built in {:.3f} s\n", options.model,
                    culled.mesh.triangle_count(), by_cells ? "octree" : "index", 1e-6 * bytes,
                    culled.build_seconds);
    text += by_cells
                ? fmt::format("{} triangles listed by visible cells ({:.3g} %), in {:.3g} us\n",
                              culled.triangles.size(), percent, 1e6 * culled.seconds)
                : fmt::format("{} triangles visible ({:.3g} %), in {} ranges of the index in "
                              "{:.3g} us, as ids in {:.3g} us\n",
                              culled.triangles.size(), percent, culled.ranges.size(),
                              1e6 * culled.seconds, 1e6 * culled.id_seconds);
    text += fmt::format("{} of {} occupied cells visible\n", culled.cells, culled.all_cells);
    if (culled.volume.empty()) text += concat(nothing_inside, '\n');
    for (const std::string& path : {options.out, options.picture})
        if (!path.empty()) text += fmt::format("wrote {}\n", path);
    return text;
}

Status run_cull(const CullOptions& given, Session& session)
{
    CullOptions options = given;
    options.out = rows_path(given.out, session, {given.picture});
    if (Status status = check_outputs(options, session); !status) return status;
    const auto prepared = prepare(options, session);
    if (!prepared) return tl::unexpected(prepared.error());
    Culled& culled = **prepared;
    if (options.method == QueryMethod::thesis) {
        cull_as_thesis(culled);
    } else {
        cull(culled, mode_of(options));
    }
    if (!options.out.empty() || !options.picture.empty()) {
        const ProgressBar shown(session.progress(), session.bar());
        if (!options.out.empty()) {
            if (Status status = write_triangle_file(culled.mesh, culled.triangles, options.out,
                                                    &session.progress());
                !status)
                return status;
        }
        if (!options.picture.empty()) {
            const CameraChoice view = for_model({.angles = options.picture_angles,
                                                 .up = options.camera.up,
                                                 .size = options.camera.size},
                                                options.model);
            const auto image = draw_octree(
                culled.octree, culled.mesh,
                {.view = view,
                 .volume = &culled.volume,
                 .mode = options.method == QueryMethod::thesis ? CullMode::exact : mode_of(options),
                 .with_legend = true,
                 .execution = {.progress = &session.progress()}});
            if (!image) return tl::unexpected(image.error());
            if (Status status = write_png(*image, options.picture, &session.progress()); !status)
                return status;
        }
    }
    if (options.out != to_stdout) {
        session.print(text_of(options, culled));
    } else if (culled.volume.empty()) {
        session.note(nothing_inside);
    }
    return session.write_json(
        {{"model", options.model},
         {"triangles", culled.mesh.triangle_count()},
         {"planes", culled.volume.planes().size()},
         {"empty", culled.volume.empty()},
         {"exact", options.exact},
         {"visible", culled.triangles.size()},
         {"ranges", culled.ranges.size()},
         {"visible_cells", culled.cells},
         {"cells", culled.all_cells},
         {"seconds", culled.seconds},
         {"id_seconds", culled.id_seconds},
         {"build_seconds", culled.build_seconds},
         {"bytes",
          options.method == QueryMethod::thesis ? culled.octree.bytes() : culled.index.bytes()},
         {"method", name_of(options.method)}});
}

} // namespace

Command add_cull_command(CLI::App& app)
{
    CLI::App* const parser = app.add_subcommand(
        "cull", "Find the triangles and cells in a camera's view; occlusion is not tested");
    const auto options = std::make_shared<CullOptions>();
    add_model_option(*parser, options->model, ModelKinds::meshes_and_indexes);
    CLI::Option* const frustum =
        parser
            ->add_option("--frustum", options->frustum,
                         "The view volume: .npy, or text, of a,b,c,d per plane, inside where "
                         "a x + b y + c z + d >= 0; - for stdin")
            ->type_name("FILE");
    parser->add_option("--plane", options->planes, "Instead: a plane; again for more")
        ->allow_extra_args(false)
        ->excludes(frustum)
        ->type_name("A,B,C,D");
    add_camera_options(*parser, options->camera, "what is culled");
    parser
        ->add_option(
            "--out", options->out,
            "Write the visible triangles: ids as .csv, .npy, or - for CSV to stdout, where they "
            "go if no output is named; a mesh as .obj, .ply, .off or .stl")
        ->type_name("FILE");
    parser
        ->add_option("--picture", options->picture,
                     "Draw the mesh with visible triangles and cells highlighted: .png")
        ->type_name("FILE");
    add_direction_option(*parser, "--picture-view", options->picture_angles, "the picture")
        ->needs("--picture");
    add_size_option(*parser, options->camera.size, "the picture, whose shape the camera has too,",
                    most_canvas_pixels);
    parser->add_flag("--exact", options->exact,
                     "Only what has a point in common with the view volume; without it, all that "
                     "no single plane excludes");
    add_query_method_option(*parser, options->method, "all triangles of the visible cells");
    add_cell_options(*parser, options->depth, options->threshold);
    parser->callback([parser, options] { check_usage(*parser, *options); });
    return {parser, [options](Session& session) { return run_cull(*options, session); }};
}

} // namespace proxima
