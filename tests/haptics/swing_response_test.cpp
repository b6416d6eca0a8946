#include "haptics/force/swing_response.h"

#include <gtest/gtest.h>

#include <array>
#include <span>

namespace proxima::swing_response_test {
namespace {

constexpr double tick_seconds = 0x1p-10;
constexpr SwungContact contact{.stiffness = 2000, .most_damping = 10};

/// An account in which all delays gave the same, J, by a motion that was in contact all the time with a
/// surface at rest.
EnergySums sums_of(double given, double motion)
{
    MotionSums sums;
    sums.given.fill(given);
    sums.motion = motion;
    sums.motion_in_contact = motion;
    return {sums, sums};
}

/// One motion whose ticks say what a test wants.
class Judged {
public:
    void judge(const SwingTick& tick, const EnergySums& sums)
    {
        response.judge(motions_, motions_[0], tick, sums, contact, tick_seconds);
    }
    void is_late(int ticks)
    {
        for (int i = 0; i < ticks; ++i) response.applied(motions_, false);
    }
    SwingResponse response;

private:
    std::array<WatchedMotion, 1> motions_;
};

TEST(SwingResponse, AnswersWhatGivesMoreThanADeviceTakes)
{
    // In a device a tenth of the motion is lost.
    const SwingTick swing{.reported = true, .legs = 2, .contact = 1};
    Judged passive;
    passive.judge(swing, sums_of(1, 10));
    EXPECT_FALSE(passive.response.acts());
    EXPECT_EQ(passive.response.report().swings, 0U);
    Judged active;
    active.judge(swing, sums_of(2, 10));
    EXPECT_EQ(active.response.damping(), 2 * 0.2); // twice what it gave, over the motion
    EXPECT_EQ(active.response.softness(), 1);
    EXPECT_EQ(active.response.report().swings, 1U);
    EXPECT_EQ(active.response.report().most_given, 2);
    // Again: what was given before that answer does not count, and more is added.
    active.judge(swing, sums_of(4, 20));
    EXPECT_EQ(active.response.damping(), 4 * 0.2);
    EXPECT_EQ(active.response.report().swings, 1U);
}

TEST(SwingResponse, WaitsForTwoLegsUnlessTheyAreQuick)
{
    const EnergySums sums = sums_of(2, 10);
    Judged single;
    single.judge({.reported = true, .legs = 1, .contact = 1}, sums);
    EXPECT_FALSE(single.response.acts());
    Judged unreported;
    unreported.judge({.turned = true, .legs = 5, .contact = 1}, sums);
    EXPECT_FALSE(unreported.response.acts());
    Judged quick;
    quick.judge({.reported = true, .legs = 1, .contact = 1, .quick = true}, sums);
    EXPECT_EQ(quick.response.softness(), 0.2);
    EXPECT_EQ(quick.response.report().most_damping, contact.most_damping);
}

TEST(SwingResponse, DampsBriefContactsAllItCan)
{
    // Brief is up to six of the delays: three ticks, and two halves of one.
    const EnergySums sums = sums_of(2, 10);
    for (const int late : {0, 3}) {
        const double longest = 6 * (4 + late) * tick_seconds;
        Judged brief;
        brief.is_late(late);
        brief.judge({.reported = true, .legs = 2, .contact = longest}, sums);
        EXPECT_EQ(brief.response.damping(), contact.most_damping) << late;
        Judged longer;
        longer.is_late(late);
        longer.judge({.reported = true, .legs = 2, .contact = longest + tick_seconds}, sums);
        EXPECT_EQ(longer.response.damping(), 2 * 0.2) << late;
    }
}

TEST(SwingResponse, SoftensWhereAllDampingIsNotEnough)
{
    Judged judged;
    double given = 0;
    double motion = 0;
    const auto swing = [&](double contact_seconds) {
        judged.judge({.reported = true, .legs = 2, .contact = contact_seconds},
                     sums_of(given += 2, motion += 10));
        return judged.response.softness();
    };
    EXPECT_EQ(swing(0.01), 1); // damps
    EXPECT_EQ(swing(1), 1);    // no brief contact: damping will end it
    EXPECT_EQ(judged.response.report().softenings, 0U);
    EXPECT_DOUBLE_EQ(swing(0.01), 0.7);
    EXPECT_EQ(judged.response.report().softenings, 1U);
    EXPECT_DOUBLE_EQ(swing(0.01), 0.49);
    EXPECT_EQ(judged.response.report().softenings, 1U);
    for (int i = 0; i < 5; ++i) swing(0.01);
    EXPECT_EQ(judged.response.softness(), 0.2); // never less
    EXPECT_EQ(judged.response.report().lowest_softness, 0.2);
    // Nothing swings: it doubles in four seconds, and twice more.
    std::array<WatchedMotion, 1> still;
    judged.response.recover(still, 4);
    EXPECT_DOUBLE_EQ(judged.response.softness(), 0.4);
    judged.response.recover(still, 8);
    EXPECT_EQ(judged.response.softness(), 1);
    EXPECT_EQ(judged.response.report().longest_softening, 12);
    swing(0.01);
    EXPECT_EQ(judged.response.report().softenings, 2U);
}

/// A hand moves to and fro in a contact, slowly and evenly, for a second and a half. `given` is what each
/// leg gives of the 5 units of its motion; a second motion, if there is one, has legs so many times as long.
void move_by_hand(SwingResponse& response, std::span<WatchedMotion> motions, EnergySums& sums,
                  double given, double other_legs)
{
    for (int tick = 0; tick < 1500; ++tick) {
        const int phase = tick % 200;
        const double at = 1e-5 * (phase < 100 ? phase : 200 - phase);
        if (motions.size() > 1)
            (void)motions[1].swing.watch(Vec3(other_legs * at, 0, 0), Vec3(1, 0, 0), tick_seconds);
        SwingTick seen = motions[0].swing.watch(Vec3(at, 0, 0), Vec3(1, 0, 0), tick_seconds);
        if (!seen.turned) continue;
        seen.reported = false;
        sums = sums_of(sums.own.given[0] + given, sums.own.motion + 5);
        response.judge(motions, motions[0], seen, sums, contact, tick_seconds);
    }
}

/// Whether damping is still there after a hand moved.
bool stays_damped(double given, double other_legs)
{
    SwingResponse response;
    std::array<WatchedMotion, 2> motions;
    EnergySums sums = sums_of(2, 10);
    response.judge(motions, motions[0], {.reported = true, .legs = 2, .contact = 1}, sums, contact,
                   tick_seconds);
    EXPECT_GT(response.damping(), 0);
    move_by_hand(response, motions, sums, given, other_legs);
    return response.damping() > 0;
}

TEST(SwingResponse, TrustsAHandThatMovesThoughTheContactTakesEnergy)
{
    EXPECT_FALSE(stays_damped(-1, 0));
    EXPECT_FALSE(stays_damped(-0.5, 0)); // as much as a device takes, to the last bit
    EXPECT_TRUE(stays_damped(-0.4375, 0));
    EXPECT_TRUE(stays_damped(1, 0));
    EXPECT_FALSE(stays_damped(-1, 0.5));
    EXPECT_TRUE(stays_damped(-1, 2)) << "the longest motion tells";
}

/// Bounces on one wall, each of which gives so much of the 10 units of its motion.
class Bounced {
public:
    void bounce(double speed_in, double speed_out, double given = 2, double flight = 0.5,
                double contact_seconds = 0.02, double at_limit = 0)
    {
        const auto judge = [&](const Bounce& bounce) {
            response.judge_bounce(motions_, motions_[0], bounce, sums_, contact, tick_seconds);
        };
        judge({.touched = true});
        sums_ = sums_of(sums_.own.given[0] + given, sums_.own.motion + 10);
        judge({.left = true,
               .flight = flight,
               .contact = contact_seconds,
               .touching = contact_seconds + at_limit,
               .speed_in = speed_in,
               .speed_out = speed_out});
    }

    SwingResponse response;

private:
    std::array<WatchedMotion, 1> motions_;
    EnergySums sums_;
};

TEST(SwingResponse, AnswersBouncesThatAWallMakesFaster)
{
    Bounced slowly;
    for (int i = 0; i < 3; ++i) slowly.bounce(0.3, 0.35);
    EXPECT_FALSE(slowly.response.acts());
    slowly.bounce(0.3, 0.35);
    EXPECT_EQ(slowly.response.damping(), contact.most_damping); // the contact is brief
    slowly.bounce(0.3, 0.35);                                   // it goes on
    EXPECT_EQ(slowly.response.softness(), 0.7);
    Bounced strongly;
    for (int i = 0; i < 2; ++i) strongly.bounce(0.3, 0.48);
    EXPECT_TRUE(strongly.response.acts());
}

TEST(SwingResponse, LeavesBouncesThatNoWallMakesFaster)
{
    const auto acts = [](auto&&... bounce) {
        Bounced bounced;
        for (int i = 0; i < 20; ++i) bounced.bounce(bounce...);
        return bounced.response.acts();
    };
    EXPECT_TRUE(acts(0.3, 0.35));
    EXPECT_FALSE(acts(0.3, 0.3)) << "no faster";
    EXPECT_FALSE(acts(0.3, 0.35, 1)) << "a device takes as much";
    EXPECT_FALSE(acts(0.3, 0.9)) << "faster than late forces make it";
    EXPECT_FALSE(acts(0.3, 0.35, 2, 0.2)) << "its legs tell";
    EXPECT_FALSE(acts(0.3, 0.35, 2, 4)) << "too long ago";
    EXPECT_FALSE(acts(0.3, 0.31, 2, 0.5, 0.06)) << "of more than a device and a finger weigh";
    EXPECT_FALSE(acts(0.01, 0.011)) << "too slow to tell";
    EXPECT_TRUE(acts(0.3, 0.35, 2, 0.5, 0.02, 0.1)) << "longer, for the force was at its limit";
    EXPECT_FALSE(acts(0.3, 0.35, 2, 0.5, 0.02, 0.4)) << "who presses so long begins anew";
    // By a hand, which makes it faster in each flight as well; and by the wall alone.
    for (const double in_flight : {1.2, 1.0}) {
        Bounced thrown;
        double speed = 0.05;
        for (int i = 0; i < 10; ++i, speed *= 1.05 * in_flight) thrown.bounce(speed, 1.05 * speed);
        EXPECT_EQ(thrown.response.acts(), in_flight == 1.0);
    }
}

TEST(SwingResponse, TrustsNoHandBeforeAnythingWasDamped)
{
    // A hand moves to and fro, and the contact takes energy. Then it gives some: that is answered at once.
    SwingResponse response;
    std::array<WatchedMotion, 1> motions;
    EnergySums sums;
    move_by_hand(response, motions, sums, -1, 0);
    response.judge(motions, motions[0], {.reported = true, .legs = 2, .length = 1e-3, .contact = 1},
                   sums_of(sums.own.given[0] + 10, sums.own.motion + 10), contact, tick_seconds);
    EXPECT_TRUE(response.acts());
}

} // namespace
} // namespace proxima::swing_response_test
