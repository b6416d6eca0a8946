// Simple motions of an object of a scene, which never leave a box and are the same in every session.
//
//     rest    no motion                           rock    to and fro about such an axis
//     spin    about an axis through its middle    swing   to and fro along a displacement
//
// A pose depends on the time alone, so that a session can be replayed bit for bit.
#pragma once

#include "proxima/geometry.h"
#include "proxima/result.h"

#include <cstdint>

namespace proxima {

enum class ObjectMotionKind : std::uint8_t { rest, spin, rock, swing };

/// Lengths in the scene's unit, axes of the scene.
struct ObjectScript {
    ObjectMotionKind kind = ObjectMotionKind::rest;
    Vec3 along = Vec3::Zero(); ///< spin, rock: the axis, of any length; swing: the displacement
    double angle = 0;          ///< spin: radians per second; rock: radians to either side
    double seconds = 0;        ///< rock, swing: there and back
};

/// The time between two updates of an application's objects: 50 updates a second.
inline constexpr double seconds_per_update = 0.02;

/// The fastest rotation, radians per second: half a radian from one update to the next.
inline constexpr double fastest_turn = 25;

/// Error invalid_argument: numbers that are not finite, an axis or displacement that is zero or not
/// 1e-100 to 1e100 long, a period that is not 1e-6 to 1e9 seconds, a rotation that is too fast.
[[nodiscard]] Status check_script(const ObjectScript& script);

/// The pose of an object that begins at `begin`. `middle` is that of its box, in its own frame.
/// noexcept, no allocation. \pre check_script holds, seconds >= 0
[[nodiscard]] RigidTransform pose_at(const ObjectScript& script, const RigidTransform& begin,
                                     const Vec3& middle, double seconds) noexcept;

/// A box that the object never leaves but by rounding, also where it moves evenly from one update to the
/// next with its middle as the pivot (object_trajectory.h).
/// \pre check_script holds
[[nodiscard]] Box swept_bounds(const ObjectScript& script, const RigidTransform& begin,
                               const Box& bounds) noexcept;

} // namespace proxima
