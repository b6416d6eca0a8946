// Detects contacts that throw a device back, between flights that may last for seconds.
//
//           flight            touched     the first tick with a force
//      \    ___    /          left        some ticks after the last one: a force that is late has ended,
//       \  /   \  /                       and the account holds all of the contact (energy_account.h)
//        \/     \/            speeds      of the flight, next to the contact and along its push
//      contact  contact
//
// A wall that gives energy throws the device back faster than it came. A hand that pushes evenly, or
// pulls like a spring, does no work from touch to leaving. So whatever it does in the flight, and however
// long that lasts, the speeds tell what the wall did, but for a hand that works within the contact.
// Speeds are those against the surface: one that comes or goes would seem to give energy or to take it.
// A force that rises anew before the last one has ended goes on with the same contact.
#pragma once

#include "haptics/force/energy_account.h"
#include "proxima/geometry.h"

#include <array>
#include <cstddef>

namespace proxima {

/// What a tick says of a contact.
struct Bounce {
    bool touched = false; ///< it begins
    bool left = false;    ///< it is over: what follows is of it
    double flight = 0;    ///< s, before it
    double contact = 0;   ///< s, without the time in which the force was at its limit
    double touching = 0;  ///< s, with it
    double speed_in = 0;  ///< m/s, against the surface
    double speed_out = 0; ///< m/s
};

/// One per motion. noexcept, no allocation, O(1).
class BounceDetector {
public:
    /// s. A device of 0.1 kg under half its weight flies as long from 5 m.
    static constexpr double longest_flight = 3;
    static constexpr double longest_contact = 0.25; ///< s

    /// Like SwingDetector::watch(), with positions less the way of what is touched, and its velocity in
    /// space, which counts where there is a force.
    [[nodiscard]] Bounce watch(const Vec3& position, const Vec3& force,
                               const Vec3& surface_velocity, double seconds,
                               double most_force) noexcept;

    void restart() noexcept { *this = {}; }

    /// Whether neither a flight nor a contact lasts so long that no bounce goes on.
    [[nodiscard]] bool is_bouncing() const noexcept
    {
        return flight_ <= longest_flight && touching_ <= longest_contact;
    }

private:
    /// Ticks until a force that is late no longer acts.
    static constexpr std::size_t settling = most_delay_ticks + 1;
    /// Ticks of a flight between two positions that give a speed: as many as the account's window, so
    /// that it is complete when the speed is known. A step of the coarsest encoder makes 5 mm/s of them.
    static constexpr std::size_t span = 10;
    static constexpr std::size_t kept = 16;
    static_assert(kept > settling + span);

    struct Tick {
        Vec3 position = Vec3::Zero();
        double seconds = 0; ///< since restart()
    };

    [[nodiscard]] const Tick& at(std::size_t ago) const noexcept
    {
        return ticks_[(now_ - ago) % kept];
    }
    [[nodiscard]] double speed(std::size_t ago) const noexcept;
    void touch(const Vec3& along, const Vec3& surface_velocity) noexcept;

    std::array<Tick, kept> ticks_ = {};
    std::size_t now_ = kept;     ///< number of the last tick, from `kept` on
    Vec3 axis_ = Vec3::Zero();   ///< of the contact's first force
    double flight_ = 0;          ///< s since the last force
    double touching_ = 0;        ///< s in contact, since a flight that counts
    double surface_speed_ = 0;   ///< m/s, along the axis, in the last tick with a force
    std::size_t free_ticks_ = 0; ///< likewise, in ticks
    bool counts_ = false;        ///< the contact came after a flight, and pushes along one axis
    Bounce last_;                ///< the contact so far
};

} // namespace proxima
