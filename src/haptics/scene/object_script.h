// How an object of a scene moves by itself: simple motions that never leave a box, the same in
// every session.
//
//     rest    where it stands          rock    to and fro about an axis through its middle
//     spin    round that axis          swing   to and fro along a way
//
// A pose follows from the time alone, so that what was felt can be felt again, bit for bit.
#pragma once

#include "proxima/geometry.h"
#include "proxima/result.h"

#include <cstdint>

namespace proxima {

enum class ObjectMotionKind : std::uint8_t { rest, spin, rock, swing };

/// Lengths in the scene's unit, axes of the scene.
struct ObjectScript {
    ObjectMotionKind kind = ObjectMotionKind::rest;
    Vec3 along = Vec3::Zero(); ///< spin, rock: the axis, of any length; swing: the way
    double angle = 0;          ///< spin: radians per second; rock: radians to either side
    double seconds = 0;        ///< rock, swing: there and back
};

/// How often an application says where its objects are to be: 50 times a second.
inline constexpr double seconds_per_word = 0.02;

/// Nothing turns faster, radians per second: half a radian from word to word.
inline constexpr double fastest_turn = 25;

/// Errors invalid_argument: numbers that are not finite, no axis or way, a time of no length, turns
/// that are too fast.
[[nodiscard]] Status check_script(const ObjectScript& script);

/// Where an object is that begins at `begin`. `middle` is the one of its own box, in its own frame.
/// noexcept, no allocation. \pre check_script holds, seconds >= 0
[[nodiscard]] RigidTransform pose_at(const ObjectScript& script, const RigidTransform& begin,
                                     const Vec3& middle, double seconds) noexcept;

/// A box that it never leaves, also where it goes straight, turning evenly, from word to word.
/// \pre check_script holds
[[nodiscard]] Box reach_of(const ObjectScript& script, const RigidTransform& begin,
                           const Box& bounds) noexcept;

} // namespace proxima
