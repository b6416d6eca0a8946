// Coulomb's friction of a tool at its contacts.
//
//     loads ─▶ frictions, at most mu times their load ─▶ motion (friction_constraint.h) ─▶ its loads
//       ▲                                                                                     │
//       └──────────────────────── until they agree, and for the next motion ◀─────────────────┘
//
// With loads that are given, friction only takes energy: the springs never store more after a motion
// than without one, whatever the loads. So a device at rest leaves the tool at rest.
//
// The tool sticks until a contact slides against mu_s, and slides against mu_d until friction holds it
// with less than a part of mu_s, as a point proxy does (proxy.h).
#pragma once

#include "haptics/tool/friction_constraint.h"
#include "haptics/tool/least_constraint.h"
#include "haptics/tool/seen_object.h"
#include "haptics/tool/tool_contacts.h"
#include "proxima/geometry.h"
#include "proxima/haptic_renderer.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace proxima {

struct FrictionOptions {
    double restick = 0.6;      ///< sliding ends below this part of mu_s
    double turning_length = 1; ///< as of the constraints
    double least_slip = 0;     ///< shorter slips count as sticking
};

/// One thread. noexcept and without allocation but for the constructor.
class ToolFriction {
public:
    /// For motions with so many constraints at most.
    ToolFriction(const FrictionOptions& options, std::size_t most_constraints);

    [[nodiscard]] Hold hold() const noexcept { return hold_; }

    /// No contact pressed before.
    void restart() noexcept;

    /// The motion from a pose nearest to the wanted one, while the objects make their steps. Constraint
    /// k is that of contact k.
    [[nodiscard]] ConstrainedMotion solve(const Vec6& wanted, const RigidTransform& pose,
                                          std::span<const SeenObject> objects,
                                          std::span<const FeatureContact> contacts,
                                          std::span<const MotionConstraint> constraints,
                                          double tolerance) noexcept;

    /// Steps of the last solve().
    [[nodiscard]] std::size_t steps() const noexcept { return steps_; }

    /// What friction takes from the springs' energy on the way to a pose, of springs of stiffness 1.
    /// \pre no object moved in the last solve()
    [[nodiscard]] double loss(const RigidTransform& to) const noexcept;

    /// Likewise for a small motion.
    [[nodiscard]] double loss(const Vec6& motion) const noexcept;

private:
    /// Where and how hard a contact presses.
    struct Load {
        Vec3 point = Vec3::Zero();   ///< in the tool's frame
        Vec3 normal = Vec3::UnitZ(); ///< in the object's
        double pressure = 0;
        std::uint32_t object = 0;
    };
    struct Loads {
        std::array<Load, max_frictions> items;
        std::size_t count = 0;

        [[nodiscard]] double total() const noexcept;
    };

    void set_frictions(std::span<const SeenObject> objects) noexcept;
    [[nodiscard]] Loads loads_of(const ConstrainedMotion& motion,
                                 std::span<const SeenObject> objects,
                                 std::span<const FeatureContact> contacts) const noexcept;
    [[nodiscard]] Hold hold_of(const FrictionalMotion& found) const noexcept;

    FrictionOptions options_;
    std::vector<MotionConstraint> scratch_;
    RigidTransform pose_; ///< of the last solve()
    Loads loads_;         ///< of the last motion
    Loads used_;          ///< those that the frictions have
    std::array<MotionFriction, max_frictions> frictions_;
    double most_friction_ = 0; ///< that static friction could have with these loads
    Hold hold_ = Hold::free;
    std::size_t steps_ = 0;
};

} // namespace proxima
