// proxima raycast: what rays hit, or which cells of the octree they go through.
#include "base/parallel.h"
#include "cli/camera_options.h"
#include "cli/commands.h"
#include "cli/index_file_model.h"
#include "cli/model_options.h"
#include "cli/query_method.h"
#include "cli/ray_picture.h"
#include "cli/ray_sources.h"
#include "cli/ray_table.h"
#include "cli/row_writer.h"
#include "cli/stopwatch.h"
#include "proxima/cast_ray.h"
#include "proxima/octree.h"
#include "proxima/thesis.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <fmt/core.h>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace proxima {

namespace {

struct RaycastOptions {
    std::string model;
    std::string rays_file;
    std::vector<std::string> rays;
    CameraChoice camera; ///< where neither is given
    bool has_camera = false;
    std::string out; ///< "-" for stdout, empty for none
    std::string picture;
    bool cells = false;
    QueryMethod method = QueryMethod::index;
    int depth = 5;
    std::uint32_t threshold = 1;

    /// Whether the octree answers, not the mesh index.
    [[nodiscard]] bool by_octree() const { return cells || method == QueryMethod::thesis; }
};

constexpr std::size_t task_rays = 1024;
constexpr std::size_t round_rays = 256 * task_rays; ///< answered before they are written
constexpr std::size_t task_cell_rays = 64;
constexpr std::size_t round_cell_rays = 64 * task_cell_rays;

void check_sources(const RaycastOptions& options)
{
    const int sources = (options.rays_file.empty() ? 0 : 1) + (options.rays.empty() ? 0 : 1) +
                        (options.has_camera ? 1 : 0);
    if (sources == 1) return;
    throw CLI::ValidationError("raycast",
                               "give one of --rays, --ray and a camera: --picture, --size, --view, "
                               "--eye, --target, --up, --fov");
}

Status check_outputs(const RaycastOptions& options, Session& session)
{
    if (Status status = check_picture(options.picture, options.camera); !status) return status;
    return check_rows(options.out, session, {options.picture});
}

/// What rays are cast at, and what came of it.
struct Casting {
    TriangleMesh mesh;
    Octree octree;   ///< empty where the index answers
    MeshIndex index; ///< empty where the octree answers
    RayList rays;
    ViewSize size;
    double build_seconds = 0;
    double seconds = 0;
    std::uint64_t hits = 0;  ///< rays that hit a triangle
    std::uint64_t cells = 0; ///< of all rays
};

Result<std::unique_ptr<Casting>> prepare(const RaycastOptions& options, Session& session)
{
    auto casting = std::make_unique<Casting>();
    auto mesh = session.load_model(options.model);
    if (!mesh) return tl::unexpected(mesh.error());
    casting->mesh = std::move(*mesh);
    const auto box = checked_bounding_box(casting->mesh);
    if (!box) return at_model(box.error(), options.model);
    const ProgressBar shown(session.progress(), session.bar());
    if (!options.has_camera) {
        auto rays =
            options.rays.empty() ? read_rays(options.rays_file, session) : parse_rays(options.rays);
        if (!rays) return tl::unexpected(rays.error());
        casting->rays = RayList(std::move(*rays));
    } else {
        casting->size = options.camera.size;
        const auto camera =
            placed_camera(for_model(options.camera, options.model), points_to_frame(casting->mesh));
        if (!camera) return at_model(camera.error(), options.model);
        casting->rays = RayList(*camera, casting->size);
    }
    const Stopwatch watch;
    if (options.by_octree()) {
        auto octree = build_octree(casting->mesh, {.max_depth = options.depth,
                                                   .threshold = options.threshold,
                                                   .classification = Classification::none,
                                                   .execution = session.execution()});
        if (!octree) return at_model(octree.error(), options.model);
        casting->octree = std::move(*octree);
    } else {
        auto index = index_of_model(options.model, casting->mesh, session);
        if (!index) return tl::unexpected(index.error());
        casting->index = *index;
    }
    casting->build_seconds = watch.seconds();
    return casting;
}

/// The first hits of rays by the chosen method.
void cast(const RaycastOptions& options, const Casting& casting, const std::vector<Ray>& rays,
          std::vector<std::optional<RayHit>>& hits, Session& session)
{
    if (options.method == QueryMethod::index) {
        // Cannot fail: sizes agree.
        (void)closest_hits(casting.index, rays, hits,
                           {.execution = {.threads = session.threads()}});
        return;
    }
    parallel_chunks(rays.size(), task_rays, session.threads(),
                    [&](std::size_t first, std::size_t end) {
                        if (session.progress().cancelled()) return;
                        for (std::size_t i = first; i < end; ++i)
                            hits[i] = closest_hit_by_cells(casting.octree, casting.mesh, rays[i]);
                    });
}

Status cast_at_triangles(const RaycastOptions& options, Casting& casting, Session& session)
{
    const bool draws = !options.picture.empty();
    auto writer = RowWriter::open(options.out);
    if (!writer) return tl::unexpected(writer.error());
    const std::size_t all = casting.rays.count();
    if (Status status = writer->write(hit_header(writer->format(), all)); !status) return status;
    Image image;
    if (draws) image = empty_image(casting.size);
    std::vector<Ray> rays;
    std::vector<std::optional<RayHit>> hits;
    {
        const ProgressBar shown(session.progress(), session.bar());
        session.progress().begin_stage("casting rays", all);
        for (std::size_t first = 0; first < all; first += round_rays) {
            rays.clear();
            for (std::size_t i = first; i < std::min(all, first + round_rays); ++i)
                rays.push_back(casting.rays[i]);
            hits.resize(rays.size());
            const Stopwatch watch;
            cast(options, casting, rays, hits, session);
            if (Status status = session.check_running(); !status) return status;
            casting.seconds += watch.seconds();
            casting.hits += static_cast<std::uint64_t>(
                std::ranges::count_if(hits, [](const auto& hit) { return hit.has_value(); }));
            if (draws) draw_hits(casting.mesh, rays, hits, image);
            const auto rows = [&](std::size_t begin, std::size_t end) {
                return hit_rows(writer->format(), first + begin,
                                std::span(hits).subspan(begin, end - begin));
            };
            if (Status status =
                    writer->write_chunks(hits.size(), task_rays, session.threads(), rows);
                !status)
                return status;
            session.progress().advance(rays.size());
        }
    }
    if (Status status = session.check_running(); !status) return status;
    if (Status status = writer->commit(); !status || !draws) return status;
    return write_png(image, options.picture, &session.progress());
}

/// How many cells all rays go through.
Status count_cells(Casting& casting, Session& session)
{
    const ProgressBar shown(session.progress(), session.bar());
    const std::size_t all = casting.rays.count();
    session.progress().begin_stage("walking cells", all);
    std::vector<std::uint64_t> counts(chunk_count(all, task_rays));
    const Stopwatch watch;
    parallel_chunks(all, task_rays, session.threads(), [&](std::size_t first, std::size_t end) {
        if (session.progress().cancelled()) return;
        for (std::size_t i = first; i < end; ++i) {
            cells_along_ray(casting.octree, casting.rays[i], [&](const CellOnRay&) {
                ++counts[first / task_rays];
                return Flow::proceed;
            });
        }
        session.progress().advance(end - first);
    });
    casting.seconds = watch.seconds();
    for (const std::uint64_t count : counts) casting.cells += count;
    return session.check_running();
}

/// Again, for a table of them, round by round: there may be thousands of a ray.
Status write_cells(const RaycastOptions& options, const Casting& casting, Session& session)
{
    auto writer = RowWriter::open(options.out);
    if (!writer || !writer->is_wanted()) return writer ? Status{} : tl::unexpected(writer.error());
    if (Status status = writer->write(cell_header(writer->format(), casting.cells)); !status)
        return status;
    const ProgressBar shown(session.progress(), session.bar());
    const std::size_t all = casting.rays.count();
    session.progress().begin_stage("writing cells", all);
    for (std::size_t first = 0; first < all; first += round_cell_rays) {
        const std::size_t count = std::min(round_cell_rays, all - first);
        const auto rows = [&](std::size_t begin, std::size_t end) {
            std::string text;
            std::vector<CellOnRay> cells;
            for (std::size_t i = first + begin; i < first + end; ++i) {
                cells.clear();
                cells_along_ray(casting.octree, casting.rays[i], [&](const CellOnRay& at) {
                    cells.push_back(at);
                    return Flow::proceed;
                });
                text += cell_rows(writer->format(), i, cells);
            }
            return text;
        };
        if (Status status = writer->write_chunks(count, task_cell_rays, session.threads(), rows);
            !status)
            return status;
        session.progress().advance(count);
        if (Status status = session.check_running(); !status) return status;
    }
    return writer->commit();
}

Status cast_at_cells(const RaycastOptions& options, Casting& casting, Session& session)
{
    if (Status status = count_cells(casting, session); !status) return status;
    if (Status status = write_cells(options, casting, session); !status || options.picture.empty())
        return status;
    const ProgressBar shown(session.progress(), session.bar());
    const Image image = draw_weights(casting.octree, casting.rays, casting.size, session.threads(),
                                     &session.progress());
    if (Status status = session.check_running(); !status) return status;
    return write_png(image, options.picture, &session.progress());
}

Status run_raycast(const RaycastOptions& given, Session& session)
{
    RaycastOptions options = given;
    if (!options.has_camera) options.out = rows_path(given.out, session);
    if (Status status = check_outputs(options, session); !status) return status;
    const auto prepared = prepare(options, session);
    if (!prepared) return tl::unexpected(prepared.error());
    Casting& casting = **prepared;
    const bool cells = options.cells;
    Status status = cells ? cast_at_cells(options, casting, session)
                          : cast_at_triangles(options, casting, session);
    if (!status) return status;

    const std::size_t queries = casting.rays.count();
    const double each = 1e9 * casting.seconds / static_cast<double>(queries);
    const bool by_octree = options.by_octree();
    const std::uint64_t bytes = by_octree ? casting.octree.bytes() : casting.index.bytes();
    if (options.out != to_stdout) {
        std::string text =
            fmt::format("{}: {} triangles, {} of {:.2f} MB built in {:.3f} s\n"
                        "{} rays in {:.3g} ms, {:.0f} ns each; ",
                        options.model, casting.mesh.triangle_count(),
                        by_octree ? "octree" : "mesh index", 1e-6 * static_cast<double>(bytes),
                        casting.build_seconds, queries, 1e3 * casting.seconds, each);
        text += cells ? fmt::format("{} cells\n", casting.cells)
                      : fmt::format("{} hit\n", casting.hits);
        for (const std::string& path : {options.out, options.picture})
            if (!path.empty()) text += fmt::format("wrote {}\n", path);
        session.print(text);
    }
    nlohmann::ordered_json json = {
        {"model", options.model}, {"triangles", casting.mesh.triangle_count()},
        {"queries", queries},     {"seconds", casting.seconds},
        {"ns_per_query", each},   {"build_seconds", casting.build_seconds},
        {"bytes", bytes},         {"method", name_of(options.method)}};
    if (cells) {
        json["cells"] = casting.cells;
    } else {
        json["hits"] = casting.hits;
    }
    return session.write_json(json);
}

} // namespace

Command add_raycast_command(CLI::App& app)
{
    CLI::App* const parser = app.add_subcommand(
        "raycast", "Find what rays hit first, or the cells of the octree that they go through");
    const auto options = std::make_shared<RaycastOptions>();
    add_model_option(*parser, options->model, ModelKinds::meshes_and_indexes);
    parser
        ->add_option("--rays", options->rays_file,
                     "The rays: .npy, or text, of ox,oy,oz,dx,dy,dz[,tmin,tmax]; - for stdin")
        ->type_name("FILE");
    parser->add_option("--ray", options->rays, "Instead: a ray; again for more")
        ->allow_extra_args(false)
        ->type_name("OX,OY,OZ,DX,DY,DZ[,TMIN,TMAX]");
    parser
        ->add_option("--out", options->out,
                     "Write the answers: .csv, .npy, - for CSV to stdout, where those of --rays "
                     "and --ray go without --out and --json")
        ->type_name("FILE");
    parser
        ->add_option("--picture", options->picture,
                     "Instead of given rays: draw what a camera sees, a ray per pixel: .png")
        ->type_name("FILE");
    add_size_option(*parser, options->camera.size, "the camera's picture", most_pixels);
    add_camera_options(*parser, options->camera, "the model");
    parser->add_flag("--cells", options->cells,
                     "The leaves along each ray instead, with both weights: penetration and "
                     "chord; drawn by their sum");
    add_query_method_option(*parser, options->method,
                            "the triangles of the cells along the ray, cell by cell");
    add_cell_options(*parser, options->depth, options->threshold);
    parser->final_callback([parser, options] {
        options->has_camera = options->camera.has_any() || parser->count("--picture") > 0 ||
                              parser->count("--size") > 0;
        check_sources(*options);
        if (!options->by_octree()) refuse_cell_options(*parser, "--cells or --method thesis");
    });
    return {parser, [options](Session& session) { return run_raycast(*options, session); }};
}

} // namespace proxima
