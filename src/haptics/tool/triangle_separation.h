// A plane between a triangle of a scene and one of a moving tool, and for how much of a motion it
// stays between them.
//
//     scene   n . x <= offset |   gap   | n . x >= offset + gap   tool
//
// The scene's triangle rests, so a plane whose gap is wide enough at both ends of a motion, but for
// the height of the arcs over their chords, keeps the two apart all the way. Where one plane does not,
// the motion is advanced from plane to plane (conservative advancement, [mirtich-1996]).
#pragma once

#include "haptics/tool/rigid_motion.h"
#include "proxima/geometry.h"

#include <cstdint>

namespace proxima {

/// Which contacts of a pair are among the constraints of a motion.
enum class PairContacts : std::uint8_t { none, near, all };

/// A triangle of an object and one of the tool, near each other.
struct NearPair {
    Triangle scene;             ///< in the scene's frame
    Triangle tool;              ///< in the tool's own
    Vec3 normal = Vec3::Zero(); ///< of length 1, or zero before the first plane
    double offset = 0;
    double reach = 0; ///< of the tool's triangle from the tool's origin
    std::uint32_t scene_row = 0;
    std::uint32_t tool_row = 0;
    std::uint32_t object = 0;
    PairContacts contacts = PairContacts::none; ///< that are among the constraints
};

/// A motion of the tool.
struct ToolMotion {
    RigidTransform from;
    RigidTransform to; ///< moved_by(from, twist, 1)
    Twist twist;
};

/// Gives the pair the plane across a direction of any length, or none where that is zero.
void set_normal(NearPair& pair, const Vec3& across) noexcept;

/// The gap of the pair's plane with the tool in a pose: below the distance of the triangles, up to
/// rounding. -infinity without a plane.
[[nodiscard]] double plane_gap(const NearPair& pair, const RigidTransform& pose) noexcept;

/// Whether the pair's plane keeps a gap of at least `least` all the motion long.
[[nodiscard]] bool stays_apart(const NearPair& pair, const ToolMotion& motion,
                               double least) noexcept;

/// Looks for a plane that does: the one across the direction that served the last pair, that of either
/// triangle, then the one across their closest points at the beginning, which it leaves behind where
/// none does, and in `last`. 0.1 to 1 us.
[[nodiscard]] bool find_plane(NearPair& pair, const ToolMotion& motion, double least,
                              Vec3& last) noexcept;

/// How near triangles may come in a motion.
struct GapLimits {
    double near = 0;   ///< triangles that begin farther apart
    double wanted = 0; ///< come no nearer than this; less than `near`
    double least = 0;  ///< others come no nearer than this, or than they are where that is less
};

/// The part of the motion, at most `most`, that keeps the triangles apart.
[[nodiscard]] double free_part(NearPair& pair, const ToolMotion& motion, const GapLimits& limits,
                               double most) noexcept;

} // namespace proxima
