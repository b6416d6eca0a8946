#include "touch_stability.h"

#include "haptics/theory_wall.h"
#include "haptics/wall_swing.h"
#include "proxima/device.h"

#include <cmath>
#include <cstdio>

namespace proxima::bench {

namespace {

using testing::swing;
using testing::SwingResult;
using testing::SwingSetting;
using testing::SwingWall;
using testing::WallSides;

HandModel free_device(double damping, int delay)
{
    HandModel model = testing::without_hand();
    model.device_damping = damping;
    model.delay_ticks = delay;
    return model;
}

/// Returns whether all limits are those of theory.
bool print_limits()
{
    std::printf("stiffness at which a wall of damping B begins to swing, N/m, tick of 1 ms\n");
    std::printf("%6s %6s %6s %10s %10s %8s\n", "b", "B", "delay", "theory", "measured", "ratio");
    bool right = true;
    for (const double b : {0.1, 0.5, 1.0}) {
        for (const double damping : {0.0, 1.0}) {
            for (int delay = 0; delay <= 3; ++delay) {
                // Late damping is no longer all damping: theory's limit is for none, or no delay.
                const bool exact = damping == 0 || delay == 0;
                const double theory = (b + damping) / (1e-3 * (0.5 + delay));
                const double limit = testing::stiffness_limit(free_device(b, delay), damping);
                std::printf("%6.1f %6.1f %6d %10.1f %10.1f %8.3f%s\n", b, damping, delay, theory,
                            limit, limit / theory, exact ? "" : "  late damping");
                right = right && (!exact || std::abs(limit / theory - 1) < 0.02);
            }
        }
    }
    return right;
}

void print_length(double metres)
{
    if (metres < testing::far_away / 2) {
        std::printf(" %12.3f", 1e3 * metres);
    } else {
        std::printf(" %12s", "gone");
    }
}

/// Returns whether all devices come to rest with the guard.
bool print_devices()
{
    std::printf("\nswing after 20 s at the greatest stiffness, b 0.1 and B 0, mm, and the guard's\n"
                "least factor of the force\n");
    std::printf("%-8s %6s %6s %12s %12s %12s %8s\n", "device", "K", "delay", "unguarded", "guarded",
                "on the way", "factor");
    const SwingWall wall(WallSides::two);
    bool rests = true;
    for (const DeviceLimits& device : known_devices()) {
        for (int delay = 0; delay <= 3; ++delay) {
            SwingSetting setting;
            setting.device = device;
            setting.stiffness = device.max_stiffness;
            setting.hand = free_device(0.1, delay);
            const SwingResult guarded = swing(wall, setting, 20, 2);
            setting.guard = Guard::off;
            const SwingResult unguarded = swing(wall, setting, 20, 2);
            std::printf("%-8s %6.0f %6d", std::string(device.name).c_str(), setting.stiffness,
                        delay);
            print_length(unguarded.amplitude);
            print_length(guarded.amplitude);
            print_length(guarded.greatest);
            std::printf(" %8.3f\n", guarded.lowest_softness);
            rests = rests && guarded.amplitude < 1e-3;
        }
    }
    return rests;
}

} // namespace

int run_stability_table()
{
    const bool right = print_limits();
    const bool rests = print_devices();
    if (!right) std::printf("a measured limit is NOT that of theory\n");
    if (!rests) std::printf("a guarded device did NOT come to rest\n");
    return right && rests ? 0 : 1;
}

} // namespace proxima::bench
