// Rays against one mesh after the other, ours beside Embree: passes in turn, medians and ratios.
//
//     ray_bench [--rays N] [--rounds N] [--seed N] [--mesh NAME]...
//
// All answers are compared with our closest hits, and two numbers are printed for each kind of
// pass: how many differ (a hit instead of a miss, or another t), and how many of these floats do
// not explain. Floats explain a difference where the ray passes the edge of the triangle in
// question closer than they can tell. Exits with status 1 where they do not explain one. Prints
// tables; one thread.
#include "bench_program.h"
#include "geometry/closest_point.h"
#include "proxima/mesh_io.h"
#include "proxima/sample_meshes.h"
#include "ray_peers.h"
#include "ray_sets.h"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <vector>

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
    std::size_t different = 0;   ///< from ours
    std::size_t unexplained = 0; ///< different by more than floats explain; for ours, all that are
};

/// Compares hits with ours, which are found in double.
class HitComparison {
public:
    explicit HitComparison(const TriangleMesh& mesh) : mesh_(mesh), box_(bounding_box(mesh)) {}

    [[nodiscard]] static bool hits(const PeerHit& hit) { return hit.triangle != PeerHit::none; }

    /// Whether one hits and the other does not, or both at a t that floats tell apart.
    [[nodiscard]] static bool differs(const PeerHit& hit, const PeerHit& ours)
    {
        if (hits(hit) != hits(ours)) return true;
        return hits(hit) && std::abs(hit.t - ours.t) > relative_noise * std::abs(ours.t);
    }

    /// Whether floats explain that a peer hits at another t, or hits and we do not, or does not
    /// and we do. \pre differs(hit, ours)
    [[nodiscard]] bool is_float_noise(const Ray& ray, const PeerHit& hit, const PeerHit& ours) const
    {
        if (!hits(hit) && !hits(ours)) return false;
        const double noise =
            length_noise * (box_.extent().norm() + (ray.origin - box_.center()).norm());
        if (hits(hit) && !is_on(ray, hit, noise)) return false;
        // The nearer of both hits is the one that the other side does not have.
        const PeerHit& disputed = hit.t < ours.t ? hit : ours;
        return distance_to_sides(ray, mesh_.triangle(TriangleId{disputed.triangle})) <= noise;
    }

private:
    static constexpr double relative_noise = 1e-4; ///< of t
    static constexpr double length_noise = 1e-5;   ///< of the mesh's size and distance

    /// Whether the hit is a point of its triangle, or the ray passes the triangle's side, where t
    /// may be far off.
    [[nodiscard]] bool is_on(const Ray& ray, const PeerHit& hit, double noise) const
    {
        const Triangle triangle = mesh_.triangle(TriangleId{hit.triangle});
        const Vec3 point = ray.origin + hit.t * ray.direction;
        return (closest_point(triangle, point).point - point).norm() <= noise ||
               distance_to_sides(ray, triangle) <= noise;
    }

    /// How far the ray's line passes from the sides, as seen along the ray.
    [[nodiscard]] static double distance_to_sides(const Ray& ray, const Triangle& triangle)
    {
        const Vec3 along = ray.direction.normalized();
        std::array<Vec3, 3> seen;
        for (std::size_t i = 0; i < 3; ++i) {
            const Vec3 from_ray = triangle.vertices[i] - ray.origin;
            seen[i] = from_ray - along.dot(from_ray) * along;
        }
        double least = std::numeric_limits<double>::infinity();
        for (std::size_t i = 0; i < 3; ++i) {
            const Segment side{seen[i], seen[(i + 1) % 3]};
            least = std::min(least, closest_point(side, Vec3::Zero()).point.norm());
        }
        return least;
    }

    const TriangleMesh& mesh_;
    Box box_;
};

/// One peer's pass of the first round, and what its answers are compared with.
struct FirstPass {
    const RayPeer& peer;
    bool is_ours = false;
    bool closest = false;
    std::span<const PeerHit> closest_hits; ///< the peer's own, ray by ray
    std::span<const PeerHit> ours;         ///< our closest hits
};

void compare(const HitComparison& comparison, std::span<const Ray> rays, const FirstPass& pass,
             PassResult& result)
{
    for (std::size_t i = 0; i < rays.size(); ++i) {
        const PeerHit& ours = pass.ours[i];
        PeerHit hit;
        if (pass.closest) {
            hit = pass.peer.hit(i);
        } else if (pass.peer.was_hit(i)) {
            hit = pass.closest_hits[i];
        }
        const bool was_hit = pass.closest ? HitComparison::hits(hit) : pass.peer.was_hit(i);
        result.hits += was_hit ? 1 : 0;
        const bool differs =
            pass.closest ? HitComparison::differs(hit, ours) : was_hit != HitComparison::hits(ours);
        if (!differs) continue;
        ++result.different;
        const bool is_noise = !pass.is_ours && comparison.is_float_noise(rays[i], hit, ours);
        result.unexplained += is_noise ? 0 : 1;
    }
}

/// How many answers differ from ours by more than floats explain.
std::size_t race(const TriangleMesh& mesh, const RaySet& set,
                 std::span<const std::unique_ptr<RayPeer>> peers, int rounds)
{
    const HitComparison comparison(mesh);
    std::vector<std::array<PassResult, pass_kinds.size()>> results(peers.size());
    std::vector<PeerHit> ours(set.rays.size());
    std::vector<PeerHit> closest(set.rays.size());
    for (int round = 0; round < rounds; ++round) {
        for (std::size_t turn = 0; turn < peers.size(); ++turn) {
            // Ours goes first in the first round: what it finds is compared with.
            const std::size_t i = (turn + static_cast<std::size_t>(round)) % peers.size();
            RayPeer& peer = *peers[i];
            for (std::size_t k = 0; k < pass_kinds.size(); ++k) {
                peer.prepare(set.rays, set.coherence);
                const double start = processor_seconds();
                (peer.*pass_kinds[k].pass)();
                results[i][k].seconds.push_back(processor_seconds() - start);
                if (round > 0) continue;
                if (k == 0) {
                    for (std::size_t ray = 0; ray < closest.size(); ++ray)
                        closest[ray] = peer.hit(ray);
                    if (i == 0) ours = closest;
                }
                compare(comparison, set.rays, {peer, i == 0, pass_kinds[k].closest, closest, ours},
                        results[i][k]);
            }
        }
    }
    std::printf("  %-11s", set.name);
    for (const PassKind& kind : pass_kinds) std::printf("%22s", kind.name);
    std::printf("   (million rays a second, ours over it)\n");
    const auto count = static_cast<double>(set.rays.size());
    std::size_t unexplained = 0;
    for (std::size_t i = 0; i < peers.size(); ++i) {
        std::printf("    %-14s", peers[i]->name().c_str());
        for (std::size_t k = 0; k < pass_kinds.size(); ++k) {
            const double own = median(results[0][k].seconds);
            const double other = median(results[i][k].seconds);
            std::printf("%12.2f (%5.2f x)", 1e-6 * count / other, other / own);
        }
        std::printf("   hits %zu", results[i][0].hits);
        for (const PassResult& result : results[i]) std::printf(" %zu", result.different);
        std::printf(" different, unexplained");
        for (const PassResult& result : results[i]) {
            std::printf(" %zu", result.unexplained);
            unexplained += result.unexplained;
        }
        std::printf("\n");
    }
    return unexplained;
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

/// How many answers differ from ours by more than floats explain; nothing where there is no mesh.
std::optional<std::size_t> run_mesh(const std::string& name, const BenchOptions& options)
{
    const auto read = is_sample_mesh_name(name) ? sample_mesh(name) : read_mesh(name);
    if (!read) {
        std::fprintf(stderr, "%s\n", describe(read.error()).c_str());
        return std::nullopt;
    }
    const TriangleMesh mesh = rounded_to_floats(*read);
    std::printf("%s: %zu triangles\n", std::filesystem::path(name).filename().string().c_str(),
                mesh.triangle_count());
    const auto peers = build_peers(mesh, options.rounds);
    const auto side = static_cast<std::size_t>(std::sqrt(static_cast<double>(options.rays)));
    std::size_t unexplained = 0;
    for (const RaySet& set : ray_sets(mesh, side, options.seed))
        unexplained += race(mesh, set, peers, options.rounds);
    std::fflush(stdout);
    return unexplained;
}

int run(const BenchOptions& options)
{
    std::printf("one thread, %zu rays a set from seed %llu, medians of %d interleaved rounds\n",
                options.rays, static_cast<unsigned long long>(options.seed), options.rounds);
    std::size_t unexplained = 0;
    for (const std::string& name : meshes_of(options)) {
        const auto of_mesh = run_mesh(name, options);
        if (!of_mesh) return 1;
        unexplained += *of_mesh;
    }
    if (unexplained == 0) return 0;
    std::fprintf(stderr, "failed: %zu answers differ by more than floats explain\n", unexplained);
    return 1;
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
