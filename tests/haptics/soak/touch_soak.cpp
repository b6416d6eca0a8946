// Millions of scripted ticks, every move of the proxy held against the surface: scripts/soak touch.
//
//     touch_soak [--ticks N] [--compare N] [--seed N] [--mesh NAME]...
//
//     passes    moves of the proxy through a triangle, decided exactly
//     cut       slides that ended by their number of moves, and went on in the next tick
//     over      ticks with more triangles near than there is room for
//     wrong     ticks in which the proxy differs from one that looks at every triangle, of
//               `compare` ticks of each row
//
// Exit status 1 if anything passed, was over or wrong.

#include "haptics/touch_meshes.h"
#include "proxima/haptics/hand_script.h"
#include "proxima/haptics/haptic_renderer.h"
#include "proxima/haptics/quality_report.h"
#include "proxima/haptics/simulated_hand.h"
#include "proxima/mesh/mesh_io.h"
#include "proxima/proximity/build_proximity_octree.h"

#include <CLI/CLI.hpp>

#include <array>
#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

namespace proxima::soak {
namespace {

constexpr double tick_seconds = 1e-3;

struct SoakOptions {
    std::uint64_t ticks = 1'000'000; ///< of every mesh
    std::uint64_t compare = 500;     ///< of every row
    std::uint64_t seed = 1;
    std::vector<std::string> meshes;
};

/// Those of the unit tests, larger ones, and a scan where there is one.
std::vector<testing::TouchMesh> soak_meshes()
{
    std::vector<testing::TouchMesh> meshes = testing::touch_meshes();
    for (const char* const name : {"sphere:100x100", "torus:300x100", "spaceship:33000"})
        meshes.push_back({name, *sample_mesh(name)});
    const char* const bunny = "/usr/share/glmark2/models/bunny.obj";
    if (std::filesystem::exists(bunny)) {
        if (auto mesh = read_mesh(bunny)) meshes.push_back({"bunny", std::move(*mesh)});
    } else {
        std::printf("without the bunny: %s is not there\n", bunny);
    }
    return meshes;
}

/// A mesh, and what was wrong with touching it.
class MeshSoak {
public:
    MeshSoak(const testing::TouchMesh& named, const SoakOptions& options)
        : named_(named), options_(options), topology_(*build_topology(named.mesh)),
          octree_(*build_proximity_octree(named.mesh, topology_)), surface_(octree_),
          all_(named.mesh), map_(fit_workspace(bounding_box(named.mesh), 0.1))
    {}

    bool run()
    {
        constexpr std::array scripts = {"press", "slide", "stroke", "corner", "poke", "walk"};
        constexpr std::array radii = {0.0, 0.002};
        bool right = true;
        for (const char* const script : scripts) {
            for (const double radius : radii) {
                right &=
                    run_row(script, radius, options_.ticks / (scripts.size() * radii.size()) + 1);
            }
        }
        return right;
    }

private:
    bool run_row(const char* script_name, double radius, std::uint64_t ticks)
    {
        const auto script =
            HandScript::make(script_name, named_.mesh, topology_, map_, options_.seed);
        if (!script) return false;
        const RenderOptions render = {.proxy_radius = radius};
        const DeviceLimits device = *find_device("omni");
        HapticRenderer renderer(surface_, map_, device, render);
        HapticRenderer slow(all_, map_, device, render);
        QualityMeter meter(surface_, map_);
        SimulatedHand hand({}, script->target(0));
        std::uint64_t wrong = 0;
        for (std::uint64_t tick = 0; tick < ticks; ++tick) {
            const DeviceState state = hand.state();
            const RenderTick& felt = renderer.tick(state, tick_seconds);
            meter.add(felt, state.velocity, renderer.proxy().path());
            if (tick < options_.compare) {
                const RenderTick& expected = slow.tick(state, tick_seconds);
                wrong += felt.force == expected.force && felt.proxy.proxy == expected.proxy.proxy
                             ? 0U
                             : 1U;
            }
            hand.step(felt.force, script->target(static_cast<double>(tick) * tick_seconds));
        }
        const QualityReport& quality = meter.report();
        std::printf("%-15s %-7s %6g %9llu %9llu %7llu %6llu %6llu %6llu %8.3f\n",
                    named_.name.c_str(), script_name, radius,
                    static_cast<unsigned long long>(quality.ticks),
                    static_cast<unsigned long long>(quality.touching_ticks),
                    static_cast<unsigned long long>(quality.passes),
                    static_cast<unsigned long long>(quality.limited_ticks),
                    static_cast<unsigned long long>(quality.overloaded_ticks),
                    static_cast<unsigned long long>(wrong), quality.max_step_ratio);
        (void)std::fflush(stdout);
        return quality.passes + quality.overloaded_ticks + wrong == 0;
    }

    const testing::TouchMesh& named_;
    const SoakOptions& options_;
    Topology topology_;
    ProximityOctree octree_;
    OctreeContactSurface surface_;
    MeshContactSurface all_;
    WorkspaceMap map_;
};

int run(const SoakOptions& options)
{
    std::printf("seed %llu\n%-15s %-7s %6s %9s %9s %7s %6s %6s %6s %8s\n",
                static_cast<unsigned long long>(options.seed), "mesh", "script", "radius", "ticks",
                "touching", "passes", "cut", "over", "wrong", "step");
    bool right = true;
    std::size_t done = 0;
    for (const testing::TouchMesh& named : soak_meshes()) {
        if (!options.meshes.empty() && std::find(options.meshes.begin(), options.meshes.end(),
                                                 named.name) == options.meshes.end())
            continue;
        right &= MeshSoak(named, options).run();
        ++done;
    }
    if (done == 0) {
        std::fprintf(stderr, "touch_soak: no mesh has such a name\n");
        return 2;
    }
    std::printf(right ? "nothing passed, nothing wrong\n" : "SOMETHING WAS WRONG\n");
    return right ? 0 : 1;
}

} // namespace
} // namespace proxima::soak

int main(int argc, char** argv)
{
    proxima::soak::SoakOptions options;
    CLI::App app("Touches meshes for millions of ticks.");
    app.add_option("--ticks", options.ticks, "Of every mesh")->capture_default_str();
    app.add_option("--compare", options.compare, "Ticks of every row held against all triangles")
        ->capture_default_str();
    app.add_option("--seed", options.seed)->capture_default_str();
    app.add_option("--mesh", options.meshes, "These alone");
    CLI11_PARSE(app, argc, argv);
    return proxima::soak::run(options);
}
