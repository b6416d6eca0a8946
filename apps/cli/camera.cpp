#include "cli/camera.h"

#include "geometry/length.h"
#include "proxima/geometry.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace proxima {
namespace {

/// The axis across `up` from which azimuth 0 looks: +z where y is up, else -y or what is left of it.
Vec3 front_of(const Vec3& up)
{
    const Vec3 axis = std::abs(up.y()) > 0.8 ? Vec3(0, 0, 1) : Vec3(0, -1, 0);
    return (axis - axis.dot(up) * up).normalized();
}

constexpr double near_part = 1e-4; // of the distance

} // namespace

View::View(const OrbitCamera& camera, ViewSize size)
    : zoom_(camera.zoom), near_(near_part * camera.distance), size_(size)
{
    const Vec3 front = front_of(camera.up);
    const Vec3 side = camera.up.cross(front);
    back_ = std::cos(camera.elevation) *
                (std::cos(camera.azimuth) * front + std::sin(camera.azimuth) * side) +
            std::sin(camera.elevation) * camera.up;
    // Seen from the pole the side still tells right from left.
    right_ = std::cos(camera.azimuth) * side - std::sin(camera.azimuth) * front;
    up_ = back_.cross(right_);
    eye_ = camera.target + camera.distance * back_;
}

ScreenPoint View::project(const Vec3& point) const noexcept
{
    const Vec3 offset = point - eye_;
    const double nearness = -1.0 / back_.dot(offset);
    const double half_height = 0.5 * size_.height;
    return {0.5 * size_.width + half_height * zoom_ * right_.dot(offset) * nearness,
            half_height * (1.0 - zoom_ * up_.dot(offset) * nearness), nearness};
}

Vec3 View::direction(const Vec2& pixel) const noexcept
{
    const double half_height = 0.5 * size_.height;
    const double right = (pixel.x() - 0.5 * size_.width) / half_height / zoom_;
    const double up = (1.0 - pixel.y() / half_height) / zoom_;
    return right * right_ + up * up_ - back_;
}

Eigen::Matrix4d View::clip_from_world(double near, double far) const
{
    Eigen::Matrix4d eye_from_world = Eigen::Matrix4d::Identity();
    eye_from_world.row(0).head<3>() = right_.transpose();
    eye_from_world.row(1).head<3>() = up_.transpose();
    eye_from_world.row(2).head<3>() = back_.transpose();
    eye_from_world.topRightCorner<3, 1>() = -eye_from_world.topLeftCorner<3, 3>() * eye_;
    const double aspect = static_cast<double>(size_.width) / size_.height;
    Eigen::Matrix4d clip_from_eye = Eigen::Matrix4d::Zero();
    clip_from_eye(0, 0) = zoom_ / aspect;
    clip_from_eye(1, 1) = zoom_;
    clip_from_eye(2, 2) = -(far + near) / (far - near);
    clip_from_eye(2, 3) = -2.0 * far * near / (far - near);
    clip_from_eye(3, 2) = -1.0;
    return clip_from_eye * eye_from_world;
}

VisiblePart visible_part(const View& view, const Triangle& triangle) noexcept
{
    const Vec3 depths(view.depth(triangle[0]), view.depth(triangle[1]), view.depth(triangle[2]));
    VisiblePart part;
    const auto add = [&](const Vec3& weights) { part.weights[part.count++] = weights; };
    for (int i = 0; i < 3; ++i) {
        const int next = (i + 1) % 3;
        const bool here = depths[i] >= view.near();
        if (here) add(Vec3::Unit(i));
        if (here == (depths[next] >= view.near())) continue;
        const double at = (view.near() - depths[i]) / (depths[next] - depths[i]);
        add((1.0 - at) * Vec3::Unit(i) + at * Vec3::Unit(next));
    }
    return part;
}

std::optional<std::array<Vec3, 2>> visible_part(const View& view, const Vec3& from,
                                                const Vec3& to) noexcept
{
    const double depth_from = view.depth(from);
    const double depth_to = view.depth(to);
    if (std::max(depth_from, depth_to) < view.near()) return std::nullopt;
    if (std::min(depth_from, depth_to) >= view.near()) return std::array{from, to};
    const double at = (view.near() - depth_from) / (depth_to - depth_from);
    const Vec3 cut = (1.0 - at) * from + at * to;
    return depth_from < depth_to ? std::array{cut, to} : std::array{from, cut};
}

std::array<Vec3, 8> corners(const Box& box)
{
    std::array<Vec3, 8> corners;
    for (unsigned bits = 0; bits < 8; ++bits) {
        corners[bits] = {(bits & 1U) != 0 ? box.upper.x() : box.lower.x(),
                         (bits & 2U) != 0 ? box.upper.y() : box.lower.y(),
                         (bits & 4U) != 0 ? box.upper.z() : box.lower.z()};
    }
    return corners;
}

OrbitCamera framed(const OrbitCamera& camera, std::span<const Vec3> points, ViewSize size,
                   Framing framing, double margin)
{
    Box box;
    for (const Vec3& point : points) box.extend(point);
    if (box.empty()) return camera;
    const Vec3 middle = box.center();
    OrbitCamera result = camera;
    result.target = middle;
    const View view(result, size);
    // An eye at (x, y, z), z towards it, sees a point (p, q, r) between left and right where
    // |p - x| <= slope (z - r): the largest p + slope r and -p + slope r bound it, and so above and
    // below.
    const double part = (1.0 - 2.0 * margin) / camera.zoom;
    const Vec2 slope(part * size.width / size.height, part);
    Eigen::Array2d most = Eigen::Array2d::Constant(-std::numeric_limits<double>::infinity());
    Eigen::Array2d least = most;
    double nearest = -std::numeric_limits<double>::infinity();
    for (const Vec3& point : points) {
        const Vec3 offset = point - middle;
        const Eigen::Array2d across(view.right().dot(offset), view.up().dot(offset));
        const double back = view.back().dot(offset);
        most = most.max(across + slope.array() * back);
        least = least.max(-across + slope.array() * back);
        nearest = std::max(nearest, back);
    }
    if (framing == Framing::centered) most = least = most.max(least).eval();
    const Eigen::Array2d center = 0.5 * (most - least);
    const double radius = 0.5 * box.extent().norm();
    result.distance =
        std::max({(0.5 * (most + least) / slope.array()).maxCoeff(), nearest + 1e-3 * radius,
                  1e-9 * middle.cwiseAbs().maxCoeff(), 1e-150});
    result.target = middle + center.x() * view.right() + center.y() * view.up();
    return result;
}

OrbitCamera looking(const OrbitCamera& camera, const Vec3& eye, const Vec3& target)
{
    OrbitCamera result = camera;
    result.target = target;
    result.distance = length_of(eye - target);
    const Vec3 back = (eye - target) / result.distance;
    const Vec3 front = front_of(camera.up);
    const Vec3 side = camera.up.cross(front);
    const double above = std::clamp(back.dot(camera.up), -1.0, 1.0);
    result.elevation = std::atan2(above, std::hypot(back.dot(side), back.dot(front)));
    // Straight from above or below the side stays where azimuth 0 has it.
    const bool is_pole = std::abs(above) > 1.0 - 1e-15;
    result.azimuth = is_pole ? 0.0 : std::atan2(back.dot(side), back.dot(front));
    return result;
}

OrbitCamera orbited(const OrbitCamera& camera, const Vec2& drag, ViewSize size)
{
    // From side to side is half a turn.
    const double turn = std::numbers::pi / size.height;
    constexpr double pole = 0.5 * std::numbers::pi;
    OrbitCamera result = camera;
    result.azimuth -= turn * drag.x();
    result.elevation = std::clamp(camera.elevation + turn * drag.y(), -pole, pole);
    return result;
}

OrbitCamera panned(const OrbitCamera& camera, const Vec2& drag, ViewSize size)
{
    const View view(camera, size);
    const double units_per_pixel = camera.distance / (camera.zoom * 0.5 * size.height);
    OrbitCamera result = camera;
    result.target += units_per_pixel * (drag.y() * view.up() - drag.x() * view.right());
    return result;
}

OrbitCamera zoomed(const OrbitCamera& camera, double steps)
{
    constexpr double per_step = 0.88;
    OrbitCamera result = camera;
    result.distance = std::max(camera.distance * std::pow(per_step, steps), 1e-12);
    return result;
}

} // namespace proxima
