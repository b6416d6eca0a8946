// The closest point of a mesh: ours beside Embree's point query, CGAL's AABB tree and brute force.
// Run by scripts/bench proximity, which prints the tables of one run.
//
//     proximity_bench [--queries N] [--rounds N] [--seed N] [--mesh NAME]... [--curve] [--out FILE]
//     proximity_bench --totals [--most N] ...
//
// Exits with status 1 where a distance is wrong by more than answer_tolerance.
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
#include <functional>
#include <numeric>

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

/// Builds of a peer, of which the median is taken: at least so many, or until they took so long.
constexpr int least_builds = 3;
constexpr double enough_build_seconds = 12;

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

using MakeContender = std::function<Result<std::unique_ptr<Contender>>()>;

/// A peer made by make_contender(), asked at most so many queries of a set, 0: all.
template <ClosestPointPeer P, class... Arguments>
MakeContender maker_of(const char* name, std::size_t at_most, const TriangleMesh& mesh,
                       Arguments... arguments)
{
    return [=, &mesh]() -> Result<std::unique_ptr<Contender>> {
        auto contender = make_contender<P>(name, mesh, arguments...);
        contender->at_most = at_most;
        return contender;
    };
}

std::vector<MakeContender> all_makers(const TriangleMesh& mesh, std::size_t queries)
{
    std::vector<MakeContender> all;
    const std::uint64_t usual = default_list_bytes(mesh.triangle_count()) / mesh.triangle_count();
    for (const std::uint64_t list_bytes : {std::uint64_t{0}, usual})
        all.emplace_back([&mesh, list_bytes] { return make_proxima_peer(mesh, list_bytes); });
    all.emplace_back([&mesh] { return make_warm_proxima_peer(mesh); });
#ifdef PROXIMA_BENCH_EMBREE
    all.push_back(maker_of<EmbreePeer>("embree", 0, mesh, FirstRadius::infinite));
    all.push_back(maker_of<WarmEmbreePeer>("embree-warm", 0, mesh));
#else
    say("skipped: Embree, not found when this was built");
#endif
#ifdef PROXIMA_BENCH_CGAL
    all.push_back(maker_of<CgalPeer>("cgal", std::max<std::size_t>(queries / 10, 1), mesh));
#else
    say("skipped: CGAL, not found when this was built");
#endif
    const std::size_t most =
        std::clamp<std::size_t>(brute_distances / mesh.triangle_count(), 10, queries);
    all.push_back(maker_of<BruteForcePeer>("brute-force", most, mesh));
    return all;
}

/// Builds all peers in turn, starting with another one each round; none again whose builds took
/// enough_build_seconds. Their build_seconds are medians.
std::vector<std::unique_ptr<Contender>> build_in_turn(const std::vector<MakeContender>& makers,
                                                      int rounds, int first_round = 0)
{
    std::vector<std::unique_ptr<Contender>> built(makers.size());
    std::vector<std::vector<double>> seconds(makers.size());
    for (int round = 0; round < rounds; ++round) {
        for (std::size_t turn = 0; turn < makers.size(); ++turn) {
            const std::size_t i =
                (turn + static_cast<std::size_t>(first_round + round)) % makers.size();
            const double spent = std::accumulate(seconds[i].begin(), seconds[i].end(), 0.0);
            if (spent > enough_build_seconds) continue;
            built[i].reset();
            auto made = makers[i]();
            if (made) {
                built[i] = std::move(*made);
                seconds[i].push_back(built[i]->build_seconds);
            } else if (round == 0) {
                say("skipped: " + describe(made.error()));
            }
        }
    }
    for (std::size_t i = 0; i < built.size(); ++i) {
        if (!built[i]) continue;
        built[i]->build_seconds = median(seconds[i]);
        built[i]->builds = seconds[i].size();
    }
    std::erase(built, nullptr);
    return built;
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
                 {"build_seconds", contender.build_seconds},
                 {"builds", contender.builds}};
    for (const BytePart& part : contender.byte_parts()) json["byte_parts"][part.name] = part.bytes;
    for (std::size_t s = 0; s < sets.size(); ++s) {
        const SetResult& set = result.sets[s];
        json["sets"][sets[s].name] = {
            {"queries", set.queries},       {"single", set.single},
            {"batch", set.batch},           {"p50", set.tail.p50},
            {"p99", set.tail.p99},          {"p99.99", set.tail.p9999},
            {"max", set.tail.worst},        {"deviation", set.agreement.deviation},
            {"wrong", set.agreement.wrong}, {"hash", hexadecimal(set.hash)}};
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

std::size_t wrong_answers(const RaceResult& result)
{
    std::size_t wrong = 0;
    for (const SetResult& set : result.sets) wrong += set.agreement.wrong;
    return wrong;
}

/// How many answers were wrong.
std::size_t race_on(const TriangleMesh& mesh, const std::array<QuerySet, 3>& sets,
                    const BenchOptions& options, Json& report)
{
    const auto contenders =
        build_in_turn(all_makers(mesh, options.queries), std::max(options.rounds, least_builds));
    const auto results = race(mesh, contenders, sets, {.rounds = options.rounds});
    std::size_t wrong = 0;
    for (std::size_t i = 0; i < results.size(); ++i) {
        report["methods"].push_back(json_of(*contenders[i], results[i], sets));
        wrong += wrong_answers(results[i]);
    }
    return wrong;
}

/// Ours alone, once for every budget. How many answers were wrong.
Result<std::size_t> draw_curve(const TriangleMesh& mesh, const std::array<QuerySet, 3>& sets,
                               const BenchOptions& options, Json& report)
{
    std::size_t wrong = 0;
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
        wrong += wrong_answers(results[0]);
    }
    return wrong;
}

/// The seconds that this peer takes for so many points of a set, those of a large number in chunks
/// of what there are. As a batch where it takes those and there is more than one. Keeps the answers
/// of the first points, as many as there is room for.
double seconds_to_answer(Contender& contender, std::span<const Vec3> points, std::size_t count,
                         std::span<PeerAnswer> answers)
{
    const double start = processor_seconds();
    for (std::size_t left = count; left > 0;) {
        const std::size_t now = std::min(left, points.size());
        if (count == 1) {
            contender.answer_singly(points.first(now), answers.first(now));
        } else {
            contender.answer_batch(points.first(now), answers.first(now));
        }
        left -= now;
    }
    return processor_seconds() - start;
}

/// What one peer took in the rounds of --totals.
struct TotalsRow {
    std::string name;
    std::vector<double> builds;
    std::array<std::vector<std::vector<double>>, 3> totals; ///< by set and count, of the rounds
    std::array<Agreement, 3> agreements;                    ///< by set
};

/// Asks all peers so many points of a set, in turn, and compares their answers.
void add_totals(const TriangleMesh& mesh, std::span<const std::unique_ptr<Contender>> contenders,
                const QuerySet& set, std::size_t count, int round,
                const std::function<void(std::size_t, double, const Agreement&)>& add)
{
    std::vector<std::vector<PeerAnswer>> answers(contenders.size());
    std::vector<double> seconds(contenders.size());
    std::vector<GivenAnswers> given(contenders.size());
    for (std::size_t turn = 0; turn < contenders.size(); ++turn) {
        const std::size_t i = (turn + static_cast<std::size_t>(round)) % contenders.size();
        Contender& contender = *contenders[i];
        // What takes no batches of points is asked no more than it can answer in time.
        if (contender.at_most != 0 && count > contender.at_most) continue;
        answers[i].resize(std::min(set.points.size(), count));
        seconds[i] = seconds_to_answer(contender, set.points, count, answers[i]);
        given[i] = {set.points, {}, answers[i]};
    }
    const auto agreements = compare(mesh, given, set.points.size());
    for (std::size_t i = 0; i < contenders.size(); ++i)
        if (!answers[i].empty()) add(i, seconds[i], agreements[i]);
}

void print_rows(std::span<const TotalsRow> rows, const std::array<QuerySet, 3>& sets,
                std::span<const std::size_t> counts)
{
    (void)std::printf("  %-14s%3s%10s", "", "set", "build");
    for (const std::size_t count : counts) (void)std::printf("%11zu", count);
    (void)std::printf("%9s%7s\n", "off", "wrong");
    for (std::size_t s = 0; s < sets.size(); ++s) {
        for (const TotalsRow& row : rows) {
            (void)std::printf("  %-14s%3s%10.4f", row.name.c_str(), sets[s].name,
                              median(row.builds));
            for (const std::vector<double>& totals : row.totals[s]) {
                if (totals.empty()) {
                    (void)std::printf("%11s", "-");
                } else {
                    (void)std::printf("%11.4f", median(totals));
                }
            }
            const Agreement& agreement = row.agreements[s];
            (void)std::printf("%9.1e%7zu\n", agreement.deviation, agreement.wrong);
        }
    }
}

/// Builds all peers anew in every round; medians of build and answers together. How many answers
/// were wrong.
std::size_t print_totals(const TriangleMesh& mesh, const std::string& label,
                         const std::array<QuerySet, 3>& sets, const BenchOptions& options)
{
    std::vector<std::size_t> counts;
    for (std::size_t count = 1; count <= options.most; count *= 100) counts.push_back(count);
    const auto makers = all_makers(mesh, options.queries);
    std::vector<TotalsRow> rows;
    for (int round = 0; round < options.rounds; ++round) {
        const auto contenders = build_in_turn(makers, 1, round);
        rows.resize(contenders.size());
        for (std::size_t i = 0; i < contenders.size(); ++i) {
            rows[i].name = contenders[i]->name;
            rows[i].builds.push_back(contenders[i]->build_seconds);
        }
        for (std::size_t s = 0; s < sets.size(); ++s) {
            for (TotalsRow& row : rows) row.totals[s].resize(counts.size());
            for (std::size_t k = 0; k < counts.size(); ++k) {
                add_totals(mesh, contenders, sets[s], counts[k], round,
                           [&](std::size_t i, double seconds, const Agreement& agreement) {
                               rows[i].totals[s][k].push_back(rows[i].builds.back() + seconds);
                               rows[i].agreements[s].add(agreement);
                           });
            }
        }
    }
    (void)std::printf("%s: %zu triangles. Seconds from the mesh to the last answer, one thread, "
                      "medians of %d rounds; the most that a distance is off over the diagonal, "
                      "and how many are off by over %g\n",
                      label.c_str(), mesh.triangle_count(), options.rounds, answer_tolerance);
    print_rows(rows, sets, counts);
    std::size_t wrong = 0;
    for (const TotalsRow& row : rows)
        for (const Agreement& agreement : row.agreements) wrong += agreement.wrong;
    return wrong;
}

/// How many answers were wrong.
Result<std::size_t> run_mesh(const std::string& name, const BenchOptions& options, Json& report)
{
    const auto mesh = is_sample_mesh_name(name) ? sample_mesh(name) : read_mesh(name);
    if (!mesh) return tl::unexpected(mesh.error());
    const auto box = checked_bounding_box(*mesh);
    if (!box) return tl::unexpected(box.error());
    const std::string label =
        is_sample_mesh_name(name) ? name : std::filesystem::path(name).filename().string();
    say(concat(label, ": ", mesh->triangle_count(), " triangles"));
    const auto sets = query_sets(*mesh, options.queries, options.seed);
    if (options.totals) return print_totals(*mesh, label, sets, options);
    Json json = {{"name", label},
                 {"triangles", mesh->triangle_count()},
                 {"diagonal", box->extent().norm()},
                 {"load_before", load_averages()}};
    auto wrong = options.curve ? draw_curve(*mesh, sets, options, json)
                               : Result<std::size_t>(race_on(*mesh, sets, options, json));
    json["load_after"] = load_averages();
    report["meshes"].push_back(std::move(json));
    return wrong;
}

int run(const BenchOptions& options)
{
    Json report = {{"processor", processor()},
                   {"queries", options.queries},
                   {"rounds", options.rounds},
                   {"seed", options.seed}};
    std::size_t wrong = 0;
    for (const std::string& name : options.meshes.empty() ? default_meshes() : options.meshes) {
        const auto of_mesh = run_mesh(name, options, report);
        if (!of_mesh) {
            say(describe(of_mesh.error()));
            return 1;
        }
        wrong += *of_mesh;
    }
    if (!options.totals) {
        std::ofstream file(options.out);
        file << report.dump(2) << '\n';
        if (!file.flush()) {
            say(options.out + ": cannot be written");
            return 1;
        }
    }
    if (wrong == 0) return 0;
    (void)std::fprintf(stderr, "failed: %zu answers are off by more than %g of the diagonal\n",
                       wrong, answer_tolerance);
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
