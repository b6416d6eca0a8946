// Millions of random points, every answer of the proximity index checked: scripts/soak proximity.
//
//     proximity_soak [--points N] [--signs N] [--seed N] [--threads N] [--mesh NAME]...
//
// Every mesh is built within its usual budget and within one that leaves most leaves without a list. One row per mesh
// and kind of points; what the columns mean is in closest_check.h and sign_check.h. The same for
// the same seed, whatever the threads. Exit status 1 if anything was wrong.

#include "base/parallel.h"
#include "index/index_parts.h"
#include "index/listed_index.h"
#include "proxima/execution.h"
#include "proxima/mesh_index.h"
#include "query/closest/soak/closest_check.h"
#include "query/closest/soak/sign_check.h"
#include "query/closest/soak/soak_meshes.h"
#include "query/closest/soak/soak_points.h"

#include <CLI/CLI.hpp>

#include <chrono>
#include <cstdio>
#include <iostream>

namespace proxima::soak {
namespace {

struct SoakOptions {
    std::uint64_t points = 10'000'000;
    std::uint64_t signs = 1'000'000;
    std::uint64_t seed = 1;
    std::vector<std::string> meshes;
    Execution execution = {};
};

/// Points that a thread makes and checks at a time.
constexpr std::size_t chunk = 4096;

/// Of a hundred points of a mesh, by all_point_sets.
constexpr std::array shares = {30U, 30U, 30U, 10U};

/// Brute winding numbers of a mesh ask at most so many triangles.
constexpr std::uint64_t solid_angles = 200'000'000;

/// Seeds of a mesh's points do not depend on which other meshes are asked for.
constexpr std::uint64_t rows_per_mesh = 16;

/// A number of its own for every chunk.
std::uint64_t chunk_seed(std::uint64_t seed, std::uint64_t row, std::uint64_t place)
{
    std::seed_seq mixed = {seed, seed >> 32U, row, place};
    std::array<std::uint32_t, 2> words{};
    mixed.generate(words.begin(), words.end());
    return std::uint64_t{words[0]} << 32U | words[1];
}

/// Checks `count` points in chunks and adds up what they found, in order.
template <class Tally, class Check>
Tally check_points(const PointMaker& maker, PointSet set, std::uint64_t count, std::uint64_t seed,
                   std::uint64_t row, Threads threads, const Check& check)
{
    std::vector<Tally> tallies(chunk_count(count, chunk));
    parallel_for(tallies.size(), threads, [&](std::size_t i) {
        const std::size_t points = std::min<std::uint64_t>(chunk, count - i * chunk);
        tallies[i] = check.check(maker.make(set, points, chunk_seed(seed, row, i)));
    });
    Tally sum;
    for (const Tally& tally : tallies) sum.add(tally);
    return sum;
}

/// Within its usual budget, and within one that leaves most leaves without a list.
Result<std::vector<MeshIndex>> build_indexes(const TriangleMesh& mesh, Threads threads)
{
    std::vector<MeshIndex> indexes;
    auto usual = testing::listed_index(mesh, {.execution = {.threads = threads}});
    if (!usual) return tl::unexpected(usual.error());
    indexes.push_back(std::move(*usual));
    auto tight = testing::listed_index(
        mesh, {.list_bytes = 2048 + 20 * mesh.triangle_count(), .execution = {.threads = threads}});
    if (!tight) return tl::unexpected(tight.error());
    indexes.push_back(std::move(*tight));
    return indexes;
}

/// Whether every edge is passed as often in one way as in the other: the mesh has an inside.
bool is_closed(const TriangleMesh& mesh, const Topology& topology)
{
    std::vector<int> passes(topology.edge_count());
    for (std::uint32_t t = 0; t < mesh.triangle_count(); ++t) {
        const TriangleCorners& corners = mesh.triangles()[t];
        const auto& edges = topology.edges(TriangleId{t});
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t from = corners[k];
            const std::uint32_t to = corners[(k + 1) % 3];
            if (edges[k] != no_edge) passes[to_index(edges[k])] += from < to ? 1 : -1;
        }
    }
    return std::ranges::all_of(passes, [](int sum) { return sum == 0; });
}

/// One mesh after the other, and the sums.
class Soak {
public:
    explicit Soak(const SoakOptions& options) : options_(options) {}

    /// Returns the exit status.
    int run()
    {
        const std::vector<SoakMesh> meshes = soak_meshes(options_.seed);
        const auto is_asked = [&](const SoakMesh& mesh) {
            return options_.meshes.empty() ||
                   std::ranges::find(options_.meshes, mesh.name) != options_.meshes.end();
        };
        const auto asked = static_cast<std::size_t>(std::ranges::count_if(meshes, is_asked));
        if (asked == 0) {
            std::fprintf(stderr, "proximity_soak: no mesh has such a name\n");
            return 2;
        }
        std::printf("seed %llu, %llu points, %llu signs\n\n",
                    static_cast<unsigned long long>(options_.seed),
                    static_cast<unsigned long long>(options_.points),
                    static_cast<unsigned long long>(options_.signs));
        std::printf("%-22s %-12s %10s %6s %12s %8s %7s %6s %6s\n", "mesh", "points", "number",
                    "wrong", "worst error", "ties", "brute", "steps", "blocks");
        for (std::size_t i = 0; i < meshes.size(); ++i) {
            row_ = rows_per_mesh * i;
            if (is_asked(meshes[i])) run_mesh(meshes[i], asked);
        }
        print_row("all", "all", all_);
        print_signs("all", all_signs_);
        return all_.wrong == 0 && all_signs_.wrong == 0 && !failed_ ? 0 : 1;
    }

private:
    void run_mesh(const SoakMesh& named, std::size_t meshes)
    {
        const TriangleMesh mesh = named.make();
        if (mesh.triangle_count() == 0) {
            std::printf("%-22s skipped: the file is not there\n", named.name.c_str());
            return;
        }
        const auto topology = build_topology(mesh);
        if (!topology) return fail_mesh(named, topology.error());
        const auto index = build_mesh_index(mesh);
        if (!index) return fail_mesh(named, index.error());
        const auto indexes = build_indexes(mesh, options_.execution.threads);
        if (!indexes) return fail_mesh(named, indexes.error());

        const PointMaker maker(mesh, *topology, indexes->front());
        const ClosestCheck check({mesh, *topology, *index}, *indexes);
        for (std::size_t s = 0; s < all_point_sets.size(); ++s) {
            const std::uint64_t count = options_.points * shares[s] / (100 * meshes) + 1;
            const auto tally =
                check_points<ClosestTally>(maker, all_point_sets[s], count, options_.seed, ++row_,
                                           options_.execution.threads, check);
            print_row(named.name, name_of(all_point_sets[s]), tally);
            all_.add(tally);
        }
        const auto with = with_signs(indexes->front());
        if (!with) return fail_mesh(named, with.error());
        check_signs(named, {mesh, *with, is_closed(mesh, *topology)}, maker, meshes);
        (void)std::fflush(stdout);
    }

    struct SignedMesh {
        const TriangleMesh& mesh;
        const MeshIndex& index;
        bool closed;
    };
    void check_signs(const SoakMesh& named, const SignedMesh& of, const PointMaker& maker,
                     std::size_t meshes)
    {
        const SignCheck check(of.mesh, of.index, of.closed);
        std::uint64_t count = options_.signs / meshes + 1;
        if (!of.closed) count = std::min(count, solid_angles / of.mesh.triangle_count() + 1);
        SignTally sum;
        for (const PointSet set :
             {PointSet::volume, PointSet::near_surface, PointSet::boundaries}) {
            sum.add(check_points<SignTally>(maker, set, count / 3 + 1, options_.seed, ++row_,
                                            options_.execution.threads, check));
        }
        print_signs(named.name + (of.closed ? " (closed)" : " (open)"), sum);
        all_signs_.add(sum);
    }

    void fail_mesh(const SoakMesh& named, const Error& error)
    {
        std::printf("%-22s failed: %s\n", named.name.c_str(), describe(error).c_str());
        failed_ = true;
    }

    static void print_row(const std::string& mesh, std::string_view set, const ClosestTally& tally)
    {
        std::printf("%-22s %-12s %10llu %6llu %12.2e %8llu %7llu %5.0f%% %5.0f%%\n", mesh.c_str(),
                    std::string(set).c_str(), static_cast<unsigned long long>(tally.points),
                    static_cast<unsigned long long>(tally.wrong), tally.worst,
                    static_cast<unsigned long long>(tally.ties),
                    static_cast<unsigned long long>(tally.brute), 100 * tally.worst_steps,
                    100 * tally.worst_blocks);
        if (!tally.first_wrong.empty()) std::printf("    %s\n", tally.first_wrong.c_str());
    }

    static void print_signs(const std::string& mesh, const SignTally& tally)
    {
        std::printf("%-35s %10llu %6llu signs, %llu inside, %llu undecided\n", mesh.c_str(),
                    static_cast<unsigned long long>(tally.points),
                    static_cast<unsigned long long>(tally.wrong),
                    static_cast<unsigned long long>(tally.inside),
                    static_cast<unsigned long long>(tally.undecided));
        if (!tally.first_wrong.empty()) std::printf("    %s\n", tally.first_wrong.c_str());
    }

    const SoakOptions& options_;
    std::uint64_t row_ = 0; ///< of points made so far
    ClosestTally all_;
    SignTally all_signs_;
    bool failed_ = false;
};

} // namespace
} // namespace proxima::soak

int main(int argc, char** argv)
try {
    proxima::soak::SoakOptions options;
    CLI::App app("Millions of random points against brute force and exact signs");
    app.add_option("--points", options.points, "Closest features asked for, over all meshes");
    app.add_option("--signs", options.signs, "Signs asked for, over all meshes");
    app.add_option("--seed", options.seed, "Seed of points and random meshes");
    app.add_option("--threads", options.execution.threads.count, "0: all that the machine offers")
        ->check(CLI::Range(0, 1024));
    app.add_option("--mesh", options.meshes, "Only the mesh of this name, as printed")
        ->allow_extra_args(false);
    CLI11_PARSE(app, argc, argv);
    const auto begin = std::chrono::steady_clock::now();
    const int status = proxima::soak::Soak(options).run();
    const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - begin;
    std::printf("%.0f seconds\n", taken.count());
    return status;
} catch (const std::exception& error) {
    std::cerr << "proximity_soak: " << error.what() << '\n';
    return 1;
}
