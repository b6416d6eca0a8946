// Vectors, boxes, triangles, rays and rigid transforms: plain values that queries take and return.
//
// Vectors are Eigen's. All shapes are closed sets. Coordinates are doubles in the mesh's own unit.
#pragma once

#include "proxima/export.h"
#include "proxima/result.h"

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>

namespace PROXIMA_EXPORT proxima {

using Vec2 = Eigen::Vector2d;
using Vec3 = Eigen::Vector3d;
using Mat3 = Eigen::Matrix3d;

/// Axis-aligned box, closed. The default one is empty and grows by extend().
struct Box {
    Vec3 lower = Vec3::Constant(std::numeric_limits<double>::infinity());
    Vec3 upper = Vec3::Constant(-std::numeric_limits<double>::infinity());

    [[nodiscard]] bool empty() const noexcept { return !(lower.array() <= upper.array()).all(); }
    [[nodiscard]] Vec3 center() const noexcept { return 0.5 * lower + 0.5 * upper; }
    [[nodiscard]] Vec3 extent() const noexcept { return upper - lower; }
    void extend(const Vec3& point) noexcept
    {
        lower = lower.cwiseMin(point);
        upper = upper.cwiseMax(point);
    }
    [[nodiscard]] bool contains(const Vec3& point) const noexcept
    {
        return (lower.array() <= point.array()).all() && (point.array() <= upper.array()).all();
    }
};

/// Triangle by its corners; may be degenerate (a segment or a point).
struct Triangle {
    std::array<Vec3, 3> vertices;

    [[nodiscard]] const Vec3& operator[](int corner) const noexcept
    {
        return vertices[static_cast<std::size_t>(corner)];
    }
};

/// The part of a triangle that a point lies on: corner i, the side from corner i to i + 1 mod 3, or
/// the inside.
enum class TrianglePart : std::uint8_t {
    corner_0,
    corner_1,
    corner_2,
    side_0,
    side_1,
    side_2,
    inside
};

/// Tight box of a triangle.
[[nodiscard]] Box bounding_box(const Triangle& triangle) noexcept;

/// (b - a) x (c - a): twice the area long, counter-clockwise outward.
[[nodiscard]] Vec3 scaled_normal(const Triangle& triangle) noexcept;

/// t counts in units of the direction, which may have any length; hits are told apart up to
/// t = 2^1020, 1e307, which directions longer than 1e-300 times the mesh's size keep far from. t_min
/// may be negative and the range without ends: then it is a line.
struct Ray {
    Vec3 origin = Vec3::Zero();
    Vec3 direction = Vec3::UnitZ();
    double t_min = 0;
    double t_max = std::numeric_limits<double>::infinity();

    [[nodiscard]] Vec3 at(double t) const noexcept { return origin + t * direction; }
};

/// Whether it is a ray at all: origin and direction finite, the direction not zero, the range not
/// empty and no end of it NaN. No other ray hits anything.
[[nodiscard]] inline bool is_valid(const Ray& ray) noexcept
{
    return ray.origin.allFinite() && ray.direction.allFinite() &&
           (ray.direction.array() != 0).any() && ray.t_min <= ray.t_max;
}

/// Which sides of triangles a ray meets. The front is the side from which the corners are seen
/// counter-clockwise. Triangles seen edge-on, and those without an area, show neither side: only
/// `both` meets them.
enum class Faces : std::uint8_t { both, front, back };

/// Takes a point p to R p + t. Made from numbers by make_rigid_transform; the default one leaves
/// everything where it is.
struct RigidTransform {
    Mat3 rotation = Mat3::Identity();
    Vec3 translation = Vec3::Zero();

    /// Each component rounded a few times, always in the same way: what is computed on moved
    /// points is exact for these.
    [[nodiscard]] Vec3 operator()(const Vec3& p) const noexcept
    {
        Vec3 moved;
        for (int i = 0; i < 3; ++i) {
            moved[i] = ((rotation(i, 0) * p[0] + rotation(i, 1) * p[1]) + rotation(i, 2) * p[2]) +
                       translation[i];
        }
        return moved;
    }
    [[nodiscard]] Triangle operator()(const Triangle& triangle) const noexcept
    {
        return {{(*this)(triangle[0]), (*this)(triangle[1]), (*this)(triangle[2])}};
    }
    /// Takes moved points back, but for rounding.
    [[nodiscard]] RigidTransform inverse() const noexcept
    {
        return {rotation.transpose(), -(rotation.transpose() * translation)};
    }
};

/// How far R^T R may be from the identity, in the sum of squares' root, where R is taken as it is.
inline constexpr double rigid_tolerance = 1e-9;

/// And where R counts as a rotation whose numbers were rounded, to floats or to four decimals.
inline constexpr double nearly_rigid_tolerance = 1e-3;

/// |R^T R - 1| of the row-major 3 x 4 matrix (R | t).
[[nodiscard]] double rotation_error(std::span<const double, 12> matrix) noexcept;

/// From the row-major 3 x 4 matrix (R | t). Beyond rigid_tolerance the nearest rotation takes the
/// place of R, as polar decomposition gives it. Error invalid_argument where a number is not finite,
/// R scales, stretches or shears (beyond nearly_rigid_tolerance) or mirrors; `where` is left empty.
[[nodiscard]] Result<RigidTransform> make_rigid_transform(std::span<const double, 12> matrix);

/// A displacement known exactly though no double may hold it: from one point to another, or a
/// vector as given, from the origin.
struct Displacement {
    Vec3 from = Vec3::Zero();
    Vec3 to = Vec3::Zero();

    /// Rounded once per component.
    [[nodiscard]] Vec3 rounded() const noexcept { return to - from; }
};

} // namespace proxima
