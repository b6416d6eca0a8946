// Poses that commands read. A pose is, by how many numbers it has:
//
//      3    tx,ty,tz                     moved
//      7    tx,ty,tz,qx,qy,qz,qw         turned by a quaternion of length 1, then moved
//     12    the 3 x 4 matrix (R | t), row by row
//     16    the 4 x 4 matrix, whose last row is 0,0,0,1
//
// and on the command line also tx,ty,tz@ax,ay,az,degrees: turned about an axis, then moved.
#pragma once

#include "cli/session.h"
#include "proxima/geometry.h"
#include "proxima/result.h"

#include <string>
#include <string_view>
#include <vector>

namespace proxima {

/// For help and messages.
inline constexpr std::string_view pose_forms =
    "TX,TY,TZ; TX,TY,TZ@AX,AY,AZ,DEGREES (turned about that axis first); TX,TY,TZ,QX,QY,QZ,QW (by "
    "a "
    "quaternion); or 12 or 16 numbers (a 3x4 or 4x4 matrix by rows)";

struct Poses {
    std::vector<RigidTransform> poses;
    /// How far the farthest rotation was from one as given (rotation_error), before the nearest one
    /// took its place.
    double rotation_error = 0;
};

/// A pose of the command line. Error invalid_argument: no pose, or no rigid transform.
[[nodiscard]] Result<Poses> parse_pose(std::string_view text);

/// One pose as parse_pose() takes it, or a table's. Errors as read_number_table, and
/// invalid_argument for a row that is no rigid transform, naming its line (of .npy its row, from 0).
[[nodiscard]] Result<Poses> read_poses(const std::string& path_or_pose, Session& session);

/// A line that says that rotations were replaced, and by how much they were off; empty where they
/// were exact. Where stdout has no report, because rows or JSON go there, it is a note.
[[nodiscard]] std::string rotation_text(double rotation_error, bool has_report, Session& session);

} // namespace proxima
