// What a tick of touching costs in direct mode: the servo loop asks the proximity octree itself.
// Run by scripts/bench touch.
//
//     touch_bench [--ticks N] [--replays N] [--radius R] [--keep DIR] [--peers] [--slowest N]
//                 [--mesh NAME]...
//     touch_bench --curve FILE.{csv,svg,pdf,png} ...      tick time by the number of triangles
//     touch_bench --scenes                             several objects, at rest and moving, and one
//                                                      that changes its shape
//     touch_bench --patches [--mesh NAME]...           what rings miss, by the hand's speed
//     touch_bench --stability                          stiffness limits beside theory, and the
//                                                      guard beyond them
//     touch_bench --loops SECONDS [--script NAME]      by the clock, with a graphics loop
//
//     script    of the simulated hand          state     what the tick was about (touch_track.h)
//     p50 ...   us computed per tick           queries   questions of the octree per tick
//     gathered  triangles that these gave      lanes     of kept triangles that scans looked at
//     in full   triangles looked at in doubles
//     raw       the first replay alone: with what else the machine did meanwhile
//
// Peers: the same proxy, which then asks the octree anew for each question of a tick, and a
// god-object over a tree of boxes (god_object_peer.h).

#include "bench_program.h"
#include "touch_changes.h"
#include "touch_curve.h"
#include "touch_loops.h"
#include "touch_patch_table.h"
#include "touch_scenes.h"
#include "touch_stability.h"
#include "touch_table.h"

#include <CLI/CLI.hpp>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace proxima::bench {
namespace {

struct TouchBenchOptions {
    TouchRaceOptions race;
    bool peers = false;
    std::size_t slowest = 0;
    std::vector<std::string> meshes;
    std::vector<std::string> curves;
    TouchLoopOptions loops;
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

/// The bunny, and the dragon of 47,794 triangles where a folder of meshes lies beside the checkout.
std::vector<std::string> meshes_for_patches()
{
    std::vector<std::string> names;
    for (const char* const name :
         {"/usr/share/glmark2/models/bunny.obj", "../shared/meshes/dragon_vrip_res3.ply"}) {
        if (std::filesystem::exists(name)) {
            names.emplace_back(name);
        } else {
            std::printf("without %s: it is not there\n", name);
        }
    }
    if (names.empty()) names.emplace_back("torus:200x100");
    return names;
}

int run_patches(const std::vector<std::string>& meshes, const TouchRaceOptions& race)
{
    int status = 0;
    for (const std::string& mesh : meshes)
        status |= run_patch_table(mesh, {.radius = race.radius, .keep = race.keep});
    return status;
}

int run_mesh(const std::string& name, const TouchBenchOptions& options)
{
    const auto model = load_touch_model(name, options.race.keep);
    if (!model) {
        std::printf("%s: %s\n", name.c_str(), describe(model.error()).c_str());
        return 1;
    }
    std::printf("%s, %zu triangles, proxy radius %g m; least of %d replays\n", name.c_str(),
                (*model)->mesh.triangle_count(), options.race.radius, options.race.replays);
    print_head("script");
    TickSums sums;
    SlowTicks slow_ticks;
    TickSums asked_sums;
    TickSums peer_sums;
    std::uint64_t differences = 0;
    const AskedSurface asked(*(*model)->surface);
    std::optional<BoxTree> tree;
    if (options.peers) tree.emplace((*model)->mesh);
    for (const char* const script : touch_scripts) {
        const TouchTrack track =
            record_track(**model, script, options.race.ticks, options.race.radius);
        const TrackTimes times = time_track(*(*model)->surface, (*model)->map, track,
                                            options.race.radius, options.race.replays);
        differences += times.differences;
        TickSums own;
        add_track(own, track, times);
        print_rows(script, own, true);
        add_track(sums, track, times);
        slow_ticks.add(script, track, times);
        if (!options.peers) continue;
        const TrackTimes slow =
            time_track(asked, (*model)->map, track, options.race.radius, options.race.replays);
        differences += slow.differences;
        add_track(asked_sums, track, slow);
        add_track(peer_sums, track, time_track(*tree, **model, track, options.race.replays));
    }
    print_rows("all", sums, true);
    slow_ticks.print(options.slowest);
    if (options.peers) {
        print_rows("asking", asked_sums, false);
        print_rows("box tree", peer_sums, false);
    }
    if (differences != 0) {
        std::printf("%llu replayed ticks gave ANOTHER FORCE\n",
                    static_cast<unsigned long long>(differences));
    }
    std::printf("\n");
    (void)std::fflush(stdout);
    return differences == 0 ? 0 : 1;
}

} // namespace
} // namespace proxima::bench

int main(int argc, char** argv) // NOLINT(bugprone-exception-escape): ends the program, and says so
{
    using namespace proxima::bench;
    TouchBenchOptions options;
    bool looping = false;
    bool scenes = false;
    bool patches = false;
    bool stability = false;
    const auto add_options = [&](CLI::App& app) {
        app.add_option("--ticks", options.race.ticks, "Of each script")->capture_default_str();
        app.add_option("--replays", options.race.replays, "Of which the least counts")
            ->check(CLI::PositiveNumber)
            ->capture_default_str();
        app.add_option("--radius", options.race.radius, "Of the proxy, m")->capture_default_str();
        app.add_option("--keep", options.race.keep, "Folder of indexes built before, and to come")
            ->check(CLI::ExistingDirectory);
        app.add_option("--mesh", options.meshes, "Files, .pxi among them, or built-ins");
        app.add_option("--slowest", options.slowest,
                       "So many of the slowest ticks, and what they did");
        app.add_flag("--peers", options.peers, "Time what it is held against, too");
        app.add_option(
            "--curve", options.curves,
            "Tick time by the number of triangles, of these meshes beside toruses, as a table "
            "(.csv) or a plot (.svg, .pdf, .png)");
        app.add_option_function<double>(
            "--loops",
            [&](double seconds) {
                looping = true;
                options.loops.seconds = seconds;
            },
            "Servo and graphics loop together for so many seconds");
        app.add_option("--script", options.loops.script, "Of the hand in --loops")
            ->capture_default_str();
        app.add_flag(
            "--scenes", scenes,
            "Only scenes of several objects, at rest and moving, and a shape that changes");
        app.add_flag("--patches", patches, "Only what patches of rings miss, by the hand's speed");
        app.add_flag("--stability", stability,
                     "Only where walls begin to swing, beside theory, with and without the guard");
    };
    return run_program(argc, argv, "Times ticks of touching.", add_options, [&] {
        if (stability) return run_stability_table();
        if (!options.curves.empty()) return run_curve(options.meshes, options.race, options.curves);
        if (scenes) return run_scenes(options.race) | run_changes(options.race);
        const bool all = options.meshes.empty() && !looping;
        if (patches) return run_patches(all ? meshes_for_patches() : options.meshes, options.race);
        if (options.meshes.empty()) options.meshes = usual_meshes();
        options.loops.keep = options.race.keep;
        int status = 0;
        for (const std::string& mesh : options.meshes)
            status |= looping ? run_loops(mesh, options.loops) : run_mesh(mesh, options);
        if (!all) return status;
        status |= run_scenes(options.race) | run_changes(options.race);
        return status | run_patches(meshes_for_patches(), options.race);
    });
}
