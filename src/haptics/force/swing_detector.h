// Detects motions to and fro against a contact that do not fade.
//
//     leg         from one turn of the motion along the force to the next
//     amplitude   of a leg: the smaller of it and the leg before
//     swing       legs of which none has a smaller amplitude than the one before
//
//          /\      /\          A growing leg is reported while it lasts, as soon as it is as long as
//         /  \    /  \    /    the amplitude before, and again each time it is half as long again.
//     \  /    \  /    \  /
//      \/      \/      \/      Positions alone decide: a hand that taps by the clock comes out of a
//      leg leg leg leg leg     contact faster than it went in, and its amplitude stays the same.
//
// A contact that oscillates by itself has grown legs, or as long as a limit keeps them. So has a hand
// that taps, and the energy tells them apart (passivity.h).
#pragma once

#include "proxima/geometry.h"

#include <limits>

namespace proxima {

/// What a tick adds to a swing. Amplitudes are lengths of legs, twice those of an oscillation.
struct SwingTick {
    bool turned = false;   ///< a new leg began
    bool reported = false; ///< the leg is longer than it would be if the motion faded
    int legs = 0;          ///< in succession of which none faded
    double length = 0;     ///< m, of the leg so far
    double growth = 1;     ///< the leg over the amplitude before
    bool fast = false;     ///< it and the leg before are faster than a hand moves to and fro
    double contact = 0;    ///< s in contact: of the last cycle or this one, whichever is longer
    bool quick = false;    ///< and it grew by half, with more acceleration than a hand has
};

/// One per device. noexcept, no allocation, O(1).
class SwingDetector {
public:
    /// A tick with the device at `position` and this force, zero away from contacts.
    /// Time with a force of `most_force` or more does not count as time in contact: a force that does
    /// not change is no later for its delay. \pre finite, seconds > 0
    [[nodiscard]] SwingTick
    watch(const Vec3& position, const Vec3& force, double seconds,
          double most_force = std::numeric_limits<double>::infinity()) noexcept;

    void restart() noexcept { *this = {}; }

    /// Whether the last contact is so long ago that its motion no longer matters.
    [[nodiscard]] bool is_away() const noexcept { return since_contact_ > longest_leg; }

    /// Whether the last leg ended, and the one since then lasts, within the time of a swing's leg.
    [[nodiscard]] bool is_swinging() const noexcept
    {
        return !is_away() && direction_ != 0 && amplitude_ > 0 && leg_seconds_ <= longest_leg;
    }
    [[nodiscard]] bool is_fast() const noexcept { return last_fast_; }
    /// Whether the last leg did not fade.
    [[nodiscard]] bool is_kept() const noexcept { return legs_ > 0; }
    /// The last leg, m; 0 where it was slower than a swing's.
    [[nodiscard]] double last_leg() const noexcept { return last_leg_; }

private:
    /// s: half a period of 2 Hz. A device of 0.3 kg on a wall of 160 N/m swings at 3.7 Hz.
    static constexpr double longest_leg = 0.25;

    void end_leg() noexcept;

    Vec3 axis_ = Vec3::Zero(); ///< of the last force
    Vec3 last_ = Vec3::Zero();
    double since_contact_ = std::numeric_limits<double>::infinity(); ///< s
    double height_ = 0;                                              ///< m along the axis
    double farthest_ = 0;                                            ///< end of the leg so far
    double turned_ = 0;                                              ///< its beginning
    double leg_seconds_ = 0;                                         ///< since the last turn
    double farthest_seconds_ = 0; ///< of these, until the farthest position
    double last_leg_ = 0;         ///< m
    double amplitude_ = 0;        ///< m, of the last leg; 0 where it began none
    double next_ = 1;             ///< growth that is reported next
    double contact_ = 0;          ///< s in contact of the leg so far
    double last_contact_ = 0;     ///< of the last leg
    double cycle_contact_ = 0;    ///< of the last two legs
    int direction_ = 0;           ///< of the leg: -1 or 1; 0 before the first
    int legs_ = 0;
    bool last_fast_ = false;
    bool first_leg_ = true; ///< the leg before is the first of a contact
};

} // namespace proxima
