// Keeps a virtual wall from giving a device more energy than it took, or the device starts to
// oscillate by itself ([hannaford-2002]), by the evidence and the answers of swing_response.h.
//
// Damping comes first because it is enough for a hand: with B >= K (delay + T / 2) a contact gives
// nothing at the rates of a hand, whatever hand it is and however long it taps or trembles. All known
// devices allow that much at their greatest stiffness for delays up to three ticks. The damping is
// late too: a wall that has all of it can still drive a swing that is in contact for less than six
// delays a cycle, where it is stiff enough to make contacts of the lightest device that brief. A slew
// limit that holds the force back makes it later still. Whatever swings more slowly is moved by a
// hand, and is not softened.
//
// Positions and velocities are the device's own, in the frame of what carries it (carried_frame.h). A swing is
// answered only where at least half of the motion against the surface, in squares of velocities, is
// the device's own: otherwise a surface that shakes drives it.
#pragma once

#include "haptics/force/energy_account.h"
#include "haptics/force/swing_response.h"
#include "proxima/device.h"
#include "proxima/geometry.h"
#include "proxima/haptic_renderer.h"

#include <span>

namespace proxima {

/// The force of a contact in a tick. Both parts are zero where nothing is touched.
struct ContactForce {
    Vec3 spring = Vec3::Zero(); ///< N, without damping
    Vec3 whole = Vec3::Zero();  ///< N, with the surface's damping
    double stiffness = 0;       ///< N/m, of the surface
    double damping = 0;         ///< N s/m, of the surface
    /// N, part of the spring: the pull of a stick point along the surface
    Vec3 aside = Vec3::Zero();
    /// m: how far the surface has moved in the frame in which the device's positions are
    Vec3 surface = Vec3::Zero();
    Vec3 surface_velocity = Vec3::Zero(); ///< m/s, in space
};

/// One per device. noexcept, no allocation, O(1).
class PassivityGuard {
public:
    PassivityGuard(Guard mode, const DeviceLimits& limits) noexcept
        : mode_(mode), max_force_(limits.max_force), max_damping_(limits.max_damping)
    {}

    /// The force for the next tick, from the device's motion in the frame. \pre all finite, seconds > 0
    [[nodiscard]] Vec3 pass(const Vec3& position, const Vec3& velocity, const ContactForce& force,
                            double seconds) noexcept;

    /// The force that the device got after later guards.
    void applied(const Vec3& force) noexcept;

    /// Forgets the motion: the device jumped, or it touches another surface. What the guard adds
    /// stays.
    void restart() noexcept;

    /// As new: no damping, no softening, an empty report.
    void reset() noexcept;

    /// Whether the last contact is so long ago that motions in it no longer matter.
    [[nodiscard]] bool is_away() const noexcept
    {
        const bool may_return = motion_.speed_out > 0 && motion_.bouncing.is_bouncing();
        return motion_.swing.is_away() && !may_return;
    }

    /// s as it is applied, 1 where no contact has oscillated.
    [[nodiscard]] double softness() const noexcept
    {
        return mode_ == Guard::on ? response_.softness() : 1;
    }
    /// The damping that the guard adds, N s/m.
    [[nodiscard]] double added_damping() const noexcept
    {
        return mode_ == Guard::on ? response_.damping() : 0;
    }
    [[nodiscard]] const SwingReport& report() const noexcept { return response_.report(); }

private:
    /// The one motion of a point.
    [[nodiscard]] std::span<WatchedMotion> motions() noexcept { return {&motion_, 1}; }
    [[nodiscard]] Vec3 guarded(const ContactForce& force, const Vec3& velocity) const noexcept;

    Guard mode_;
    double max_force_;
    double max_damping_;
    WatchedMotion motion_;
    EnergyAccount account_;
    SwingResponse response_;
    Vec3 wanted_ = Vec3::Zero(); ///< N: what the device would get without a slew limit
    double stiffness_ = 0;       ///< N/m, of the last contact
    double surface_damping_ = 0; ///< N s/m
};

} // namespace proxima
