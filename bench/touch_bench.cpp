// What a tick of touching costs in direct mode: the servo loop asks the proximity octree itself.
// Run by scripts/bench touch [--ticks N] [--radius R] [--mesh NAME]...
//
//     slide walk stroke press poke    scripts of the simulated hand, thousands of ticks a second
//     touching                        ticks with contact, which is what is timed in their column
//     moves                           of the proxy per tick
//
// Computed work alone: from what the device says to the force, without sleeping or the hand.

#include "proxima/haptics/hand_script.h"
#include "proxima/haptics/haptic_renderer.h"
#include "proxima/haptics/quality_report.h"
#include "proxima/haptics/simulated_hand.h"
#include "proxima/mesh/mesh_io.h"
#include "proxima/mesh/sample_meshes.h"
#include "proxima/proximity/build_proximity_octree.h"

#include <CLI/CLI.hpp>

#include <array>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

namespace proxima::bench {
namespace {

constexpr double tick_seconds = 1e-3;

struct TouchBenchOptions {
    std::uint64_t ticks = 20000;
    double radius = 0; ///< m
    std::vector<std::string> meshes;
};

std::vector<std::string> usual_meshes()
{
    std::vector<std::string> names = {"sphere:30x30", "torus:200x100", "spaceship:33000"};
    const char* const bunny = "/usr/share/glmark2/models/bunny.obj";
    if (std::filesystem::exists(bunny)) names.emplace_back(bunny);
    const char* const own = std::getenv("PROXIMA_BENCH_MESH");
    if (own != nullptr) names.emplace_back(own);
    return names;
}

std::int64_t nanoseconds_now()
{
    return std::chrono::steady_clock::now().time_since_epoch() / std::chrono::nanoseconds(1);
}

/// Times of one script.
struct ScriptTimes {
    LatencyHistogram free;
    LatencyHistogram touching;
    QualityReport quality;
};

ScriptTimes time_script(const OctreeContactSurface& surface, const HandScript& script,
                        const WorkspaceMap& map, const TouchBenchOptions& options)
{
    HapticRenderer renderer(surface, map, *find_device("omni"), {.proxy_radius = options.radius});
    QualityMeter meter(surface, map);
    SimulatedHand hand({}, script.target(0));
    ScriptTimes times;
    for (std::uint64_t tick = 0; tick < options.ticks; ++tick) {
        const DeviceState state = hand.state();
        const std::int64_t begin = nanoseconds_now();
        const RenderTick& felt = renderer.tick(state, tick_seconds);
        const std::int64_t end = nanoseconds_now();
        (felt.proxy.hold == Hold::free ? times.free : times.touching).add(end - begin);
        meter.add(felt, state.velocity, renderer.proxy().path());
        hand.step(felt.force, script.target(static_cast<double>(tick) * tick_seconds));
    }
    times.quality = meter.report();
    return times;
}

double microseconds(const LatencyHistogram& histogram, double part)
{
    return 1e-3 * static_cast<double>(histogram.quantile(part));
}

int run_mesh(const std::string& name, const TouchBenchOptions& options)
{
    const auto mesh = is_sample_mesh_name(name) ? sample_mesh(name) : read_mesh(name);
    if (!mesh) {
        std::printf("%s: %s\n", name.c_str(), describe(mesh.error()).c_str());
        return 1;
    }
    const auto topology = build_topology(*mesh);
    if (!topology) return 1;
    const auto octree = build_proximity_octree(*mesh, *topology);
    if (!octree) return 1;
    const OctreeContactSurface surface(*octree);
    const WorkspaceMap map = fit_workspace(bounding_box(*mesh), 0.1);
    std::printf("%s, %zu triangles, proxy radius %g m\n", name.c_str(), mesh->triangle_count(),
                options.radius);
    std::printf("%-8s %8s %7s %7s  %8s %8s %8s %8s %8s  %9s %9s  %5s %5s\n", "script", "touching",
                "moves", "free us", "p50 us", "p99", "p99.9", "p99.99", "max", "Hz at p50",
                "at p99.99", "cut", "pass");
    for (const char* const script_name : {"slide", "walk", "stroke", "press", "poke"}) {
        const auto script = HandScript::make(script_name, *mesh, *topology, map, 1);
        if (!script) return 1;
        const ScriptTimes times = time_script(surface, *script, map, options);
        const LatencyHistogram& at = times.touching;
        std::printf(
            "%-8s %7.1f%% %7.2f %7.2f  %8.2f %8.2f %8.2f %8.2f %8.2f  %9.0f %9.0f  %5llu %5llu\n",
            script_name,
            100.0 * static_cast<double>(times.quality.touching_ticks) /
                static_cast<double>(times.quality.ticks),
            static_cast<double>(times.quality.moves) / static_cast<double>(times.quality.ticks),
            microseconds(times.free, 0.5), microseconds(at, 0.5), microseconds(at, 0.99),
            microseconds(at, 0.999), microseconds(at, 0.9999), microseconds(at, 1),
            1e6 / microseconds(at, 0.5), 1e6 / microseconds(at, 0.9999),
            static_cast<unsigned long long>(times.quality.limited_ticks),
            static_cast<unsigned long long>(times.quality.passes));
    }
    std::printf("\n");
    return 0;
}

} // namespace
} // namespace proxima::bench

int main(int argc, char** argv)
{
    using namespace proxima::bench;
    TouchBenchOptions options;
    CLI::App app("Times ticks of touching.");
    app.add_option("--ticks", options.ticks, "Of each script")->capture_default_str();
    app.add_option("--radius", options.radius, "Of the proxy, m")->capture_default_str();
    app.add_option("--mesh", options.meshes, "Files or built-ins");
    CLI11_PARSE(app, argc, argv);
    if (options.meshes.empty()) options.meshes = usual_meshes();
    int status = 0;
    for (const std::string& mesh : options.meshes) status |= run_mesh(mesh, options);
    return status;
}
