// The force for the device, from the proxy: a spring, a damper, and guards.
//
//     spring    F = K (anchor - device)                from the surface to the device
//     damper    F += -B (v . n) n                     along the contact's normal; never pulls
//     guards    in this order: not finite -> zero; ramps; clamp to |F|max; slew limit
//
// The result is finite and within the device's limit, whatever the input. A ramp goes up at the
// start, so that a device that starts deep inside is not kicked out, and another goes down to zero
// while the patch is lost.
#pragma once

#include "proxima/device.h"
#include "proxima/geometry.h"
#include "proxima/haptic_renderer.h"

#include <cstdint>

namespace proxima {

/// The vector, shortened to a length of at most `most`, rounding included.
[[nodiscard]] Vec3 shortened(const Vec3& v, double most) noexcept;

/// The options within a device's limits.
[[nodiscard]] ForceOptions limited(ForceOptions options, const DeviceLimits& limits) noexcept;

/// A contact, in the device's metres.
struct SpringContact {
    bool touching = false;
    Vec3 stretch = Vec3::Zero(); ///< from the device to the anchor
    Vec3 normal = Vec3::Zero();  ///< of length 1, outward
};

/// Spring and damper. Damping never makes the force pull against the contact's normal.
[[nodiscard]] Vec3 spring_force(const ForceOptions& options, const SpringContact& contact,
                                const Vec3& velocity) noexcept;

/// The baseline without a proxy: F = K d n - B (v . n) n for a depth d > 0 below the closest
/// feature. Jumps where the feature switches, and passes through thin walls.
[[nodiscard]] Vec3 penalty_force(const ForceOptions& options, double depth, const Vec3& normal,
                                 const Vec3& velocity) noexcept;

/// The guards; one per device. noexcept, no allocation.
class ForceGuard {
public:
    /// \pre max_force > 0
    ForceGuard(const ForceOptions& options, double max_force) noexcept;

    /// The force for this tick of `seconds`: finite, at most max_force long, and at most
    /// max_slew * seconds away from the last one.
    [[nodiscard]] Vec3 pass(const Vec3& wanted, double seconds,
                            Patch patch = Patch::available) noexcept;

    /// Starts anew: the next force ramps up from zero.
    void restart() noexcept;

    /// Crosses over to another surface: the last force fades in loss_seconds, while new ones ramp up
    /// as at the start.
    void cross_over() noexcept;

    [[nodiscard]] const Vec3& last() const noexcept { return last_; }

    /// The factor of the ramps in the last force: 1 except after a start or a loss.
    [[nodiscard]] double ramp() const noexcept { return start_ * patch_; }

    /// Ticks in which a guard changed the force.
    [[nodiscard]] std::uint64_t clamped() const noexcept { return clamped_; }
    [[nodiscard]] std::uint64_t slewed() const noexcept { return slewed_; }
    [[nodiscard]] std::uint64_t refused() const noexcept { return refused_; } ///< not finite

private:
    ForceOptions options_;
    double max_force_;
    double start_ = 0; ///< 0 to 1
    double patch_ = 1; ///< 0 to 1
    double fade_ = 0;  ///< 1 to 0: the part of `fading_` that is left
    Vec3 fading_ = Vec3::Zero();
    Vec3 last_ = Vec3::Zero();
    std::uint64_t clamped_ = 0;
    std::uint64_t slewed_ = 0;
    std::uint64_t refused_ = 0;
};

} // namespace proxima
