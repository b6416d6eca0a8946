// The quick part of intersect() (ray_triangle.h), for callers that ask many triangles about one
// ray. For sources of this library alone: its bits are those of sources without contraction to
// fused multiply-adds.
#pragma once

#include "geometry/ray_triangle.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

namespace proxima {

namespace detail {

using Three = std::array<double, 3>;

/// One point of the triangle on the ray's line: barycentric weights, sum 1.
struct Meeting {
    double t = 0;
    Three weights = {};
};

[[nodiscard]] inline bool is_wanted(double determinant, Faces faces) noexcept
{
    // The sum of the weights is direction . normal: negative where the front is seen.
    return faces == Faces::both || (faces == Faces::front) == (determinant < 0);
}

[[nodiscard]] inline std::optional<RayTriangleHit> within_range(const Ray& ray,
                                                                const Meeting& at) noexcept
{
    if (!(ray.t_min <= at.t && at.t <= ray.t_max)) return std::nullopt;
    return RayTriangleHit{at.t, at.weights[1], at.weights[2]};
}

/// The point with weights of one sign, none of them all.
[[nodiscard]] inline Meeting inner_point(const Three& weights, const Three& depths) noexcept
{
    const double sum = weights[0] + weights[1] + weights[2];
    Meeting at;
    for (std::size_t i = 0; i < 3; ++i) at.weights[i] = weights[i] / sum;
    const double t =
        at.weights[0] * depths[0] + at.weights[1] * depths[1] + at.weights[2] * depths[2];
    const double least = std::min(std::min(depths[0], depths[1]), depths[2]);
    const double most = std::max(std::max(depths[0], depths[1]), depths[2]);
    at.t = std::clamp(t, least, most);
    return at;
}

// Bounds of the quick test, which looks along the ray: with d_k the largest component of the
// direction, S = d_i / d_k, corners become x = A_i - S_x A_k and y, A about the origin. Let M be
// the largest component of all A, R the largest of all x and y, u = 2^-53. Rounding A, S (twice),
// their product and the difference leaves x off by at most 7 u M, a weight x_1 y_2 - y_1 x_2 by
// less than 28 u M R + 98 u^2 M^2 + 4 u R^2 < 2^-47 M (R + 2^-51 M), as R <= 2 M (1 + 7 u). Where
// that is at least 2^-900, what products lost by underflow is within its slack. It is at least 2^-48
// R^2, all but: where it is at most 2^970, no weight exceeds 2^1020 and their sum does not overflow.
// Infinity compares as unsure.
inline constexpr double error_factor = 0x1p-47;
inline constexpr double own_error = 0x1p-51;
inline constexpr double safe_error = 0x1p-900;
inline constexpr double greatest_error = 0x1p970;
// Weights whose sum is at least so many errors are good to 2^-24 of it, and so is t, over the
// triangle's extent, at worst. Less is for triangles seen all but edge-on, or from far away.
inline constexpr double sure_sum = 0x1p24;

// An error of 2^-24 of the sum in each weight moves a share s by (1 + 3 s) 2^-24 at most. Shares sum
// to 1, so t is good to 6 * 2^-24 < 2^-21 of the largest depth. A smaller one may be zero, or have
// the wrong sign.
inline constexpr double start_doubt = 0x1p-21;

[[nodiscard]] inline double doubt_of(const Three& depths) noexcept
{
    return start_doubt *
           std::max(std::max(std::abs(depths[0]), std::abs(depths[1])), std::abs(depths[2]));
}

/// Gives a t that is all but zero the sign that it has, 0 where the ray begins in the triangle's
/// plane. `facing` has the sign of direction . normal. \pre not zero
[[nodiscard]] Meeting sign_start(const Ray& ray, const Triangle& triangle, double facing,
                                 Meeting at) noexcept;

/// The decisions that rounding could change, and the cases in which a sign is zero.
[[nodiscard]] std::optional<RayTriangleHit>
intersect_exactly(const Ray& ray, const Triangle& triangle, Faces faces) noexcept;

} // namespace detail

/// The same as intersect() of ray_triangle.h. \pre the shear is of the ray's direction
[[nodiscard]] inline std::optional<RayTriangleHit>
intersect(const Ray& ray, const RayShear& shear, const Triangle& triangle, Faces faces) noexcept
{
    const double* const origin = ray.origin.data();
    detail::Three x;
    detail::Three y;
    detail::Three depths;
    double size = 0;
    double reach = 0;
    for (std::size_t corner = 0; corner < 3; ++corner) {
        const double* const vertex = triangle.vertices[corner].data();
        const double about_x = vertex[shear.x] - origin[shear.x];
        const double about_y = vertex[shear.y] - origin[shear.y];
        const double about_z = vertex[shear.z] - origin[shear.z];
        x[corner] = about_x - shear.slope_x * about_z;
        y[corner] = about_y - shear.slope_y * about_z;
        depths[corner] = about_z * shear.inverse_z;
        size = std::max({size, std::abs(about_x), std::abs(about_y), std::abs(about_z)});
        reach = std::max({reach, std::abs(x[corner]), std::abs(y[corner])});
    }
    const detail::Three weights = {x[1] * y[2] - y[1] * x[2], x[2] * y[0] - y[2] * x[0],
                                   x[0] * y[1] - y[0] * x[1]};
    const double error = detail::error_factor * size * (reach + detail::own_error * size);
    const double least = std::min(std::min(weights[0], weights[1]), weights[2]);
    const double most = std::max(std::max(weights[0], weights[1]), weights[2]);
    if (error >= detail::safe_error && error <= detail::greatest_error) {
        if (least < -error && most > error) return std::nullopt;
        const double sum = weights[0] + weights[1] + weights[2];
        if ((least > error || most < -error) && std::abs(sum) > detail::sure_sum * error) {
            const double facing = shear.inverse_z > 0 ? sum : -sum;
            if (!detail::is_wanted(facing, faces)) return std::nullopt;
            const detail::Meeting at = detail::inner_point(weights, depths);
            const double doubt = detail::doubt_of(depths);
            if (std::abs(at.t) <= doubt && ray.t_min <= doubt)
                return detail::within_range(ray, detail::sign_start(ray, triangle, facing, at));
            if (std::abs(at.t) <= farthest_hit) return detail::within_range(ray, at);
        }
    }
    return detail::intersect_exactly(ray, triangle, faces);
}

} // namespace proxima
