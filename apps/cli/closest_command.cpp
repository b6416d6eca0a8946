// proxima closest: the closest feature of a mesh for each point of a file.
#include "base/parallel.h"
#include "base/text.h"
#include "cli/answer_table.h"
#include "cli/closest_searcher.h"
#include "cli/commands.h"
#include "cli/index_file_model.h"
#include "cli/model_options.h"
#include "cli/point_options.h"
#include "cli/query_method.h"
#include "cli/row_writer.h"
#include "cli/stopwatch.h"
#include "cli/thesis_closest_run.h"
#include "proxima/closest_feature.h"
#include "proxima/octree.h"

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

struct ClosestOptions {
    std::string model;
    PointOptions points;
    std::string out; ///< "-" for stdout, empty for none
    bool is_signed = false;
    bool lists = false;
    std::uint64_t lists_mb = 0; ///< of lists; 0: the library's own
    QueryMethod method = QueryMethod::index;
    ThesisClosestOptions thesis; ///< of --method thesis
};

/// Points of a task, and of a round: what is held at once beside the points.
constexpr std::size_t task_points = 1024;
constexpr std::size_t round_points = 128 * task_points;

/// What the answers were like, for people.
struct AnswerCounts {
    std::array<std::uint64_t, 3> by_kind = {};
    std::array<std::uint64_t, 3> by_method = {};
    std::uint64_t inside = 0;
    double least = HUGE_VAL;
    double most = 0;

    void add(std::span<const ClosestFeature> answers, std::span<const SignedDistance> signs)
    {
        for (const ClosestFeature& answer : answers) {
            ++by_kind[static_cast<std::size_t>(answer.feature.kind)];
            const double distance = std::sqrt(answer.squared_distance);
            least = std::min(least, distance);
            most = std::max(most, distance);
        }
        for (const SignedDistance& sign : signs) {
            ++by_method[static_cast<std::size_t>(sign.method)];
            if (sign.distance < 0) ++inside;
        }
    }
};

/// Answers points round by round.
class ClosestRun {
public:
    ClosestRun(const MeshIndex& index, AnswerSigns kinds, const NumberTable& table,
               Session& session)
        : index_(index), kinds_(kinds), table_(table), session_(session)
    {}

    Status run(RowWriter& writer)
    {
        if (Status status = writer.write(answer_header(writer.format(), kinds_, table_.rows()));
            !status)
            return status;
        const ProgressBar shown(session_.progress(), session_.bar());
        session_.progress().begin_stage("closest features", table_.rows());
        const std::size_t capacity = std::min(table_.rows(), round_points);
        answers_.resize(capacity);
        if (is_signed()) signs_.resize(capacity);
        for (std::size_t first = 0; first < table_.rows(); first += round_points) {
            const std::size_t count = std::min(round_points, table_.rows() - first);
            const Stopwatch watch;
            parallel_chunks(count, task_points, session_.threads(),
                            [&](std::size_t begin, std::size_t end) {
                                answer_chunk(first, begin, end - begin);
                            });
            seconds_ += watch.seconds();
            if (Status status = session_.check_running(); !status) return status;
            const auto answers = std::span<const ClosestFeature>(answers_).first(count);
            const auto signs =
                std::span<const SignedDistance>(signs_).first(is_signed() ? count : 0);
            counts_.add(answers, signs);
            if (Status status = write(writer, first, answers, signs); !status) return status;
        }
        return writer.commit();
    }

    [[nodiscard]] double seconds() const noexcept { return seconds_; }
    [[nodiscard]] const AnswerCounts& counts() const noexcept { return counts_; }

private:
    [[nodiscard]] bool is_signed() const noexcept { return kinds_ == AnswerSigns::present; }

    /// The rows of a round.
    Status write(RowWriter& writer, std::uint64_t first, std::span<const ClosestFeature> answers,
                 std::span<const SignedDistance> signs)
    {
        const auto rows = [&](std::size_t begin, std::size_t end) {
            return answer_rows(writer.format(), first + begin, answers.subspan(begin, end - begin),
                               signs.empty() ? signs : signs.subspan(begin, end - begin));
        };
        return writer.write_chunks(answers.size(), task_points, session_.threads(), rows);
    }

    /// Answers `count` points of the round that starts at row `first`, from its `begin`th on.
    void answer_chunk(std::size_t first, std::size_t begin, std::size_t count)
    {
        if (session_.progress().cancelled()) return;
        std::array<Vec3, task_points> points;
        for (std::size_t i = 0; i < count; ++i) {
            const double* const row = table_.values.data() + 3 * (first + begin + i);
            points[i] = {row[0], row[1], row[2]};
        }
        // Cannot fail: sizes agree and the table holds finite numbers.
        (void)closest_features(index_, std::span(points).first(count),
                               {.answers = std::span(answers_).subspan(begin, count)},
                               {.execution = {.threads = {1}}});
        if (is_signed()) {
            for (std::size_t i = 0; i < count; ++i)
                signs_[begin + i] = *sign_of(index_, answers_[begin + i], points[i]);
        }
        session_.progress().advance(count);
    }

    const MeshIndex& index_;
    AnswerSigns kinds_;
    const NumberTable& table_;
    Session& session_;
    std::vector<ClosestFeature> answers_;
    std::vector<SignedDistance> signs_;
    double seconds_ = 0;
    AnswerCounts counts_;
};

std::string text_of(const ClosestOptions& options, const ClosestSearcher& searcher,
                    const ClosestRun& run, std::size_t queries)
{
    const AnswerCounts& counts = run.counts();
    const bool loaded = searcher.load_seconds.has_value();
    std::string text = fmt::format(
        "{}: {} triangles, index of {:.2f} MB {} in {:.3f} s\n"
        "{} points in {:.3g} ms, {:.0f} ns each; distances {:.6g} to {:.6g}\n"
        "closest: vertices {}, edges {}, faces {}\n",
        options.model, searcher.index.triangle_count(),
        1e-6 * static_cast<double>(searcher.index.bytes()), loaded ? "loaded" : "built",
        loaded ? *searcher.load_seconds : searcher.build_seconds, queries, 1e3 * run.seconds(),
        1e9 * run.seconds() / static_cast<double>(queries), counts.least, counts.most,
        counts.by_kind[0], counts.by_kind[1], counts.by_kind[2]);
    if (options.is_signed) {
        text += fmt::format("inside {}; signs by pseudonormal {}, by winding number {}, on the "
                            "surface {}\n",
                            counts.inside, counts.by_method[1], counts.by_method[2],
                            counts.by_method[0]);
    }
    if (!options.out.empty()) text += fmt::format("wrote {}\n", options.out);
    return text;
}

Status run_as_thesis(const ClosestOptions& options, Session& session)
{
    ThesisClosestOptions thesis = options.thesis;
    thesis.model = options.model;
    thesis.points = options.points;
    thesis.out = options.out;
    return run_thesis_closest(thesis, session);
}

/// An option that the method has no use for is wrong usage.
void check_method_options(const CLI::App& parser, QueryMethod method)
{
    const auto refuse = [&](const char* name, const char* other) {
        if (parser.count(name) == 0) return;
        throw CLI::ValidationError(name, concat("it goes with --method ", other));
    };
    if (method == QueryMethod::thesis) {
        for (const char* const name : {"--signed", "--lists", "--lists-mb"}) refuse(name, "index");
    } else {
        for (const char* const name : {"--depth", "--save", "--octree"}) refuse(name, "thesis");
    }
    if (parser.count("--octree") > 0 && parser.count("--depth") > 0)
        throw CLI::ValidationError("--depth", "a saved octree has its own");
}

Status run_closest(const ClosestOptions& given, Session& session)
{
    ClosestOptions options = given;
    options.out = rows_path(given.out, session);
    if (options.method == QueryMethod::thesis) return run_as_thesis(options, session);
    if (Status status = check_rows(options.out, session); !status) return status;
    const auto table = read_points(options.points, session);
    if (!table) return tl::unexpected(table.error());
    const auto searcher = make_closest_searcher(options.model,
                                                {.is_signed = options.is_signed,
                                                 .lists = options.lists || options.lists_mb != 0,
                                                 .list_bytes = options.lists_mb * 1'000'000},
                                                session);
    if (!searcher) return tl::unexpected(searcher.error());
    auto writer = RowWriter::open(options.out);
    if (!writer) return tl::unexpected(writer.error());
    ClosestRun run(searcher->index, options.is_signed ? AnswerSigns::present : AnswerSigns::absent,
                   *table, session);
    if (Status status = run.run(*writer); !status) return status;

    if (options.out != to_stdout) session.print(text_of(options, *searcher, run, table->rows()));
    nlohmann::ordered_json load_seconds; // null where it was built
    if (searcher->load_seconds) load_seconds = *searcher->load_seconds;
    return session.write_json(
        {{"model", options.model},
         {"triangles", searcher->index.triangle_count()},
         {"queries", table->rows()},
         {"seconds", run.seconds()},
         {"ns_per_query", 1e9 * run.seconds() / static_cast<double>(table->rows())},
         {"build_seconds", searcher->build_seconds},
         {"load_seconds", load_seconds},
         {"bytes", searcher->index.bytes()}});
}

} // namespace

Command add_closest_command(CLI::App& app)
{
    CLI::App* const parser = app.add_subcommand(
        "closest", "Find the closest vertex, edge or face of a mesh for each point");
    const auto options = std::make_shared<ClosestOptions>();
    add_model_option(*parser, options->model, ModelKinds::meshes_and_indexes);
    add_point_options(*parser, options->points);
    add_rows_option(*parser, options->out);
    parser->add_flag("--signed", options->is_signed,
                     "Add the signed distance, negative inside, and how the sign was found");
    parser->add_flag("--lists", options->lists,
                     "Build closest-feature lists: the same answers, a bound on the slowest query, "
                     "a much longer build");
    add_list_budget_option(*parser, options->lists_mb);
    add_query_method_option(*parser, options->method,
                            "its proximity octree, of convex meshes, for points outside");
    parser
        ->add_option("--depth", options->thesis.depth,
                     "Depth of the thesis's octree, the root is 0")
        ->check(CLI::Range(0, max_octree_depth))
        ->capture_default_str()
        ->type_name("N");
    parser->add_option("--save", options->thesis.save, "Write the thesis's octree")
        ->type_name("FILE.pxv");
    parser->add_option("--octree", options->thesis.octree, "Search this saved octree of the thesis")
        ->type_name("FILE.pxv");
    parser->callback([parser, options] {
        check_points_given(options->points);
        check_method_options(*parser, options->method);
    });
    refuse_beside_index_file(*parser, options->model, {"--lists", "--lists-mb"});
    return {parser, [options](Session& session) { return run_closest(*options, session); }};
}

} // namespace proxima
