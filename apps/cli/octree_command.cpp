// proxima octree: builds the octree of a mesh or opens a saved one, counts it, saves and exports
// it.
#include "base/file_extension.h"
#include "base/text.h"
#include "cli/camera_options.h"
#include "cli/commands.h"
#include "cli/model_options.h"
#include "cli/names.h"
#include "cli/octree_file_model.h"
#include "cli/octree_picture.h"
#include "cli/statistics_text.h"
#include "cli/stopwatch.h"
#include "proxima/octree.h"
#include "proxima/octree_io.h"
#include "proxima/thesis.h"
#include "thesis/octree_generation/overlap_as_printed.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <fmt/core.h>
#include <memory>
#include <nlohmann/json.hpp>

namespace proxima {

namespace {

struct OctreeCommandOptions {
    std::string model;
    std::string mesh; ///< of an octree file, may be empty
    int depth = 5;
    std::uint32_t threshold = 1;
    OverlapMethod method = OverlapMethod::fast;
    bool exact = false;
    bool as_printed = false;
    bool uniform = false;
    bool two_pass = false;
    RootShape root = RootShape::cube;
    std::uint64_t budget_mb = 0;
    std::string save;
    std::vector<std::string> outs;
    std::string picture;
    CameraChoice view;
};

/// Refuses before the work what could not be written after it.
Status check_outputs(const OctreeCommandOptions& options, Session& session)
{
    std::vector<std::string> files = {options.save, options.picture};
    for (const std::string& path : options.outs) {
        constexpr std::array known = {".vtu", ".htg", ".glb", ".ply"};
        if (path != "-" && std::ranges::find(known, lower_case_extension(path)) == known.end()) {
            return fail(ErrorCode::unsupported_format,
                        "unknown extension: cells are written to .vtu, .htg, .glb or .ply", path);
        }
        files.push_back(path);
    }
    if (Status status = session.check_outputs(files); !status) return status;
    if (Status status = check_picture(options.picture, options.view); !status) return status;
    return check_extension(options.save, ".pxo");
}

/// What the command works on: built, or loaded from a file.
struct OctreeAndMesh {
    Octree octree;
    TriangleMesh mesh; ///< without triangles where the octree is a file's and no mesh was named
    double seconds = 0.0;
};

/// The picture, of the cells alone where there is no mesh.
Status draw(const OctreeCommandOptions& options, const OctreeAndMesh& model, Progress& progress)
{
    const std::string& shape = options.mesh.empty() ? options.model : options.mesh;
    const auto image = draw_octree(model.octree, model.mesh,
                                   {.view = for_model(options.view, shape),
                                    .with_legend = true,
                                    .execution = {.progress = &progress}});
    if (!image) return tl::unexpected(image.error());
    return write_png(*image, options.picture, &progress);
}

Status write_outputs(const OctreeCommandOptions& options, const OctreeAndMesh& model,
                     Session& session)
{
    Progress* const progress = &session.progress();
    const auto write = [&](const std::string& path, const auto& write_file) -> Status {
        Status status = [&] {
            const ProgressBar shown(session.progress(), session.bar());
            return write_file();
        }();
        if (status) session.print(fmt::format("wrote {}\n", path));
        return status;
    };
    if (!options.save.empty()) {
        const auto save = [&] {
            return save_octree(model.octree, options.save, {.execution = {.progress = progress}});
        };
        if (auto status = write(options.save, save); !status) return status;
    }
    for (const std::string& path : options.outs) {
        const auto write_cells = [&] {
            return export_octree(model.octree, model.mesh, path,
                                 {.execution = {.progress = progress}});
        };
        if (auto status = write(path, write_cells); !status) return status;
    }
    if (options.picture.empty()) return {};
    return write(options.picture, [&] { return draw(options, model, *progress); });
}

/// About how many leaves surround the edges and vertices of a mesh, where cells of more than one
/// triangle are split to the deepest level: along a line of L cells 7 L leaves or so.
double leaves_round_edges(const TriangleMesh& mesh, int depth)
{
    double length = 0;
    for (std::uint32_t i = 0; i < mesh.triangle_count(); ++i) {
        const Triangle triangle = mesh.triangle(TriangleId{i});
        for (int k = 0; k < 3; ++k) length += 0.5 * (triangle[(k + 1) % 3] - triangle[k]).norm();
    }
    return 7.0 * std::ldexp(length / bounding_box(mesh).extent().maxCoeff(), depth);
}

/// Says before a build that it is large because of its threshold.
void warn_of_threshold(const OctreeCommandOptions& options, const TriangleMesh& mesh,
                       const Session& session)
{
    constexpr std::uint32_t usual_valence = 6; // as many triangles as share a vertex
    constexpr double many = 2e6;
    if (options.threshold >= usual_valence || options.uniform || mesh.triangle_count() == 0) return;
    const double leaves = leaves_round_edges(mesh, options.depth);
    if (!(leaves > many) || leaves < 8.0 * static_cast<double>(mesh.triangle_count())) return;
    session.print(fmt::format("--threshold {} splits round edges and vertices down to depth {}: "
                              "some {:.0f} million leaves. "
                              "--threshold 8 makes far fewer, a lower --depth too.\n",
                              options.threshold, options.depth, 1e-6 * leaves));
    std::fflush(stdout); // before the build
}

Result<OctreeAndMesh> build(const OctreeCommandOptions& options, Session& session)
{
    auto mesh = session.load_model(options.model);
    if (!mesh) return tl::unexpected(mesh.error());
    warn_of_threshold(options, *mesh, session);
    const OctreeOptions build_options{.max_depth = options.depth,
                                      .threshold = options.threshold,
                                      .subdivision = options.uniform ? Subdivision::uniform
                                                                     : Subdivision::adaptive,
                                      .root_shape = options.root,
                                      .execution = {.threads = session.threads(),
                                                    .progress = &session.progress(),
                                                    .budget = {options.budget_mb * 1'000'000}}};
    const OverlapChoice choice{options.method,
                               options.exact ? Exactness::exact : Exactness::rounded};
    const Stopwatch watch;
    auto octree = [&] {
        const ProgressBar shown(session.progress(), session.bar());
        if (options.as_printed) return build_octree_as_printed(*mesh, {}, build_options);
        return options.two_pass ? build_octree_two_pass(*mesh, choice, build_options)
                                : build_octree_by(*mesh, choice, build_options);
    }();
    const double seconds = watch.seconds();
    if (!octree) return at_model(octree.error(), options.model);
    return OctreeAndMesh{std::move(*octree), std::move(*mesh), seconds};
}

Result<OctreeAndMesh> load(const OctreeCommandOptions& options, Session& session)
{
    const Stopwatch watch;
    auto octree = load_octree_file(options.model, session);
    const double seconds = watch.seconds();
    if (!octree) return tl::unexpected(octree.error());
    auto mesh = load_mesh_of(*octree, options.mesh, session);
    if (!mesh) return tl::unexpected(mesh.error());
    return OctreeAndMesh{std::move(*octree), std::move(*mesh), seconds};
}

Status run_octree(const OctreeCommandOptions& options, Session& session)
{
    if (auto status = check_outputs(options, session); !status) return status;
    const bool is_loaded = is_octree_file(options.model);
    const auto model = is_loaded ? load(options, session) : build(options, session);
    if (!model) return tl::unexpected(model.error());

    const Octree& octree = model->octree;
    const OctreeParameters& parameters = octree.parameters();
    const OctreeStatistics statistics = octree_statistics(octree);
    const std::string_view method = method_name(parameters.method);
    const bool says_exact = parameters.exact && parameters.method != OverlapMethod::fast;
    session.print(fmt::format("{}: {}{} triangles, method {}{}, {}{:.3f} s\n\n{}\n", options.model,
                              is_loaded ? "octree of " : "", octree.triangle_count(), method,
                              says_exact ? ", exact" : "", is_loaded ? "loaded in " : "",
                              model->seconds, statistics_text(parameters, statistics)));
    if (auto status = session.check_running(); !status) return status;
    if (auto status = write_outputs(options, *model, session); !status) return status;
    return session.write_json({{"model", options.model},
                               {"triangles", octree.triangle_count()},
                               {"depth", parameters.max_depth},
                               {"threshold", parameters.threshold},
                               {"method", method},
                               {"total", statistics.total},
                               {"leaves", statistics.leaves},
                               {"occupied_percent", statistics.occupied_percent},
                               {"min_triangles", statistics.min_triangles},
                               {"max_triangles", statistics.max_triangles},
                               {"references", statistics.references},
                               {"mean_triangles", statistics.mean_triangles},
                               {"std_triangles", statistics.std_triangles},
                               {"mean_all_leaves", statistics.mean_all_leaves},
                               {"std_all_leaves", statistics.std_all_leaves},
                               {"inner", statistics.inner},
                               {"outer", statistics.outer},
                               {"boundary", statistics.boundary},
                               {"bytes", statistics.bytes},
                               {"seconds", model->seconds}});
}

} // namespace

Command add_octree_command(CLI::App& app)
{
    CLI::App* const parser = app.add_subcommand(
        "octree", "Build or load the octree of a mesh, report its size, save and export it");
    const auto options = std::make_shared<OctreeCommandOptions>();
    add_model_option(*parser, options->model, ModelKinds::meshes_and_octrees);
    add_cell_options(*parser, options->depth, options->threshold);
    add_method_option(*parser, options->method);
    parser->add_flag("--exact", options->exact,
                     "Decide overlaps exactly with the thesis's methods too, as fast always does");
    parser->add_flag("--as-printed", options->as_printed,
                     "With --method minkowski: the pseudocode of the thesis as printed, errata "
                     "and all");
    parser->add_flag("--uniform", options->uniform, "Split every cell to the deepest level")
        ->excludes("--threshold");
    parser->add_flag("--two-pass", options->two_pass,
                     "Build twice, with the longest list of the first octree as threshold of the "
                     "second (thesis 2.1.1)");
    parser
        ->add_option_function<std::string>(
            "--root",
            [options](const std::string& name) {
                if (name != "cube" && name != "box") {
                    throw CLI::ValidationError(
                        "--root", concat(name, " is no shape of a root: they are cube, box"));
                }
                options->root = name == "cube" ? RootShape::cube : RootShape::box;
            },
            "Shape of the root: cube, box (default cube)")
        ->type_name("SHAPE");
    add_budget_option(*parser, options->budget_mb,
                      "Memory the build may use, in 10^6 bytes (default: 3/4 of the machine's)");
    parser->add_option("--save", options->save, "Write the octree's own format")
        ->type_name("FILE.pxo");
    parser
        ->add_option("--out", options->outs,
                     "Write the cells: for ParaView (.vtu, .htg), or as boxes (.glb, .ply); again "
                     "for more")
        ->allow_extra_args(false)
        ->type_name("FILE");
    add_picture_options(*parser, options->picture, options->view,
                        "Draw the mesh and the leaves that hold triangles");
    add_mesh_option(*parser, options->model, ModelKinds::meshes_and_octrees, options->mesh,
                    {"--depth", "--threshold", "--method", "--exact", "--as-printed", "--uniform",
                     "--two-pass", "--root", "--budget-mb"});
    parser->callback([options] {
        if (options->as_printed &&
            (options->method != OverlapMethod::minkowski || options->exact || options->two_pass)) {
            throw CLI::ValidationError("--as-printed",
                                       "is of --method minkowski, without --exact and --two-pass");
        }
    });
    return {parser, [options](Session& session) { return run_octree(*options, session); }};
}

} // namespace proxima
