#include "viewer/camera.h"

#include "proxima/geometry.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace proxima {
namespace {

/// Some axis across `up`: the direction from which azimuth 0 looks.
Vec3 front_of(const Vec3& up)
{
    return std::abs(up.y()) > 0.5 ? Vec3(0, 0, 1) : Vec3(0, -1, 0);
}

} // namespace

View::View(const OrbitCamera& camera, ViewSize size)
    : zoom_(camera.zoom), shift_(camera.shift), size_(size)
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
    return {0.5 * size_.width + half_height * (zoom_ * right_.dot(offset) * nearness + shift_.x()),
            half_height * (1.0 - zoom_ * up_.dot(offset) * nearness - shift_.y()), nearness};
}

Vec3 View::direction(const Vec2& pixel) const noexcept
{
    const double half_height = 0.5 * size_.height;
    const double right = ((pixel.x() - 0.5 * size_.width) / half_height - shift_.x()) / zoom_;
    const double up = (1.0 - pixel.y() / half_height - shift_.y()) / zoom_;
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
    clip_from_eye(0, 2) = -shift_.x() / aspect;
    clip_from_eye(1, 2) = -shift_.y();
    clip_from_eye(2, 2) = -(far + near) / (far - near);
    clip_from_eye(2, 3) = -2.0 * far * near / (far - near);
    clip_from_eye(3, 2) = -1.0;
    return clip_from_eye * eye_from_world;
}

OrbitCamera fitted(const OrbitCamera& camera, std::span<const Vec3> points, ViewSize size,
                   double margin)
{
    Box box;
    for (const Vec3& point : points) box.extend(point);
    if (box.empty()) return camera;
    constexpr double distance_in_radii = 4.0;
    OrbitCamera result = camera;
    result.target = box.center();
    result.distance = distance_in_radii * std::max(0.5 * box.extent().norm(), 1e-12);
    result.zoom = 1.0;
    result.shift = Vec2::Zero();
    const View view(result, size);
    Eigen::AlignedBox2d seen;
    for (const Vec3& point : points) {
        const ScreenPoint at = view.project(point);
        seen.extend(Vec2(at.x, at.y));
    }
    const Vec2 whole(size.width, size.height);
    const double scale =
        ((1.0 - 2.0 * margin) * whole.array() / seen.sizes().array().max(1e-9)).minCoeff();
    result.zoom = scale;
    const Vec2 away = scale * (seen.center() - 0.5 * whole) / (0.5 * size.height);
    result.shift = Vec2(-away.x(), away.y());
    return result;
}

OrbitCamera framed(const OrbitCamera& camera, std::span<const Vec3> points, ViewSize size)
{
    Box box;
    for (const Vec3& point : points) box.extend(point);
    if (box.empty()) return camera;
    constexpr double part = 0.88; // of the picture, from its middle to its side
    const Vec3 slopes(part * size.width / size.height / camera.zoom, part / camera.zoom, 1.0);
    OrbitCamera result = camera;
    result.target = box.center();
    const View view(result, size);
    result.distance = 1e-12;
    for (const Vec3& point : points) {
        const Vec3 offset = point - result.target;
        const double needed = std::max(std::abs(view.right().dot(offset)) / slopes.x(),
                                       std::abs(view.up().dot(offset)) / slopes.y());
        result.distance = std::max(result.distance, view.back().dot(offset) + needed);
    }
    result.shift = Vec2::Zero();
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
