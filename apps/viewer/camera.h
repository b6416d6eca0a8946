// A camera that orbits a point, and where it puts points on the screen.
#pragma once

#include "cli/canvas.h"
#include "proxima/geometry.h"

#include <span>

namespace proxima {

/// Of a picture or a window, in pixels.
struct ViewSize {
    int width = 800;
    int height = 600;
};

/// The eye stands `distance` from the target. Azimuth 0, elevation 0 looks along +y at z up.
struct OrbitCamera {
    Vec3 target = Vec3::Zero();
    double distance = 4.0;
    double azimuth = 0.5;      ///< radians, the eye wanders to the right
    double elevation = 0.35;   ///< radians above the horizon
    Vec3 up = Vec3::UnitZ();   ///< unit axis
    double zoom = 2.0;         ///< half picture heights per unit of the tangent
    Vec2 shift = Vec2::Zero(); ///< of the picture, right and up, in half picture heights
};

/// A camera on pictures of one size: cheap to ask.
class View {
public:
    View(const OrbitCamera& camera, ViewSize size);

    [[nodiscard]] const Vec3& eye() const noexcept { return eye_; }
    [[nodiscard]] const Vec3& right() const noexcept { return right_; }
    [[nodiscard]] const Vec3& up() const noexcept { return up_; }
    [[nodiscard]] const Vec3& back() const noexcept { return back_; } ///< to the eye

    /// Along the view axis from the eye.
    [[nodiscard]] double depth(const Vec3& point) const noexcept { return back_.dot(eye_ - point); }

    /// \pre depth(point) > 0
    [[nodiscard]] ScreenPoint project(const Vec3& point) const noexcept;

    /// Where a pixel's ray from the eye goes, one unit of depth long.
    [[nodiscard]] Vec3 direction(const Vec2& pixel) const noexcept;

    /// Homogeneous OpenGL clip coordinates of points, depths from `near` to `far`.
    [[nodiscard]] Eigen::Matrix4d clip_from_world(double near, double far) const;

private:
    Vec3 eye_;
    Vec3 right_;
    Vec3 up_;
    Vec3 back_;
    double zoom_;
    Vec2 shift_;
    ViewSize size_;
};

/// The camera moved, not turned, so that all points fill the picture but for a margin on each side,
/// as part of the picture. A camera without points stays. \pre margin in [0, 0.5)
[[nodiscard]] OrbitCamera fitted(const OrbitCamera& camera, std::span<const Vec3> points,
                                 ViewSize size, double margin = 0.06);

/// Moved, not turned, so that the middle of the points is the target and all are in the picture but
/// for a margin. A camera without points stays.
[[nodiscard]] OrbitCamera framed(const OrbitCamera& camera, std::span<const Vec3> points,
                                 ViewSize size);

/// As a hand at the mouse moves it; `drag` in pixels, right and down. Never over the pole.
[[nodiscard]] OrbitCamera orbited(const OrbitCamera& camera, const Vec2& drag, ViewSize size);

/// What is as far as the target follows the mouse.
[[nodiscard]] OrbitCamera panned(const OrbitCamera& camera, const Vec2& drag, ViewSize size);

/// Nearer to the target by so many steps of a wheel.
[[nodiscard]] OrbitCamera zoomed(const OrbitCamera& camera, double steps);

} // namespace proxima
