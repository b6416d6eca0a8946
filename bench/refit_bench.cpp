// What bringing a mesh index with lists up to date costs when vertices moved, beside building it
// again, and what its queries cost afterwards. Run by scripts/bench refit [MESH] [--rounds N].
//
// Each round builds, refits, and asks both indices the same queries, one after the other. Medians
// of processor time.
//
//     scattered   vertices anywhere, each by 1e-3 of the diagonal
//     together    as many about one place
//     pays        queries of set a after which building again would have been cheaper

#include "bench_program.h"
#include "index/index_parts.h"
#include "index/lists/proximity_lists.h"
#include "lab/query_sets.h"
#include "proxima/closest_feature.h"
#include "proxima/mesh_index.h"
#include "proxima/mesh_io.h"
#include "proxima/sample_meshes.h"

#include <CLI/CLI.hpp>
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <numeric>
#include <random>
#include <string>
#include <vector>

namespace proxima::bench {
namespace {

constexpr std::uint64_t seed = 5;
constexpr std::size_t queries = 100000;

const Execution one_thread{.threads = {1}};

Result<MeshIndex> build_with_lists(const TriangleMesh& mesh)
{
    const auto index = build_mesh_index(mesh, {.execution = one_thread});
    return index ? with_lists(*index, {.execution = one_thread}) : index;
}

enum class Spread : std::uint8_t { scattered, together };

/// `part` of the vertices moved by 1e-3 of the diagonal.
TriangleMesh moved_mesh(const TriangleMesh& mesh, double part, Spread spread)
{
    std::mt19937_64 random(seed);
    std::normal_distribution<double> normal;
    std::vector<Vec3> positions(mesh.positions().begin(), mesh.positions().end());
    std::vector<std::size_t> order(positions.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    if (spread == Spread::scattered) {
        std::shuffle(order.begin(), order.end(), random);
    } else {
        const Vec3 place = positions[positions.size() / 3];
        std::ranges::sort(
            order, {}, [&](std::size_t i) { return (mesh.positions()[i] - place).squaredNorm(); });
    }
    const double step = 1e-3 * bounding_box(mesh).extent().norm();
    const auto count = static_cast<std::size_t>(part * static_cast<double>(order.size()));
    for (std::size_t i = 0; i < std::max<std::size_t>(count, 1); ++i) {
        const Vec3 direction(normal(random), normal(random), normal(random));
        positions[order[i]] += step * direction.normalized();
    }
    const auto triangles = mesh.triangles();
    return make_triangle_mesh(std::move(positions), {triangles.begin(), triangles.end()}).value();
}

/// Mean nanoseconds of a query, of one pass over the points.
double query_time(const MeshIndex& index, std::span<const Vec3> points)
{
    const double start = processor_seconds();
    for (const Vec3& p : points) {
        ClosestFeature found = *closest_feature(index, p);
        benchmark::DoNotOptimize(found);
    }
    return 1e9 * (processor_seconds() - start) / static_cast<double>(points.size());
}

/// What was measured in each round.
struct RefitTimes {
    std::vector<double> build; ///< seconds
    std::vector<double> refit;
    std::vector<double> built_query; ///< nanoseconds
    std::vector<double> refitted_query;
};

/// Adds a round: each step in turn, starting with the refitted one in odd rounds. Returns the
/// refitted index.
Result<MeshIndex> add_round(const MeshIndex& before, const TriangleMesh& moved,
                            const Topology& topology, std::span<const Vec3> points, int round,
                            RefitTimes& times)
{
    Result<MeshIndex> built = MeshIndex{};
    Result<MeshIndex> refitted = MeshIndex{};
    const auto build = [&] {
        const double start = processor_seconds();
        built = build_with_lists(moved);
        times.build.push_back(processor_seconds() - start);
    };
    const auto refit = [&] {
        const double start = processor_seconds();
        refitted = refit_index(before, moved, topology, {.execution = one_thread});
        times.refit.push_back(processor_seconds() - start);
    };
    const auto ask_built = [&] { times.built_query.push_back(query_time(*built, points)); };
    const auto ask_refitted = [&] {
        times.refitted_query.push_back(query_time(*refitted, points));
    };
    if (round % 2 == 0) {
        build();
        refit();
    } else {
        refit();
        build();
    }
    if (!built || !refitted) return built ? refitted : built;
    if (round % 2 == 0) {
        ask_built();
        ask_refitted();
    } else {
        ask_refitted();
        ask_built();
    }
    return refitted;
}

Status print_row(const TriangleMesh& mesh, const MeshIndex& before, const Topology& topology,
                 double part, Spread spread, int rounds)
{
    const TriangleMesh moved = moved_mesh(mesh, part, spread);
    const auto points = query_sets(moved, queries, seed)[0].points;
    RefitTimes times;
    ProximityStatistics counts;
    for (int round = 0; round < rounds; ++round) {
        const auto refitted = add_round(before, moved, topology, points, round, times);
        if (!refitted) return tl::unexpected(refitted.error());
        counts = refitted->parts().lists()->statistics();
    }
    const double build = median(times.build);
    const double refit = median(times.refit);
    const double slow = median(times.refitted_query);
    const double fast = median(times.built_query);
    std::printf("%5.1f %% %s %9.2f %9.3f %8.1fx %6.1f%% %10.0f %10.0f %10.2g\n", 100 * part,
                spread == Spread::scattered ? "scattered" : "together ", build, refit,
                build / refit,
                100 * static_cast<double>(counts.stale_leaves) / static_cast<double>(counts.leaves),
                slow, fast, slow > fast ? (build - refit) * 1e9 / (slow - fast) : 1e99);
    std::fflush(stdout);
    return {};
}

Status measure(const std::string& name, int rounds)
{
    const auto mesh = is_sample_mesh_name(name) ? sample_mesh(name) : read_mesh(name);
    if (!mesh) return tl::unexpected(mesh.error());
    const auto topology = build_topology(*mesh);
    if (!topology) return tl::unexpected(topology.error());
    const auto before = build_with_lists(*mesh);
    if (!before) return tl::unexpected(before.error());
    std::printf("%s: %zu triangles, seed %llu, one thread, processor time, medians of %d rounds\n",
                name.c_str(), mesh->triangle_count(), static_cast<unsigned long long>(seed),
                rounds);
    std::puts(
        "moved             build s   refit s   cheaper   stale   refit ns   built ns       pays");
    for (const double part : {0.001, 0.01, 0.1}) {
        for (const Spread spread : {Spread::scattered, Spread::together}) {
            if (auto status = print_row(*mesh, *before, *topology, part, spread, rounds); !status)
                return status;
        }
    }
    return {};
}

int run(const std::string& name, int rounds)
{
    const Status status = measure(name, rounds);
    if (status) return 0;
    std::fprintf(stderr, "%s\n", describe(status.error()).c_str());
    return 1;
}

} // namespace
} // namespace proxima::bench

int main(int argc, char** argv)
{
    const std::string bunny = "/usr/share/glmark2/models/bunny.obj";
    std::string mesh = std::filesystem::exists(bunny) ? bunny : "torus:200x100";
    int rounds = 3;
    return proxima::bench::run_program(
        argc, argv, "Refitting an index beside building it again",
        [&](CLI::App& app) {
            app.add_option("MESH", mesh, "A file or a built-in instead of the usual mesh");
            app.add_option("--rounds", rounds, "Rounds, of which medians are taken")
                ->check(CLI::Range(1, 1000));
        },
        [&] { return proxima::bench::run(mesh, rounds); });
}
