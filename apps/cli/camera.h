// A camera that orbits a point, and where it puts points on the screen.
#pragma once

#include "cli/canvas.h"
#include "proxima/geometry.h"

#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <optional>
#include <span>

namespace proxima {

/// Of a picture or a window, in pixels.
struct ViewSize {
    int width = 1280;
    int height = 960;
};

/// The zoom of an opening angle from bottom to top, radians.
[[nodiscard]] inline double zoom_of_angle(double angle) noexcept
{
    return 1.0 / std::tan(0.5 * angle);
}

/// The eye stands `distance` from the target, by default in front of it and a little above. Azimuth
/// 0, elevation 0 looks along -z where y is up, along +y where z is.
struct OrbitCamera {
    Vec3 target = Vec3::Zero();
    double distance = 4.0;
    double azimuth = 0.0;                    ///< radians, the eye wanders to the right
    double elevation = std::numbers::pi / 9; ///< radians above the horizon: 20 degrees
    Vec3 up = Vec3::UnitZ();                 ///< of length 1
    double zoom = 3.171595; ///< half picture heights per unit of the tangent: 35 degrees
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

    /// How long a unit across the view is at this depth, in pixels.
    [[nodiscard]] double pixels_at(double depth) const noexcept
    {
        return 0.5 * size_.height * zoom_ / depth;
    }

    /// What is nearer than this depth is not drawn.
    [[nodiscard]] double near() const noexcept { return near_; }

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
    double near_;
    ViewSize size_;
};

/// Whether all of a triangle is as far from the eye as `near`.
[[nodiscard]] inline bool is_in_front(const View& view, const Triangle& triangle) noexcept
{
    return view.depth(triangle[0]) >= view.near() && view.depth(triangle[1]) >= view.near() &&
           view.depth(triangle[2]) >= view.near();
}

/// The part of a triangle that is as far from the eye as `near`: no corner, or three or four in
/// order, by their weights of the triangle's corners.
struct VisiblePart {
    std::array<Vec3, 4> weights;
    std::size_t count = 0;

    [[nodiscard]] Vec3 position(const Triangle& triangle, std::size_t corner) const noexcept
    {
        const Vec3& at = weights[corner];
        return at[0] * triangle[0] + at[1] * triangle[1] + at[2] * triangle[2];
    }
    [[nodiscard]] Color color(const std::array<Color, 3>& colors, std::size_t corner) const noexcept
    {
        const Eigen::Vector3f at = weights[corner].cast<float>();
        return at[0] * colors[0] + at[1] * colors[1] + at[2] * colors[2];
    }
};
[[nodiscard]] VisiblePart visible_part(const View& view, const Triangle& triangle) noexcept;

/// The same of a segment.
[[nodiscard]] std::optional<std::array<Vec3, 2>> visible_part(const View& view, const Vec3& from,
                                                              const Vec3& to) noexcept;

/// The corners of a box; bits of their numbers: x, y, z.
[[nodiscard]] std::array<Vec3, 8> corners(const Box& box);

/// What of the points is in the middle of a picture.
enum class Framing : std::uint8_t {
    filled,  ///< the middle of their picture
    centered ///< the middle of their box
};

/// The camera moved, not turned, so that all points fill the picture but for a margin on each side,
/// as part of the picture; the target is as deep as their middle. A camera without points stays.
/// \pre margin in [0, 0.5)
[[nodiscard]] OrbitCamera framed(const OrbitCamera& camera, std::span<const Vec3> points,
                                 ViewSize size, Framing framing = Framing::filled,
                                 double margin = 0.06);

/// The camera at an eye that looks at a target, with its up axis and zoom. \pre they differ
[[nodiscard]] OrbitCamera looking(const OrbitCamera& camera, const Vec3& eye, const Vec3& target);

/// As a hand at the mouse moves it; `drag` in pixels, right and down. Never over the pole.
[[nodiscard]] OrbitCamera orbited(const OrbitCamera& camera, const Vec2& drag, ViewSize size);

/// What is as far as the target follows the mouse.
[[nodiscard]] OrbitCamera panned(const OrbitCamera& camera, const Vec2& drag, ViewSize size);

/// Nearer to the target by so many steps of a wheel.
[[nodiscard]] OrbitCamera zoomed(const OrbitCamera& camera, double steps);

} // namespace proxima
