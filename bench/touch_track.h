// What a hand does for some seconds, and what each tick of it costs.
//
//     record   the simulated hand follows a script, closed loop: what the device said is kept
//     replay   a fresh renderer feels it again, several times over; of each tick the least time
//
// Only what is computed is timed, from what the device says to the force: neither sleeping nor the
// hand. The least of several replays, each of the whole track so that caches are as cold as they
// were, leaves out what other programs on the machine take.
#pragma once

#include "god_object_peer.h"
#include "haptics/proxy/contact_cache.h"
#include "haptics/proxy/proxy.h"
#include "haptics/surface/contact_surface.h"
#include "proxima/device.h"
#include "proxima/haptic_renderer.h"
#include "touch_model.h"

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace proxima::bench {

inline constexpr double tick_seconds = 1e-3;

/// What a tick is about.
enum class TickState : std::uint8_t {
    free,    ///< nothing is touched
    contact, ///< held by one plane, sticking
    slide,   ///< held by one plane, sliding
    corner   ///< held by two or three planes
};
inline constexpr std::array<std::string_view, 4> tick_state_names = {"free", "contact", "slide",
                                                                     "corner"};

struct TouchTrack {
    std::vector<DeviceState> states;
    std::vector<Vec3> forces;
    std::vector<TickState> kinds;
    std::vector<ContactWork> work;  ///< of each tick
    std::vector<std::size_t> moves; ///< of all slides of each tick
    double max_speed = 0;           ///< m/s
};

[[nodiscard]] TickState state_of(const RenderTick& tick);

/// What was asked for between two accounts.
[[nodiscard]] ContactWork difference(const ContactWork& after, const ContactWork& before);

/// \pre there is such a script, and something to touch
[[nodiscard]] TouchTrack record_track(const TouchModel& model, std::string_view script,
                                      std::uint64_t ticks, double radius);

struct TrackTimes {
    std::vector<std::int64_t> nanoseconds; ///< of each tick, the least
    std::vector<std::int64_t> first;       ///< of each tick in the first replay, with all noise
    std::uint64_t differences = 0;         ///< ticks whose force was another: must be none
};

/// The renderer over a surface: the octree's, or one that keeps nothing.
[[nodiscard]] TrackTimes time_track(const ContactSurface& surface, const WorkspaceMap& map,
                                    const TouchTrack& track, double radius, int replays);

/// The proxy of the baseline alone, without forces.
[[nodiscard]] TrackTimes time_track(const BoxTree& tree, const TouchModel& model,
                                    const TouchTrack& track, int replays);

/// The octree's surface asked anew for every question of a tick.
class AskedSurface final : public ContactSurface {
public:
    explicit AskedSurface(const IndexContactSurface& surface) : surface_(surface) {}
    [[nodiscard]] const SurfaceScale& scale() const noexcept override { return surface_.scale(); }
    [[nodiscard]] std::size_t collect(const Vec3& p, double distance,
                                      std::span<ContactTriangle> buffer) const noexcept override
    {
        return surface_.collect(p, distance, buffer);
    }
    [[nodiscard]] double clearance(const Vec3& p) const noexcept override
    {
        return surface_.clearance(p);
    }

private:
    const IndexContactSurface& surface_;
};

} // namespace proxima::bench
