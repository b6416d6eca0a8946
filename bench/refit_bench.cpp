// What bringing a proximity octree up to date costs when vertices moved, beside building it again,
// and what its queries cost afterwards. Run by scripts/bench refit [MESH].
//
//     scattered   vertices anywhere, each by 1e-3 of the diagonal
//     together    as many about one place
//     pays        queries of set a after which building again would have been cheaper

#include "index/index_parts.h"
#include "index/lists/proximity_lists.h"
#include "instruction_set.h"
#include "lab/query_sets.h"
#include "proxima/closest_feature.h"
#include "proxima/mesh_index.h"
#include "proxima/mesh_io.h"
#include "proxima/sample_meshes.h"

#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
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

double seconds_now()
{
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch())
        .count();
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

/// Nanoseconds of a query of set a, the least of three passes.
double query_time(const MeshIndex& octree, std::span<const Vec3> points)
{
    double least = 1e9;
    for (int pass = 0; pass < 3; ++pass) {
        const double start = seconds_now();
        for (const Vec3& p : points) {
            ClosestFeature found = *closest_feature(octree, p);
            benchmark::DoNotOptimize(found);
        }
        least = std::min(least, seconds_now() - start);
    }
    return 1e9 * least / static_cast<double>(points.size());
}

int run(const std::string& name)
{
    const auto mesh = is_sample_mesh_name(name) ? sample_mesh(name) : read_mesh(name);
    if (!mesh) {
        std::fprintf(stderr, "%s\n", describe(mesh.error()).c_str());
        return 1;
    }
    const auto topology = build_topology(*mesh).value();
    const MeshIndex built = with_lists(build_mesh_index(*mesh).value()).value();
    std::printf("%s: %zu triangles, seed %llu\n", name.c_str(), mesh->triangle_count(),
                static_cast<unsigned long long>(seed));
    std::puts(
        "moved             build s   refit s   cheaper   stale   refit ns   built ns       pays");
    for (const double part : {0.001, 0.01, 0.1}) {
        for (const Spread spread : {Spread::scattered, Spread::together}) {
            const TriangleMesh other = moved_mesh(*mesh, part, spread);
            const auto points = query_sets(other, queries, seed)[0].points;
            double start = seconds_now();
            const MeshIndex again = with_lists(build_mesh_index(other).value()).value();
            const double build = seconds_now() - start;
            start = seconds_now();
            const auto refitted = refit_index(built, other, topology);
            const double refit = seconds_now() - start;
            if (!refitted) {
                std::fprintf(stderr, "%s\n", describe(refitted.error()).c_str());
                return 1;
            }
            const double slow = query_time(*refitted, points);
            const double fast = query_time(again, points);
            const ProximityStatistics& counts = refitted->parts().lists()->statistics();
            std::printf("%5.1f %% %s %9.2f %9.3f %8.1fx %6.1f%% %10.0f %10.0f %10.2g\n", 100 * part,
                        spread == Spread::scattered ? "scattered" : "together ", build, refit,
                        build / refit,
                        100 * static_cast<double>(counts.stale_leaves) /
                            static_cast<double>(counts.leaves),
                        slow, fast, slow > fast ? (build - refit) * 1e9 / (slow - fast) : 1e99);
        }
    }
    return 0;
}

} // namespace
} // namespace proxima::bench

int main(int argc, char** argv)
{
    if (!proxima::bench::use_instruction_set_asked_for()) return 2;
    const std::string bunny = "/usr/share/glmark2/models/bunny.obj";
    if (argc > 1) return proxima::bench::run(argv[1]);
    return proxima::bench::run(std::filesystem::exists(bunny) ? bunny : "torus:200x100");
}
