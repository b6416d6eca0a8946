#include "touch_track.h"

#include "haptics/force/surface_renderer.h"
#include "haptics/proxy/proxy.h"
#include "haptics/surface/contact_surface.h"
#include "lab/hand_script.h"
#include "lab/simulated_hand.h"
#include "proxima/device.h"
#include "proxima/haptic_renderer.h"

#include <algorithm>
#include <chrono>
#include <limits>

namespace proxima::bench {

namespace {

std::int64_t nanoseconds_now()
{
    return std::chrono::steady_clock::now().time_since_epoch() / std::chrono::nanoseconds(1);
}

HapticRenderer renderer_of(const ContactSurface& surface, const WorkspaceMap& map, double radius)
{
    return make_surface_renderer(surface, map, *find_device("omni"), {.proxy_radius = radius});
}

} // namespace

TickState state_of(const RenderTick& tick)
{
    if (tick.hold == Hold::free) return TickState::free;
    if (tick.contact_count > 1) return TickState::corner;
    return tick.hold == Hold::sticking ? TickState::contact : TickState::slide;
}

ContactWork difference(const ContactWork& after, const ContactWork& before)
{
    return {after.distances - before.distances, after.gathers - before.gathers,
            after.gathered - before.gathered,   after.scans - before.scans,
            after.scanned - before.scanned,     after.passed - before.passed};
}

TouchTrack record_track(const TouchModel& model, std::string_view script_name, std::uint64_t ticks,
                        double radius)
{
    const auto script = HandScript::make(script_name, model.mesh, model.topology, model.map, 1);
    TouchTrack track;
    if (!script) return track;
    HapticRenderer renderer = renderer_of(*model.surface, model.map, radius);
    SimulatedHand hand({}, script->target(0));
    ContactWork before;
    for (std::uint64_t tick = 0; tick < ticks; ++tick) {
        const DeviceState state = hand.state();
        const RenderTick& felt = renderer.tick(state, tick_seconds);
        const ContactWork& work = parts_of(renderer).proxy().work();
        track.states.push_back(state);
        track.forces.push_back(felt.force);
        track.kinds.push_back(state_of(felt));
        track.work.push_back(difference(work, before));
        track.moves.push_back(felt.moves);
        track.max_speed = std::max(track.max_speed, state.velocity.norm());
        before = work;
        hand.step(felt.force, script->target(static_cast<double>(tick) * tick_seconds));
    }
    return track;
}

TrackTimes time_track(const ContactSurface& surface, const WorkspaceMap& map,
                      const TouchTrack& track, double radius, int replays)
{
    TrackTimes times;
    times.nanoseconds.assign(track.states.size(), std::numeric_limits<std::int64_t>::max());
    for (int replay = 0; replay < replays; ++replay) {
        HapticRenderer renderer = renderer_of(surface, map, radius);
        for (std::size_t tick = 0; tick < track.states.size(); ++tick) {
            const std::int64_t begin = nanoseconds_now();
            const RenderTick& felt = renderer.tick(track.states[tick], tick_seconds);
            const std::int64_t end = nanoseconds_now();
            times.nanoseconds[tick] = std::min(times.nanoseconds[tick], end - begin);
            if (replay == 0) times.first.push_back(end - begin);
            times.differences += felt.force != track.forces[tick] ? 1U : 0U;
        }
    }
    return times;
}

TrackTimes time_track(const BoxTree& tree, const TouchModel& model, const TouchTrack& track,
                      int replays)
{
    constexpr double offset = 1e-6; // of the extent
    TrackTimes times;
    times.nanoseconds.assign(track.states.size(), std::numeric_limits<std::int64_t>::max());
    for (int replay = 0; replay < replays; ++replay) {
        GodObject proxy(tree, offset * model.surface->scale().extent);
        if (!track.states.empty())
            proxy.place(model.map.to_model(track.states.front().pose.translation));
        for (std::size_t tick = 0; tick < track.states.size(); ++tick) {
            const std::int64_t begin = nanoseconds_now();
            (void)proxy.follow(model.map.to_model(track.states[tick].pose.translation));
            const std::int64_t end = nanoseconds_now();
            times.nanoseconds[tick] = std::min(times.nanoseconds[tick], end - begin);
        }
    }
    return times;
}

} // namespace proxima::bench
