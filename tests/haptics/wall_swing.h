// A simulated hand against walls, through the whole renderer: what swings, and how far.
#pragma once

#include "haptics/force/surface_renderer.h"
#include "haptics/surface/contact_surface.h"
#include "lab/simulated_hand.h"
#include "octree/small_meshes.h"
#include "proxima/device.h"
#include "proxima/haptic_renderer.h"
#include "proxima/sample_meshes.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace proxima::testing {

/// The upper face of a cube, or a slot between two cubes that is as wide as the proxy.
enum class WallSides : int { one = 1, two = 2 };

/// A wall at z = 0 in the device's metres, which pushes along z.
class SwingWall {
public:
    explicit SwingWall(WallSides sides) : sides_(sides), mesh_(make(sides)), surface_(mesh_) {}

    [[nodiscard]] const ContactSurface& surface() const { return surface_; }
    [[nodiscard]] WallSides sides() const { return sides_; }
    [[nodiscard]] static WorkspaceMap map() { return {1, Vec3::Zero()}; }
    /// Of the proxy: of a slot the half width but for a thousandth of a millimetre.
    [[nodiscard]] double radius() const { return sides_ == WallSides::two ? ball : 0; }

private:
    static constexpr double ball = 0.005;
    static constexpr double room = 1e-6;

    static TriangleMesh make(WallSides sides)
    {
        const double half = 0.5;
        const double gap = sides == WallSides::two ? ball + room : 0.0;
        TriangleMesh below = cube_mesh(Vec3(0, 0, -half - gap), half);
        if (sides == WallSides::one) return below;
        return joined(below, cube_mesh(Vec3(0, 0, half + gap), half));
    }

    WallSides sides_;
    TriangleMesh mesh_;
    MeshContactSurface surface_;
};

inline constexpr double far_away = 0.5; ///< m

struct SwingSetting {
    DeviceLimits device = *find_device("omni");
    double stiffness = 500;
    double damping = 0;
    HandModel hand = {};
    double target = 0; ///< m: height to which the hand pulls
    Guard guard = Guard::on;
};

struct SwingResult {
    double amplitude = 0; ///< m: half the way between the highest and the lowest place in half a
                          ///< second of the end, the most of all
    double greatest = 0;  ///< m: the same of all
    double lowest_softness = 1;
    std::uint64_t softened = 0;
    std::uint64_t damped = 0;
    double checksum = 0; ///< of all forces
};

/// Lets the device go 1 mm below z = 0, for some seconds; the end is the last of `last` seconds.
inline SwingResult swing(const SwingWall& wall, const SwingSetting& setting, double seconds,
                         double last)
{
    RenderOptions options;
    options.force.stiffness = setting.stiffness;
    options.force.damping = setting.damping;
    options.proxy_radius = wall.radius();
    options.guard = setting.guard;
    HapticRenderer renderer =
        make_surface_renderer(wall.surface(), SwingWall::map(), setting.device, options);
    const double hand_tick = setting.hand.tick_seconds;
    // The proxy begins outside, and the ramp of the start is over when the hand lets go.
    DeviceState rest;
    rest.pose.translation = Vec3(0, 0, wall.sides() == WallSides::one ? 1e-3 : 0.0);
    for (int tick = 0; tick < 300; ++tick) renderer.tick(rest, hand_tick);
    SimulatedHand hand(setting.hand, Vec3(0, 0, -1e-3));
    const Vec3 target(0, 0, setting.target);
    const int ticks = static_cast<int>(std::lround(seconds / hand_tick));
    const int end = ticks - static_cast<int>(std::lround(last / hand_tick));
    SwingResult outcome;
    double low = 0;
    double high = 0;
    double end_low = 0;
    double end_high = 0;
    const int part = static_cast<int>(std::lround(0.5 / hand_tick));
    for (int tick = 0; tick < ticks; ++tick) {
        const RenderTick& result = renderer.tick(hand.state(), hand_tick);
        hand.step(result.force, target);
        const double z = hand.position().z();
        outcome.checksum += result.force.z() * (tick % 1000 + 1);
        low = std::min(low, z);
        high = std::max(high, z);
        if (!(std::abs(z) < far_away)) { // out of any hand
            outcome.amplitude = (high - low) / 2;
            break;
        }
        if (tick < end) continue;
        if ((tick - end) % part == 0) end_low = end_high = z;
        end_low = std::min(end_low, z);
        end_high = std::max(end_high, z);
        outcome.amplitude = std::max(outcome.amplitude, (end_high - end_low) / 2);
    }
    outcome.greatest = (high - low) / 2;
    const SwingReport& report = parts_of(renderer).passivity().report();
    outcome.lowest_softness = report.lowest_softness;
    outcome.softened = report.softened_ticks;
    outcome.damped = report.damped_ticks;
    return outcome;
}

} // namespace proxima::testing
