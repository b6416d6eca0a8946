// Keeps a virtual wall from giving a device more energy than it took, or the device starts to
// oscillate by itself ([hannaford-2002]).
//
//     evidence     a motion to and fro that does not fade (swing_detector.h), while the contact gave
//                  more energy than a device takes (energy_account.h)
//     damping      the first answer: twice as much as the contact gave, over v^2, up to the device's
//                  limit
//     softening    the second, where all damping does not end it and contacts are brief: the force is
//                  scaled by s, from 1 down to a fifth, and the guard's damping by its square root
//     trust        a contact that takes energy for every delay cannot keep a swing going. Where a
//                  motion does not fade all the same a hand makes it: damping ends, and begins again
//                  only where the motion doubles, or after some seconds
//     recovery     both halve or double in four seconds, once the contact no longer swings
//
// Damping comes first because it is enough for a hand: with B >= K (delay + T / 2) a contact gives
// nothing at the rates of a hand, whatever hand it is and however long it taps or trembles. All known
// devices allow that much at their greatest stiffness for delays up to three ticks. The damping is
// late too: a wall that has all of it can still drive a swing that is in contact for less than six
// delays a cycle, where it is stiff enough to make contacts of the lightest device that brief. A slew
// limit that holds the force back makes it later still. Whatever swings more slowly is moved by a
// hand, and is not softened.
#pragma once

#include "haptics/force/energy_account.h"
#include "haptics/force/swing_detector.h"
#include "proxima/device.h"
#include "proxima/geometry.h"
#include "proxima/haptic_renderer.h"

#include <cstdint>

namespace proxima {

/// The force of a contact in a tick. Both parts are zero where nothing is touched.
struct ContactForce {
    Vec3 spring = Vec3::Zero(); ///< N, without damping
    Vec3 whole = Vec3::Zero();  ///< N, with the surface's damping
    double stiffness = 0;       ///< N/m, of the surface
    double damping = 0;         ///< N s/m, of the surface
    /// N, part of the spring: the pull of a stick point along the surface
    Vec3 aside = Vec3::Zero();
};

/// What the guard saw in a session, and did. With Guard::observe, what it would have done.
struct SwingReport {
    std::uint64_t damped_ticks = 0;   ///< in contact, with damping of the guard's
    std::uint64_t softened_ticks = 0; ///< in contact, with s < 1
    std::uint64_t swings = 0;         ///< times that damping began
    std::uint64_t softenings = 0;     ///< times that s fell below 1
    double most_damping = 0;          ///< N s/m, of the guard's
    double lowest_softness = 1;       ///< s
    double longest_softening = 0;     ///< s, from s = 1 to s = 1
    double most_given = 0;            ///< J, in a cycle of a swing, for the worst delay
};

/// One per device. noexcept, no allocation, O(1).
class PassivityGuard {
public:
    PassivityGuard(Guard mode, const DeviceLimits& limits) noexcept
        : mode_(mode), max_force_(limits.max_force), max_damping_(limits.max_damping)
    {}

    /// The force for the next tick. \pre all finite, seconds > 0
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
    [[nodiscard]] bool is_away() const noexcept { return swing_.is_away(); }

    /// s as it is applied, 1 where no contact has oscillated.
    [[nodiscard]] double softness() const noexcept { return mode_ == Guard::on ? softness_ : 1; }
    /// The damping that the guard adds, N s/m.
    [[nodiscard]] double added_damping() const noexcept
    {
        return mode_ == Guard::on ? softened_damping() : 0;
    }
    [[nodiscard]] const SwingReport& report() const noexcept { return report_; }

private:
    void judge(const SwingTick& tick, double seconds) noexcept;
    void answer(const SwingTick& tick, double needed, bool brief) noexcept;
    void trust_hand(double given) noexcept;
    void soften(double factor) noexcept;
    [[nodiscard]] double softened_damping() const noexcept;
    void recover(double seconds) noexcept;
    void mark() noexcept;
    [[nodiscard]] Vec3 guarded(const ContactForce& force, const Vec3& velocity) const noexcept;

    Guard mode_;
    double max_force_;
    double max_damping_;
    SwingDetector swing_;
    EnergyAccount account_;
    EnergySums leg_began_;       ///< the account at the last turn
    EnergySums cycle_began_;     ///< and at the turn before
    bool gives_ = false;         ///< the last cycle gave more than a device takes
    int kept_legs_ = 0;          ///< in succession, since the last answer
    double trust_ = 0;           ///< s, for which a hand's motion is not answered
    double trusted_leg_ = 0;     ///< m, of that motion
    Vec3 wanted_ = Vec3::Zero(); ///< N: what the device would get without a slew limit
    int late_ = 0;               ///< ticks for which it has not got it
    int leg_late_ = 0;           ///< the most of them in this leg
    int last_leg_late_ = 0;
    double stiffness_ = 0;       ///< N/m, of the last contact
    double surface_damping_ = 0; ///< N s/m
    double damping_ = 0;
    double softness_ = 1;
    double softened_seconds_ = 0; ///< s, of the softening in progress
    SwingReport report_;
};

} // namespace proxima
