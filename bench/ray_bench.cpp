// Rays against one mesh after the other, ours beside Embree: passes in turn, medians and ratios.
//
//     ray_bench [--rays N] [--rounds N] [--seed N] [--mesh NAME]...
//
// Every row of hits is compared with ours: another triangle at another t, or a miss where we hit,
// is counted. Prints tables; one thread.
#include "bench_program.h"
#include "proxima/mesh_io.h"
#include "proxima/sample_meshes.h"
#include "ray_peers.h"
#include "ray_sets.h"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <filesystem>

namespace proxima::bench {
namespace {

struct BenchOptions : CommonOptions {
    std::size_t rays = 1'000'000;
};

using Pass = void (RayPeer::*)();
struct PassKind {
    const char* name;
    Pass pass;
    bool closest;
};
constexpr std::array<PassKind, 4> pass_kinds = {
    {{"closest", &RayPeer::cast_closest, true},
     {"closest batch", &RayPeer::cast_closest_together, true},
     {"any", &RayPeer::cast_any, false},
     {"any batch", &RayPeer::cast_any_together, false}}};

/// What a peer did on one set by one kind of pass.
struct PassResult {
    std::vector<double> seconds;
    std::size_t hits = 0;
    std::size_t different = 0; ///< from ours: hit or not, or t by more than floats round
};

bool differs(const PeerHit& a, const PeerHit& b)
{
    if ((a.triangle == PeerHit::none) != (b.triangle == PeerHit::none)) return true;
    constexpr double float_noise = 1e-4;
    return a.triangle != PeerHit::none && a.triangle != b.triangle &&
           std::abs(a.t - b.t) > float_noise * std::abs(b.t);
}

void race(const RaySet& set, std::span<const std::unique_ptr<RayPeer>> peers, int rounds)
{
    std::vector<std::array<PassResult, pass_kinds.size()>> results(peers.size());
    std::vector<PeerHit> ours(set.rays.size());
    for (int round = 0; round < rounds; ++round) {
        for (std::size_t turn = 0; turn < peers.size(); ++turn) {
            // Ours goes first in the first round: what it finds is compared with.
            const std::size_t i = (turn + static_cast<std::size_t>(round)) % peers.size();
            RayPeer& peer = *peers[i];
            for (std::size_t k = 0; k < pass_kinds.size(); ++k) {
                peer.prepare(set.rays, set.coherence);
                const double start = processor_seconds();
                (peer.*pass_kinds[k].pass)();
                PassResult& result = results[i][k];
                result.seconds.push_back(processor_seconds() - start);
                if (round > 0) continue;
                for (std::size_t ray = 0; ray < set.rays.size(); ++ray) {
                    if (!pass_kinds[k].closest) {
                        const bool hit = peer.was_hit(ray);
                        result.hits += hit ? 1 : 0;
                        result.different += hit != (ours[ray].triangle != PeerHit::none) ? 1 : 0;
                        continue;
                    }
                    const PeerHit hit = peer.hit(ray);
                    if (i == 0 && k == 0) ours[ray] = hit;
                    result.hits += hit.triangle != PeerHit::none ? 1 : 0;
                    result.different += differs(hit, ours[ray]) ? 1 : 0;
                }
            }
        }
    }
    std::printf("  %-11s", set.name);
    for (const PassKind& kind : pass_kinds) std::printf("%22s", kind.name);
    std::printf("   (million rays a second, ours over it)\n");
    const auto count = static_cast<double>(set.rays.size());
    for (std::size_t i = 0; i < peers.size(); ++i) {
        std::printf("    %-14s", peers[i]->name().c_str());
        for (std::size_t k = 0; k < pass_kinds.size(); ++k) {
            const double own = median(results[0][k].seconds);
            const double other = median(results[i][k].seconds);
            std::printf("%12.2f (%5.2f x)", 1e-6 * count / other, other / own);
        }
        std::printf("   hits %zu", results[i][0].hits);
        for (const PassResult& result : results[i]) std::printf(" %zu", result.different);
        std::printf(" different\n");
    }
}

/// Builds every peer `rounds` times, interleaved, and prints medians of processor time.
std::vector<std::unique_ptr<RayPeer>> build_peers(const TriangleMesh& mesh, int rounds)
{
    using MakePeer = std::unique_ptr<RayPeer> (*)(const TriangleMesh& mesh);
    const std::vector<MakePeer> makers{
        [](const TriangleMesh& of) { return make_proxima_ray_peer(of); },
#ifdef PROXIMA_BENCH_EMBREE
        [](const TriangleMesh& of) { return make_embree_ray_peer(of, EmbreeMode::robust); },
        [](const TriangleMesh& of) { return make_embree_ray_peer(of, EmbreeMode::fast); },
#endif
    };
    std::vector<std::unique_ptr<RayPeer>> peers(makers.size());
    std::vector<std::vector<double>> seconds(makers.size());
    for (int round = 0; round < rounds; ++round) {
        for (std::size_t i = 0; i < makers.size(); ++i) {
            peers[i].reset();
            const double start = processor_seconds();
            peers[i] = makers[i](mesh);
            seconds[i].push_back(processor_seconds() - start);
        }
    }
    for (std::size_t i = 0; i < peers.size(); ++i) {
        std::printf(
            "    %-14s built in %.4f s (%.2f x), %.1f bytes per triangle\n",
            peers[i]->name().c_str(), median(seconds[i]), median(seconds[i]) / median(seconds[0]),
            static_cast<double>(peers[i]->bytes()) / static_cast<double>(mesh.triangle_count()));
    }
    return peers;
}

int run_mesh(const std::string& name, const BenchOptions& options)
{
    const auto read = is_sample_mesh_name(name) ? sample_mesh(name) : read_mesh(name);
    if (!read) {
        std::fprintf(stderr, "%s\n", describe(read.error()).c_str());
        return 1;
    }
    const TriangleMesh mesh = rounded_to_floats(*read);
    std::printf("%s: %zu triangles\n", std::filesystem::path(name).filename().string().c_str(),
                mesh.triangle_count());
    const auto peers = build_peers(mesh, options.rounds);
    const auto side = static_cast<std::size_t>(std::sqrt(static_cast<double>(options.rays)));
    for (const RaySet& set : ray_sets(mesh, side, options.seed)) race(set, peers, options.rounds);
    std::fflush(stdout);
    return 0;
}

int run(const BenchOptions& options)
{
    std::printf("one thread, %zu rays a set from seed %llu, medians of %d interleaved rounds\n",
                options.rays, static_cast<unsigned long long>(options.seed), options.rounds);
    for (const std::string& name : meshes_of(options))
        if (const int status = run_mesh(name, options); status != 0) return status;
    return 0;
}

} // namespace
} // namespace proxima::bench

int main(int argc, char** argv)
{
    proxima::bench::BenchOptions options;
    return proxima::bench::run_program(
        argc, argv, "Rays against meshes, ours beside Embree",
        [&](CLI::App& app) {
            app.add_option("--rays", options.rays, "Rays of each set")
                ->check(CLI::Range(1, 100000000));
            add_common_options(app, options);
        },
        [&] { return proxima::bench::run(options); });
}
