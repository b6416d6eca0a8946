#include "cli/thesis_closest_run.h"

#include "base/parallel.h"
#include "cli/answer_table.h"
#include "cli/model_options.h"
#include "cli/names.h"
#include "cli/number_table.h"
#include "cli/row_writer.h"
#include "cli/stopwatch.h"
#include "thesis/proximity_octree/thesis_closest.h"
#include "thesis/proximity_octree/thesis_proximity_file.h"

#include <algorithm>
#include <fmt/core.h>
#include <nlohmann/json.hpp>
#include <optional>
#include <vector>

namespace proxima {

namespace {

constexpr std::size_t points_per_task = 1024;

/// What answers.
struct Searcher {
    TriangleMesh mesh;
    Topology topology;
    ThesisProximityOctree octree;
    double seconds = 0; ///< building or opening
};

/// Error invalid_argument where the octree is of another mesh.
Status check_mesh_of(const ThesisProximityOctree& octree, const TriangleMesh& mesh,
                     const Topology& topology, const std::string& path)
{
    if (fits_mesh(octree, mesh, topology)) return {};
    const FeatureCounts& features = octree.features();
    return fail(ErrorCode::invalid_argument,
                fmt::format("this octree is of another model, or of this one before it changed, of "
                            "{} vertices, {} edges and {} triangles: name that model, or build the "
                            "octree again",
                            features.vertices, features.edges, features.faces),
                path);
}

Result<Searcher> prepare(const ThesisClosestOptions& options, Session& session)
{
    auto mesh = session.load_model(options.model);
    if (!mesh) return tl::unexpected(mesh.error());
    const ProgressBar shown(session.progress(), session.bar());
    Progress* const progress = &session.progress();
    auto topology =
        build_topology(*mesh, {.execution = {.threads = session.threads(), .progress = progress}});
    if (!topology) return at_model(topology.error(), options.model);
    const Stopwatch watch;
    auto octree = options.octree.empty()
                      ? build_thesis_proximity_octree(
                            *mesh, *topology,
                            {.max_depth = options.depth,
                             .execution = {.threads = session.threads(), .progress = progress}})
                      : load_thesis_proximity_octree(options.octree, progress);
    const double seconds = watch.seconds();
    if (!octree) {
        return options.octree.empty() ? at_model(octree.error(), options.model)
                                      : tl::unexpected(octree.error());
    }
    if (!options.octree.empty()) {
        if (Status status = check_mesh_of(*octree, *mesh, *topology, options.octree); !status)
            return tl::unexpected(status.error());
    }
    if (!options.save.empty()) {
        if (Status status = save_thesis_proximity_octree(*octree, options.save, progress); !status)
            return tl::unexpected(status.error());
    }
    return Searcher{std::move(*mesh), std::move(*topology), std::move(*octree), seconds};
}

using Answers = std::vector<std::optional<ClosestFeature>>;

Answers answer(const Searcher& searcher, const NumberTable& table, Session& session)
{
    Answers answers(table.rows());
    const ProgressBar shown(session.progress(), session.bar());
    session.progress().begin_stage("closest features", table.rows());
    parallel_chunks(
        table.rows(), points_per_task, session.threads(), [&](std::size_t first, std::size_t end) {
            if (session.progress().cancelled()) return;
            for (std::size_t i = first; i < end; ++i) {
                const double* const row = table.values.data() + 3 * i;
                answers[i] = closest_feature(searcher.octree, searcher.mesh, searcher.topology,
                                             {row[0], row[1], row[2]});
            }
            session.progress().advance(end - first);
        });
    return answers;
}

Status write_answers(const Answers& answers, std::size_t answered, const std::string& path,
                     Session& session)
{
    auto writer = RowWriter::open(path);
    if (!writer) return tl::unexpected(writer.error());
    if (Status status =
            writer->write(answer_header(writer->format(), AnswerSigns::absent, answered));
        !status)
        return status;
    const auto rows = [&](std::size_t first, std::size_t end) {
        std::string text;
        for (std::size_t i = first; i < end; ++i) {
            if (answers[i])
                text += answer_rows(writer->format(), i, std::span(&*answers[i], 1), {});
        }
        return text;
    };
    Status status = writer->write_chunks(answers.size(), points_per_task, session.threads(), rows);
    return status ? writer->commit() : status;
}

} // namespace

Status run_thesis_closest(const ThesisClosestOptions& options, Session& session)
{
    if (Status status = check_rows(options.out, session, {options.save}); !status) return status;
    if (Status status = check_extension(options.save, thesis_proximity_extension); !status)
        return status;
    const auto table = read_points(options.points, session);
    if (!table) return tl::unexpected(table.error());
    const auto searcher = prepare(options, session);
    if (!searcher) return tl::unexpected(searcher.error());
    const Stopwatch watch;
    const Answers answers = answer(*searcher, *table, session);
    const double seconds = watch.seconds();
    if (Status status = session.check_running(); !status) return status;
    const auto answered = static_cast<std::size_t>(
        std::ranges::count_if(answers, [](const auto& each) { return each.has_value(); }));
    if (Status status = write_answers(answers, answered, options.out, session); !status)
        return status;
    const double each = 1e9 * seconds / static_cast<double>(table->rows());
    if (options.out != to_stdout) {
        session.print(fmt::format(
            "{}: {} triangles, the thesis's proximity octree of {:.2f} MB {} in {:.3f} s\n"
            "{} points in {:.3g} ms, {:.0f} ns each; {} answered, the others are inside the mesh "
            "or outside the root\n",
            options.model, searcher->mesh.triangle_count(),
            1e-6 * static_cast<double>(searcher->octree.bytes()),
            options.octree.empty() ? "built" : "opened", searcher->seconds, table->rows(),
            1e3 * seconds, each, answered));
        for (const std::string& path : {options.out, options.save})
            if (!path.empty()) session.print(fmt::format("wrote {}\n", path));
    }
    nlohmann::ordered_json build_seconds;
    nlohmann::ordered_json load_seconds;
    (options.octree.empty() ? build_seconds : load_seconds) = searcher->seconds;
    return session.write_json({{"model", options.model},
                               {"triangles", searcher->mesh.triangle_count()},
                               {"method", "thesis"},
                               {"queries", table->rows()},
                               {"answered", answered},
                               {"seconds", seconds},
                               {"ns_per_query", each},
                               {"build_seconds", build_seconds},
                               {"load_seconds", load_seconds},
                               {"bytes", searcher->octree.bytes()}});
}

} // namespace proxima
