#include "haptics/force/swing_response.h"

#include <numbers>

namespace proxima {

namespace {

/// N s/m: the friction of the best devices. Less than this is not enough to keep a swing going, and
/// less damping ends none.
constexpr double least_device_damping = 0.1;

/// Damping and softening answer two legs in succession that do not fade. A leg that is half as long
/// again as the one before counts twice.
constexpr int least_legs = 2;

/// The damping of an answer, in parts of what leaves a contact that gives nothing: it takes as much
/// as it gave, so what grew by itself fades as fast.
constexpr double firmness = 2;

/// A leg is compared with the shorter of the two before it. So the third leg after an answer is the
/// first one that is compared with legs after the answer alone.
constexpr int hand_legs = 3;

/// Where another axis moves by more than this part of the longest leg, they may exchange their energy, and
/// the longest be kept while all of them fades: a box that rocks from edge to edge. Then more legs tell.
constexpr double exchanging = 0.5;
constexpr int exchanging_legs = 5;

/// Where less than this part of the motion against a surface is the device's own, in squares of velocities,
/// the surface shakes and drives it.
constexpr double own_part = 0.5;

/// Contacts in succession that throw the device back faster than it came, before the first answer. One
/// that makes it half as fast again counts twice.
constexpr int least_bounces = 4;
constexpr double strong_gain = 1.5;
constexpr double least_bounce_gain = 1.02;
constexpr double least_bounce_speed = 0.02; ///< m/s: four steps of the coarsest encoder
constexpr double least_flight = 0.25;       ///< s: the legs of shorter ones tell
/// Of speeds in a flight to which nothing gives energy; more than 1 for encoders.
constexpr double most_flight_gain = 1.05;

/// A mass m that a wall throws back is in contact for t = pi sqrt(m / K), and forces that are late by d
/// make it exp(pi^2 d / (2 t)) times as fast. Heavier than this are no device and finger.
constexpr double most_mass = 0.6; ///< kg

constexpr double nearly_all = 0.9; ///< of the damping that is allowed
constexpr double least_softness = 0.2;
constexpr double softening = 0.7;
constexpr double recovery = 4; ///< s, in which s doubles, or damping halves; and of trust

/// A mass m that hits a wall is in contact for pi sqrt(m / K) or longer. With all damping that the known
/// devices allow, the wall throws it back faster than it came only if that is less than five and a
/// half times the delay of the damping: the ticks of the force's delay, half a tick for the hold, and
/// half a tick for a velocity by differences. Ticks in which a slew limit holds the force back add to
/// them.
constexpr double brief_contact = 6; ///< of these delays
constexpr double least_mass = 0.06; ///< kg: an assumption, of a device and what holds it

/// Whether a fully damped wall, whose forces are late by further ticks, may have caused a cycle with so
/// much time in contact.
bool is_brief(double contact, double stiffness, int late_ticks, double tick_seconds) noexcept
{
    const double longest =
        brief_contact * (static_cast<double>(most_delay_ticks + 1) + late_ticks) * tick_seconds;
    const double least = std::numbers::pi * std::sqrt(least_mass / stiffness);
    return contact <= longest && least <= longest;
}

/// The leg that ended becomes the last one.
void begin_leg(WatchedMotion& motion, const EnergySums& sums, int late) noexcept
{
    motion.cycle_began = motion.leg_began;
    motion.leg_began = sums;
    motion.last_leg_late = motion.leg_late;
    motion.leg_late = late;
}

} // namespace

void SwingResponse::applied(std::span<WatchedMotion> motions, bool in_full) noexcept
{
    late_ = in_full ? 0 : late_ + 1;
    for (WatchedMotion& motion : motions) {
        motion.leg_late = std::max(motion.leg_late, late_);
        motion.bounce_late = std::max(motion.bounce_late, late_);
    }
}

void SwingResponse::soften(double factor) noexcept
{
    report_.softenings += softness_ >= 1 ? 1U : 0U;
    softness_ = std::max(softness_ * factor, least_softness);
    report_.lowest_softness = std::min(report_.lowest_softness, softness_);
}

/// Adds damping, or softens where the damping that the device allows is there and is not enough.
void SwingResponse::answer(std::span<WatchedMotion> motions, const SwingTick& tick,
                           const EnergySums& sums, double most, double needed, bool brief) noexcept
{
    if (damping_ < nearly_all * most) {
        report_.swings += damping_ > 0 ? 0U : 1U;
        const double step = brief || tick.quick ? most : firmness * needed;
        damping_ = std::min(damping_ + step, most);
        report_.most_damping = std::max(report_.most_damping, damping_);
    } else if (!brief && !tick.quick) {
        return;
    } else if (!tick.quick) {
        soften(softening);
    }
    if (tick.quick) soften(least_softness);
    // What was given before the answer says nothing about what is given after it.
    for (WatchedMotion& motion : motions) {
        motion.leg_began = motion.cycle_began = motion.touched = sums;
        motion.kept_legs = 0;
    }
    trust_ = 0;
}

/// Ends the damping, at a turn of the motion, where a hand makes it: legs do not fade though the last
/// cycle took energy. Motions of a tool exchange energy: only the longest one tells.
void SwingResponse::trust_hand(std::span<WatchedMotion> motions, WatchedMotion& motion,
                               double given) noexcept
{
    motion.kept_legs = motion.swing.is_kept() ? motion.kept_legs + 1 : 0;
    if (!(damping_ > 0) || motion.kept_legs < hand_legs || given > 0 || motion.swing.is_fast())
        return;
    const double longest = motion.swing.last_leg();
    for (const WatchedMotion& other : motions) {
        if (&other == &motion || !other.swing.is_swinging()) continue;
        if (other.swing.last_leg() > longest) return;
        if (other.swing.last_leg() > exchanging * longest && motion.kept_legs < exchanging_legs)
            return;
    }
    damping_ = 0;
    trust_ = recovery;
    for (WatchedMotion& each : motions) each.trusted_leg = each.swing.last_leg();
}

void SwingResponse::judge(std::span<WatchedMotion> motions, WatchedMotion& motion,
                          const SwingTick& tick, const EnergySums& sums,
                          const SwungContact& contact, double seconds) noexcept
{
    if (!tick.turned && !tick.reported) return;
    const double given = sums.own.most_given_since(motion.cycle_began.own);
    const double moved = sums.own.motion - motion.cycle_began.own.motion;
    const double in_contact = sums.own.motion_in_contact - motion.cycle_began.own.motion_in_contact;
    const double relative = sums.relative.motion - motion.cycle_began.relative.motion;
    motion.gives = given > least_device_damping * moved && moved >= own_part * relative;
    // Beyond doubt, as for gives.
    if (tick.turned) trust_hand(motions, motion, given + least_device_damping * moved);
    if (tick.reported && (tick.legs >= least_legs || tick.quick) && motion.gives) {
        const bool brief = is_brief(tick.contact, contact.stiffness,
                                    std::max(motion.leg_late, motion.last_leg_late), seconds);
        const bool trusted = trust_ > 0 && tick.length < 2 * motion.trusted_leg;
        if (!trusted || brief || tick.fast) {
            report_.most_given = std::max(report_.most_given, given);
            answer(motions, tick, sums, contact.most_damping,
                   in_contact > 0 ? std::max(given, 0.0) / in_contact : 0, brief);
        }
    }
    if (tick.turned) begin_leg(motion, sums, late_);
}

/// Whether a wall with forces that are late may have thrown a free mass back so much faster than it came.
bool SwingResponse::may_throw(const Bounce& bounce, double stiffness, int late_ticks,
                              double seconds) const noexcept
{
    if (bounce.speed_in < least_bounce_speed) return false;
    const double gain = bounce.speed_out / bounce.speed_in;
    if (gain < least_bounce_gain) return false;
    const double longest =
        std::numbers::pi * std::sqrt(most_mass / (softness_ * std::max(stiffness, 1.0)));
    const double late = (static_cast<double>(most_delay_ticks + 1) + late_ticks) * seconds;
    const double most_gain = std::exp(std::numbers::pi * std::numbers::pi / 2 * late /
                                      std::max(bounce.contact, seconds));
    return bounce.contact <= longest && gain <= most_gain;
}

void SwingResponse::judge_bounce(std::span<WatchedMotion> motions, WatchedMotion& motion,
                                 const Bounce& bounce, const EnergySums& sums,
                                 const SwungContact& contact, double seconds) noexcept
{
    if (bounce.touched) {
        motion.touched = sums;
        motion.bounce_late = 0;
    }
    if (!bounce.left) return;
    // Against the surface: one that goes away takes what it is given, and gives what it took, by going.
    const double given = sums.relative.most_given_since(motion.touched.relative);
    const double in_contact =
        sums.relative.motion_in_contact - motion.touched.relative.motion_in_contact;
    const double moved = sums.own.motion - motion.touched.own.motion;
    const double relative = sums.relative.motion - motion.touched.relative.motion;
    const bool gives = given > least_device_damping * in_contact && moved >= own_part * relative;
    // Who throws a device at a wall gives it in the flight what the wall takes.
    const bool flew = bounce.speed_in <= most_flight_gain * motion.speed_out;
    // A long flight, a rest or a press ends the succession of bounces.
    const bool goes_on = bounce.flight <= BounceDetector::longest_flight &&
                         bounce.touching <= BounceDetector::longest_contact;
    motion.thrown = motion.thrown && flew && goes_on;
    const bool drives = gives && goes_on &&
                        may_throw(bounce, contact.stiffness, motion.bounce_late, seconds) &&
                        (motion.thrown || bounce.flight >= least_flight);
    const int before = flew ? motion.bounces : 0;
    const bool strong = bounce.speed_out >= strong_gain * bounce.speed_in;
    motion.bounces = drives ? before + (strong ? 2 : 1) : 0;
    motion.speed_out = bounce.speed_out;
    if (!drives || !(motion.thrown || motion.bounces >= least_bounces)) return;
    report_.most_given = std::max(report_.most_given, given);
    answer(motions, {}, sums, contact.most_damping, in_contact > 0 ? given / in_contact : 0,
           is_brief(bounce.contact, contact.stiffness, motion.bounce_late, seconds));
    motion.thrown = true;
}

void SwingResponse::recover(std::span<const WatchedMotion> motions, double seconds) noexcept
{
    trust_ = std::max(trust_ - seconds, 0.0);
    if (softness_ < 1) {
        softened_seconds_ += seconds;
        report_.longest_softening = std::max(report_.longest_softening, softened_seconds_);
    }
    if (std::ranges::any_of(motions, &WatchedMotion::is_driven)) return;
    if (softness_ < 1) {
        softness_ = std::min(softness_ * std::exp2(seconds / recovery), 1.0);
        if (softness_ >= 1) softened_seconds_ = 0;
    } else if (damping_ > 0) {
        damping_ *= std::exp2(-seconds / recovery);
        if (damping_ < least_device_damping) damping_ = 0;
    }
}

} // namespace proxima
