// Judges motions that do not fade by the energy of their contact, and answers those that a wall drives:
// the rules of the passivity guard (passivity.h), for a point's motion and for the six of a tool.
//
//     evidence     a motion to and fro that does not fade (swing_detector.h), while the contact gave
//                  more energy than a device takes (energy_account.h)
//     bounces      where the legs are slow: contacts in succession that throw the device back faster than it
//                  came, though no more than late forces can, while they gave energy (swing_bounces.h). Nothing
//                  gave it any in the flights between, as a hand does that throws it at a wall that takes some
//     damping      the first answer: twice as much as the contact gave, over v^2, up to the most that
//                  the device allows
//     softening    the second, where all damping does not end it and contacts are brief: the force is
//                  scaled by s, from 1 down to a fifth, and the guard's damping by its square root
//     trust        a contact that takes energy for every delay cannot keep a swing going. Where a
//                  motion does not fade all the same a hand makes it: damping ends, and begins again
//                  only where the motion doubles, or after some seconds
//     recovery     both halve or double in four seconds, once the contact no longer swings, and the device
//                  no longer bounces after an answer to that
#pragma once

#include "haptics/force/energy_account.h"
#include "haptics/force/swing_bounces.h"
#include "haptics/force/swing_detector.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>

namespace proxima {

/// What the guard saw in a session, and did. With Guard::observe, what it would have done.
struct SwingReport {
    std::uint64_t damped_ticks = 0;   ///< in contact, with damping of the guard's
    std::uint64_t softened_ticks = 0; ///< in contact, with s < 1
    std::uint64_t swings = 0;         ///< times that damping began
    std::uint64_t softenings = 0;     ///< times that s fell below 1
    double most_damping = 0;          ///< N s/m, of the guard's
    double lowest_softness = 1;       ///< s
    double longest_softening = 0;     ///< s, from s = 1 to s = 1
    double most_given = 0;            ///< J, in a cycle of a swing or a bounce, for the worst delay
};

/// A motion that is watched: a point's along the force of its contact, or a tool's along one axis.
struct WatchedMotion {
    SwingDetector swing;
    BounceDetector bouncing; ///< of a point, or of a tool's displacement
    EnergySums leg_began;    ///< the account at the last turn
    EnergySums cycle_began;  ///< and at the turn before
    bool gives = false;      ///< the last cycle gave more than a device takes
    int kept_legs = 0;       ///< in succession, since the last answer
    double trusted_leg = 0;  ///< m, of the motion of a hand
    int leg_late = 0;        ///< most ticks in this leg for which the device has not got its force
    int last_leg_late = 0;
    EnergySums touched; ///< the account where the last contact after a flight, or its answer, began
    int bounce_late = 0; ///< most ticks since then for which the device has not got its force
    int bounces = 0; ///< in succession, that the wall threw back faster; strong ones count twice
    double speed_out = 0; ///< m/s, of the last bounce
    bool thrown = false;  ///< bounces were answered, and nothing but the wall has driven them since

    /// Whether the contact may drive this motion.
    [[nodiscard]] bool is_driven() const noexcept
    {
        return (swing.is_swinging() && (gives || swing.is_fast())) ||
               (thrown && bouncing.is_bouncing());
    }
};

/// The contact in which a motion was seen.
struct SwungContact {
    double stiffness = 0;    ///< N/m
    double most_damping = 0; ///< N s/m, that the guard may add
};

/// One per device: the answer to all its motions. noexcept, no allocation, O(motions).
class SwingResponse {
public:
    /// Weighs a tick of one of the motions, with the account of all of them after it. \pre seconds > 0
    void judge(std::span<WatchedMotion> motions, WatchedMotion& motion, const SwingTick& tick,
               const EnergySums& sums, const SwungContact& contact, double seconds) noexcept;

    /// Weighs a contact between two flights, once it is over. After judge(). A tool that turns bounces
    /// faster and slower without a wall that gives energy, so that one bounce of it tells nothing.
    void judge_bounce(std::span<WatchedMotion> motions, WatchedMotion& motion, const Bounce& bounce,
                      const EnergySums& sums, const SwungContact& contact, double seconds) noexcept;

    /// Softening and damping fade, in this order, once none of the motions is driven.
    void recover(std::span<const WatchedMotion> motions, double seconds) noexcept;

    /// Says whether the device got what it should have got in this tick, which a slew limit may prevent.
    void applied(std::span<WatchedMotion> motions, bool in_full) noexcept;

    /// Counts a tick.
    void count(bool touches) noexcept
    {
        report_.damped_ticks += touches && damping_ > 0 ? 1U : 0U;
        report_.softened_ticks += touches && softness_ < 1 ? 1U : 0U;
    }

    /// Forgets what the motions had shown. What is added stays.
    void restart() noexcept
    {
        trust_ = 0;
        late_ = 0;
    }

    /// The factor of the force.
    [[nodiscard]] double softness() const noexcept { return softness_; }
    /// N s/m. Less than by s, so that a softened contact can stop what made it swing; never more than
    /// is allowed.
    [[nodiscard]] double damping() const noexcept { return std::sqrt(softness_) * damping_; }
    [[nodiscard]] bool acts() const noexcept { return softness_ < 1 || damping_ > 0; }
    [[nodiscard]] const SwingReport& report() const noexcept { return report_; }

    /// The force `whole` with this answer: softened, and damped but never so much that it turns round.
    /// Vectors have three or six components. \pre `whole` is clamped to the device's limit: softening an
    /// excessive force could still leave as much as the limit
    template <class Vector>
    [[nodiscard]] Vector answered(const Vector& whole, const Vector& velocity) const noexcept
    {
        const double size = whole.norm();
        if (!(size > 0)) return whole;
        const Vector along = whole / size;
        const Vector damped = -damping() * velocity;
        const double back = std::min(damped.dot(along) + softness_ * size, 0.0);
        return softness_ * whole + damped - back * along;
    }

private:
    [[nodiscard]] bool may_throw(const Bounce& bounce, double stiffness, int late_ticks,
                                 double seconds) const noexcept;
    void answer(std::span<WatchedMotion> motions, const SwingTick& tick, const EnergySums& sums,
                double most, double needed, bool brief) noexcept;
    void trust_hand(std::span<WatchedMotion> motions, WatchedMotion& motion, double given) noexcept;
    void soften(double factor) noexcept;

    double damping_ = 0;
    double softness_ = 1;
    double softened_seconds_ = 0; ///< s, of the softening in progress
    double trust_ = 0;            ///< s, for which a hand's motion is not answered
    int late_ = 0;                ///< ticks for which the device has not got its force
    SwingReport report_;
};

} // namespace proxima
