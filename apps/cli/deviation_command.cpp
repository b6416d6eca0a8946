// proxima deviation: how far two meshes are from each other at most and on average, with bounds.
#include "base/file_extension.h"
#include "cli/camera_options.h"
#include "cli/commands.h"
#include "cli/deviation_answer.h"
#include "cli/deviation_report.h"
#include "cli/fine_mesh.h"
#include "cli/index_file_model.h"
#include "cli/model_options.h"
#include "cli/number_checks.h"
#include "cli/plot.h"
#include "cli/poses.h"
#include "cli/stopwatch.h"
#include "proxima/closest_feature.h"
#include "proxima/mesh_deviation.h"
#include "proxima/mesh_index.h"
#include "proxima/signed_distance.h"

#include <CLI/CLI.hpp>
#include <fmt/core.h>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

namespace proxima {

namespace {

struct DeviationOptions {
    std::string model_a;
    std::string model_b;
    std::string pose;
    double tolerance = 0;
    double mean_tolerance = 0;
    std::uint32_t places = 0;
    double place_spacing = 0;
    bool one_sided = false;
    bool no_mean = false;
    bool is_signed = false;
    std::uint32_t bins = 16;
    std::uint64_t max_splits = default_deviation_splits;
    std::uint64_t budget_mb = 0;
    std::string histogram;
    std::string out;
    std::string picture;
    CameraChoice view;
};

struct DeviationModel {
    std::string name;
    TriangleMesh mesh;
    MeshIndex index;
};

Status check_deviation_outputs(const DeviationOptions& options, Session& session)
{
    if (!options.out.empty() && lower_case_extension(options.out) != ".ply") {
        return fail(ErrorCode::unsupported_format, "--out writes .ply alone", options.out);
    }
    if (Status status = check_picture(options.picture, options.view); !status) return status;
    if (!options.histogram.empty()) {
        if (Status status = check_plot_format(options.histogram); !status) return status;
    }
    return session.check_outputs({options.out, options.picture, options.histogram});
}

TriangleMesh moved_mesh(const TriangleMesh& mesh, const RigidTransform& pose)
{
    std::vector<Vec3> positions(mesh.positions().begin(), mesh.positions().end());
    for (Vec3& position : positions) position = pose(position);
    return make_triangle_mesh(std::move(positions),
                              {mesh.triangles().begin(), mesh.triangles().end()})
        .value();
}

Result<DeviationModel> load_deviation_model(const std::string& name, const RigidTransform* pose,
                                            Session& session)
{
    auto mesh = session.load_model(name);
    if (!mesh) return tl::unexpected(mesh.error());
    DeviationModel model{.name = name, .mesh = std::move(*mesh), .index = {}};
    const ProgressBar shown(session.progress(), session.bar());
    if (pose == nullptr) {
        auto index = index_of_model(name, model.mesh, session);
        if (!index) return tl::unexpected(index.error());
        model.index = *index;
        return model;
    }
    model.mesh = moved_mesh(model.mesh, *pose);
    auto index = build_mesh_index(model.mesh, {.execution = session.execution()});
    if (!index) return at_model(index.error(), name);
    model.index = *index;
    return model;
}

Execution deviation_execution(const DeviationOptions& options, Session& session)
{
    Execution execution = session.execution();
    if (options.budget_mb != 0) execution.budget = {options.budget_mb * 1'000'000};
    return execution;
}

Result<OneWayDeviation> measure_greatest(const DeviationModel& from, const DeviationModel& to,
                                         const DeviationOptions& options, Session& session)
{
    OneWayDeviation way;
    const Stopwatch watch;
    const ProgressBar shown(session.progress(), session.bar());
    auto greatest = greatest_deviation(from.index, to.index,
                                       {.tolerance = options.tolerance,
                                        .max_places = options.places,
                                        .place_spacing = options.place_spacing,
                                        .max_splits = options.max_splits,
                                        .execution = deviation_execution(options, session)});
    if (!greatest) return at_model(greatest.error(), from.name);
    way.greatest = *greatest;
    way.greatest_seconds = watch.seconds();
    return way;
}

Status measure_mean(const DeviationModel& from, const DeviationModel& to,
                    const DeviationOptions& options, double end, Session& session,
                    OneWayDeviation& way)
{
    const Stopwatch watch;
    const ProgressBar shown(session.progress(), session.bar());
    auto mean = mean_deviation(from.index, to.index,
                               {.tolerance = options.mean_tolerance,
                                .histogram_bins = end > 0 ? options.bins : 0,
                                .histogram_end = end,
                                .max_splits = options.max_splits,
                                .execution = deviation_execution(options, session)});
    if (!mean && mean.error().code == ErrorCode::invalid_mesh) {
        session.note(fmt::format("{}: {}", from.name, mean.error().message));
        return {};
    }
    if (!mean) return at_model(mean.error(), from.name);
    way.mean = std::move(*mean);
    if (end == 0) way.mean->histogram = {1.0}; // all that there is, at distance 0
    way.mean_seconds = watch.seconds();
    return {};
}

Result<VertexDeviations> vertex_deviations(const TriangleMesh& mesh, const DeviationModel& b,
                                           const DeviationOptions& options, double largest,
                                           Session& session)
{
    VertexDeviations result{.distances = std::vector<double>(mesh.vertex_count()),
                            .largest = largest,
                            .is_signed = options.is_signed};
    // Vertices that no triangle uses may be anything, and have no distance that counts.
    std::vector<Vec3> points(mesh.positions().begin(), mesh.positions().end());
    for (Vec3& point : points)
        if (!point.allFinite()) point = Vec3::Zero();
    const ProgressBar shown(session.progress(), session.bar());
    Status status;
    if (options.is_signed) {
        const auto index = index_with_signs(b.index, b.name, session);
        if (!index) return tl::unexpected(index.error());
        status = signed_distances(*index, points, {.distances = result.distances},
                                  {.execution = session.execution()});
    } else {
        status = closest_features(b.index, points, {.distances = result.distances},
                                  {.execution = session.execution()});
    }
    if (!status) return tl::unexpected(status.error());
    return result;
}

DeviationHistogram histogram_of(const std::vector<OneWayDeviation>& ways, double end)
{
    DeviationHistogram histogram{.end = end, .names = {}, .shares = {}};
    for (std::size_t i = 0; i < ways.size(); ++i) {
        if (!ways[i].mean || ways[i].mean->histogram.empty()) continue;
        histogram.names.emplace_back(i == 0 ? "A to B" : "B to A");
        histogram.shares.push_back(ways[i].mean->histogram);
    }
    return histogram;
}

Status write_deviation_files(const DeviationModel& a, const DeviationModel& b,
                             const DeviationOptions& options, const DeviationHistogram& histogram,
                             double largest, Session& session)
{
    Progress* const progress = &session.progress();
    if (!options.histogram.empty()) {
        if (Status status = write_deviation_histogram(
                histogram, fmt::format("Distances of {} and {}", a.name, b.name), options.histogram,
                progress);
            !status)
            return status;
    }
    if (!options.out.empty()) {
        const auto deviations = vertex_deviations(a.mesh, b, options, largest, session);
        if (!deviations) return tl::unexpected(deviations.error());
        if (Status status = write_deviation_ply(a.mesh, *deviations, options.out, progress);
            !status)
            return status;
    }
    if (options.picture.empty()) return {};
    const auto fine = finely_cut(a.mesh); // distances change within triangles
    if (!fine) return tl::unexpected(fine.error());
    const auto deviations = vertex_deviations(*fine, b, options, largest, session);
    if (!deviations) return tl::unexpected(deviations.error());
    const auto image =
        draw_deviation(*fine, *deviations, for_model(options.view, options.model_a), progress);
    if (!image) return tl::unexpected(image.error());
    return write_png(*image, options.picture, progress);
}

Status run_deviation(const DeviationOptions& options, Session& session)
{
    if (Status status = check_deviation_outputs(options, session); !status) return status;
    Poses read{.poses = {}};
    if (!options.pose.empty()) {
        auto parsed = parse_pose(options.pose);
        if (!parsed) return tl::unexpected(parsed.error());
        read = std::move(*parsed);
    }
    const auto a = load_deviation_model(options.model_a, nullptr, session);
    if (!a) return tl::unexpected(a.error());
    const auto b = load_deviation_model(options.model_b,
                                        read.poses.empty() ? nullptr : read.poses.data(), session);
    if (!b) return tl::unexpected(b.error());

    std::vector<OneWayDeviation> ways;
    DistanceBounds hausdorff;
    for (int i = 0; i < (options.one_sided ? 1 : 2); ++i) {
        auto way = i == 0 ? measure_greatest(*a, *b, options, session)
                          : measure_greatest(*b, *a, options, session);
        if (!way) return tl::unexpected(way.error());
        hausdorff = both_ways(hausdorff, way->greatest.distance);
        ways.push_back(std::move(*way));
    }
    for (std::size_t i = 0; i < ways.size() && !options.no_mean; ++i) {
        if (Status status = measure_mean(i == 0 ? *a : *b, i == 0 ? *b : *a, options,
                                         hausdorff.upper, session, ways[i]);
            !status)
            return status;
    }
    const DeviationHistogram histogram = histogram_of(ways, hausdorff.upper);
    if (!options.histogram.empty() && histogram.shares.empty()) {
        return fail(ErrorCode::invalid_mesh,
                    "a histogram has the shares of an area, and there is no area with a mean "
                    "distance: leave --histogram out",
                    options.histogram);
    }
    if (Status status = write_deviation_files(*a, *b, options, histogram,
                                              ways.front().greatest.distance.upper, session);
        !status)
        return status;

    std::string text = fmt::format("A {}: {} triangles\nB {}: {} triangles\n", a->name,
                                   a->mesh.triangle_count(), b->name, b->mesh.triangle_count());
    text += rotation_text(read.rotation_error, true, session);
    text += deviation_text(ways, hausdorff);
    if (!histogram.shares.empty()) text += histogram_text(histogram);
    for (const std::string& path : {options.histogram, options.out, options.picture})
        if (!path.empty()) text += fmt::format("wrote {}\n", path);
    session.print(text);
    nlohmann::ordered_json json = {{"a", a->name},
                                   {"b", b->name},
                                   {"triangles_a", a->mesh.triangle_count()},
                                   {"triangles_b", b->mesh.triangle_count()},
                                   {"rotation_error", read.rotation_error}};
    json.update(deviation_json(ways, hausdorff, options.places > 0));
    if (!histogram.shares.empty()) json["histogram_end"] = histogram.end;
    return session.write_json(json);
}

} // namespace

Command add_deviation_command(CLI::App& app)
{
    CLI::App* const parser = app.add_subcommand(
        "deviation", "Bound how far two meshes are from each other at most and on average");
    const auto options = std::make_shared<DeviationOptions>();
    parser->add_option("A", options->model_a, "The first mesh: a file or a built-in")
        ->required()
        ->type_name("MODEL");
    parser->add_option("B", options->model_b, "The mesh that a pose moves")
        ->required()
        ->type_name("MODEL");
    parser->add_option("--pose", options->pose, "One pose of B")->type_name("POSE");
    const auto add_tolerance = [&](const char* name, double& number, const char* what) {
        return parser->add_option(name, number, what)->check(not_negative())->type_name("T");
    };
    add_tolerance("--tolerance", options->tolerance,
                  "How far the bounds of the greatest distance may be apart, in the meshes' unit "
                  "(default, and 0: 1e-6 of the diagonal of the box about both)");
    CLI::Option* const mean_tolerance =
        add_tolerance("--mean-tolerance", options->mean_tolerance,
                      "The same of the mean (default, and 0: 1e-5 of the diagonal)");
    CLI::Option* const places =
        parser
            ->add_option("--places", options->places,
                         "Name up to so many points that are as far as any, each way")
            ->check(CLI::Range(0U, max_deviation_places))
            ->capture_default_str()
            ->type_name("N");
    add_tolerance("--place-spacing", options->place_spacing,
                  "How far such points are from each other at least (default: 0.01 of the "
                  "diagonal)")
        ->needs(places);
    parser->add_flag("--one-sided", options->one_sided, "From A to B alone");
    CLI::Option* const no_mean = parser->add_flag("--no-mean", options->no_mean,
                                                  "The greatest distances alone: much quicker");
    no_mean->excludes(mean_tolerance);
    parser
        ->add_option(
            "--max-splits", options->max_splits,
            "How often parts of triangles are cut at most each way; then the bounds so far")
        ->check(CLI::Range(std::uint64_t{0}, std::uint64_t{1} << 40U))
        ->capture_default_str()
        ->type_name("N");
    add_budget_option(*parser, options->budget_mb,
                      "Memory for measuring, in 10^6 bytes (default: 3/4 of the machine's)");
    parser->add_option("--bins", options->bins, "Bins of the histogram")
        ->excludes(no_mean)
        ->check(CLI::Range(1U, max_histogram_bins))
        ->capture_default_str()
        ->type_name("N");
    parser
        ->add_option("--histogram", options->histogram,
                     "Write the shares of the areas by distance: .csv, .svg, .pdf, .png")
        ->excludes(no_mean)
        ->type_name("FILE");
    parser
        ->add_option("--out", options->out,
                     "Write A with the distances of its vertices as colours and as their quality: "
                     ".ply")
        ->type_name("FILE");
    parser->add_flag("--signed", options->is_signed,
                     "Colours and qualities by signed distances, negative inside B");
    add_picture_options(*parser, options->picture, options->view,
                        "Draw A in the colours of its distances");
    parser->callback([options] {
        if (options->is_signed && options->out.empty() && options->picture.empty()) {
            throw CLI::ValidationError(
                "--signed", "is of the colours of --out and --picture: give one of them");
        }
    });
    return {parser, [options](Session& session) { return run_deviation(*options, session); }};
}

} // namespace proxima
