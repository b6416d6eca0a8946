// Mass, damping, friction and delay of a device along an axis, from how known forces moved it.
//
//     force     +A ┐      ┌ +A                     measured position
//               ───┘      │   ┘────                       │
//                  └ -A ──┘                        least squares: which m, b, f, k, w, delay
//                                                         │
//     m x'' = F(t - delay) - b x' - f sign(x') - k x + w ─┘  model, solved piece by piece
//
// The fit compares positions, not their derivatives, so the encoder's step adds an error of its own
// size and nothing more. For each whole number of ticks of delay the other numbers are fitted
// (Levenberg-Marquardt); the delay is that of the least sum of squares. The stiffness k is that of
// whatever still holds the device, and w a constant force, such as weight.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace proxima {

/// What was seen in a tick, and the force that was set in it.
struct PushSample {
    double seconds = 0;
    double position = 0; ///< m, along the axis
    double force = 0;    ///< N, held until the next sample
    bool fresh = true;   ///< false: the position is that of an earlier tick
};

/// A push that begins with the device at rest, or nearly: the force of its first `lead` samples is 0.
struct Push {
    std::span<const PushSample> samples;
    std::size_t lead = 0;
};

/// A number and its standard error.
struct Fitted {
    double value = 0;
    double error = 0;

    /// Whether it differs from 0 by more than chance.
    [[nodiscard]] bool is_certain() const noexcept { return value > 4 * error; }
};

struct MotionFit {
    Fitted mass = {};      ///< kg
    Fitted damping = {};   ///< N s/m
    Fitted friction = {};  ///< N, Coulomb's, while it slides
    Fitted stiffness = {}; ///< N/m, of what holds the device; 0 if nothing does
    double weight = 0;     ///< N, a constant force along the axis
    int delay = 0;       ///< ticks, of all that lies between setting a force and seeing its effect
    int least_delay = 0; ///< ticks: delays that the positions exclude are outside of these two
    int most_delay = 0;
    double residual = 0; ///< m, root of the mean square of measured less fitted positions
    double travel = 0;   ///< m, how far the pushes moved the device
    bool found = false;  ///< false: the device did not move enough to say anything, or is_later
    /// The positions do not exclude the longest delay that was tried: the delay is least_delay or
    /// more, and all other numbers may be wrong.
    bool is_later = false;
};

struct MotionFitOptions {
    int most_delay = 80;   ///< ticks: delays from 0 to this are tried
    double resolution = 0; ///< m: positions are exact to this, the encoder's step
};

/// Fits all pushes along an axis together. The cost grows with the number of
/// delays: tenths of a second for all of them. Allocates.
[[nodiscard]] MotionFit fit_motion(std::span<const Push> pushes, const MotionFitOptions& options);

} // namespace proxima
