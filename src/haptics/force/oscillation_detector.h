// Detects a contact that oscillates by itself: forces that are constant over a tick and arrive late
// give a device more speed than it brought, whatever its mass, damping and delay, which are unknown.
//
//     in    the device moves against the force     greatest speed  v_in
//     out   the force moves the device             greatest speed  v_out
//     L     += log(v_out / v_in), not below 0      the growth, over successive turns
//
// A device in a hand loses speed at every turn. A hand that presses slowly and leaves fast gains
// speed once. So several turns in succession are needed, and each counts up to a limit. Slow turns,
// which a hand could make by itself, count less. A single turn counts if it came in faster than
// hands tremble and goes out twice as fast within a twentieth of a second.
//
// Speeds are means of four ticks, for encoders have steps. Oscillations of 12 ticks and less vanish
// in these means and are detected by their turns (fast_oscillations.h).
#pragma once

#include "haptics/force/fast_oscillations.h"
#include "proxima/geometry.h"

#include <array>
#include <cstddef>

namespace proxima {

/// One per device. noexcept, no allocation, O(1).
class OscillationDetector {
public:
    /// A tick with the device at `position` and this force, zero away from all contacts. Returns the
    /// growth log(v_out / v_in) of a turn that proves an oscillation of the contact, else 0.
    /// \pre all finite, seconds > 0
    [[nodiscard]] double watch(const Vec3& position, const Vec3& force, double seconds) noexcept;

    /// Starts anew: the device jumped.
    void restart() noexcept { *this = {}; }

    /// Whether the last contact is too long ago to matter.
    [[nodiscard]] bool is_away() const noexcept { return away_ > last_ticks; }

private:
    enum class Leg { none, in, out };
    /// The motion in one direction, in or out.
    struct Stroke {
        enum class State : bool { ongoing, complete };
        double peak = 0;   ///< m/s
        double length = 0; ///< m
        double seconds = 0;
        Vec3 along = Vec3::Zero(); ///< of the force at the peak
        void add(double speed, double tick, const Vec3& direction) noexcept;
    };
    [[nodiscard]] double judge(const Stroke& in, const Stroke& out, Stroke::State state) noexcept;
    [[nodiscard]] double judge_last(const Vec3& velocity) noexcept;

    static constexpr std::size_t window = 4; ///< ticks that speeds are taken over
    static constexpr int last_ticks = 10;    ///< after a contact, in which late forces still push

    std::array<Vec3, window> positions_ = {};
    std::size_t ticks_ = 0;
    Vec3 along_ = Vec3::Zero(); ///< of the last force
    int away_ = last_ticks + 1; ///< ticks since the last force
    Leg leg_ = Leg::none;
    Stroke in_;
    Stroke out_;
    bool judged_ = false; ///< the current turn
    Stroke last_in_;      ///< of the turn before
    Stroke last_out_;
    std::size_t pending_ = 0; ///< ticks until the turn before is judged
    double since_turn_ = 0;   ///< s
    double growth_ = 0;       ///< L
    int turns_ = 0;           ///< in succession, with growth
    FastOscillations quick_;
};

} // namespace proxima
