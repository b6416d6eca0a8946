// The quality of a touch session: statistics of its ticks.
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

/// Statistics of one object of a scene.
struct ObjectQuality {
    std::uint64_t touching_ticks = 0; ///< in which it touched the proxy
    std::uint64_t moving_ticks = 0;
    double max_carrying = 0; ///< m/s, of its surface at the proxy in these ticks
};

struct QualityReport {
    std::uint64_t ticks = 0;
    std::uint64_t touching_ticks = 0;
    std::uint64_t sticking_ticks = 0;
    /// Pop-through: moves of the proxy through a triangle; with penalty forces, ticks that passed the
    /// surface or pushed against the side of the tick before.
    std::uint64_t passes = 0;
    std::uint64_t limited_ticks = 0; ///< slides that ended by their number of moves
    std::uint64_t overloaded_ticks = 0;
    std::uint64_t faulty_ticks = 0; ///< input that was not finite, jumped, or not well
    double max_force = 0;           ///< N
    double max_spring = 0;          ///< N, before clamp, slew and ramps
    double max_depth = 0;           ///< m
    double max_speed = 0;           ///< m/s, of the device
    /// The largest |change of the spring's force|, without damping, between two ticks of a contact,
    /// over K (|step of the proxy| + |step of the device|): above 1 only where the force jumps.
    double max_step_ratio = 0;
    double max_turn_degrees = 0;      ///< of the force between two ticks of a contact
    double taken_energy = 0;          ///< J, by the trapezoidal sum of force times step; 0 after a
                                      ///< closed path without friction and damping
    std::uint64_t max_moves = 0;      ///< of the proxy in a tick
    std::uint64_t moves = 0;          ///< of all
    std::uint64_t moving_ticks = 0;   ///< in which an object of a scene moved
    std::uint64_t squeezed_ticks = 0; ///< in which moving objects left no free position
    std::vector<ObjectQuality> objects; ///< of a scene
};

/// Gathers statistics. One thread; add() is noexcept and without allocation, 1 us.
class QualityMeter {
public:
    /// Tests the proxy's moves exactly against the triangles of a surface, which must outlive this.
    QualityMeter(const ContactSurface& surface, WorkspaceMap map);

    /// Tests moves against a scene whose bodies stay the same, and also, in each object's frame, the
    /// path on which objects carried the proxy. add() must be called in every tick of the scene.
    QualityMeter(const TouchScene& scene, const WorkspaceMap& map);

    void add(const RenderTick& tick, const Vec3& velocity, std::span<const Vec3> path) noexcept;
    /// Counts a pop-through that the renderer found (SurfaceRenderer::popped).
    void add_pass() noexcept { ++report_.passes; }

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
