// What the stub libraries have instead of a device: a mass on a spring that is led up and down
// through the middle of the workspace, and faults at given ticks. Nothing of Proxima is in here:
// the libraries stand for foreign ones.
//
// Faults come from the environment variable PROXIMA_STUB: "NAME=TICK NAME=TICK ...", or from tests
// that look the symbol stub_state up.
#pragma once

#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <sstream>
#include <string>

namespace stub {

constexpr long never = std::numeric_limits<long>::max();

struct State {
    // What shall go wrong, by ticks.
    long unplug = never;
    long replug = never;
    long nan = never;  ///< for ten ticks
    long jump = never; ///< a metre away, for good
    long freeze = never;
    long stall = never;         ///< the library calls no more
    long write_fault = never;   ///< the frame of this tick ends with an error of the device
    long write_refusal = never; ///< likewise, of a value
    long force_error = never;
    long fail_open = never;   ///< anything but never
    long fail_enable = never; ///< likewise: forces cannot be enabled
    long fail_start = never;  ///< likewise: the scheduler does not start
    long press = never;       ///< button 1, for 100 ticks
    long model = 0;           ///< which name a device has that is polled
    long wrist = never;       ///< anything but never: such a device reports how it is turned
    long needs_hands = never; ///< likewise: a user has to calibrate it
    long no_limits = never;   ///< likewise: the driver reports none
    long turn = never;        ///< from this tick on it is turned about z, by a right angle
    // A hand that moves the device slowly, then fast, and lets go: a device with these numbers.
    long release = never; ///< the tick; the fast motion takes the 500 ticks before it
    long friction = 200;  ///< mN
    long damping = 300;   ///< mN s/m
    long step = 20000;    ///< nm, of the encoders along the axes
    long period = 1000;   ///< us, of a scheduler; the hand's time is its ticks
    // What was seen.
    long ticks = 0;
    long forces = 0;
    long bad_forces = 0;     ///< not finite, or above the limit
    long forces_outside = 0; ///< set where that is no use
    double largest_force = 0;
    double last_force = 0;
    long open_devices = 0;
    long forces_enabled = 0;
};

struct Hand {
    double place[3] = {0.002, 0.001, 0.09}; // m
    double speed[3] = {0, 0, 0};
    double force[3] = {0, 0, 0};
};

inline void read_environment(State& state)
{
    const char* const text = std::getenv("PROXIMA_STUB");
    if (text == nullptr) return;
    std::istringstream words(text);
    for (std::string word; words >> word;) {
        const std::size_t equal = word.find('=');
        if (equal == std::string::npos) continue;
        const std::string name = word.substr(0, equal);
        const long tick = std::atol(word.c_str() + equal + 1);
        if (name == "unplug") state.unplug = tick;
        if (name == "replug") state.replug = tick;
        if (name == "nan") state.nan = tick;
        if (name == "jump") state.jump = tick;
        if (name == "freeze") state.freeze = tick;
        if (name == "stall") state.stall = tick;
        if (name == "force_error") state.force_error = tick;
        if (name == "fail_open") state.fail_open = tick;
        if (name == "fail_enable") state.fail_enable = tick;
        if (name == "press") state.press = tick;
        if (name == "model") state.model = tick;
        if (name == "wrist") state.wrist = tick;
        if (name == "needs_hands") state.needs_hands = tick;
        if (name == "no_limits") state.no_limits = tick;
        if (name == "turn") state.turn = tick;
        if (name == "release") state.release = tick;
        if (name == "friction") state.friction = tick;
        if (name == "damping") state.damping = tick;
        if (name == "step") state.step = tick;
    }
}

/// A millisecond of a device that is let go at a tick, in a hundred parts. Each axis has friction of
/// its own.
inline void move_and_let_go(Hand& hand, const State& state)
{
    constexpr int parts = 100;
    constexpr double mass = 0.1;
    constexpr double turn = 6.283185307179586;
    const double time = 1e-3 * static_cast<double>(state.ticks);
    const bool holds = state.ticks < state.release;
    const bool slow = state.ticks < state.release - 500;
    const bool fast = !slow && state.ticks < state.release - 100;
    for (int i = 0; i < 3; ++i) {
        const double swing = slow   ? 0.01 * std::sin(turn * (0.5 + 0.13 * i) * time)
                             : fast ? 0.03 * std::sin(turn * (2 + 0.3 * i) * time)
                                    : 0;
        for (int part = 0; part < parts; ++part) {
            double force =
                hand.force[i] - 1e-3 * static_cast<double>(state.damping) * hand.speed[i];
            if (holds) force += 400 * (swing - hand.place[i]) - 8 * hand.speed[i];
            // Friction takes what it can of the speed, and no more.
            const double free = hand.speed[i] + 1e-3 / parts * force / mass;
            const double taken = 1e-3 / parts * 1e-3 * static_cast<double>(state.friction) / mass;
            hand.speed[i] = std::abs(free) <= taken ? 0 : free - std::copysign(taken, free);
            hand.place[i] += 1e-3 / parts * hand.speed[i];
        }
    }
}

/// A millisecond: half implicit, which is stable here.
inline void move(Hand& hand, const State& state)
{
    if (state.release != never) return move_and_let_go(hand, state);
    const double time = 1e-3 * static_cast<double>(state.ticks);
    const double target[3] = {0.002, 0.001, 0.09 * std::cos(6.283185307179586 * time)};
    for (int i = 0; i < 3; ++i) {
        const double pull = 150 * (target[i] - hand.place[i]) - 5.5 * hand.speed[i];
        hand.speed[i] += 1e-3 * (pull + hand.force[i]) / 0.1;
        hand.place[i] += 1e-3 * hand.speed[i];
    }
}

inline bool unplugged(const State& state)
{
    return state.ticks >= state.unplug && state.ticks < state.replug;
}

/// Where the hand says it is, faults included.
inline double said(const Hand& hand, const State& state, int axis)
{
    static double frozen[3];
    if (state.ticks < state.freeze) frozen[axis] = hand.place[axis];
    if (state.ticks >= state.nan && state.ticks < state.nan + 10)
        return std::numeric_limits<double>::quiet_NaN();
    const double step = 1e-9 * static_cast<double>(state.step);
    if (state.release != never && state.ticks < state.freeze)
        return std::round(hand.place[axis] / step) * step;
    const double away = state.ticks >= state.jump && axis == 0 ? 1.0 : 0.0;
    return frozen[axis] + away;
}

/// An element of the rotation from the device's end to its base.
inline double turned(const State& state, int row, int column)
{
    constexpr double quarter[3][3] = {{0, -1, 0}, {1, 0, 0}, {0, 0, 1}};
    if (state.ticks >= state.turn) return quarter[row][column];
    return row == column ? 1 : 0;
}

inline void take_force(Hand& hand, State& state, const double* force, double most)
{
    const double length =
        std::sqrt(force[0] * force[0] + force[1] * force[1] + force[2] * force[2]);
    ++state.forces;
    if (!(length <= most)) ++state.bad_forces;
    if (length > state.largest_force) state.largest_force = length;
    state.last_force = length;
    for (int i = 0; i < 3; ++i) hand.force[i] = force[i];
}

inline int buttons(const State& state)
{
    return state.ticks >= state.press && state.ticks < state.press + 100 ? 1 : 0;
}

} // namespace stub
