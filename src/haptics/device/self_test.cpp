#include "haptics/device/self_test.h"

#include "haptics/device/check_numbers.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace proxima {

namespace {

constexpr int ramps = 6;
constexpr int motor_segments = 12;

/// The tip rests for so long before a force acts: long enough to notice that it coasts slowly.
constexpr std::uint64_t lead_ticks = 200;
constexpr std::uint64_t still_ticks = 300;
/// Farther than two steps of the coarsest encoder; a tip that moves less in still_ticks rests.
constexpr double still_distance = 2e-4; // m
/// A ramp has moved the tip.
constexpr double moved_distance = 2.5e-4; // m
constexpr int most_gaps = 20;
constexpr int most_restless = 5;
constexpr std::uint64_t settle_ticks = 5000;
constexpr std::uint64_t shortest_part = 20;
constexpr std::uint64_t longest_part = 200;
constexpr std::uint64_t coast_ticks = 400;
constexpr double least_push = 0.3; // N
constexpr double push_of_ramp = 3; ///< times the force that moved the tip
constexpr double least_of_ramp = 1.4;

std::uint64_t ticks_in(double seconds, double tick_seconds) noexcept
{
    return static_cast<std::uint64_t>(std::llround(seconds / tick_seconds));
}

} // namespace

Result<SelfTest> SelfTest::make(const DeviceInfo& info, const SelfTestOptions& options)
{
    if (Status status = check_positive({"tick_seconds", options.tick_seconds}); !status)
        return tl::unexpected(status.error());
    if (Status status = check_positive({"ramp_rate", options.ramp_rate}); !status)
        return tl::unexpected(status.error());
    if (Status status = check_not_negative({{"wait_seconds", options.wait_seconds},
                                            {"prepare_seconds", options.prepare_seconds},
                                            {"slow_seconds", options.slow_seconds},
                                            {"fast_seconds", options.fast_seconds},
                                            {"let_go_seconds", options.let_go_seconds},
                                            {"release_seconds", options.release_seconds},
                                            {"rest_seconds", options.rest_seconds},
                                            {"force_share", options.force_share},
                                            {"most_travel", options.most_travel},
                                            {"most_speed", options.most_speed},
                                            {"push_distance", options.push_distance},
                                            {"most_silence", options.most_silence}});
        !status)
        return tl::unexpected(status.error());
    if (options.force_share > 1) {
        return fail(ErrorCode::invalid_argument,
                    "force_share must be at most 1: forces stay within the device's limit",
                    "force_share");
    }
    auto input = make_device_input(info, {.tick_seconds = options.tick_seconds});
    if (!input) return tl::unexpected(input.error());
    const double largest = options.force_share * info.limits.max_force;
    return SelfTest(std::move(*input), options, largest);
}

SelfTest::SelfTest(DeviceInput input, const SelfTestOptions& options, double largest_force)
    : input_(std::move(input)), options_(options), largest_force_(largest_force)
{
    const double of_ramp = largest_force / options.ramp_rate;
    const double seconds =
        options.slow_seconds + options.fast_seconds + options.rest_seconds + ramps * of_ramp;
    const auto motor_ticks = motor_segments * (lead_ticks + 4 * longest_part + coast_ticks);
    samples_.reserve(ticks_in(seconds, options.tick_seconds) + motor_ticks + motor_segments);
    segments_.reserve(3 + motor_segments);
}

SelfTest::SelfTest(SelfTest&& other) noexcept
    : input_(std::move(other.input_)), options_(other.options_),
      largest_force_(other.largest_force_), samples_(std::move(other.samples_)),
      segments_(std::move(other.segments_))
{}

void SelfTest::begin(SelfTestStep step) noexcept
{
    using enum SelfTestStep;
    step_.store(step);
    ticks_ = 0;
    still_ = 0;
    confirmed_.store(false);
    prepares_.store(step == slow || step == fast || step == release);
    if (step == slow || step == fast || step == rest)
        segments_.push_back({.step = step, .begin = samples_.size(), .end = samples_.size()});
}

void SelfTest::end(SelfTestFault fault) noexcept
{
    fault_ = fault;
    prepares_.store(false);
    step_.store(SelfTestStep::finished);
}

/// The next ramp or push, once the tip rests.
void SelfTest::begin_motor_segment() noexcept
{
    if (motor_segment_ == motor_segments) return end(SelfTestFault::none);
    step_.store(motor_segment_ < ramps ? SelfTestStep::ramp : SelfTestStep::push);
    ticks_ = 0;
    still_ = 0;
    settles_ = true;
    first_part_ = 0;
    const int number = motor_segment_ % ramps;
    segments_.push_back({.step = step_.load(),
                         .axis = number / 2,
                         .sign = number % 2 == 0 ? 1.0 : -1.0,
                         .begin = samples_.size(),
                         .end = samples_.size()});
}

void SelfTest::end_segment(SelfTestOutcome outcome) noexcept
{
    segments_.back().outcome = outcome;
    segments_.back().end = samples_.size();
    ++motor_segment_;
    begin_motor_segment();
}

/// Forgets the segment in progress.
void SelfTest::drop_segment() noexcept
{
    samples_.resize(segments_.back().begin);
    segments_.pop_back();
}

void SelfTest::watch_rest(const Vec3& position) noexcept
{
    if (still_ == 0 || (position - rest_).cwiseAbs().maxCoeff() > still_distance) {
        rest_ = position;
        still_ = 0;
    }
    ++still_;
}

bool SelfTest::is_too_far(const Vec3& position) const noexcept
{
    const double interval = static_cast<double>(recent_.size() - 1) * options_.tick_seconds;
    return (position - begun_at_).norm() > options_.most_travel ||
           (position - recent_.back()).norm() > options_.most_speed * interval;
}

double SelfTest::force_of_ramp(const Vec3& position) noexcept
{
    SelfTestSegment& segment = segments_.back();
    const auto axis = static_cast<std::size_t>(segment.axis);
    const double force =
        options_.ramp_rate * options_.tick_seconds * static_cast<double>(ticks_ - lead_ticks);
    const bool moved = (position - begun_at_).norm() > moved_distance;
    if (moved || force > largest_force_) {
        moved_by_[axis] = std::max(moved_by_[axis], moved ? force : 2 * largest_force_);
        end_segment(moved ? SelfTestOutcome::complete : SelfTestOutcome::unmoved);
        return 0;
    }
    return segment.sign * force;
}

double SelfTest::force_of_push(const Vec3& position) noexcept
{
    const SelfTestSegment& segment = segments_.back();
    const std::uint64_t pushed = ticks_ - lead_ticks;
    const double moved = (position - begun_at_).norm();
    if (first_part_ == 0 && pushed >= shortest_part &&
        (moved >= options_.push_distance || pushed >= longest_part))
        first_part_ = pushed;
    // The first part, back for twice as long, and the first part again: then it is where it was, and
    // at rest, but for what friction took.
    const std::uint64_t part = first_part_;
    const double first = segment.sign * push_force_;
    if (part == 0 || pushed < part) return first;
    if (pushed < 3 * part) return -first;
    if (pushed < 4 * part) return first;
    if (pushed < 4 * part + coast_ticks) return 0;
    end_segment(SelfTestOutcome::complete);
    return 0;
}

/// The force along the axis of a ramp or push.
double SelfTest::force_of_step(const Vec3& position) noexcept
{
    SelfTestSegment& segment = segments_.back();
    const bool is_ramp = step_.load() == SelfTestStep::ramp;
    if (settles_) {
        if (ticks_ > settle_ticks) {
            end_segment(SelfTestOutcome::no_rest);
            return 0;
        }
        if (still_ < still_ticks) return 0;
        const double moved_by = moved_by_[static_cast<std::size_t>(segment.axis)];
        push_force_ = std::min(largest_force_, std::max(least_push, push_of_ramp * moved_by));
        if (!is_ramp && push_force_ < least_of_ramp * moved_by) {
            end_segment(SelfTestOutcome::too_weak);
            return 0;
        }
        settles_ = false;
        ticks_ = 0;
        begun_at_ = position;
        segment.begin = samples_.size();
        segment.lead = lead_ticks;
    }
    if (is_too_far(position)) {
        end_segment(SelfTestOutcome::too_far);
        return 0;
    }
    if (ticks_ < lead_ticks) return 0;
    return is_ramp ? force_of_ramp(position) : force_of_push(position);
}

SelfTestFault SelfTest::fault_of(const DeviceReading& reading, InputCondition condition) noexcept
{
    using enum SelfTestFault;
    if (cancelled_.load()) return cancelled;
    if (condition == InputCondition::gone) return gone;
    if (condition == InputCondition::released) return left;
    if (condition == InputCondition::unsure) {
        if (reading.state.condition == InputCondition::unsure) return refused;
        return input_.report().not_finite > 0 ? not_finite : jumped;
    }
    const double limit = placed_ ? options_.most_silence : options_.wait_seconds;
    if (static_cast<double>(silence_) * options_.tick_seconds > limit)
        return placed_ ? silent : no_sample;
    return none;
}

/// The tip has been let go and moves, or moved unseen.
void SelfTest::wait_for_rest() noexcept
{
    begin(SelfTestStep::release);
    prepares_.store(false);
}

/// The steps in which a person moves the device, or keeps the hands off.
void SelfTest::follow_person() noexcept
{
    const auto passed = [&](double seconds) {
        return ticks_ >= ticks_in(seconds, options_.tick_seconds);
    };
    if (prepares()) {
        if (!confirmed_.load() && !passed(options_.prepare_seconds)) return;
        prepares_.store(false);
        ticks_ = 0;
        return;
    }
    switch (step()) {
    case SelfTestStep::waiting:
        begin(SelfTestStep::slow);
        break;
    case SelfTestStep::slow:
        if (passed(options_.slow_seconds)) begin(SelfTestStep::fast);
        break;
    case SelfTestStep::fast:
        if (passed(options_.fast_seconds)) begin(SelfTestStep::release);
        break;
    case SelfTestStep::release:
        if (passed(options_.let_go_seconds) && still_ > still_ticks) {
            begin(SelfTestStep::rest);
        } else if (passed(options_.release_seconds)) {
            end(SelfTestFault::none);
        }
        break;
    case SelfTestStep::rest:
        if (still_ < ticks_) {
            // It has begun to move: the hand let go only now, or it sinks.
            drop_segment();
            if (++restless_ > most_restless) return end(SelfTestFault::none);
            wait_for_rest();
        } else if (passed(options_.rest_seconds)) {
            rested_ = true;
            begin_motor_segment();
        }
        break;
    default:
        break;
    }
}

/// A gap in the input. Rest is watched anew, and what the motors did before it says nothing: they
/// begin again.
void SelfTest::bridge_gap() noexcept
{
    still_ = 0;
    const bool rests = step() == SelfTestStep::rest;
    if (!rests && (!is_motor() || settles_)) return;
    if (++gaps_ > most_gaps) return end(SelfTestFault::silent);
    drop_segment();
    if (rests) {
        wait_for_rest();
    } else {
        begin_motor_segment();
    }
}

DeviceCommand SelfTest::tick(const DeviceReading& reading, double seconds, double arrival) noexcept
{
    DeviceCommand command;
    const DeviceState& state = input_.accept(reading);
    command.condition = state.condition;
    const bool well = state.condition == InputCondition::well;
    const bool fresh = well && reading.sample != sample_;
    sample_ = reading.sample;
    silence_ = fresh ? 0 : silence_ + 1;
    if (step() != SelfTestStep::finished) {
        const SelfTestFault fault = fault_of(reading, state.condition);
        if (fault != SelfTestFault::none) end(fault);
    }
    if (step() == SelfTestStep::finished) {
        ++ending_;
        return command;
    }
    if (!well) {
        bridge_gap();
        return command;
    }
    placed_ = true;
    const Vec3& position = state.pose.translation;
    watch_rest(position);
    if (is_motor()) {
        const int axis = segments_.back().axis;
        command.force[axis] = force_of_step(position);
    } else {
        follow_person();
    }
    for (std::size_t i = recent_.size() - 1; i > 0; --i) recent_[i] = recent_[i - 1];
    recent_[0] = position;
    const bool is_recorded = !prepares() && !settles_ && step() != SelfTestStep::release &&
                             step() != SelfTestStep::finished;
    if (is_recorded && samples_.size() < samples_.capacity()) {
        samples_.push_back({seconds, arrival, position, command.force, fresh});
        segments_.back().end = samples_.size();
    }
    ++ticks_;
    return command;
}

} // namespace proxima
