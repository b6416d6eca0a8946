#include "haptics/soak/hand_soak.h"

#include "haptics/hand_sessions.h"
#include "proxima/device.h"

#include <algorithm>
#include <cstdio>
#include <string>
#include <vector>

namespace proxima::soak {

int run_hand_soak(double seconds, std::uint64_t seed, bool hardest, const std::string& only,
                  const std::string& name)
{
    std::printf("seed %llu, sessions of %g s\n%-8s %6s %9s %9s %9s %9s %9s %9s %9s\n",
                static_cast<unsigned long long>(seed), seconds, "device", "K", "sessions",
                "damped %", "most", "taken %", "softened", "least", "faulty");
    const testing::SwingWall wall(testing::WallSides::one);
    bool right = true;
    for (const DeviceLimits& device : known_devices()) {
        if (!only.empty() && device.name != only) continue;
        const double usual = std::min(ForceOptions{}.stiffness, device.max_stiffness);
        std::vector<double> values = {usual};
        if (hardest && device.max_stiffness > usual) values.push_back(device.max_stiffness);
        for (const double stiffness : values) {
            auto sessions = testing::hand_sessions(device, stiffness, seed);
            std::erase_if(sessions, [&](const testing::HandSession& session) {
                return session.name.find(name) == std::string::npos;
            });
            double damped = 0;
            double most_damped = 0;
            double most_taken = 0;
            int softened = 0;
            int faulty = 0;
            double least = 1;
            for (const testing::HandSession& session : sessions) {
                const testing::HandOutcome outcome =
                    testing::run_hand_session(wall, session, seconds);
                const SwingReport& swings = outcome.swings;
                damped += outcome.damped / static_cast<double>(sessions.size());
                most_damped = std::max(most_damped, outcome.damped);
                most_taken = std::max(most_taken, outcome.taken);
                faulty += outcome.input.faulty_ticks > 0 ? 1 : 0;
                if (swings.softened_ticks == 0) continue;
                ++softened;
                least = std::min(least, swings.lowest_softness);
                std::printf("    softened %llu times, to %.2f, for %.1f s at most: %s\n",
                            static_cast<unsigned long long>(swings.softenings),
                            swings.lowest_softness, swings.longest_softening, session.name.c_str());
            }
            std::printf("%-8s %6.0f %9zu %9.1f %9.1f %9.1f %9d %9.2f %9d\n",
                        std::string(device.name).c_str(), stiffness, sessions.size(), 100 * damped,
                        100 * most_damped, 100 * most_taken, softened, least, faulty);
            (void)std::fflush(stdout);
            right = right && faulty == 0 && (softened == 0 || stiffness > usual);
        }
    }
    std::printf("%s\n", right ? "no force was lost" : "FORCE WAS LOST");
    return right ? 0 : 1;
}

} // namespace proxima::soak
