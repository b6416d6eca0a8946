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

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>

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
    double floor = 0; ///< how near it may come in a motion (free_part)
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

/// Looks for a plane that does without looking for closest points: across a direction that served
/// another pair, and that of either triangle. Leaves the pair any plane where none does. 0.1 us.
[[nodiscard]] bool find_plane(NearPair& pair, const ToolMotion& motion, double least,
                              const Vec3& other) noexcept;

inline constexpr std::size_t closest_planes_at_once = 8;

/// Gives pairs the planes across their closest points with the tool in a pose, eight pairs at a time.
/// The gaps of these planes are the distances of the triangles, up to rounding. 0.1 us each.
void set_closest_planes(std::span<NearPair* const> pairs, const RigidTransform& pose) noexcept;

/// How near triangles may come in a motion.
struct GapLimits {
    double near = 0;   ///< triangles that begin farther apart
    double wanted = 0; ///< come no nearer than this; less than `near`
    double least = 0;  ///< others come no nearer than this, or than they are where that is less
};

inline constexpr std::size_t unlimited_work = std::numeric_limits<std::size_t>::max();

/// The work of a tick, about a microsecond a unit, and where it has to end.
struct ToolEffort {
    std::size_t spent = 0;
    std::size_t most = unlimited_work;
    bool cut_short = false; ///< something was left undone for it

    /// Whether something that takes so much may begin within a share of the work, and counts it.
    [[nodiscard]] bool begin(std::size_t work, double share = 1) noexcept
    {
        const bool may = static_cast<double>(spent + work) <= share * static_cast<double>(most);
        if (may) spent += work;
        cut_short = cut_short || !may;
        return may;
    }
};

/// The work of set_closest_planes.
[[nodiscard]] constexpr std::size_t closest_planes_work(std::size_t pairs) noexcept
{
    return (pairs + closest_planes_at_once - 1) / closest_planes_at_once;
}

/// The part of the motion, 0 to 1, that keeps all pairs apart. Where the effort ends it takes
/// what the planes that the pairs have prove. Changes the order of the pairs.
[[nodiscard]] double free_part(std::span<NearPair*> pairs, const ToolMotion& motion,
                               const GapLimits& limits, ToolEffort& effort) noexcept;

} // namespace proxima
