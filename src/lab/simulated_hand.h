// A simulated hand that holds a device. Unlike a replay it can show an unstable setting.
//
//     m x'' = F(t - delay) - b x' - friction + hand        F is constant over a tick
//     hand  = k (target - x) - d x'                        the target is a script's
//     reported: x rounded to the encoder's step, and its velocity by differences
//
// Between ticks the motion is solved exactly (matrix exponential), so limits of stability are those
// of theory: K < (b + B) / (T / 2 + delay) for a wall of stiffness K and damping B
// [colgate-1997], and no limit cycle below K = 2 friction / step [abbott-2005].
#pragma once

#include "proxima/device.h"
#include "proxima/geometry.h"

#include <array>
#include <cstddef>

namespace proxima {

/// Velocities as the device reports them.
enum class VelocityEstimate : std::uint8_t {
    backward_difference, ///< of reported positions
    exact                ///< as simulated
};

struct HandModel {
    double mass = 0.1;           ///< kg, of device and hand
    double device_damping = 0.5; ///< b, N s/m
    double coulomb_friction = 0; ///< N, against the velocity
    double encoder_step = 0;     ///< m; 0 = none
    int delay_ticks = 0;         ///< between setting a force and its effect
    double hand_stiffness = 150; ///< k, N/m
    double hand_damping = 5;     ///< d, N s/m
    double tick_seconds = 1e-3;  ///< T
    VelocityEstimate velocity = VelocityEstimate::backward_difference;
};

/// The longest delay, in ticks.
inline constexpr int max_hand_delay = 64;

/// State of hand and device. One thread; noexcept, no allocation.
class SimulatedHand {
public:
    /// At rest at a position. \pre mass > 0, tick > 0, the rest not negative, delay at most
    /// max_hand_delay
    SimulatedHand(const HandModel& model, const Vec3& at) noexcept;

    [[nodiscard]] const HandModel& model() const noexcept { return model_; }

    /// The state that the device reports.
    [[nodiscard]] DeviceState state() const noexcept;

    /// Advances by a tick: the force acts after the delay, the hand pulls towards the target.
    void step(const Vec3& force, const Vec3& target) noexcept;

    /// The true position.
    [[nodiscard]] const Vec3& position() const noexcept { return position_; }
    [[nodiscard]] const Vec3& velocity() const noexcept { return velocity_; }

    /// J
    [[nodiscard]] double kinetic_energy() const noexcept
    {
        return 0.5 * model_.mass * velocity_.squaredNorm();
    }

    /// Sets the motion, for tests of decay and growth.
    void set_motion(const Vec3& position, const Vec3& velocity) noexcept;

private:
    [[nodiscard]] Vec3 reported_position() const noexcept;

    HandModel model_;
    // x+ = free_xx x + free_xv v + push_x a,  v+ = ..., with a the held force over the mass and x
    // counted from the target
    double free_xx_ = 1;
    double free_xv_ = 0;
    double free_vx_ = 0;
    double free_vv_ = 1;
    double push_x_ = 0;
    double push_v_ = 0;
    Vec3 position_;
    Vec3 velocity_ = Vec3::Zero();
    Vec3 reported_before_;
    std::array<Vec3, max_hand_delay + 1> delayed_;
    std::size_t ticks_ = 0;
};

} // namespace proxima
