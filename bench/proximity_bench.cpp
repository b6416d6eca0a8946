// The closest point of a mesh: ours beside Embree's point query, CGAL's AABB tree and brute force.
// Run by scripts/bench proximity, which prints the tables of one run.
//
//     proximity_bench [--queries N] [--rounds N] [--seed N] [--mesh NAME]... [--curve] [--out FILE]
//     proximity_bench --totals [--most N] ...
//
// Without --mesh: sphere:100x100, the bunny of Debian's glmark2-data, the dragon of 47,794
// triangles where a folder shared/meshes lies beside this one, and PROXIMA_BENCH_MESH. With
// --curve only ours, by its budget. With --totals the seconds in all from a mesh in memory to the
// last answer, for one point, a hundred, ten thousand and so on up to --most.

#include "base/text.h"
#include "bench_program.h"
#include "brute_force_peer.h"
#include "proxima/mesh_index.h"
#include "proxima/mesh_io.h"
#include "proxima/sample_meshes.h"
#include "proxima_peer.h"
#include "proximity_race.h"
#ifdef PROXIMA_BENCH_CGAL
#include "cgal_peer.h"
#endif
#ifdef PROXIMA_BENCH_EMBREE
#include "embree_peer.h"
#endif

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>

namespace proxima::bench {
namespace {

using Json = nlohmann::ordered_json;

struct BenchOptions {
    std::size_t queries = 1000000;
    int rounds = 5;
    std::uint64_t seed = 1;
    std::vector<std::string> meshes;
    bool curve = false;
    bool totals = false;
    std::size_t most = 1000000; ///< points of --totals
    std::string out = "proximity-bench.json";
};

/// Bytes per triangle that --curve builds with.
constexpr std::array<std::uint64_t, 10> curve_budgets = {100, 150,  200,  300,  400,
                                                         600, 1000, 2000, 5000, 12000};

/// Brute force is asked as many queries as make this many distances.
constexpr std::size_t brute_distances = 40'000'000;

void say(const std::string& text)
{
    (void)std::fprintf(stderr, "%s\n", text.c_str());
}

std::vector<std::string> default_meshes()
{
    std::vector<std::string> names = {"sphere:100x100"};
    for (const char* const file :
         {"/usr/share/glmark2/models/bunny.obj", "../shared/meshes/dragon_vrip_res3.ply"}) {
        if (std::filesystem::exists(file)) {
            names.emplace_back(file);
        } else {
            say(concat("skipped: no ", file));
        }
    }
    if (const char* const file = std::getenv("PROXIMA_BENCH_MESH"); file != nullptr) {
        names.emplace_back(file);
    } else {
        say("skipped: a mesh of your own, PROXIMA_BENCH_MESH is not set");
    }
    return names;
}

std::vector<std::unique_ptr<Contender>> all_contenders(const TriangleMesh& mesh,
                                                       std::size_t queries)
{
    std::vector<std::unique_ptr<Contender>> all;
    const std::uint64_t usual = default_list_bytes(mesh.triangle_count()) / mesh.triangle_count();
    for (const std::uint64_t list_bytes : {std::uint64_t{0}, usual}) {
        auto ours = make_proxima_peer(mesh, list_bytes);
        if (ours) {
            all.push_back(std::move(*ours));
        } else {
            say("skipped: " + describe(ours.error()));
        }
    }
#ifdef PROXIMA_BENCH_EMBREE
    all.push_back(make_contender<EmbreePeer>("embree", mesh, FirstRadius::infinite));
    all.push_back(make_contender<WarmEmbreePeer>("embree-warm", mesh));
#else
    say("skipped: Embree, not found when this was built");
#endif
#ifdef PROXIMA_BENCH_CGAL
    all.push_back(make_contender<CgalPeer>("cgal", mesh));
    all.back()->at_most = std::max<std::size_t>(queries / 10, 1);
#else
    say("skipped: CGAL, not found when this was built");
#endif
    all.push_back(make_contender<BruteForcePeer>("brute-force", mesh));
    all.back()->at_most =
        std::clamp<std::size_t>(brute_distances / mesh.triangle_count(), 10, queries);
    return all;
}

std::string hexadecimal(std::uint64_t value)
{
    char text[17];
    (void)std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(value));
    return text;
}

Json json_of(const Contender& contender, const RaceResult& result,
             const std::array<QuerySet, 3>& sets)
{
    Json json = {{"name", contender.name},
                 {"bytes", contender.bytes()},
                 {"build_seconds", contender.build_seconds}};
    for (std::size_t s = 0; s < sets.size(); ++s) {
        const SetResult& set = result.sets[s];
        json["sets"][sets[s].name] = {{"queries", set.queries}, {"single", set.single},
                                      {"batch", set.batch},     {"p50", set.tail.p50},
                                      {"p99", set.tail.p99},    {"p99.99", set.tail.p9999},
                                      {"max", set.tail.worst},  {"deviation", set.deviation},
                                      {"wrong", set.wrong},     {"hash", hexadecimal(set.hash)}};
    }
    return json;
}

Json load_averages()
{
    std::array<double, 3> load{};
    (void)getloadavg(load.data(), static_cast<int>(load.size()));
    return load;
}

std::string processor()
{
    std::ifstream file("/proc/cpuinfo");
    for (std::string line; std::getline(file, line);)
        if (line.starts_with("model name")) return line.substr(line.find(':') + 2);
    return {};
}

void race_on(const TriangleMesh& mesh, const std::array<QuerySet, 3>& sets,
             const BenchOptions& options, Json& report)
{
    const auto contenders = all_contenders(mesh, options.queries);
    const auto results = race(mesh, contenders, sets, {.rounds = options.rounds});
    for (std::size_t i = 0; i < results.size(); ++i)
        report["methods"].push_back(json_of(*contenders[i], results[i], sets));
}

/// Ours alone, once for every budget.
Status draw_curve(const TriangleMesh& mesh, const std::array<QuerySet, 3>& sets,
                  const BenchOptions& options, Json& report)
{
    for (const std::uint64_t budget : curve_budgets) {
        std::vector<std::unique_ptr<Contender>> ours;
        auto built = make_proxima_peer(mesh, budget);
        if (!built && built.error().code == ErrorCode::budget_exceeded) {
            say(concat("skipped: ", budget, " bytes per triangle: ", describe(built.error())));
            continue;
        }
        if (!built) return tl::unexpected(built.error());
        ours.push_back(std::move(*built));
        const auto results = race(mesh, ours, sets, {.rounds = options.rounds, .tail_passes = 0});
        Json row = json_of(*ours[0], results[0], sets);
        row["budget"] = budget;
        report["curve"].push_back(std::move(row));
    }
    return {};
}

/// The seconds that this peer takes for so many points of a set, those of a large number in chunks
/// of what there are. As a batch where it takes those and there is more than one.
double seconds_to_answer(Contender& contender, std::span<const Vec3> points, std::size_t count)
{
    std::vector<PeerAnswer> answers(std::min(points.size(), count));
    const double start = processor_seconds();
    for (std::size_t left = count; left > 0;) {
        const std::size_t now = std::min(left, points.size());
        if (count == 1) {
            contender.answer_singly(points.first(now), std::span(answers).first(now));
        } else {
            contender.answer_batch(points.first(now), std::span(answers).first(now));
        }
        left -= now;
    }
    return processor_seconds() - start;
}

/// Builds all peers anew in every round; medians of build and answers together.
void print_totals(const TriangleMesh& mesh, const std::string& label,
                  const std::array<QuerySet, 3>& sets, const BenchOptions& options)
{
    std::vector<std::size_t> counts;
    for (std::size_t count = 1; count <= options.most; count *= 100) counts.push_back(count);
    struct Row {
        std::vector<double> builds;
        /// By set and count, of the rounds.
        std::array<std::vector<std::vector<double>>, 3> totals;
    };
    std::vector<std::pair<std::string, Row>> rows;
    for (int round = 0; round < options.rounds; ++round) {
        const auto contenders = all_contenders(mesh, options.queries);
        rows.resize(contenders.size());
        for (std::size_t i = 0; i < contenders.size(); ++i) {
            const std::size_t at = (i + static_cast<std::size_t>(round)) % contenders.size();
            Contender& contender = *contenders[at];
            auto& [name, row] = rows[at];
            name = contender.name;
            row.builds.push_back(contender.build_seconds);
            for (std::size_t s = 0; s < sets.size(); ++s) {
                row.totals[s].resize(counts.size());
                for (std::size_t k = 0; k < counts.size(); ++k) {
                    // What takes no batches of points is asked no more than it can answer in time.
                    if (contender.at_most != 0 && counts[k] > contender.at_most) continue;
                    row.totals[s][k].push_back(
                        contender.build_seconds +
                        seconds_to_answer(contender, sets[s].points, counts[k]));
                }
            }
        }
    }
    (void)std::printf("%s: %zu triangles. Seconds from the mesh to the last answer, one thread, "
                      "medians of %d rounds\n",
                      label.c_str(), mesh.triangle_count(), options.rounds);
    (void)std::printf("  %-14s%3s%10s", "", "set", "build");
    for (const std::size_t count : counts) (void)std::printf("%11zu", count);
    (void)std::printf("\n");
    for (std::size_t s = 0; s < sets.size(); ++s) {
        for (const auto& [name, row] : rows) {
            (void)std::printf("  %-14s%3s%10.4f", name.c_str(), sets[s].name, median(row.builds));
            for (const std::vector<double>& totals : row.totals[s]) {
                if (totals.empty()) {
                    (void)std::printf("%11s", "-");
                } else {
                    (void)std::printf("%11.4f", median(totals));
                }
            }
            (void)std::printf("\n");
        }
    }
}

Status run_mesh(const std::string& name, const BenchOptions& options, Json& report)
{
    const auto mesh = is_sample_mesh_name(name) ? sample_mesh(name) : read_mesh(name);
    if (!mesh) return tl::unexpected(mesh.error());
    const auto box = checked_bounding_box(*mesh);
    if (!box) return tl::unexpected(box.error());
    const std::string label =
        is_sample_mesh_name(name) ? name : std::filesystem::path(name).filename().string();
    say(concat(label, ": ", mesh->triangle_count(), " triangles"));
    const auto sets = query_sets(*mesh, options.queries, options.seed);
    if (options.totals) {
        print_totals(*mesh, label, sets, options);
        return {};
    }
    Json json = {{"name", label},
                 {"triangles", mesh->triangle_count()},
                 {"diagonal", box->extent().norm()},
                 {"load_before", load_averages()}};
    if (options.curve) {
        if (auto status = draw_curve(*mesh, sets, options, json); !status) return status;
    } else {
        race_on(*mesh, sets, options, json);
    }
    json["load_after"] = load_averages();
    report["meshes"].push_back(std::move(json));
    return {};
}

int run(const BenchOptions& options)
{
    Json report = {{"processor", processor()},
                   {"queries", options.queries},
                   {"rounds", options.rounds},
                   {"seed", options.seed}};
    for (const std::string& name : options.meshes.empty() ? default_meshes() : options.meshes) {
        if (const auto status = run_mesh(name, options, report); !status) {
            say(describe(status.error()));
            return 1;
        }
    }
    if (options.totals) return 0;
    std::ofstream file(options.out);
    file << report.dump(2) << '\n';
    if (file.flush()) return 0;
    say(options.out + ": cannot be written");
    return 1;
}

} // namespace
} // namespace proxima::bench

int main(int argc, char** argv)
{
    proxima::bench::BenchOptions options;
    return proxima::bench::run_program(
        argc, argv, "The closest point of a mesh, ours beside Embree, CGAL and brute force",
        [&](CLI::App& app) {
            app.add_option("--queries", options.queries, "Points of each set")
                ->check(CLI::Range(1, 100000000));
            app.add_option("--rounds", options.rounds, "Passes, of which medians are taken")
                ->check(CLI::Range(1, 1000));
            app.add_option("--seed", options.seed, "Seed of the sets");
            app.add_option("--mesh", options.meshes,
                           "A file or a built-in instead of the usual meshes")
                ->allow_extra_args(false);
            app.add_flag("--curve", options.curve, "Speed against budget, ours alone");
            app.add_flag("--totals", options.totals,
                         "Seconds in all, build included, for 1 point, 100, 10000 and so on");
            app.add_option("--most", options.most, "The most points of --totals")
                ->check(CLI::Range(1, 100000000));
            app.add_option("--out", options.out, "The report, as JSON");
        },
        [&] { return proxima::bench::run(options); });
}
