// How good the touch was: what a session of ticks amounts to.
#pragma once

#include "haptics/scene/contact_body.h"
#include "haptics/scene/moving_surface.h"
#include "haptics/surface/contact_surface.h"
#include "proxima/device.h"
#include "proxima/haptic_renderer.h"
#include "proxima/touch_scene.h"

#include <cstdint>
#include <vector>

namespace proxima {

/// What became of one object of a scene.
struct ObjectQuality {
    std::uint64_t touching_ticks = 0; ///< in which it held the proxy, alone or with others
    std::uint64_t moving_ticks = 0;
    double max_carrying = 0; ///< m/s: of its surface, where it held the proxy
};

struct QualityReport {
    std::uint64_t ticks = 0;
    std::uint64_t touching_ticks = 0;
    std::uint64_t sticking_ticks = 0;
    /// Pop-through: moves of the proxy through a triangle; by penalty forces ticks that leapt over
    /// the surface or were pushed against the side on which they were pushed out before.
    std::uint64_t passes = 0;
    std::uint64_t limited_ticks = 0; ///< slides that ended by their number of moves
    std::uint64_t overloaded_ticks = 0;
    std::uint64_t faulty_ticks = 0; ///< input that was no number, jumped, or not well
    double max_force = 0;           ///< N
    double max_spring = 0;          ///< N, before clamp, slew and ramps
    double max_depth = 0;           ///< m
    double max_speed = 0;           ///< m/s, of the device
    /// The largest |change of the spring's force|, damping apart, between two ticks of a contact,
    /// over K (|way of the proxy| + |way of the device|): above 1 only where the force jumps.
    double max_step_ratio = 0;
    double max_turn_degrees = 0; ///< of the force between two ticks of a contact
    double taken_energy = 0;     ///< J: by the trapezoidal sum of force times way; 0 after a closed
                                 ///< path without friction and damping
    std::uint64_t max_moves = 0; ///< of the proxy in a tick
    std::uint64_t moves = 0;     ///< of all
    std::uint64_t moving_ticks = 0;     ///< in which an object of a scene moved
    std::uint64_t squeezed_ticks = 0;   ///< in which moving objects left the proxy no room
    std::vector<ObjectQuality> objects; ///< of a scene
};

/// Adds ticks up. One thread; add() is noexcept and without allocation, 1 us.
class QualityMeter {
public:
    /// The surface must outlive this: the proxy's moves are held against its triangles, exactly.
    QualityMeter(const ContactSurface& surface, WorkspaceMap map);

    /// The same of a scene whose bodies stay the same, held also against what moves: as each object
    /// sees it, the way from the last tick's place to where they have carried the proxy. Wants
    /// every tick of the scene.
    QualityMeter(const TouchScene& scene, const WorkspaceMap& map);

    void add(const RenderTick& tick, const Vec3& velocity, std::span<const Vec3> path) noexcept;

    [[nodiscard]] const QualityReport& report() const noexcept { return report_; }

private:
    [[nodiscard]] bool passes(const ContactSurface& surface, const Vec3& from,
                              const Vec3& to) noexcept;
    [[nodiscard]] bool passes(const ContactBody& body, const Vec3& from, const Vec3& to) noexcept;
    [[nodiscard]] bool passes_standing(const Vec3& from, const Vec3& to) noexcept;
    void count_passes(std::span<const Vec3> path) noexcept;
    void count_carried(const RenderTick& tick, std::span<const Vec3> path) noexcept;
    void add_objects(const RenderTick& tick) noexcept;

    const ContactSurface& surface_;
    const MovingSurface* scene_ = nullptr;
    WorkspaceMap map_;
    std::vector<ContactTriangle> near_;
    QualityReport report_;
    RenderTick last_;
};

} // namespace proxima
