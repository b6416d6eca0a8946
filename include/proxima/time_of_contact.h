// When a moving mesh first touches another one: continuous collision detection of rigid motions.
//
//     const RigidMotion motion = motion_between(pose_now, pose_next, center);
//     if (auto contact = time_of_contact(*index_a, *index_b, motion)) {
//         place_b(contact->free_pose);             // nothing was touched on the path up to here
//         slide_along(contact->normal);
//     }
//
//     time     0 -------- free_until | touches_at -------- 1
//              proven free of contact  the meshes meet, decided exactly
//
// Conservative advancement [mirtich-1996], [zhang-2006], [tang-2009] of pairs of parts: from a time at which
// two parts are apart, they stay so as long as their gap along one direction is not closed. Parts that may come
// together within the motion are divided, down to triangles. What slides along something else is dismissed,
// however near it is. Contact is that of surfaces: a mesh that moves inside another one,
// touching nothing, is free. Triangles are closed: touching counts.
#pragma once

#include "proxima/execution.h"
#include "proxima/export.h"
#include "proxima/geometry.h"
#include "proxima/mesh_index.h"
#include "proxima/result.h"
#include "proxima/triangle_mesh.h"

#include <cstdint>
#include <optional>

namespace PROXIMA_EXPORT proxima {

/// A rigid motion of B from time 0 to time 1: B turns about `center` at a constant angular velocity, and
/// the center moves along a straight line at a constant speed. At time t a point p of B is at
///
///     Rotation(t turn) start.rotation (p - center) + start(center) + t displacement
struct RigidMotion {
    RigidTransform start = {};
    Vec3 center = Vec3::Zero();       ///< in B's own coordinates
    Vec3 displacement = Vec3::Zero(); ///< of the center, over the whole motion
    Vec3 turn = Vec3::Zero(); ///< the axis times the angle in radians, in A's axes; more than
                              ///< one revolution is one
};

/// Radians that a motion may turn: about 10,000 revolutions.
inline constexpr double max_motion_turn = 65536;

/// B's pose at a time: at 0 `start`, bit for bit. Rotations by sines and cosines of the C library, off
/// by a few roundings of the angle. Without a turn, coordinates move monotonically, bit for bit.
[[nodiscard]] RigidTransform pose_at(const RigidMotion& motion, double time) noexcept;

/// The motion from a pose to another one whose rotation takes the shorter path, half a revolution at
/// most. pose_at(motion, 1) is `to` but for rounding. `center` is in B's own coordinates.
[[nodiscard]] RigidMotion motion_between(const RigidTransform& from, const RigidTransform& to,
                                         const Vec3& center) noexcept;

/// Error invalid_argument where a number is not finite or the turn is longer than max_motion_turn.
[[nodiscard]] Status check_motion(const RigidMotion& motion);

/// What a time of contact rests on.
enum class ContactEvidence : std::uint8_t {
    intersection, ///< the meshes meet at touches_at, as meshes_intersect decides, exactly
    /// Whatever the tolerance, they are nearer at free_until than six margins (below), and do not meet
    /// at the times that were tried: the tolerance and 4, 16, 64, ... margins later, up to 2^-10 of
    /// the time or 64 margins. Contact can be neither shown nor excluded. Where a mesh is larger
    /// than 2^1001, free_until is 0 and only contact at those times is shown.
    rounding,
    steps,    ///< max_steps were taken: free_until is as far as they got, 0 perhaps
    cancelled ///< the progress asked to stop: likewise
};

struct TimeOfContact {
    /// B does not touch A from 0 up to this time, at any time between: proven, roundings included. 0
    /// where they meet at the start.
    double free_until = 0;
    /// A time at which they meet; the first contact is between the two. At most the tolerance later where
    /// B comes nearer faster than roundings hide. Where it does not, as where it grazes A, at most 2^-10
    /// later, or the time in which the fastest point of B moves by 64 margins (below), or the next double,
    /// the latest of these. Infinity where the evidence is no intersection.
    double touches_at = 0;
    ContactEvidence evidence = ContactEvidence::intersection;

    RigidTransform free_pose; ///< of B at free_until
    /// How far the meshes are apart at free_until. If the progress was cancelled before this was known, it
    /// is infinite, and both points are 0.
    double distance = 0;
    Vec3 point_a = Vec3::Zero(); ///< their closest points then
    Vec3 point_b = Vec3::Zero();
    TriangleId triangle_a = {};
    TriangleId triangle_b = {};
    /// From A to B, of length 1: the direction that keeps the triangles that are about to touch apart;
    /// zero where the meshes meet at the start.
    Vec3 normal = Vec3::Zero();
    std::uint32_t steps = 0; ///< pairs of parts that were divided, and steps of pairs of triangles
};

struct TimeOfContactOptions {
    double tolerance = 1e-9;                 ///< of the time; 0 to 1, and 0 if NaN
    std::uint32_t max_steps = 1'000'000'000; ///< at least 1; about 1 us each
    Execution execution = {};                ///< one thread; stage "finding the time of contact"
};

/// The first contact of A with B along the motion; nothing where there is none, proven for every time
/// from 0 to 1, or where a mesh is empty. The proof holds for the motion as defined, and for B's
/// vertices as pose_at rounds them. Its margin is 3^(1/2) 2^-45 (1 + angle / 4) of the coordinates, those of
/// the path and the center included: what passes A at less ends the search by `rounding`. Real-time
/// safe: noexcept, no allocation, no lock, 0.3 MB of stack; any number of threads. 0.1 to 0.4 ms, median, of
/// scans; 1 us for each pair of triangles that slide along each other and whose surfaces are curved: bound
/// max_steps, or cancel. Indexes with slabs are faster. \pre check_motion(motion), the start is
/// rigid, moved coordinates are finite
[[nodiscard]] std::optional<TimeOfContact>
time_of_contact(const MeshIndex& a, const MeshIndex& b, const RigidMotion& motion,
                const TimeOfContactOptions& options = {}) noexcept;

} // namespace proxima
