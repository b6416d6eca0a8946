// Millions of scripted ticks, every move of the proxy held against the surface: scripts/soak touch.
//
//     touch_soak [--ticks N] [--compare N] [--seed N] [--mesh NAME]...
//     touch_soak --scenes [--ticks N] [--seed N]       several objects, moving (scene_soak.h)
//     touch_soak --hands [--seconds S] [--seed N] [--device NAME] [--session TEXT]
//                [--hardest]                            hands (hand_soak.h)
//
//     compared  ticks in which a second proxy, that looks at every triangle of the mesh in every
//               question, felt the same hand: all on meshes of up to 5,000 triangles, the first
//               1,000 of each row on larger ones, or as many as --compare says
//     wrong     of these, in which proxy or force differ in any bit
//     passes    moves of the proxy through a triangle, decided exactly: through walls and through
//               seams; of all ticks
//     cut       slides that ended by their number of moves, and went on in the next tick
//     over      ticks with more triangles near than there is room for
//
// Exit status 1 if anything passed, was over or wrong.

#include "haptics/force/surface_renderer.h"
#include "haptics/servo_tick.h"
#include "haptics/soak/every_triangle.h"
#include "haptics/soak/hand_soak.h"
#include "haptics/soak/scene_soak.h"
#include "haptics/surface/contact_surface.h"
#include "haptics/touch_meshes.h"
#include "index/listed_index.h"
#include "lab/hand_script.h"
#include "lab/quality_report.h"
#include "lab/simulated_hand.h"
#include "proxima/device.h"
#include "proxima/haptic_renderer.h"
#include "proxima/mesh_io.h"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace proxima::soak {
namespace {

using testing::tick_seconds;

/// Of larger meshes, all triangles are asked in the first ticks of a row alone.
constexpr std::size_t small_mesh = 5000;
constexpr std::uint64_t compared_ticks_of_large = 1000;

struct SoakOptions {
    std::uint64_t ticks = 1'000'000;      ///< of every mesh
    std::optional<std::uint64_t> compare; ///< of every row
    std::uint64_t seed = 1;
    std::vector<std::string> meshes; ///< by name, or files
};

/// What all rows amount to.
struct SoakTotals {
    std::uint64_t ticks = 0;
    std::uint64_t touching = 0;
    std::uint64_t compared = 0;
    std::uint64_t wrong = 0;
    std::uint64_t passes = 0;
    std::uint64_t cut = 0;
    std::uint64_t over = 0;

    void add(const SoakTotals& row)
    {
        ticks += row.ticks;
        touching += row.touching;
        compared += row.compared;
        wrong += row.wrong;
        passes += row.passes;
        cut += row.cut;
        over += row.over;
    }
    [[nodiscard]] bool right() const { return wrong + passes + over == 0; }
    void print() const
    {
        for (const std::uint64_t number : {ticks, touching, compared, wrong, passes, cut, over})
            std::printf(" %9llu", static_cast<unsigned long long>(number));
    }
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
          index_(*testing::listed_index(named.mesh)), surface_(index_), all_(named.mesh),
          map_(fit_workspace(bounding_box(named.mesh), 0.1))
    {}

    SoakTotals run()
    {
        constexpr std::array scripts = {"press", "slide", "stroke", "corner", "poke", "walk"};
        constexpr std::array radii = {0.0, 0.002};
        SoakTotals totals;
        for (const char* const script : scripts) {
            for (const double radius : radii) {
                totals.add(
                    run_row(script, radius, options_.ticks / (scripts.size() * radii.size()) + 1));
            }
        }
        return totals;
    }

private:
    SoakTotals run_row(const char* script_name, double radius, std::uint64_t ticks)
    {
        const auto script =
            HandScript::make(script_name, named_.mesh, topology_, map_, options_.seed);
        if (!script) return {.wrong = 1};
        const RenderOptions render = {.proxy_radius = radius};
        const DeviceLimits device = *find_device("omni");
        HapticRenderer renderer = make_surface_renderer(surface_, map_, device, render);
        HapticRenderer slow = make_surface_renderer(all_, map_, device, render);
        const bool is_small = named_.mesh.triangle_count() <= small_mesh;
        QualityMeter meter(is_small ? static_cast<const ContactSurface&>(all_) : surface_, map_);
        const std::uint64_t compared =
            options_.compare.value_or(is_small ? ticks : compared_ticks_of_large);
        SimulatedHand hand({}, script->target(0));
        SoakTotals row;
        for (std::uint64_t tick = 0; tick < ticks; ++tick) {
            const DeviceState state = hand.state();
            const RenderTick& felt = renderer.tick(state, tick_seconds);
            meter.add(felt, state.velocity, renderer.path());
            if (tick < compared) {
                const RenderTick& expected = slow.tick(state, tick_seconds);
                ++row.compared;
                const bool same = felt.force == expected.force && felt.proxy == expected.proxy;
                row.wrong += same ? 0U : 1U;
            }
            hand.step(felt.force, script->target(static_cast<double>(tick) * tick_seconds));
        }
        const QualityReport& quality = meter.report();
        row.ticks = quality.ticks;
        row.touching = quality.touching_ticks;
        row.passes = quality.passes;
        row.cut = quality.limited_ticks;
        row.over = quality.overloaded_ticks;
        std::printf("%-15s %-7s %6g", named_.name.c_str(), script_name, radius);
        row.print();
        std::printf(" %8.3f\n", quality.max_step_ratio);
        (void)std::fflush(stdout);
        return row;
    }

    const testing::TouchMesh& named_;
    const SoakOptions& options_;
    Topology topology_;
    MeshIndex index_;
    IndexContactSurface surface_;
    EveryTriangle all_;
    WorkspaceMap map_;
};

/// The usual meshes, those of them that are named, or files.
std::vector<testing::TouchMesh> chosen_meshes(const SoakOptions& options)
{
    std::vector<testing::TouchMesh> usual = soak_meshes();
    if (options.meshes.empty()) return usual;
    std::vector<testing::TouchMesh> chosen;
    for (const std::string& name : options.meshes) {
        const auto known = std::ranges::find(usual, name, &testing::TouchMesh::name);
        if (known != usual.end()) {
            chosen.push_back(*known);
        } else if (auto mesh = read_mesh(name)) {
            chosen.push_back({std::filesystem::path(name).stem().string(), std::move(*mesh)});
        } else {
            std::fprintf(stderr, "touch_soak: %s is no mesh of the soak, and %s\n", name.c_str(),
                         describe(mesh.error()).c_str());
            return {};
        }
    }
    return chosen;
}

int run(const SoakOptions& options)
{
    const std::vector<testing::TouchMesh> meshes = chosen_meshes(options);
    if (meshes.empty()) return 2;
    std::printf("seed %llu\n%-15s %-7s %6s %9s %9s %9s %9s %9s %9s %9s %8s\n",
                static_cast<unsigned long long>(options.seed), "mesh", "script", "radius", "ticks",
                "touching", "compared", "wrong", "passes", "cut", "over", "step");
    SoakTotals totals;
    for (const testing::TouchMesh& named : meshes) {
        const SoakTotals mesh = MeshSoak(named, options).run();
        std::printf("%-30s",
                    (named.name + ", " + std::to_string(named.mesh.triangle_count()) + " triangles")
                        .c_str());
        mesh.print();
        std::printf("\n");
        (void)std::fflush(stdout);
        totals.add(mesh);
    }
    std::printf("%-30s", ("all " + std::to_string(meshes.size()) + " meshes").c_str());
    totals.print();
    std::printf("\n%s\n", totals.right() ? "nothing passed, nothing wrong" : "SOMETHING WAS WRONG");
    return totals.right() ? 0 : 1;
}

} // namespace
} // namespace proxima::soak

int main(int argc, char** argv) // NOLINT(bugprone-exception-escape): one ends it, and says so
{
    proxima::soak::SoakOptions options;
    CLI::App app("Touches meshes for millions of ticks.");
    app.add_option("--ticks", options.ticks, "Of every mesh")->capture_default_str();
    app.add_option("--compare", options.compare, "Ticks of every row held against all triangles");
    app.add_option("--seed", options.seed)->capture_default_str();
    app.add_option("--mesh", options.meshes, "These alone, by name, or files");
    bool scenes = false;
    app.add_flag("--scenes", scenes, "Scenes of small meshes, of so many ticks each");
    bool hands = false;
    bool hardest = false;
    double seconds = 60;
    app.add_flag("--hands", hands, "Hands that tap, tremble, press and write: no force is lost");
    app.add_flag("--hardest", hardest, "Of --hands: also walls as stiff as each device allows");
    app.add_option("--seconds", seconds, "Of --hands: the length of each session")
        ->check(CLI::Range(1.0, 86400.0))
        ->capture_default_str();
    std::string device;
    app.add_option("--device", device, "Of --hands: one alone")->check([](const std::string& name) {
        return proxima::find_device(name) ? std::string() : name + " is not a device";
    });
    std::string session;
    app.add_option("--session", session, "Of --hands: those with this in their names");
    CLI11_PARSE(app, argc, argv);
    if (hands) return proxima::soak::run_hand_soak(seconds, options.seed, hardest, device, session);
    if (scenes) return proxima::soak::run_scene_soak(options.ticks, options.seed);
    return proxima::soak::run(options);
}
