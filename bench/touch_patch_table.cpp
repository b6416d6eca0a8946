#include "touch_patch_table.h"

#include "cli/touch_patches.h"
#include "cli/touch_session.h"
#include "haptics/device/hand_script.h"
#include "haptics/force/haptic_renderer.h"
#include "touch_curve.h"
#include "touch_model.h"
#include "touch_table.h"
#include "touch_track.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <utility>

namespace proxima::bench {

namespace {

constexpr std::array speeds = {0.1, 0.25, 0.5, 1.0}; // m/s
constexpr std::uint64_t ticks_at_rest = 30;
constexpr std::array kinds = {-1, 1, 2, 3}; // metric, then rings

/// Straight from place to place of a script, always at one speed.
class SteadyPath {
public:
    SteadyPath(const HandScript& script, double speed)
        : script_(script), step_(speed * tick_seconds), at_(script.target(0))
    {}

    Vec3 next()
    {
        double left = step_;
        // A script that rests for a period goes nowhere.
        const double end = seconds_ + script_.period();
        while (left > 0 && seconds_ < end) {
            const Vec3 way = goal_ - at_;
            const double length = way.norm();
            if (length > left) {
                at_ += way * (left / length);
                break;
            }
            at_ = goal_;
            left -= length;
            seconds_ += sample_seconds;
            goal_ = script_.target(seconds_);
        }
        return at_;
    }

private:
    static constexpr double sample_seconds = 0.02;
    const HandScript& script_;
    double step_;
    double seconds_ = 0;
    Vec3 at_;
    Vec3 goal_ = at_;
};

void add(PatchAccount& sum, const PatchAccount& other)
{
    sum.settings = other.settings;
    sum.model_triangles = other.model_triangles;
    sum.patches += other.patches;
    sum.incomplete += other.incomplete;
    sum.triangles += other.triangles;
    sum.largest = std::max(sum.largest, other.largest);
    sum.touching_ticks += other.touching_ticks;
    sum.missed_ticks += other.missed_ticks;
    sum.apart_ticks += other.apart_ticks;
    sum.oldest_ticks = std::max(sum.oldest_ticks, other.oldest_ticks);
    sum.lost_ticks += other.lost_ticks;
}

PatchAccount touch_patches(const proxima::TouchModel& model, const WorkspaceMap& map,
                           const HandScript& script, double speed, int rings,
                           const PatchTableOptions& options, TickTimes& times)
{
    const RenderOptions render = {.proxy_radius = options.radius};
    PatchTouch patches(model, {.rings = rings}, map, render, nullptr, tick_seconds, Pace::unpaced);
    HapticRenderer renderer(patches.surface(), map, *find_device("omni"), render);
    SteadyPath path(script, speed);
    Vec3 last = script.target(0);
    for (std::uint64_t tick = 0; tick < options.ticks; ++tick) {
        DeviceState state;
        // Until the first patch comes there is nothing to touch.
        state.pose.translation = tick < ticks_at_rest ? last : path.next();
        state.velocity = (state.pose.translation - last) / tick_seconds;
        last = state.pose.translation;
        const auto begin = std::chrono::steady_clock::now();
        const Patch patch = patches.begin_tick();
        const RenderTick& felt = renderer.tick(state, tick_seconds, patch);
        times.add((std::chrono::steady_clock::now() - begin) / std::chrono::nanoseconds(1));
        patches.end_tick(felt);
    }
    return patches.finish();
}

} // namespace

int run_patch_table(const std::string& mesh, const PatchTableOptions& options)
{
    auto loaded = load_touch_model(mesh, options.keep);
    if (!loaded) {
        std::printf("%s: %s\n", mesh.c_str(), describe(loaded.error()).c_str());
        return 1;
    }
    const WorkspaceMap map = (*loaded)->map;
    proxima::TouchModel model;
    model.surface = {std::move((*loaded)->mesh), std::move((*loaded)->topology)};
    model.index = std::move((*loaded)->index);
    model.contact = std::make_unique<IndexContactSurface>(model.index);
    std::printf(
        "%s, %zu triangles: patches at 100 Hz, a period late, in %llu ticks of each script\n",
        mesh.c_str(), model.surface.mesh.triangle_count(),
        static_cast<unsigned long long>(options.ticks));
    std::printf("%-6s %-9s %8s %10s %8s %10s %8s %9s %9s %9s %8s %8s %8s %8s\n", "m/s", "patch",
                "patches", "triangles", "largest", "sent down", "touching", "missed", "apart",
                "cut off", "lost", "p50 us", "p99.9", "max");
    bool right = true;
    for (const double speed : speeds) {
        for (const int rings : kinds) {
            PatchAccount sum;
            TickTimes times;
            for (const char* const name : touch_scripts) {
                const auto script =
                    HandScript::make(name, model.surface.mesh, model.surface.topology, map, 1);
                if (!script) continue;
                add(sum, touch_patches(model, map, *script, speed, rings, options, times));
            }
            const double patches = std::max(1.0, static_cast<double>(sum.patches));
            const double mean = static_cast<double>(sum.triangles) / patches;
            const double touching = std::max(1.0, static_cast<double>(sum.touching_ticks));
            std::printf("%-6g %-9s %8llu %10.1f %8llu %9.3f%% %8llu %8.3f%% %8.3f%% %9llu %8llu "
                        "%8.2f %8.2f "
                        "%8.2f\n",
                        speed, name_of(sum.settings).c_str(),
                        static_cast<unsigned long long>(sum.patches), mean,
                        static_cast<unsigned long long>(sum.largest),
                        100 * mean / static_cast<double>(sum.model_triangles),
                        static_cast<unsigned long long>(sum.touching_ticks),
                        100 * static_cast<double>(sum.missed_ticks) / touching,
                        100 * static_cast<double>(sum.apart_ticks) / touching,
                        static_cast<unsigned long long>(sum.incomplete),
                        static_cast<unsigned long long>(sum.lost_ticks), times.microseconds(0.5),
                        times.microseconds(0.999), times.microseconds(1));
            (void)std::fflush(stdout);
            right = right && (rings >= 0 || sum.missed_ticks == 0);
        }
    }
    std::printf("%s\n\n",
                right ? "metric patches missed nothing" : "METRIC PATCHES MISSED TRIANGLES");
    return right ? 0 : 1;
}

} // namespace proxima::bench
