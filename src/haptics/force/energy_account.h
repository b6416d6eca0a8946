// The energy that a contact gave a device, beyond what its spring had stored.
//
//     F     the force that the device gets, held for a tick
//     E     the spring's part of it, without damping
//     g_n   += F(k - n) . dx(k) - (E(k) + E(k+1)) / 2 . dx(k)        n = 0 to 3 ticks of delay
//     dx    the step in the frame of what carries the device, or against the surface
//
// The second term is what the spring gives back of what it took: without it a hand that presses and
// lets go would seem to be pushed, and stored energy would hide what an oscillation gains. What is
// left is the work of the hold and of the delay, about K (n + 1/2) T v^2 per second, less what
// damping takes, about B v^2 ([colgate-1997], [hannaford-2002]). The delay of a device is not known:
// a contact is passive for certain where no g_n grows.
//
// Positions come in steps of an encoder, and forces of damping in the same ticks. Steps are spread
// over 10 ticks, so that forces that are late by 3 ticks and 1 more of a velocity by differences
// meet the motion that they belong to. Oscillations of 10 ticks vanish in this.
#pragma once

#include "proxima/geometry.h"

#include <array>
#include <cstddef>

namespace proxima {

/// The longest delay of a force, in ticks, that is reckoned with.
inline constexpr std::size_t most_delay_ticks = 3;

/// Sums since restart() of one of the two steps.
struct MotionSums {
    std::array<double, most_delay_ticks + 1> given = {}; ///< J, by ticks of delay
    double motion = 0;                                   ///< J s / kg: of v^2, by time
    double motion_in_contact = 0;                        ///< the part where a force acts

    /// The most that was given since an earlier tick, whatever the delay, J.
    [[nodiscard]] double most_given_since(const MotionSums& earlier) const noexcept;
    MotionSums& operator+=(const MotionSums& other) noexcept;
};

/// Differences between two ticks are those of the motion between them.
struct EnergySums {
    MotionSums own;      ///< in the frame
    MotionSums relative; ///< against the surface
};

/// One per device. noexcept, no allocation, O(1).
class EnergyAccount {
public:
    /// A tick at a position with the spring's force there, from a surface that has moved so far.
    /// \pre finite, seconds > 0
    void add(const Vec3& position, const Vec3& spring, double seconds,
             const Vec3& surface = Vec3::Zero()) noexcept;

    /// The force that the device gets in this tick.
    void applied(const Vec3& force) noexcept { at(0).force = force; }

    void restart() noexcept { *this = {}; }

    [[nodiscard]] const EnergySums& sums() const noexcept { return sums_; }

private:
    struct Place {
        Vec3 position = Vec3::Zero();
        double returned = 0; ///< J, by the spring in the step to here
    };
    struct Tick {
        Place own;
        Place relative;
        Vec3 spring = Vec3::Zero();
        Vec3 force = Vec3::Zero();
    };
    static constexpr std::size_t window = 10;
    static constexpr std::size_t kept = 16;
    static_assert(kept > window && kept > window / 2 + most_delay_ticks + 1);

    /// The tick so many ticks ago.
    [[nodiscard]] Tick& at(std::size_t ago) noexcept { return ticks_[(now_ - ago) % kept]; }
    void add_step(Place Tick::*place, double& returned, MotionSums& sums, double seconds) noexcept;

    std::array<Tick, kept> ticks_ = {};
    std::size_t now_ = kept; ///< number of the last tick, from `kept` on
    double returned_ = 0;    ///< J, in the window
    double relative_returned_ = 0;
    EnergySums sums_;
};

} // namespace proxima
