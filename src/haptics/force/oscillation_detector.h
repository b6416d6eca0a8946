// Whether a contact swings by itself: held forces that come late give a device back more speed than
// it brought, whatever its mass, its damping and the delay, which nothing here knows.
//
//     in    the device moves against the force     greatest speed  v_in
//     out   the force moves the device             greatest speed  v_out
//     L     += log(v_out / v_in), not below 0      the growth of a swing, over successive ones
//
// What a hand holds loses speed at every turn. A hand that presses slowly and leaves fast gains
// some once: several turns in succession count, each only so much, and of turns that a hand could
// make by itself little; one alone counts that came in faster than hands tremble and goes out twice
// as fast within a twentieth of a second.
//
// Speeds are means of four ticks, for encoders have steps: swings of 12 ticks and less fade in
// them, and are seen by where they turn (fast_oscillations.h).
#pragma once

#include "haptics/force/fast_oscillations.h"
#include "proxima/geometry.h"

#include <array>
#include <cstddef>

namespace proxima {

/// One per device. noexcept, no allocation, O(1).
class OscillationDetector {
public:
    /// The device is at `position`, where `force` is wanted: zero away from all contacts. Returns
    /// the growth log(v_out / v_in) of the turn that proves that the contact swings by itself, else
    /// 0. \pre all finite, seconds > 0
    [[nodiscard]] double watch(const Vec3& position, const Vec3& force, double seconds) noexcept;

    /// As new: the device is somewhere else.
    void restart() noexcept { *this = {}; }

    /// Whether the last contact is so long ago that nothing of it is looked at any more.
    [[nodiscard]] bool is_away() const noexcept { return away_ > last_ticks; }

private:
    enum class Leg { none, in, out };
    /// One way, in or out.
    struct Way {
        enum class State : bool { going_on, over };
        double peak = 0;   ///< m/s
        double length = 0; ///< m
        double seconds = 0;
        Vec3 along = Vec3::Zero(); ///< of the force at the peak
        void add(double speed, double tick, const Vec3& direction) noexcept;
    };
    [[nodiscard]] double judge(const Way& in, const Way& out, Way::State state) noexcept;
    [[nodiscard]] double judge_last(const Vec3& velocity) noexcept;

    static constexpr std::size_t window = 4; ///< ticks that speeds are taken over
    static constexpr int last_ticks = 10;    ///< after a contact in which late forces still push

    std::array<Vec3, window> places_ = {};
    std::size_t ticks_ = 0;
    Vec3 along_ = Vec3::Zero(); ///< of the last force
    int away_ = last_ticks + 1; ///< ticks since there was one
    Leg leg_ = Leg::none;
    Way in_;
    Way out_;
    bool judged_ = false; ///< the turn at hand
    Way last_in_;         ///< of the turn before
    Way last_out_;
    std::size_t pending_ = 0; ///< ticks until it is judged
    double since_turn_ = 0;   ///< s
    double growth_ = 0;       ///< L
    int turns_ = 0;           ///< in succession, with growth
    FastOscillations quick_;
};

} // namespace proxima
