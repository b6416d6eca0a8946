#include "cli/patch_speeds.h"

#include "haptics/force/surface_renderer.h"
#include "lab/hand_script.h"
#include "proxima/device.h"
#include "proxima/haptic_renderer.h"

#include <algorithm>
#include <chrono>

namespace proxima {

namespace {

constexpr double servo_tick = 1e-3;
constexpr std::uint64_t ticks_at_rest = 30; ///< until the first patch comes

/// Straight from place to place of a script, always at one speed.
class SteadyPath {
public:
    SteadyPath(const HandScript& script, double speed)
        : script_(script), step_(speed * servo_tick), at_(script.target(0))
    {}

    Vec3 next()
    {
        double left = step_;
        // A script that rests for a period goes nowhere.
        const double end = seconds_ + script_.period();
        while (left > 0 && seconds_ < end) {
            const Vec3 ahead = goal_ - at_;
            const double length = ahead.norm();
            if (length > left) {
                at_ += ahead * (left / length);
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
    sum.tick.add(other.tick);
}

PatchAccount touch_along(const HandScript& script, const TouchModel& model, const WorkspaceMap& map,
                         const PatchSettings& settings, const PatchSpeedOptions& options)
{
    const RenderOptions render = {.proxy_radius = options.radius};
    PatchTouch patches(model, settings, map, render, nullptr, servo_tick, Pace::unpaced);
    HapticRenderer renderer =
        make_surface_renderer(patches.surface(), map, *find_device("omni"), render);
    SteadyPath path(script, options.speed);
    LatencyHistogram times;
    Vec3 last = script.target(0);
    for (std::uint64_t tick = 0; tick < options.ticks; ++tick) {
        DeviceState state;
        state.pose.translation = tick < ticks_at_rest ? last : path.next();
        state.velocity = (state.pose.translation - last) / servo_tick;
        last = state.pose.translation;
        const auto begin = std::chrono::steady_clock::now();
        const Patch patch = patches.begin_tick();
        const RenderTick& rendered = renderer.tick(state, servo_tick, patch);
        times.add((std::chrono::steady_clock::now() - begin) / std::chrono::nanoseconds(1));
        patches.end_tick(rendered);
    }
    PatchAccount account = patches.finish();
    account.tick = times;
    return account;
}

} // namespace

PatchAccount touch_at_speed(const TouchModel& model, const WorkspaceMap& map,
                            const PatchSettings& settings, const PatchSpeedOptions& options)
{
    PatchAccount sum;
    for (const std::string_view name : patch_scripts) {
        const auto script =
            HandScript::make(name, model.surface.mesh, model.surface.topology, map, 1);
        if (script) add(sum, touch_along(*script, model, map, settings, options));
    }
    return sum;
}

} // namespace proxima
