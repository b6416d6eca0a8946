#include "haptics/force/oscillation_detector.h"

#include <algorithm>
#include <cmath>

namespace proxima {

namespace {

constexpr double least_swing = 1.5e-4; ///< m: three steps of the coarsest encoder
constexpr double hand_swing = 3e-4;    ///< m: of slow strokes, as trembling hands make
constexpr double hand_seconds = 0.05;  ///< no hand moves in and out again in less
constexpr double memory_seconds = 0.5; ///< turns that are farther apart are independent
constexpr double most_growth = 0.2;    ///< counted of a turn: a hand may have helped
constexpr double proof = 0.3;
constexpr double hand_proof = 0.4;
constexpr double fading = 0.01; ///< oscillations that fade by less a turn count as lasting
constexpr int least_turns = 2;
constexpr double one_turn_proof = 0.7; ///< growth of a single turn that proves: twice as fast,
constexpr double fast = 0.1;           ///< m/s: and faster in than hands tremble
constexpr double same_direction = 0.8;

} // namespace

void OscillationDetector::Stroke::add(double speed, double tick, const Vec3& direction) noexcept
{
    length += speed * tick;
    seconds += tick;
    if (!(speed > peak)) return;
    peak = speed;
    along = direction;
}

/// Judges a turn. While its outward stroke is ongoing only a proof counts; once that is complete, its
/// growth is added.
double OscillationDetector::judge(const Stroke& in, const Stroke& out, Stroke::State state) noexcept
{
    const bool slow = std::max(in.seconds, out.seconds) > hand_seconds;
    const double least = slow ? hand_swing : least_swing;
    if (std::min(in.length, out.length) < least || in.along.dot(out.along) < same_direction)
        return 0;
    if (since_turn_ > memory_seconds) {
        growth_ = 0;
        turns_ = 0;
    }
    const double grown = std::log(out.peak / in.peak);
    const double counted = std::min(grown, most_growth) + (slow ? 0 : fading);
    const double growth = std::max(growth_ + counted, 0.0);
    const int turns = growth > 0 ? turns_ + 1 : 0;
    const bool blatant = !slow && in.peak > fast && grown > one_turn_proof;
    const bool proves = blatant || (turns >= least_turns && growth > (slow ? hand_proof : proof));
    if (!proves && state == Stroke::State::ongoing) return 0;
    since_turn_ = 0;
    turns_ = turns;
    growth_ = proves ? 0 : growth;
    return proves ? std::max(growth, grown) : 0;
}

/// Judges the last turn with a delay: mean speeds may peak after the end of the outward stroke.
double OscillationDetector::judge_last(const Vec3& velocity) noexcept
{
    if (pending_ == 0) return 0;
    last_out_.peak = std::max(last_out_.peak, velocity.dot(last_out_.along));
    if (--pending_ > 0) return 0;
    return judge(last_in_, last_out_, Stroke::State::complete);
}

double OscillationDetector::watch(const Vec3& position, const Vec3& force, double seconds) noexcept
{
    const Vec3 before = ticks_ == 0 ? position : positions_[ticks_ % std::min(ticks_, window)];
    const auto ticks = static_cast<double>(std::min(std::max<std::size_t>(ticks_, 1), window));
    positions_[ticks_ % window] = position;
    ++ticks_;
    since_turn_ += seconds;
    const double size = force.norm();
    if (size > 0) {
        along_ = force / size;
        away_ = 0;
    } else if (!is_away()) {
        ++away_;
    }
    const Vec3 velocity = (position - before) / (ticks * seconds);
    double proven = judge_last(velocity);
    if (is_away()) {
        quick_.restart();
    } else {
        proven = std::max(proven, quick_.watch(position));
    }
    const double speed = velocity.dot(along_);
    if (leg_ == Leg::out && (is_away() || speed < 0)) {
        if (out_.length < least_swing / 2 && !is_away()) {
            leg_ = Leg::in; // no turn: noise of the encoder
        } else {
            if (!judged_) {
                last_in_ = in_;
                last_out_ = out_;
                pending_ = window;
            }
            leg_ = Leg::none;
        }
    }
    if (is_away()) {
        leg_ = Leg::none;
    } else if (speed < 0) {
        if (leg_ != Leg::in) in_ = {};
        leg_ = Leg::in;
        in_.add(-speed, seconds, along_);
    } else if (speed > 0 && leg_ != Leg::none) {
        if (leg_ == Leg::in) {
            out_ = {};
            judged_ = false;
        }
        leg_ = Leg::out;
        out_.add(speed, seconds, along_);
        const double early = judged_ ? 0 : judge(in_, out_, Stroke::State::ongoing);
        judged_ = judged_ || early > 0;
        proven = std::max(proven, early);
    }
    return proven;
}

} // namespace proxima
