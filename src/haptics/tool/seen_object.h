// An object as a tool sees it: where the tool has proven to be clear of it.
//
//     goal    where the object is in the scene
//     pose    where the tool sees it, which follows the goal as far as it passes nothing
//     step    from there towards the goal, while the tool makes a move
//
// An object that moves takes the tool along or takes its pose in the first move of a tick, unless it would
// enter the tool and the tool cannot give way: then it stays behind for the tool, and goes on in later
// ticks. All of a pair's geometry is in the object's frame, in which the tool moves relative to it.
#pragma once

#include "haptics/tool/contact_features.h"
#include "haptics/tool/rigid_motion.h"
#include "haptics/tool/triangle_separation.h"
#include "proxima/geometry.h"
#include "proxima/intersect_meshes.h"
#include "proxima/mesh_index.h"
#include "proxima/result.h"

#include <cstdint>

namespace proxima {

/// A mesh of a scene or a tool, with all that contacts need of it.
struct RigidBody {
    MeshIndex index;
    ContactFeatures features;
    Enclosure inside;

    /// Errors: those of with_slabs, ContactFeatures::build and build_enclosure.
    [[nodiscard]] static Result<RigidBody> build(const MeshIndex& index);
};

/// Coulomb's coefficients.
struct Friction {
    double fixed = 0;
    double sliding = 0; ///< at most `fixed`
};

struct SeenObject {
    RigidBody body;
    RigidTransform pose = {};
    RigidTransform goal = {};
    Friction friction = {};
    Twist step = {};              ///< in a move; zero at rest
    bool moves = false;           ///< in a move
    bool arrives = false;         ///< at the goal at its end
    RigidTransform relative = {}; ///< the tool's pose in this frame
    ToolMotion motion = {};       ///< of the tool in this frame, in a move
    RigidTransform listed = {};   ///< `relative` when near pairs were listed
    double list_reach = -1;       ///< no other triangle was nearer then
    std::uint32_t first_pair = 0; ///< of its pairs in the list
    std::uint32_t end_pair = 0;

    [[nodiscard]] bool is_behind() const noexcept;

    /// Sees the tool in a pose.
    void look_at(const RigidTransform& tool) noexcept;

    /// The tool's pose as the object will see it at its goal.
    [[nodiscard]] RigidTransform seen_from_goal(const RigidTransform& tool) const noexcept;

    /// Steps by a part of what is left to the goal.
    void begin_step(double part) noexcept;

    /// The tool's motion in this frame: a part of a twist to a pose, while the object steps by that
    /// part of its step.
    void set_motion(const Twist& twist, const RigidTransform& to, double part) noexcept;

    /// Where the object is after a part of its step.
    [[nodiscard]] RigidTransform stepped(double part) const noexcept;

    /// How far a point of the object moves in the step.
    [[nodiscard]] Vec3 displacement(const Vec3& point) const noexcept
    {
        return step.linear + step.angular.cross(point - pose.translation);
    }
};

} // namespace proxima
