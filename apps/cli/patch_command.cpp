// proxima patch: the triangles round the position of a mesh that is closest to a point, by rings of
// neighbours (thesis 5.1.1) or by distance.
#include "base/text.h"
#include "cli/answer_table.h"
#include "cli/commands.h"
#include "cli/index_file_model.h"
#include "cli/json_numbers.h"
#include "cli/model_options.h"
#include "cli/names.h"
#include "cli/row_writer.h"
#include "cli/stopwatch.h"
#include "cli/triangle_file.h"
#include "proxima/closest_feature.h"
#include "proxima/mesh_index.h"
#include "proxima/neighbourhood.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <fmt/core.h>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

namespace proxima {

namespace {

using Json = nlohmann::ordered_json;

constexpr int default_rings = 1;

struct PatchOptions {
    std::string model;
    Vec3 point = Vec3::Zero();
    int rings = default_rings;
    std::optional<double> radius; ///< instead of the rings
    std::string out;              ///< "-" for stdout, empty for none
};

/// The surface and what searches it.
struct PatchModel {
    ModelSurface surface;
    MeshIndex index;
    double seconds = 0; ///< making all this, without reading a mesh
};

struct CollectedPatch {
    ClosestFeature closest;
    std::vector<TriangleId> triangles;  ///< ascending
    std::vector<std::size_t> ring_ends; ///< empty with a radius; last rings without triangles apart
    double seconds = 0;
};

/// The mesh and its topology; of a saved index also that.
Status load_surface(const std::string& name, Session& session, PatchModel& model)
{
    const auto take = [&](Result<ModelSurface> surface) -> Status {
        if (!surface) return tl::unexpected(surface.error());
        model.surface = std::move(*surface);
        return {};
    };
    if (!is_index_file(name)) {
        auto mesh = session.load_model(name);
        if (!mesh) return tl::unexpected(mesh.error());
        const Stopwatch watch;
        Status status = take(surface_of(std::move(*mesh), name, session));
        model.seconds = watch.seconds();
        return status;
    }
    const Stopwatch watch;
    auto index = load_index_file(name, session);
    if (!index) return tl::unexpected(index.error());
    Status status = take(surface_of(*index, name, session));
    model.index = *index;
    model.seconds = watch.seconds();
    return status;
}

Result<std::unique_ptr<PatchModel>> load_model(const std::string& name, Session& session)
{
    auto model = std::make_unique<PatchModel>();
    if (Status status = load_surface(name, session, *model); !status)
        return tl::unexpected(status.error());
    if (is_index_file(name)) return model;
    const Stopwatch watch;
    const ProgressBar shown(session.progress(), session.bar());
    auto index = build_mesh_index(model->surface.mesh, {.execution = session.execution()});
    if (!index) return at_model(index.error(), name);
    model->index = *index;
    model->seconds += watch.seconds();
    return model;
}

Result<CollectedPatch> collect_patch(const PatchModel& model, const PatchOptions& options)
{
    const TriangleMesh& mesh = model.surface.mesh;
    CollectedPatch patch;
    patch.triangles.resize(mesh.triangle_count());
    NeighbourhoodScratch scratch(mesh);
    // Every ring but the last ones has a triangle.
    const std::size_t most_rings =
        std::min(static_cast<std::size_t>(options.rings), mesh.triangle_count());
    if (!options.radius) patch.ring_ends.resize(most_rings + 1);

    const Stopwatch watch;
    patch.closest = closest_feature(model.index, options.point).value_or(no_closest_feature());
    if (!std::isfinite(patch.closest.squared_distance)) {
        return fail(ErrorCode::invalid_argument,
                    concat("the point is too far from ", options.model,
                           ": its squared distance is no number"),
                    "--point");
    }
    const Neighbourhood found =
        options.radius
            ? collect_triangles(model.index, options.point, *options.radius, patch.triangles)
            : collect_rings(mesh, model.surface.topology, patch.closest.feature,
                            static_cast<int>(most_rings), scratch, patch.triangles,
                            patch.ring_ends);
    patch.triangles.resize(found.written);
    std::ranges::sort(patch.triangles);
    patch.seconds = watch.seconds();
    std::vector<std::size_t>& ends = patch.ring_ends;
    while (ends.size() > 1 && ends[ends.size() - 2] == ends.back()) ends.pop_back();
    return patch;
}

double area_of(const TriangleMesh& mesh, std::span<const TriangleId> triangles)
{
    double doubled = 0;
    for (const TriangleId id : triangles) doubled += scaled_normal(mesh.triangle(id)).norm();
    return doubled / 2;
}

/// Triangles ring by ring.
std::vector<std::size_t> ring_counts(const CollectedPatch& patch)
{
    std::vector<std::size_t> counts;
    std::size_t begin = 0;
    for (const std::size_t end : patch.ring_ends) {
        counts.push_back(end - begin);
        begin = end;
    }
    return counts;
}

std::string text_of(const PatchOptions& options, const PatchModel& model,
                    const CollectedPatch& patch, double area)
{
    const ClosestFeature& closest = patch.closest;
    const auto position = [](const Vec3& p) {
        return fmt::format("({:.9g}, {:.9g}, {:.9g})", p.x(), p.y(), p.z());
    };
    std::string text =
        fmt::format("{}: {} triangles\n"
                    "closest to {}: {} {} of triangle {} at {}, distance {:.6g}\n",
                    options.model, model.surface.mesh.triangle_count(), position(options.point),
                    kind_name(closest.feature.kind), closest.feature.id, to_index(closest.triangle),
                    position(closest.point), std::sqrt(closest.squared_distance));
    const std::size_t count = patch.triangles.size();
    if (options.radius) {
        text += fmt::format("within {:g} of the point: {} {}, area {:.6g}\n", *options.radius,
                            count, count == 1 ? "triangle" : "triangles", area);
        return text;
    }
    constexpr std::size_t most_shown = 8; // rings
    std::string sum;
    const std::vector<std::size_t> counts = ring_counts(patch);
    for (std::size_t i = 0; i < std::min(counts.size(), most_shown); ++i)
        sum += fmt::format("{}{}", i == 0 ? "" : " + ", counts[i]);
    if (counts.size() > most_shown) sum += " + ...";
    text += fmt::format("rings 0 to {}: {} = {} {}, area {:.6g}\n", options.rings, sum, count,
                        count == 1 ? "triangle" : "triangles", area);
    return text;
}

Json json_of(const PatchOptions& options, const PatchModel& model, const CollectedPatch& patch,
             double area)
{
    const ClosestFeature& closest = patch.closest;
    Json result = {{"model", options.model},
                   {"triangles", model.surface.mesh.triangle_count()},
                   {"point", json_numbers(options.point)},
                   {"rings", nullptr},
                   {"radius", nullptr},
                   {"distance", std::sqrt(closest.squared_distance)},
                   {"closest_point", json_numbers(closest.point)},
                   {"kind", kind_name(closest.feature.kind)},
                   {"feature", closest.feature.id},
                   {"triangle", to_index(closest.triangle)},
                   {"patch_triangles", patch.triangles.size()},
                   {"ring_triangles", nullptr},
                   {"area", area},
                   {"build_seconds", model.seconds},
                   {"seconds", patch.seconds}};
    if (options.radius) {
        result["radius"] = *options.radius;
    } else {
        result["rings"] = options.rings;
        result["ring_triangles"] = ring_counts(patch);
    }
    return result;
}

Status run_patch(const PatchOptions& given, Session& session)
{
    PatchOptions options = given;
    options.out = rows_path(given.out, session);
    if (!options.out.empty()) {
        if (Status status = check_triangle_file_format(options.out); !status) return status;
        if (Status status = check_outputs_or_stdout(options.out, session); !status) return status;
    }
    const auto model = load_model(options.model, session);
    if (!model) return tl::unexpected(model.error());
    const auto patch = collect_patch(**model, options);
    if (!patch) return tl::unexpected(patch.error());
    if (Status status = session.check_running(); !status) return status;

    const TriangleMesh& mesh = (*model)->surface.mesh;
    const double area = area_of(mesh, patch->triangles);
    const bool speaks = options.out != to_stdout;
    if (speaks) session.print(text_of(options, **model, *patch, area));
    if (!options.out.empty()) {
        Status status =
            write_triangle_file(mesh, patch->triangles, options.out, &session.progress());
        if (!status) return status;
        if (speaks) session.print(fmt::format("wrote {}\n", options.out));
    }
    return session.write_json(json_of(options, **model, *patch, area));
}

void add_point_option(CLI::App& parser, Vec3& point)
{
    parser
        .add_option_function<std::string>(
            "--point",
            [&point](const std::string& text) {
                const auto coordinates = parse_finite_numbers(text);
                if (!coordinates || coordinates->size() != 3) {
                    throw CLI::ValidationError(
                        "--point", concat(text, " is no point: give three finite numbers, X,Y,Z"));
                }
                point = {(*coordinates)[0], (*coordinates)[1], (*coordinates)[2]};
            },
            "The point; the patch surrounds the closest point of the mesh")
        ->required()
        ->type_name("X,Y,Z");
}

void add_extent_options(CLI::App& parser, PatchOptions& options)
{
    CLI::Option* const rings =
        parser
            .add_option(
                "--rings", options.rings,
                "Triangles at the closest feature, and so many rings of neighbours around them")
            ->check(CLI::Range(0, std::numeric_limits<int>::max()))
            ->capture_default_str()
            ->type_name("K");
    parser
        .add_option_function<std::string>(
            "--radius",
            [&options](const std::string& text) {
                const auto numbers = parse_finite_numbers(text);
                if (!numbers || numbers->size() != 1 || !(numbers->front() >= 0)) {
                    throw CLI::ValidationError(
                        "--radius", concat(text, " is no radius: give a finite number from 0 up"));
                }
                options.radius = numbers->front();
            },
            "Instead: all triangles that are not farther from the point than this")
        ->excludes(rings)
        ->type_name("R");
}

} // namespace

Command add_patch_command(CLI::App& app)
{
    CLI::App* const parser = app.add_subcommand(
        "patch", "Find the triangles round the point of a mesh that is closest to a given point");
    const auto options = std::make_shared<PatchOptions>();
    add_model_option(*parser, options->model, ModelKinds::meshes_and_indexes);
    add_point_option(*parser, options->point);
    add_extent_options(*parser, *options);
    parser
        ->add_option(
            "--out", options->out,
            "Write the triangles: ids as .csv, .npy, or - for CSV to stdout, where they go "
            "without --out and --json; a mesh of just them as .obj, .ply, .off or .stl")
        ->type_name("FILE");
    return {parser, [options](Session& session) { return run_patch(*options, session); }};
}

} // namespace proxima
