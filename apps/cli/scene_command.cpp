// proxima scene: rays, points and pairs among many placed copies of models.
#include "base/text.h"
#include "cli/closest_searcher.h"
#include "cli/commands.h"
#include "cli/npy_header.h"
#include "cli/number_checks.h"
#include "cli/point_options.h"
#include "cli/poses.h"
#include "cli/ray_sources.h"
#include "cli/row_text.h"
#include "cli/row_writer.h"
#include "cli/stopwatch.h"
#include "proxima/scene.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/core.h>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

namespace proxima {

namespace {

struct SceneCommandOptions {
    std::vector<std::string> models;
    std::string poses;
    std::string shapes; ///< empty: models in turn
    std::string rays_file;
    std::vector<std::string> rays;
    PointOptions points;
    bool pairs = false;
    std::optional<double> within;
    std::string out;

    [[nodiscard]] bool has_rays() const { return !rays_file.empty() || !rays.empty(); }
    [[nodiscard]] bool has_points() const { return !points.file.empty() || !points.points.empty(); }
};

/// Answers as rows of numbers, and what to say of them.
struct SceneAnswers {
    std::string_view columns;
    std::size_t width = 0;
    std::size_t kind_column;     ///< in CSV a word; beyond all where there is none
    std::vector<double> numbers; ///< row by row
    std::uint64_t queries = 0;
    std::uint64_t found = 0;
    std::string text;
    double seconds = 0;

    SceneAnswers(std::string_view names, std::size_t count)
        : columns(names), width(static_cast<std::size_t>(1 + std::ranges::count(names, ','))),
          queries(count)
    {
        const std::size_t at = names.find(",kind");
        kind_column =
            at == std::string_view::npos
                ? width
                : static_cast<std::size_t>(1 + std::ranges::count(names.substr(0, at), ','));
    }
    template <std::size_t N>
    void add(const std::array<double, N>& row)
    {
        numbers.insert(numbers.end(), row.begin(), row.end());
    }
    [[nodiscard]] double ns_per_query() const
    {
        return 1e9 * seconds / static_cast<double>(std::max<std::uint64_t>(queries, 1));
    }
};

double number_of(InstanceId id)
{
    return static_cast<double>(to_index(id));
}

/// Which model each instance is of: as the table says, or in turn.
Result<std::vector<std::uint32_t>> read_shapes(const SceneCommandOptions& options,
                                               std::size_t instances, Session& session)
{
    std::vector<std::uint32_t> shapes(instances);
    const std::size_t models = options.models.size();
    if (options.shapes.empty()) {
        for (std::size_t i = 0; i < instances; ++i)
            shapes[i] = static_cast<std::uint32_t>(i % models);
        for (std::size_t i = instances; i < models; ++i)
            session.note(concat("no pose places ", options.models[i]));
        return shapes;
    }
    constexpr std::array<std::string_view, 1> layouts = {"model"};
    // Without its note on a first line that may be a header: 0 is a model.
    const auto table =
        read_number_table(options.shapes, {layouts}, {.execution = session.execution()});
    if (!table) return tl::unexpected(table.error());
    if (table->rows() != instances) {
        return fail(ErrorCode::invalid_argument,
                    concat("it has ", table->rows(), " rows, but there are ", instances,
                           " poses; give a model's number for each"),
                    options.shapes);
    }
    for (std::size_t i = 0; i < instances; ++i) {
        const double model = table->values[i];
        if (!(model >= 0 && model < static_cast<double>(models) && model == std::floor(model))) {
            return fail(
                ErrorCode::invalid_argument,
                concat("there is no model ", model, "; give numbers from 0 to ", models - 1),
                table->place_of(i));
        }
        shapes[i] = static_cast<std::uint32_t>(model);
    }
    return shapes;
}

/// A scene, and how long its parts took.
struct LoadedScene {
    Scene scene;
    std::uint64_t triangles = 0; ///< of all models
    double index_seconds = 0;
    double build_seconds = 0;
    double rotation_error = 0;
};

Result<LoadedScene> load_scene(const SceneCommandOptions& options, Session& session)
{
    LoadedScene loaded;
    std::vector<MeshIndex> models;
    for (const std::string& model : options.models) {
        const auto searcher = make_closest_searcher(model, {}, session);
        if (!searcher) return tl::unexpected(searcher.error());
        models.push_back(searcher->index);
        loaded.triangles += searcher->index.triangle_count();
        loaded.index_seconds += searcher->build_seconds + searcher->load_seconds.value_or(0);
    }
    const auto poses = read_poses(options.poses, session);
    if (!poses) return tl::unexpected(poses.error());
    loaded.rotation_error = poses->rotation_error;
    const auto shapes = read_shapes(options, poses->poses.size(), session);
    if (!shapes) return tl::unexpected(shapes.error());
    std::vector<Instance> instances(poses->poses.size());
    for (std::size_t i = 0; i < instances.size(); ++i) {
        instances[i].shape = (*shapes)[i];
        instances[i].pose = poses->poses[i];
    }
    const ProgressBar shown(session.progress(), session.bar());
    const Stopwatch watch;
    auto scene = build_scene(models, instances, {.execution = session.execution()});
    if (!scene) return tl::unexpected(scene.error());
    loaded.build_seconds = watch.seconds();
    loaded.scene = *scene;
    return loaded;
}

Result<SceneAnswers> cast_rays(const SceneCommandOptions& options, const Scene& scene,
                               Session& session)
{
    const auto rays =
        options.rays.empty() ? read_rays(options.rays_file, session) : parse_rays(options.rays);
    if (!rays) return tl::unexpected(rays.error());
    std::vector<std::optional<SceneHit>> hits(rays->size());
    SceneAnswers answers("index,t,instance,triangle,u,v", rays->size());
    {
        const ProgressBar shown(session.progress(), session.bar());
        const Stopwatch watch;
        if (Status status = closest_hits(scene, *rays, hits, {.execution = session.execution()});
            !status)
            return tl::unexpected(status.error());
        answers.seconds = watch.seconds();
    }
    for (std::size_t i = 0; i < hits.size(); ++i) {
        std::array<double, 6> row = {static_cast<double>(i), HUGE_VAL, -1, -1, 0, 0};
        if (hits[i]) {
            const RayHit& hit = hits[i]->hit;
            row = {row[0],
                   hit.t,
                   number_of(hits[i]->instance),
                   static_cast<double>(to_index(hit.triangle)),
                   hit.u,
                   hit.v};
            ++answers.found;
        }
        answers.add(row);
    }
    answers.text = fmt::format("{} of {} rays hit, {:.0f} ns each\n", answers.found,
                               answers.queries, answers.ns_per_query());
    return answers;
}

Result<SceneAnswers> ask_points(const SceneCommandOptions& options, const Scene& scene,
                                Session& session)
{
    const auto table = read_points(options.points, session);
    if (!table) return tl::unexpected(table.error());
    std::vector<Vec3> points(table->rows());
    for (std::size_t i = 0; i < points.size(); ++i)
        points[i] = {table->row(i)[0], table->row(i)[1], table->row(i)[2]};
    std::vector<std::optional<SceneFeature>> near(points.size());
    SceneAnswers answers("index,distance,x,y,z,instance,triangle,kind,feature", points.size());
    {
        const ProgressBar shown(session.progress(), session.bar());
        const Stopwatch watch;
        if (Status status =
                closest_features(scene, points, near, {.execution = session.execution()});
            !status)
            return tl::unexpected(status.error());
        answers.seconds = watch.seconds();
    }
    for (std::size_t i = 0; i < near.size(); ++i) {
        std::array<double, 9> row = {static_cast<double>(i), HUGE_VAL, 0, 0, 0, -1, -1, -1, -1};
        if (near[i]) {
            const ClosestFeature& closest = near[i]->closest;
            const Vec3& p = near[i]->point;
            row = {row[0],
                   near[i]->distance,
                   p[0],
                   p[1],
                   p[2],
                   number_of(near[i]->instance),
                   static_cast<double>(to_index(closest.triangle)),
                   static_cast<double>(closest.feature.kind),
                   static_cast<double>(closest.feature.id)};
            ++answers.found;
        }
        answers.add(row);
    }
    answers.text =
        fmt::format("{} points, {:.0f} ns each\n", answers.queries, answers.ns_per_query());
    return answers;
}

Result<SceneAnswers> find_pairs(const SceneCommandOptions& options, const Scene& scene,
                                Session& session)
{
    const ProgressBar shown(session.progress(), session.bar());
    const ScenePairOptions pair_options = {.execution = session.execution()};
    const Stopwatch watch;
    if (!options.within) {
        const auto pairs = pairs_in_contact(scene, pair_options);
        if (!pairs) return tl::unexpected(pairs.error());
        SceneAnswers answers("a,b", scene.instance_count());
        answers.seconds = watch.seconds();
        answers.found = pairs->size();
        for (const InstancePair& pair : *pairs)
            answers.add(std::array{number_of(pair.a), number_of(pair.b)});
        answers.text = fmt::format("{} pairs in contact, in {:.3g} ms\n", answers.found,
                                   1e3 * answers.seconds);
        return answers;
    }
    const auto pairs = pairs_within(scene, *options.within, pair_options);
    if (!pairs) return tl::unexpected(pairs.error());
    SceneAnswers answers("a,b,distance,ax,ay,az,bx,by,bz", scene.instance_count());
    answers.seconds = watch.seconds();
    answers.found = pairs->size();
    for (const NearInstances& pair : *pairs) {
        answers.add(std::array{number_of(pair.a), number_of(pair.b), pair.nearest.distance,
                               pair.point_a[0], pair.point_a[1], pair.point_a[2], pair.point_b[0],
                               pair.point_b[1], pair.point_b[2]});
    }
    answers.text = fmt::format("{} pairs within {:.6g}, in {:.3g} ms\n", answers.found,
                               *options.within, 1e3 * answers.seconds);
    return answers;
}

/// A row of numbers as CSV, or as they are.
void append_answer(fmt::memory_buffer& text, AnswerFormat format, const SceneAnswers& answers,
                   std::span<const double> row)
{
    if (format == AnswerFormat::npy || answers.kind_column >= row.size())
        return append_row(text, format, row);
    for (std::size_t i = 0; i < row.size(); ++i) {
        const std::string_view comma = i == 0 ? "" : ",";
        if (i == answers.kind_column && row[i] >= 0) {
            fmt::format_to(std::back_inserter(text), "{}{}", comma,
                           kind_name(static_cast<FeatureKind>(static_cast<int>(row[i]))));
        } else {
            fmt::format_to(std::back_inserter(text), "{}{:.17g}", comma, row[i]);
        }
    }
    text.push_back('\n');
}

Status write_answers(const SceneAnswers& answers, const std::string& path)
{
    auto writer = RowWriter::open(path);
    if (!writer) return tl::unexpected(writer.error());
    const std::size_t rows = answers.numbers.size() / answers.width;
    const std::string header = writer->format() == AnswerFormat::npy
                                   ? npy_header(rows, answers.width)
                                   : concat(answers.columns, '\n');
    if (Status status = writer->write(header); !status) return status;
    constexpr std::size_t rows_together = 4096;
    for (std::size_t first = 0; first < rows; first += rows_together) {
        fmt::memory_buffer text;
        for (std::size_t i = first; i < std::min(rows, first + rows_together); ++i) {
            append_answer(text, writer->format(), answers,
                          std::span(answers.numbers).subspan(answers.width * i, answers.width));
        }
        if (Status status = writer->write(fmt::to_string(text)); !status) return status;
    }
    return writer->commit();
}

Status run_scene(const SceneCommandOptions& options, Session& session)
{
    const std::string out = rows_path(options.out, session);
    if (Status status = check_rows(out, session); !status) return status;
    const auto loaded = load_scene(options, session);
    if (!loaded) return tl::unexpected(loaded.error());
    const Scene& scene = loaded->scene;
    const auto answers = options.has_rays()     ? cast_rays(options, scene, session)
                         : options.has_points() ? ask_points(options, scene, session)
                                                : find_pairs(options, scene, session);
    if (!answers) return tl::unexpected(answers.error());
    if (Status status = write_answers(*answers, out); !status) return status;
    const std::string rotated = rotation_text(loaded->rotation_error, out != to_stdout, session);
    if (out != to_stdout) {
        session.print(fmt::format(
            "{} instances of {} models with {} triangles, scene of {:.2f} MB built in {:.3g} ms\n"
            "{}{}{}",
            scene.instance_count(), scene.shape_count(), loaded->triangles,
            1e-6 * static_cast<double>(scene.bytes()), 1e3 * loaded->build_seconds, rotated,
            answers->text, out.empty() ? std::string() : fmt::format("wrote {}\n", out)));
    }
    return session.write_json({{"models", options.models},
                               {"triangles", loaded->triangles},
                               {"instances", scene.instance_count()},
                               {"query", options.has_rays()     ? "rays"
                                         : options.has_points() ? "points"
                                         : options.within       ? "within"
                                                                : "contact"},
                               {"queries", answers->queries},
                               {"found", answers->found},
                               {"seconds", answers->seconds},
                               {"ns_per_query", answers->ns_per_query()},
                               {"index_seconds", loaded->index_seconds},
                               {"build_seconds", loaded->build_seconds},
                               {"rotation_error", loaded->rotation_error},
                               {"bytes", scene.bytes()}});
}

/// Exactly one question.
void check_questions(const SceneCommandOptions& options)
{
    const int questions = (options.rays_file.empty() ? 0 : 1) + (options.rays.empty() ? 0 : 1) +
                          (options.has_points() ? 1 : 0) + (options.pairs ? 1 : 0);
    if (questions != 1) {
        throw CLI::ValidationError("scene",
                                   "give one of --rays, --ray, --points, --point, --pairs");
    }
    if (options.within && !options.pairs)
        throw CLI::ValidationError("--within", "it goes with --pairs");
}

} // namespace

Command add_scene_command(CLI::App& app)
{
    CLI::App* const parser = app.add_subcommand(
        "scene", "Ask rays, points or pairs of many placed copies of some models");
    const auto options = std::make_shared<SceneCommandOptions>();
    parser->add_option("MODEL", options->models, "The models: files, saved indexes or built-ins")
        ->required()
        ->type_name("MODEL ...");
    parser
        ->add_option("--poses", options->poses,
                     concat("A table of poses, an instance each (.npy, text, - for stdin), or one "
                            "pose. A pose is ",
                            pose_forms))
        ->required()
        ->type_name("POSE|FILE");
    parser
        ->add_option("--shapes", options->shapes,
                     "Which model each instance is of, from 0: .npy or text of one column "
                     "(default: models in turn)")
        ->type_name("FILE");
    parser
        ->add_option(
            "--rays", options->rays_file,
            "What do rays hit first: .npy, or text, of ox,oy,oz,dx,dy,dz[,tmin,tmax]; - for "
            "stdin")
        ->type_name("FILE");
    parser->add_option("--ray", options->rays, "What does a ray hit first; again for more")
        ->allow_extra_args(false)
        ->type_name("OX,OY,OZ,DX,DY,DZ[,TMIN,TMAX]");
    add_point_options(*parser, options->points);
    parser->add_flag("--pairs", options->pairs, "Which instances touch each other");
    parser
        ->add_option("--within", options->within,
                     "With --pairs: which are at most this far apart, and their closest points")
        ->check(not_negative())
        ->type_name("D");
    add_rows_option(*parser, options->out);
    parser->callback([options] { check_questions(*options); });
    return {parser, [options](Session& session) { return run_scene(*options, session); }};
}

} // namespace proxima
