// proxima raycast: what rays hit, or which cells of the octree they go through.
#include "cli/commands.h"
#include "cli/model_options.h"
#include "cli/ray_picture.h"
#include "cli/ray_sources.h"
#include "cli/ray_table.h"
#include "cli/stopwatch.h"
#include "proxima/base/file_extension.h"
#include "proxima/base/output_file.h"
#include "proxima/octree/build_octree.h"
#include "proxima/query/build_ray_index.h"
#include "proxima/query/cast_ray.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <fmt/core.h>
#include <memory>
#include <nlohmann/json.hpp>

namespace proxima {

namespace {

struct RaycastOptions {
    std::string model;
    std::string rays;
    std::string camera;
    std::string out; ///< "-" for stdout, empty for none
    bool cells = false;
    bool shade = false;
    int depth = 5;
    std::uint32_t threshold = 1;
};

constexpr std::size_t task_rays = 1024;

bool is_picture(const RaycastOptions& options)
{
    return lower_case_extension(options.out) == ".png";
}

/// Whether cells are asked for, not triangles.
bool wants_cells(const RaycastOptions& options)
{
    return options.cells || (!options.camera.empty() && !options.shade && is_picture(options));
}

Status check_options(const RaycastOptions& options, const Session& session)
{
    if (options.rays.empty() == options.camera.empty())
        return fail(ErrorCode::invalid_argument, "give either --rays or --camera", "raycast");
    if (!options.camera.empty() && !parse_picture_size(options.camera)) {
        return fail(ErrorCode::invalid_argument,
                    "a camera is WIDTHxHEIGHT in pixels, each from 1 to 16384", options.camera);
    }
    const bool picture = is_picture(options);
    if (picture && options.camera.empty())
        return fail(ErrorCode::invalid_argument, "a picture needs --camera", options.out);
    if (options.shade && !picture) {
        return fail(ErrorCode::invalid_argument, "--shade needs --camera and --out F.png",
                    "raycast");
    }
    if (options.out.empty() || picture) return session.check_outputs({options.out});
    if (const auto format = answer_format(options.out); !format)
        return tl::unexpected(format.error());
    if (options.out != to_stdout) return session.check_outputs({options.out});
    if (session.options().json != to_stdout) return {};
    return fail(ErrorCode::invalid_argument,
                "--json and --out would both write to stdout: give one of them a file", to_stdout);
}

/// What rays are cast at, and what came of it.
struct Casting {
    TriangleMesh mesh;
    Octree octree;
    RayIndex index; ///< empty where cells are asked for
    std::vector<Ray> rays;
    PictureSize size;
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
    if (options.camera.empty()) {
        auto rays = read_rays(options.rays, &session.progress());
        if (!rays) return tl::unexpected(rays.error());
        casting->rays = std::move(*rays);
    } else {
        casting->size = *parse_picture_size(options.camera);
        casting->rays = camera_rays(*box, casting->size, up_axis_of_model(options.model));
    }
    const Stopwatch watch;
    auto octree = build_octree(casting->mesh, {.max_depth = options.depth,
                                               .threshold = options.threshold,
                                               .classification = Classification::none,
                                               .threads = session.threads(),
                                               .progress = &session.progress()});
    if (!octree) return at_model(octree.error(), options.model);
    casting->octree = std::move(*octree);
    if (!wants_cells(options)) {
        auto index =
            build_ray_index(casting->octree, casting->mesh,
                            {.threads = session.threads(), .progress = &session.progress()});
        if (!index) return at_model(index.error(), options.model);
        casting->index = std::move(*index);
    }
    casting->build_seconds = watch.seconds();
    return casting;
}

/// Writes texts where --out says, whole or not at all.
Status write_texts(const std::string& path, const std::string& header,
                   std::span<const std::string> texts)
{
    if (path == to_stdout) {
        std::fwrite(header.data(), 1, header.size(), stdout); // finish() asks whether it arrived
        for (const std::string& text : texts) std::fwrite(text.data(), 1, text.size(), stdout);
        return {};
    }
    auto file = OutputFile::create(path);
    if (!file) return tl::unexpected(file.error());
    if (Status status = file->write(header); !status) return status;
    for (const std::string& text : texts)
        if (Status status = file->write(text); !status) return status;
    return file->commit();
}

Status cast_at_triangles(const RaycastOptions& options, Casting& casting, Session& session)
{
    std::vector<std::optional<RayHit>> hits(casting.rays.size());
    const Stopwatch watch;
    {
        const ProgressBar shown(session.progress(), session.bar());
        if (Status status =
                closest_hits(casting.index, casting.rays, hits,
                             {.threads = session.threads(), .progress = &session.progress()});
            !status)
            return status;
    }
    casting.seconds = watch.seconds();
    casting.hits = static_cast<std::uint64_t>(
        std::ranges::count_if(hits, [](const auto& hit) { return hit.has_value(); }));
    if (options.out.empty()) return {};
    if (is_picture(options)) {
        return write_png(draw_hits(casting.mesh, casting.rays, hits, casting.size), options.out,
                         &session.progress());
    }
    const AnswerFormat format = answer_format(options.out).value();
    std::vector<std::string> texts((hits.size() + task_rays - 1) / task_rays);
    parallel_for(texts.size(), session.threads(), [&](std::size_t task) {
        const std::size_t first = task * task_rays;
        const std::size_t count = std::min(task_rays, hits.size() - first);
        texts[task] = hit_rows(format, first, std::span(hits).subspan(first, count));
    });
    return write_texts(options.out, hit_header(format, hits.size()), texts);
}

Status cast_at_cells(const RaycastOptions& options, Casting& casting, Session& session)
{
    const std::size_t tasks = (casting.rays.size() + task_rays - 1) / task_rays;
    const bool wants_rows = !options.out.empty() && !is_picture(options);
    const AnswerFormat format = wants_rows ? answer_format(options.out).value() : AnswerFormat::csv;
    std::vector<std::string> texts(tasks);
    std::vector<std::uint64_t> counts(tasks);
    const Stopwatch watch;
    {
        const ProgressBar shown(session.progress(), session.bar());
        session.progress().begin_stage("walking cells", casting.rays.size());
        parallel_for(tasks, session.threads(), [&](std::size_t task) {
            if (session.progress().cancelled()) return;
            const std::size_t end = std::min(casting.rays.size(), (task + 1) * task_rays);
            std::vector<CellOnRay> cells;
            for (std::size_t i = task * task_rays; i < end; ++i) {
                cells.clear();
                cells_along_ray(casting.octree, casting.rays[i], [&](const CellOnRay& at) {
                    ++counts[task];
                    if (wants_rows) cells.push_back(at);
                });
                if (wants_rows) texts[task] += cell_rows(format, i, cells);
            }
            session.progress().advance(end - task * task_rays);
        });
    }
    casting.seconds = watch.seconds();
    for (const std::uint64_t count : counts) casting.cells += count;
    if (Status status = session.check_running(); !status) return status;
    if (options.out.empty()) return {};
    if (wants_rows) return write_texts(options.out, cell_header(format, casting.cells), texts);
    const ProgressBar shown(session.progress(), session.bar());
    const Image image = draw_weights(casting.octree, casting.rays, casting.size, session.threads(),
                                     &session.progress());
    if (Status status = session.check_running(); !status) return status;
    return write_png(image, options.out, &session.progress());
}

Status run_raycast(const RaycastOptions& options, Session& session)
{
    if (Status status = check_options(options, session); !status) return status;
    const auto prepared = prepare(options, session);
    if (!prepared) return tl::unexpected(prepared.error());
    Casting& casting = **prepared;
    const bool cells = wants_cells(options);
    Status status = cells ? cast_at_cells(options, casting, session)
                          : cast_at_triangles(options, casting, session);
    if (!status) return status;

    const std::size_t queries = casting.rays.size();
    const double each = 1e9 * casting.seconds / static_cast<double>(queries);
    const std::uint64_t bytes = cells ? casting.octree.bytes() : casting.index.bytes();
    if (options.out != to_stdout) {
        std::string text =
            fmt::format("{}: {} triangles, {} of {:.2f} MB built in {:.3f} s\n"
                        "{} rays in {:.3g} ms, {:.0f} ns each; ",
                        options.model, casting.mesh.triangle_count(),
                        cells ? "octree" : "ray index", 1e-6 * static_cast<double>(bytes),
                        casting.build_seconds, queries, 1e3 * casting.seconds, each);
        text += cells ? fmt::format("{} cells\n", casting.cells)
                      : fmt::format("{} hit\n", casting.hits);
        if (!options.out.empty()) text += fmt::format("wrote {}\n", options.out);
        session.print(text);
    }
    nlohmann::ordered_json json = {
        {"model", options.model}, {"triangles", casting.mesh.triangle_count()},
        {"queries", queries},     {"seconds", casting.seconds},
        {"ns_per_query", each},   {"build_seconds", casting.build_seconds},
        {"bytes", bytes}};
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
    add_model_option(*parser, options->model);
    parser
        ->add_option("--rays", options->rays,
                     "The rays: .npy, else CSV, of ox,oy,oz,dx,dy,dz[,tmin,tmax]")
        ->type_name("FILE");
    parser->add_option("--camera", options->camera, "Instead: one ray per pixel of a picture")
        ->type_name("WxH");
    parser
        ->add_option("--out", options->out,
                     "Write the answers: .csv, .npy, - for CSV to stdout, or a camera's picture: "
                     ".png")
        ->type_name("FILE");
    CLI::Option* const cells =
        parser->add_flag("--cells", options->cells, "All cells along each ray, with their weights");
    parser
        ->add_flag("--shade", options->shade,
                   "Draw the first hits shaded; without it the weights of the cells")
        ->excludes(cells);
    parser->add_option("--depth", options->depth, "Depth of the octree for cells")
        ->check(CLI::Range(0, max_octree_depth))
        ->type_name("N");
    parser->add_option("--threshold", options->threshold, "Triangles that a cell may keep")
        ->type_name("N");
    return {parser, [options](Session& session) { return run_raycast(*options, session); }};
}

} // namespace proxima
