#include "haptics/device/self_test_report.h"

#include "proxima/haptic_renderer.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <span>
#include <vector>

namespace proxima {

namespace {

/// What is left of a limit that was measured.
constexpr double caution = 0.8;

/// Damping B that comes late by t drives a mass m from B t / m = 1.57 on; less than a fifth of that is
/// damping as the formulas have it.
constexpr double damping_of_mass = 0.3;

/// Half of the window in which the speed of a fast motion is judged, samples.
constexpr std::size_t window = 8;
constexpr double steps_per_sample = 3;
constexpr std::size_t least_judged = 50;

using Samples = std::span<const SelfTestSample>;

Samples samples_of(const SelfTest& test, const SelfTestSegment& segment)
{
    return Samples(test.samples()).subspan(segment.begin, segment.end - segment.begin);
}

std::vector<SelfTestSample> fresh_samples(const SelfTest& test, SelfTestStep step)
{
    std::vector<SelfTestSample> fresh;
    for (const SelfTestSegment& segment : test.segments()) {
        if (segment.step != step) continue;
        for (const SelfTestSample& sample : samples_of(test, segment))
            if (sample.fresh) fresh.push_back(sample);
    }
    return fresh;
}

SampleTiming timing_of(const SelfTest& test)
{
    SampleTiming timing;
    std::vector<double> intervals;
    for (const SelfTestSegment& segment : test.segments()) {
        if (segment.step != SelfTestStep::slow && segment.step != SelfTestStep::fast) continue;
        const Samples samples = samples_of(test, segment);
        if (samples.empty()) continue;
        timing.ticks += samples.size();
        std::optional<double> before;
        for (const SelfTestSample& sample : samples) {
            if (!sample.fresh) continue;
            ++timing.samples;
            if (before) intervals.push_back(sample.arrival - *before);
            before = sample.arrival;
        }
    }
    if (intervals.empty()) return timing;
    const auto count = static_cast<double>(intervals.size());
    timing.seconds = std::accumulate(intervals.begin(), intervals.end(), 0.0);
    timing.mean_interval = timing.seconds / count;
    timing.sample_rate = timing.seconds > 0 ? count / timing.seconds : 0;
    double squares = 0;
    for (const double interval : intervals)
        squares += (interval - timing.mean_interval) * (interval - timing.mean_interval);
    timing.interval_deviation = std::sqrt(squares / count);
    std::ranges::sort(intervals);
    timing.interval_p99 = intervals[(intervals.size() - 1) * 99 / 100];
    timing.longest_interval = intervals.back();
    return timing;
}

/// Samples that repeat a position although the tip moves fast.
std::optional<double> repeated_part(std::span<const SelfTestSample> fast, const Vec3& steps)
{
    std::size_t judged = 0;
    std::size_t repeated = 0;
    const Vec3 least = 2 * window * steps_per_sample * steps.cwiseMax(1e-7);
    for (std::size_t i = window; i + window < fast.size(); ++i) {
        const Vec3 moved = (fast[i + window].position - fast[i - window].position).cwiseAbs();
        if ((moved.array() < least.array()).all()) continue;
        ++judged;
        repeated += fast[i].position == fast[i - 1].position ? 1U : 0U;
    }
    if (judged < least_judged) return std::nullopt;
    return static_cast<double>(repeated) / static_cast<double>(judged);
}

void measure_noise(std::span<const SelfTestSample> rest, std::array<AxisReport, 3>& axes)
{
    if (rest.empty()) return;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto k = static_cast<int>(axis);
        double mean = 0;
        double least = rest.front().position[k];
        double most = least;
        for (const SelfTestSample& sample : rest) {
            mean += sample.position[k] / static_cast<double>(rest.size());
            least = std::min(least, sample.position[k]);
            most = std::max(most, sample.position[k]);
        }
        double squares = 0;
        for (const SelfTestSample& sample : rest)
            squares += (sample.position[k] - mean) * (sample.position[k] - mean);
        axes[axis].noise = std::sqrt(squares / static_cast<double>(rest.size()));
        axes[axis].noise_range = most - least;
    }
}

std::vector<PushSample> along_axis(Samples samples, int axis)
{
    std::vector<PushSample> result;
    result.reserve(samples.size());
    for (const SelfTestSample& sample : samples)
        result.push_back({sample.seconds, sample.position[axis], sample.force[axis], sample.fresh});
    return result;
}

MotionFit fit_axis(const SelfTest& test, int axis, double step)
{
    std::vector<std::vector<PushSample>> records;
    std::vector<std::size_t> leads;
    for (const SelfTestSegment& segment : test.segments()) {
        if (segment.step != SelfTestStep::push || segment.axis != axis ||
            segment.outcome != SelfTestOutcome::complete)
            continue;
        records.push_back(along_axis(samples_of(test, segment), axis));
        leads.push_back(segment.lead);
    }
    std::vector<Push> pushes;
    for (std::size_t i = 0; i < records.size(); ++i) pushes.push_back({records[i], leads[i]});
    return fit_motion(pushes, {.resolution = step});
}

/// The force of a ramp when the tip began to move: earlier than it is seen, by the time in which the
/// growing force moves the mass by as much as can be seen, and by the delay.
double breakaway_of(Samples samples, const SelfTestSegment& segment, const AxisReport& axis,
                    const SelfTestOptions& options)
{
    double least = samples.front().position[segment.axis];
    double most = least;
    for (std::size_t i = 0; i < segment.lead; ++i) {
        least = std::min(least, samples[i].position[segment.axis]);
        most = std::max(most, samples[i].position[segment.axis]);
    }
    std::size_t first = samples.size();
    while (first > segment.lead) {
        const double x = samples[first - 1].position[segment.axis];
        if (x >= least && x <= most) break;
        --first;
    }
    if (first == samples.size()) --first;
    const double force = std::abs(samples[first].force[segment.axis]);
    if (!axis.motion.found) return force;
    // The tip may have been anywhere between two steps when it rested.
    const double seen = axis.encoder.step / 2 + (most - least) / 2;
    const double rate = options.ramp_rate;
    const double late = std::cbrt(6 * axis.motion.mass.value * seen / rate) +
                        options.tick_seconds * (axis.motion.delay + 1);
    return std::max(0.0, force - rate * late);
}

void measure_ramps(const SelfTest& test, std::array<AxisReport, 3>& axes)
{
    for (const SelfTestSegment& segment : test.segments()) {
        if (segment.step != SelfTestStep::ramp && segment.step != SelfTestStep::push) continue;
        AxisReport& axis = axes[static_cast<std::size_t>(segment.axis)];
        const std::size_t side = segment.sign > 0 ? 0 : 1;
        if (segment.step == SelfTestStep::push) {
            axis.pushes[side] = segment.outcome;
            continue;
        }
        axis.ramps[side] = segment.outcome;
        if (segment.outcome != SelfTestOutcome::complete) continue;
        axis.breakaway[side] =
            breakaway_of(samples_of(test, segment), segment, axis, test.options());
    }
    for (AxisReport& axis : axes) {
        if (!axis.breakaway[0] || !axis.breakaway[1]) continue;
        axis.static_friction = (*axis.breakaway[0] + *axis.breakaway[1]) / 2;
        axis.weight = (*axis.breakaway[1] - *axis.breakaway[0]) / 2;
    }
}

/// The unit of a number's second digit.
double second_digit(double value)
{
    return std::pow(10.0, std::floor(std::log10(value)) - 1);
}

/// Two digits, rounded down; a millionth less does not change it.
double rounded_down(double value)
{
    if (!(value > 0)) return 0;
    const double unit = second_digit(value);
    return std::floor(value / unit + 1e-6) * unit;
}

double rounded_up(double value)
{
    if (!(value > 0)) return 0;
    const double unit = second_digit(value);
    return std::ceil(value / unit - 1e-6) * unit;
}

} // namespace

SuggestedSettings suggest_settings(const DeviceLimits& limits, double tick_seconds, int delay,
                                   const MotionFit& motion, double step)
{
    const double late = tick_seconds * (0.5 + delay);
    const bool is_damped = motion.damping.is_certain();
    const double b = is_damped ? motion.damping.value : 0;
    SuggestedSettings result;
    result.by_device = limits.max_stiffness;
    if (is_damped) result.passive = 2 * b / tick_seconds;
    double wanted = limits.max_stiffness;
    double most_damping = std::min(limits.max_damping, damping_of_mass * motion.mass.value / late);
    if (motion.friction.is_certain() && step > 0) {
        const double friction = motion.friction.value;
        result.by_encoder = 2 * friction / step;
        wanted = std::min(wanted, *result.by_encoder);
        most_damping = std::min(most_damping, friction * tick_seconds / step);
    }
    const double needed = wanted / caution * late - b;
    result.damping = std::min(most_damping, rounded_up(std::max(ForceOptions{}.damping, needed)));
    result.by_delay = (b + result.damping) / late;
    double least = result.by_device;
    const auto consider = [&](double stiffness, StiffnessLimit limit) {
        // Where damping was chosen for the device's stiffness, rounding does not take it away.
        if (!(caution * stiffness < least * (1 - 1e-9))) return;
        least = caution * stiffness;
        result.limit = limit;
    };
    consider(result.by_delay, StiffnessLimit::delay);
    if (result.by_encoder) consider(*result.by_encoder, StiffnessLimit::encoder);
    result.stiffness = rounded_down(least);
    return result;
}

bool SelfTestReport::any_is_later() const noexcept
{
    return std::ranges::any_of(axes, [](const AxisReport& axis) { return axis.motion.is_later; });
}

SelfTestReport report_of(const SelfTest& test, const DeviceLimits& limits)
{
    SelfTestReport report;
    report.rested = test.rested();
    report.largest_force = test.largest_force();
    report.timing = timing_of(test);
    const std::vector<SelfTestSample> slow = fresh_samples(test, SelfTestStep::slow);
    Vec3 steps = Vec3::Zero();
    for (int axis = 0; axis < 3; ++axis) {
        std::vector<double> positions;
        positions.reserve(slow.size());
        for (const SelfTestSample& sample : slow) positions.push_back(sample.position[axis]);
        EncoderStep& encoder = report.axes[static_cast<std::size_t>(axis)].encoder;
        encoder = estimate_encoder_step(positions);
        steps[axis] = encoder.step;
        report.step = std::max(report.step, encoder.step);
    }
    report.timing.repeated = repeated_part(fresh_samples(test, SelfTestStep::fast), steps);
    measure_noise(fresh_samples(test, SelfTestStep::rest), report.axes);
    for (int axis = 0; axis < 3; ++axis) {
        AxisReport& seen = report.axes[static_cast<std::size_t>(axis)];
        seen.motion = fit_axis(test, axis, seen.encoder.step);
        if (!seen.motion.found) continue;
        report.delay = std::max(report.delay, seen.motion.delay);
        // A hand that holds a device is a spring of some 100 N/m.
        report.held =
            report.held || (seen.motion.stiffness.is_certain() && seen.motion.stiffness.value > 10);
    }
    measure_ramps(test, report.axes);
    for (const AxisReport& axis : report.axes) {
        if (!axis.motion.found || report.any_is_later()) continue;
        const SuggestedSettings settings = suggest_settings(
            limits, test.options().tick_seconds, report.delay, axis.motion, axis.encoder.step);
        if (!report.settings || settings.stiffness < report.settings->stiffness)
            report.settings = settings;
    }
    return report;
}

} // namespace proxima
