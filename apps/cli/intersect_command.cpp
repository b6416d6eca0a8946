// proxima intersect: where two meshes meet, in any rigid poses of the second one.
#include "base/file_extension.h"
#include "base/output_file.h"
#include "base/text.h"
#include "cli/answer_table.h"
#include "cli/camera_options.h"
#include "cli/commands.h"
#include "cli/index_file_model.h"
#include "cli/intersection_files.h"
#include "cli/intersection_picture.h"
#include "cli/json_numbers.h"
#include "cli/model_options.h"
#include "cli/poses.h"
#include "cli/query_method.h"
#include "cli/row_writer.h"
#include "cli/stopwatch.h"
#include "geometry/triangle_intersection.h"
#include "index/index_parts.h"
#include "index/slabs/block_slab.h"
#include "proxima/intersect_meshes.h"
#include "proxima/mesh_distance.h"
#include "proxima/mesh_index.h"
#include "proxima/octree.h"
#include "proxima/thesis.h"
#include "query/contact/find_pairs.h"
#include "thesis/object_intersections/cancellable_cells.h"
#include "thesis/object_intersections/intersect_octrees.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <fmt/core.h>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

namespace proxima {

namespace {

using Json = nlohmann::ordered_json;

struct IntersectOptions {
    std::string model_a;
    std::string model_b;
    std::string poses;
    std::string out; ///< "-" for stdout, empty for none
    std::string pairs;
    std::string contour;
    std::string picture;
    CameraChoice view;
    bool cells = false;
    bool distance = false;
    QueryMethod method = QueryMethod::index;
    int depth = 5;
    std::uint32_t threshold = 1;

    [[nodiscard]] bool looks_at_cells() const { return cells || !picture.empty(); }
};

/// One mesh and what is built of it.
struct Body {
    std::string model;
    TriangleMesh mesh;
    Octree octree;
    MeshIndex index;
    std::optional<Enclosure> enclosure;
};

/// What was found in one pose.
struct PoseAnswer {
    std::vector<TrianglePair> pairs;
    ContainmentAnswer inside;
    double seconds = 0;
    IntersectionContour contour;  ///< where asked for
    std::vector<LeafPair> leaves; ///< where asked for
    std::uint64_t cell_tests = 0;
    std::uint64_t triangle_tests = 0; ///< of the thesis's method
    double cell_seconds = 0;
    CandidateTriangles candidates;
    std::optional<MeshDistance> nearest; ///< where asked for
    double distance_seconds = 0;
};

Status check_outputs(const IntersectOptions& options, Session& session)
{
    const auto wants = [](const std::string& path, std::string_view extension,
                          std::string_view option) -> Status {
        if (path.empty() || lower_case_extension(path) == extension) return {};
        return fail(ErrorCode::unsupported_format,
                    fmt::format("{} writes {} alone", option, extension), path);
    };
    if (Status status = wants(options.contour, ".obj", "--contour"); !status) return status;
    if (Status status = check_picture(options.picture, options.view); !status) return status;
    if (!options.pairs.empty()) {
        if (const auto format = answer_format(options.pairs); !format)
            return tl::unexpected(format.error());
    }
    return check_rows(options.out, session, {options.pairs, options.contour, options.picture});
}

Status prepare(Body& body, const std::string& model, const IntersectOptions& options,
               Session& session)
{
    body.model = model;
    auto mesh = session.load_model(model);
    if (!mesh) return tl::unexpected(mesh.error());
    body.mesh = std::move(*mesh);
    const ProgressBar shown(session.progress(), session.bar());
    if (options.looks_at_cells() || options.method == QueryMethod::thesis) {
        auto octree = build_octree(body.mesh, {.max_depth = options.depth,
                                               .threshold = options.threshold,
                                               .classification = Classification::none,
                                               .execution = session.execution()});
        if (!octree) return at_model(octree.error(), model);
        body.octree = std::move(*octree);
    }
    auto index = index_of_model(model, body.mesh, session);
    if (!index) return tl::unexpected(index.error());
    body.index = *index;
    auto enclosure = build_enclosure(body.index, {.execution = session.execution()});
    if (!enclosure) return at_model(enclosure.error(), model);
    body.enclosure = std::move(*enclosure);
    if (!options.distance || !body.index.parts().slabs().empty()) return {};
    auto with = with_slabs(body.index, {.execution = session.execution()});
    if (!with) return at_model(with.error(), model);
    body.index = *with;
    return {};
}

/// `last`: the nearest points of another pose, if any. Error: cancelled.
Result<PoseAnswer> find_in(const Body& a, const Body& b, const RigidTransform& pose,
                           const IntersectOptions& options, const MeshDistance* last,
                           Session& session)
{
    PoseAnswer answer;
    {
        const Stopwatch watch;
        if (options.method == QueryMethod::thesis) {
            CellIntersection found = intersect_by_cells({a.mesh, a.octree}, {b.mesh, b.octree},
                                                        pose, &session.progress());
            answer.pairs = std::move(found.pairs);
            answer.triangle_tests = found.triangle_tests;
        } else {
            answer.pairs = find_pairs(a.index, b.index, pose, &session.progress());
        }
        if (answer.pairs.empty())
            answer.inside = find_containment(*a.enclosure, *b.enclosure, pose);
        answer.seconds = watch.seconds();
    }
    if (Status status = session.check_running(); !status) return tl::unexpected(status.error());
    if (!options.contour.empty() || !options.picture.empty()) {
        auto contour = intersection_contour(a.mesh, b.mesh, pose, answer.pairs,
                                            {.execution = session.execution()});
        if (!contour) return tl::unexpected(contour.error());
        answer.contour = *std::move(contour);
    }
    if (options.looks_at_cells()) {
        const Stopwatch watch;
        answer.cell_tests =
            visit_intersecting_leaves(a.octree, b.octree, pose, [&](const LeafPair& pair) {
                answer.leaves.push_back(pair);
                return session.progress().cancelled() ? Flow::stop : Flow::proceed;
            });
        answer.cell_seconds = watch.seconds();
        if (Status status = session.check_running(); !status) return tl::unexpected(status.error());
        auto candidates =
            candidate_triangles(a.octree, b.octree, answer.leaves, &session.progress());
        if (!candidates) return tl::unexpected(candidates.error());
        answer.candidates = *std::move(candidates);
    }
    if (options.distance) {
        const Stopwatch watch;
        answer.nearest = mesh_distance(a.index, b.index, pose,
                                       {.start_from = last, .progress = &session.progress()});
        answer.distance_seconds = watch.seconds();
        if (Status status = session.check_running(); !status) return tl::unexpected(status.error());
    }
    return answer;
}

std::string_view name_of(Containment containment)
{
    return containment == Containment::a_in_b   ? "A_in_B"
           : containment == Containment::b_in_a ? "B_in_A"
                                                : "none";
}

std::string_view name_of(InsideMethod method)
{
    return method == InsideMethod::crossings ? "crossings"
           : method == InsideMethod::parity  ? "parity"
                                             : "winding_number";
}

FeatureKind kind_of(TrianglePart part)
{
    return is_corner(part) ? FeatureKind::vertex
           : is_side(part) ? FeatureKind::edge
                           : FeatureKind::face;
}

std::uint64_t distinct_cells(const std::vector<LeafPair>& pairs, Cell LeafPair::*side)
{
    std::vector<CellKey> keys;
    keys.reserve(pairs.size());
    for (const LeafPair& pair : pairs) keys.push_back((pair.*side).key);
    std::ranges::sort(keys);
    return static_cast<std::uint64_t>(std::unique(keys.begin(), keys.end()) - keys.begin());
}

MeetingCells cells_of(const PoseAnswer& answer)
{
    return {.pairs = answer.leaves.size(),
            .of_a = distinct_cells(answer.leaves, &LeafPair::a),
            .of_b = distinct_cells(answer.leaves, &LeafPair::b),
            .triangles_of_a = answer.candidates.a.size(),
            .triangles_of_b = answer.candidates.b.size()};
}

Json json_of(const PoseAnswer& answer, const IntersectOptions& options)
{
    Json json = {{"intersecting", !answer.pairs.empty()},
                 {"pairs", answer.pairs.size()},
                 {"contained", name_of(answer.inside.containment)},
                 {"seconds", answer.seconds}};
    if (options.method == QueryMethod::thesis) json["triangle_tests"] = answer.triangle_tests;
    if (answer.pairs.empty()) json["inside_method"] = name_of(answer.inside.method);
    if (!options.contour.empty()) {
        json["contour"] = {
            {"lines", answer.contour.lines.size()},
            {"closed", std::ranges::count_if(answer.contour.lines, &ContourLine::closed)},
            {"points", answer.contour.points.size()},
            {"length", answer.contour.length()}};
    }
    if (answer.nearest) {
        json["separation"] = answer.nearest->distance;
        json["closest_a"] = json_numbers(answer.nearest->point_a);
        json["closest_b"] = json_numbers(answer.nearest->point_b);
        json["triangle_a"] = to_index(answer.nearest->triangle_a);
        json["triangle_b"] = to_index(answer.nearest->triangle_b);
        json["feature_a"] = kind_name(kind_of(answer.nearest->part_a));
        json["feature_b"] = kind_name(kind_of(answer.nearest->part_b));
        json["distance_seconds"] = answer.distance_seconds;
    }
    if (options.cells) {
        const MeetingCells cells = cells_of(answer);
        json["cells"] = {{"pairs", cells.pairs},
                         {"a", cells.of_a},
                         {"b", cells.of_b},
                         {"triangles_a", cells.triangles_of_a},
                         {"triangles_b", cells.triangles_of_b},
                         {"tests", answer.cell_tests},
                         {"seconds", answer.cell_seconds}};
    }
    return json;
}

std::string text_of(const PoseAnswer& answer, const IntersectOptions& options)
{
    std::string text;
    if (!answer.pairs.empty()) {
        text = fmt::format("{} pairs of triangles meet", answer.pairs.size());
    } else {
        text = answer.inside.containment == Containment::a_in_b   ? "A is inside of B"
               : answer.inside.containment == Containment::b_in_a ? "B is inside of A"
                                                                  : "apart";
    }
    text += fmt::format(", {:.1f} us", 1e6 * answer.seconds);
    if (!options.contour.empty()) {
        text +=
            fmt::format("; contour of {} line{}, {} closed, length {:.6g}",
                        answer.contour.lines.size(), answer.contour.lines.size() == 1 ? "" : "s",
                        std::ranges::count_if(answer.contour.lines, &ContourLine::closed),
                        answer.contour.length());
    }
    if (answer.nearest) {
        text += fmt::format("; separation {:.9g} between triangles {} and {}, {:.1f} us",
                            answer.nearest->distance, to_index(answer.nearest->triangle_a),
                            to_index(answer.nearest->triangle_b), 1e6 * answer.distance_seconds);
    }
    if (options.cells) {
        const MeetingCells cells = cells_of(answer);
        text += fmt::format("; {} pairs of cells ({} of A, {} of B) hold {} and {} triangles, "
                            "{:.1f} us",
                            cells.pairs, cells.of_a, cells.of_b, cells.triangles_of_a,
                            cells.triangles_of_b, 1e6 * answer.cell_seconds);
    }
    return text + '\n';
}

/// The files that grow by a piece per pose.
class OutputTexts {
public:
    explicit OutputTexts(const IntersectOptions& options) : options_(options) {}

    void add(std::uint64_t pose, const PoseAnswer& answer)
    {
        if (!options_.out.empty()) {
            PoseRow row = {.pairs = answer.pairs.size(),
                           .containment = answer.inside.containment,
                           .nearest = answer.nearest ? &*answer.nearest : nullptr};
            if (options_.cells) row.cells = cells_of(answer);
            poses_ += pose_row(answer_format(options_.out).value(), pose, row);
            ++pose_count_;
        }
        if (!options_.pairs.empty()) {
            pairs_ += pair_rows(answer_format(options_.pairs).value(), pose, answer.pairs);
            rows_ += answer.pairs.size();
        }
        if (!options_.contour.empty()) {
            contour_ += contour_obj(answer.contour, pose, next_vertex_);
            next_vertex_ += answer.contour.points.size();
        }
    }

    [[nodiscard]] Status write() const
    {
        auto rows = RowWriter::open(options_.out);
        if (!rows) return tl::unexpected(rows.error());
        const std::string header = pose_header(
            rows->format(), {.distance = options_.distance, .cells = options_.cells}, pose_count_);
        if (Status status = rows->write(header + poses_); !status) return status;
        if (Status status = rows->commit(); !status) return status;
        if (!options_.pairs.empty()) {
            const AnswerFormat format = answer_format(options_.pairs).value();
            if (Status status = write_file(options_.pairs, pair_header(format, rows_), pairs_);
                !status)
                return status;
        }
        return options_.contour.empty() ? Status{} : write_file(options_.contour, "", contour_);
    }

private:
    static Status write_file(const std::string& path, std::string_view header,
                             std::string_view text)
    {
        auto file = OutputFile::create(path);
        if (!file) return tl::unexpected(file.error());
        if (Status status = file->write(header); !status) return status;
        if (Status status = file->write(text); !status) return status;
        return file->commit();
    }

    const IntersectOptions& options_;
    std::string poses_;
    std::uint64_t pose_count_ = 0;
    std::string pairs_;
    std::string contour_;
    std::uint64_t rows_ = 0;
    std::uint64_t next_vertex_ = 1;
};

Status run_intersect(const IntersectOptions& given, Session& session)
{
    IntersectOptions options = given;
    options.out = rows_path(given.out, session, {given.pairs, given.contour, given.picture});
    if (Status status = check_outputs(options, session); !status) return status;
    Poses read{.poses = std::vector<RigidTransform>(1)};
    if (!options.poses.empty()) {
        auto table = read_poses(options.poses, session);
        if (!table) return tl::unexpected(table.error());
        read = std::move(*table);
    }
    const std::vector<RigidTransform>& poses = read.poses;
    const auto a = std::make_unique<Body>();
    const auto b = std::make_unique<Body>();
    const Stopwatch watch;
    if (Status status = prepare(*a, options.model_a, options, session); !status) return status;
    if (Status status = prepare(*b, options.model_b, options, session); !status) return status;
    const double build_seconds = watch.seconds();

    constexpr std::size_t shown_poses = 10;
    OutputTexts texts(options);
    Json rows = Json::array();
    std::string text = fmt::format("A {}: {} triangles\nB {}: {} triangles\nloaded and built in "
                                   "{:.3f} s\n",
                                   a->model, a->mesh.triangle_count(), b->model,
                                   b->mesh.triangle_count(), build_seconds);
    std::size_t intersecting = 0;
    double seconds = 0;
    std::optional<MeshDistance> last;
    {
        const ProgressBar shown(session.progress(), session.bar());
        for (std::size_t i = 0; i < poses.size(); ++i) {
            // Contours have a stage of their own.
            session.progress().begin_stage("intersecting", poses.size());
            session.progress().advance(i);
            if (Status status = session.check_running(); !status) return status;
            const auto found = find_in(*a, *b, poses[i], options, last ? &*last : nullptr, session);
            if (!found) return tl::unexpected(found.error());
            const PoseAnswer& answer = *found;
            last = answer.nearest;
            texts.add(i, answer);
            rows.push_back(json_of(answer, options));
            intersecting += answer.pairs.empty() ? 0U : 1U;
            seconds += answer.seconds;
            if (i < shown_poses) text += fmt::format("pose {}: {}", i, text_of(answer, options));
            if (i == 0 && !options.picture.empty()) {
                const auto image =
                    draw_intersection({a->mesh, b->mesh, a->octree, b->octree, poses[0],
                                       answer.leaves, answer.contour},
                                      {.view = for_model(options.view, options.model_a),
                                       .with_legend = true,
                                       .execution = {.progress = &session.progress()}});
                if (!image) return tl::unexpected(image.error());
                if (Status status = write_png(*image, options.picture, &session.progress());
                    !status)
                    return status;
            }
        }
    }
    if (Status status = texts.write(); !status) return status;
    if (poses.size() > shown_poses) text += "...\n";
    text += rotation_text(read.rotation_error, options.out != to_stdout, session);
    text += fmt::format("{} of {} poses intersect, {:.1f} us each\n", intersecting, poses.size(),
                        1e6 * seconds / static_cast<double>(poses.size()));
    for (const std::string& path : {options.out, options.pairs, options.contour, options.picture}) {
        if (!path.empty()) text += fmt::format("wrote {}\n", path);
    }
    if (options.out != to_stdout) session.print(text);
    return session.write_json({{"a", a->model},
                               {"b", b->model},
                               {"triangles_a", a->mesh.triangle_count()},
                               {"triangles_b", b->mesh.triangle_count()},
                               {"build_seconds", build_seconds},
                               {"method", name_of(options.method)},
                               {"rotation_error", read.rotation_error},
                               {"poses", rows}});
}

} // namespace

Command add_intersect_command(CLI::App& app)
{
    CLI::App* const parser = app.add_subcommand(
        "intersect", "Find where two meshes meet, in any rigid poses of the second one");
    const auto options = std::make_shared<IntersectOptions>();
    const auto model = [&](const char* name, std::string& text, const char* what) {
        parser->add_option(name, text, what)->required()->type_name("MODEL");
    };
    model("A", options->model_a, "The mesh that stands still: a file or a built-in");
    model("B", options->model_b, "The mesh that poses move");
    parser
        ->add_option(
            "--pose", options->poses,
            concat("One pose of B, or a table of poses, a row each (.npy, text, - for stdin). "
                   "A pose is ",
                   pose_forms))
        ->type_name("POSE|FILE");
    parser
        ->add_option("--out", options->out,
                     "Write what was found, a row per pose of pose,intersecting,pairs,contained, "
                     "with what --distance and --cells add: .csv, .npy, or - for CSV to stdout, "
                     "where it goes if no output is named")
        ->type_name("FILE");
    parser
        ->add_option("--pairs", options->pairs,
                     "Write the pairs of triangles that meet: .csv or .npy of pose,a,b")
        ->type_name("FILE");
    parser->add_option("--contour", options->contour, "Write the contours as polylines: .obj")
        ->type_name("FILE");
    add_picture_options(
        *parser, options->picture, options->view,
        "Draw the first pose: the cells that meet, their triangles and the contour");
    parser->add_flag("--cells", options->cells, "Count the leaves of the octrees that meet, too");
    parser->add_flag("--distance", options->distance,
                     "How far the surfaces are apart, and their closest points");
    add_query_method_option(*parser, options->method,
                            "double recursion of two octrees, and the triangles of leaves that "
                            "meet");
    add_cell_options(*parser, options->depth, options->threshold);
    parser->callback([parser, options] {
        if (options->distance && options->method == QueryMethod::thesis) {
            throw CLI::ValidationError(
                "--distance", "is of --method index: the thesis has no distance between meshes");
        }
        if (!options->looks_at_cells() && options->method != QueryMethod::thesis)
            refuse_cell_options(*parser, "--cells, --picture or --method thesis");
    });
    return {parser, [options](Session& session) { return run_intersect(*options, session); }};
}

} // namespace proxima
