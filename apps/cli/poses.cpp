#include "cli/poses.h"

#include "base/text.h"
#include "cli/names.h"
#include "cli/number_table.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <fmt/format.h>
#include <numbers>
#include <optional>
#include <span>

namespace proxima {

namespace {

constexpr std::array<std::string_view, 4> pose_layouts = {
    "tx,ty,tz", "tx,ty,tz,qx,qy,qz,qw", "r00,r01,r02,tx,r10,r11,r12,ty,r20,r21,r22,tz",
    "r00,r01,r02,tx,r10,r11,r12,ty,r20,r21,r22,tz,r30,r31,r32,r33"};

tl::unexpected<Error> refuse(std::string message)
{
    return fail(ErrorCode::invalid_argument, std::move(message));
}

/// 3, 7, 12 or 16 numbers.
Status add_pose(std::span<const double> n, Poses& poses)
{
    RigidTransform pose;
    if (n.size() < 12) pose.translation = {n[0], n[1], n[2]};
    if (n.size() == 7) {
        const Eigen::Quaterniond turn(n[6], n[3], n[4], n[5]);
        const double off = std::abs(turn.norm() - 1);
        if (!(off <= nearly_rigid_tolerance)) {
            return refuse(concat("the quaternion has length ", turn.norm(),
                                 ": give qx,qy,qz,qw of length 1, after tx,ty,tz"));
        }
        poses.rotation_error = std::max(poses.rotation_error, off > rigid_tolerance ? off : 0);
        pose.rotation = turn.normalized().toRotationMatrix();
    }
    if (n.size() == 16 && (n[12] != 0 || n[13] != 0 || n[14] != 0 || n[15] != 1)) {
        return refuse("the last row of a 4x4 matrix must be 0,0,0,1: give the matrix by rows, for "
                      "points that are columns");
    }
    if (n.size() >= 12) {
        const auto matrix = n.first<12>();
        const auto rigid = make_rigid_transform(matrix);
        if (!rigid) return tl::unexpected(rigid.error());
        const double off = rotation_error(matrix);
        poses.rotation_error = std::max(poses.rotation_error, off > rigid_tolerance ? off : 0);
        pose = *rigid;
    }
    poses.poses.push_back(pose);
    return {};
}

/// tx,ty,tz@ax,ay,az,degrees
Result<RigidTransform> turned(std::span<const double> moved, std::span<const double> turn)
{
    Vec3 axis(turn[0], turn[1], turn[2]);
    const double largest = axis.cwiseAbs().maxCoeff();
    if (largest == 0) return refuse("the axis of a pose must not be zero");
    // By a power of two, which rounds nothing, so that squares stay within the doubles.
    for (double& component : axis) component = std::ldexp(component, -std::ilogb(largest));
    const double angle = std::fmod(turn[3], 360.0) * (std::numbers::pi / 180);
    RigidTransform pose;
    pose.rotation = Eigen::AngleAxisd(angle, axis.normalized()).toRotationMatrix();
    pose.translation = {moved[0], moved[1], moved[2]};
    return pose;
}

/// Whether the text is a list of numbers, with commas, of which one is "nan", "inf" or too large for a double (1e999).
bool has_number_not_finite(std::string_view text)
{
    if (text.find(',') == std::string_view::npos) return false;
    bool found = false;
    for (const std::string& part : split_list(text.substr(0, text.find('@')))) {
        const char* const end = part.data() + part.size();
        double number = 0;
        const auto parsed = std::from_chars(part.data(), end, number);
        if (parsed.ec == std::errc::invalid_argument || parsed.ptr != end) return false;
        found = found || parsed.ec == std::errc::result_out_of_range || !std::isfinite(number);
    }
    return found;
}

} // namespace

Result<Poses> parse_pose(std::string_view text)
{
    const auto failed = [&](const Error& error) {
        return refuse(concat("'", text, "': ", error.message));
    };
    const auto no_pose = [&] {
        return refuse(concat("'", text, "' is no pose: give ", pose_forms));
    };
    const std::size_t at = text.find('@');
    const auto numbers = parse_finite_numbers(text.substr(0, at));
    if (!numbers) return no_pose();
    Poses poses;
    if (at != std::string_view::npos) {
        const auto turn = parse_finite_numbers(text.substr(at + 1));
        if (!turn || turn->size() != 4 || numbers->size() != 3) return no_pose();
        const auto pose = turned(*numbers, *turn);
        if (!pose) return failed(pose.error());
        poses.poses.push_back(*pose);
        return poses;
    }
    constexpr std::array<std::size_t, 4> sizes = {3, 7, 12, 16};
    if (std::ranges::find(sizes, numbers->size()) == sizes.end()) return no_pose();
    if (Status status = add_pose(*numbers, poses); !status) return failed(status.error());
    return poses;
}

Result<Poses> read_poses(const std::string& path_or_pose, Session& session)
{
    // Files may have numbers for names, but hardly three of them and commas.
    const std::string_view text = path_or_pose;
    const bool is_pose = text.find(',') != std::string_view::npos &&
                         parse_finite_numbers(text.substr(0, text.find('@'))).has_value();
    if (is_pose) return parse_pose(text);
    if (has_number_not_finite(text)) {
        return refuse(concat(
            "'", text, "' has a number that is NaN, infinite or beyond doubles: give finite ones"));
    }
    const auto table = session.load_table(path_or_pose, {pose_layouts});
    if (!table && table.error().code == ErrorCode::file_not_found) {
        return fail(table.error().code,
                    concat("is no pose, and no file of poses either (", table.error().message,
                           "): give ", pose_forms),
                    path_or_pose);
    }
    if (!table) return tl::unexpected(table.error());
    Poses poses;
    poses.poses.reserve(table->rows());
    for (std::size_t i = 0; i < table->rows(); ++i) {
        const Status status = add_pose(table->row(i), poses);
        if (!status) return fail(status.error().code, status.error().message, table->place_of(i));
    }
    return poses;
}

std::string rotation_text(double rotation_error, bool has_report, Session& session)
{
    if (rotation_error == 0) return {};
    const std::string text =
        fmt::format("rotations are rounded, up to {:.2g} off (R^T R from the identity, or a "
                    "quaternion's length from 1): the nearest rotations were used",
                    rotation_error);
    if (has_report && session.options().json != to_stdout) return text + '\n';
    session.note(text);
    return {};
}

} // namespace proxima
