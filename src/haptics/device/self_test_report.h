// What the record of a self-test (self_test.h) says of a device, and the settings that follow.
//
//     b damping   f friction   m mass   D encoder step   d delay      measured
//     T tick      K_max, B_max                                        stated
//     B    the surface's damping      chosen: no more than f T / D, so that a step of the encoder
//                                     causes no force that can be felt through the friction, and
//                                     than 0.3 m / (T / 2 + d): late damping drives
//     K <= (b + B) / (T / 2 + d)      the wall does not oscillate by itself   [colgate-1997]
//     K <= 2 f / D                    nor does an encoder step make it        [abbott-2005]
//     K <= K_max                      as the maker says
//     K <= 2 b / T                    passive without B, whatever holds it    [abbott-2005]
//
// The last limit is reported and not obeyed: it leaves out the damping of the surface and of the hand,
// and a wall above it is stable as long as it is below the others.
#pragma once

#include "haptics/device/encoder_step.h"
#include "haptics/device/motion_fit.h"
#include "haptics/device/self_test.h"

#include <array>
#include <optional>

namespace proxima {

/// How regularly samples came while a hand moved the device.
struct SampleTiming {
    double seconds = 0;
    std::uint64_t ticks = 0;
    std::uint64_t samples = 0;     ///< new ones
    double sample_rate = 0;        ///< new samples per second
    double mean_interval = 0;      ///< s, between new samples
    double interval_deviation = 0; ///< s, standard deviation
    double interval_p99 = 0;       ///< s: 99 of 100 are no longer
    double longest_interval = 0;   ///< s
    /// The part of samples that repeat the position before, of those in which the tip moved by more
    /// than three steps a tick: the device measures less often than it is asked. Nothing where the tip
    /// was never that fast.
    std::optional<double> repeated;
};

/// What was found along an axis of the device.
struct AxisReport {
    EncoderStep encoder;
    double noise = 0;                               ///< m, standard deviation at rest
    double noise_range = 0;                         ///< m, largest less smallest position at rest
    std::array<SelfTestOutcome, 2> ramps = {};      ///< along +axis and -axis
    std::array<std::optional<double>, 2> breakaway; ///< N that moved the tip, along +axis and -axis
    std::optional<double> static_friction; ///< N: the mean of both, which weight cancels in
    double weight = 0;                     ///< N along the axis: half of what they differ by
    std::array<SelfTestOutcome, 2> pushes = {};
    MotionFit motion;
};

/// Which limit a stiffness meets first.
enum class StiffnessLimit : std::uint8_t { device, delay, encoder };

/// Settings for a device, by the axis that allows least.
struct SuggestedSettings {
    double stiffness = 0; ///< N/m, a fifth below the limit
    double damping = 0;   ///< N s/m
    StiffnessLimit limit = StiffnessLimit::device;
    double by_delay = 0;              ///< N/m: (b + B) / (T / 2 + d)
    double by_device = 0;             ///< N/m
    std::optional<double> by_encoder; ///< N/m: 2 f / D; none where f or D is not known
    std::optional<double> passive;    ///< N/m: 2 b / T; none where b is not certain
};

struct SelfTestReport {
    SampleTiming timing;
    std::array<AxisReport, 3> axes;
    bool rested = false; ///< the tip came to rest after the release
    bool held = false;   ///< something held the tip while the motors pushed
    int delay = 0;       ///< ticks, the largest of the axes for which one was found
    double step = 0;     ///< m, the coarsest of the axes
    /// None without a motion, or where the delay along an axis may be longer than all that were
    /// tried.
    std::optional<SuggestedSettings> settings;
    double largest_force = 0; ///< N that the test allowed itself

    /// Whether the delay along an axis may be longer than all that were tried.
    [[nodiscard]] bool any_is_later() const noexcept;
};

/// Computes the report. A second or two. \pre the loop has ended
[[nodiscard]] SelfTestReport report_of(const SelfTest& test, const DeviceLimits& limits);

/// Settings for an axis whose motion was found and whose encoder has a step, m, or 0. Numbers that
/// are not certain count as 0 damping and unknown friction. \pre tick_seconds > 0, the mass is
/// positive
[[nodiscard]] SuggestedSettings suggest_settings(const DeviceLimits& limits, double tick_seconds,
                                                 int delay, const MotionFit& motion, double step);

} // namespace proxima
