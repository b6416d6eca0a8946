#include "proxima/query/open_ray.h"

#include "proxima/geometry/ray_triangle.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace proxima {

namespace {

constexpr double root_reach = 1.01; // the mesh is within 1, its boxes within 1 + 2^-19
constexpr double too_far = 0x1p40;
constexpr double far = 0x1p26; // moving an origin from nearer costs less than half a float's ulp
constexpr std::uint64_t exponent_bits = 0x7FF0000000000000U;

/// A float below the value, and one above, by little; infinity where that is.
float rounded_down(double value) noexcept
{
    const auto nearest = static_cast<float>(value);
    return nearest - std::min(std::abs(nearest), 0x1p100F) * 0x1p-23F;
}
float rounded_up(double value) noexcept
{
    return -rounded_down(-value);
}

} // namespace

RayStart open_ray(const RayIndex& index, const Ray& ray, Faces faces, OpenRay& open) noexcept
{
    if (index.triangle_count() == 0 || !is_valid(ray)) return RayStart::misses;
    const Vec3 sizes = ray.direction.cwiseAbs();
    const int greater = sizes[1] > sizes[0] ? 1 : 0;
    const int z = sizes[2] > sizes[greater] ? 2 : greater;
    const double largest = sizes[z];
    const std::uint64_t exponent = std::bit_cast<std::uint64_t>(largest) & exponent_bits;
    // 1 / k by the bits of an exponent.
    const auto unscale = std::bit_cast<double>(exponent);
    const auto scale = std::bit_cast<double>(0x7FE0000000000000U - exponent);
    const double rate = index.scale() * unscale;
    if (!(unscale > 0x1p-1000 && unscale < 0x1p1000 && rate > 0x1p-1000 && rate < 0x1p1000))
        return RayStart::too_far;
    Vec3 origin = (ray.origin - index.center()) * index.scale();
    const Vec3 direction = ray.direction * scale;
    const Vec3 inverse = direction.cwiseInverse(); // infinite where a component is zero
    // A component below 2^-40 moves the ray by less than 2^-37 within the root.
    constexpr double most_inverse = 0x1p40;
    open.octant = 0;
    for (int axis = 0; axis < 3; ++axis) {
        const bool negative = direction[axis] < 0;
        const double size = std::min(std::abs(inverse[axis]), most_inverse);
        open.octant |= static_cast<std::uint32_t>(negative) << static_cast<unsigned>(axis);
        open.inverse[static_cast<std::size_t>(axis)] = static_cast<float>(negative ? -size : size);
    }
    for (std::size_t axis = 0; axis < 3; ++axis) {
        constexpr std::uint32_t half = 32; // bytes for lower planes, then as many for upper ones
        const std::uint32_t negative = open.octant >> axis & 1U;
        open.near_planes[axis] = half * (2 * open.octant + negative);
        open.far_planes[axis] = half * (2 * open.octant + 1 - negative);
    }
    const double distance = origin.cwiseAbs().maxCoeff();
    double least = ray.t_min * rate;
    double most = ray.t_max * rate;
    double shift = 0;
    double moved = 0; // how far off the origin is for having been moved
    if (distance > root_reach) {
        if (!(distance < too_far)) return RayStart::too_far;
        for (int axis = 0; axis < 3; ++axis) {
            // Infinite where the ray stays between the two planes, or never gets there.
            const double one = (-root_reach - origin[axis]) * inverse[axis];
            const double other = (root_reach - origin[axis]) * inverse[axis];
            least = std::max(least, std::min(one, other));
            most = std::min(most, std::max(one, other));
        }
        if (!(least <= most)) return RayStart::misses;
        shift = least;
        origin += shift * direction;
        moved = 0x1p-50 * distance;
    }
    for (int axis = 0; axis < 3; ++axis) {
        open.origin[static_cast<std::size_t>(axis)] = static_cast<float>(origin[axis]);
    }
    const int x = (z + 1) % 3;
    const int y = (z + 2) % 3;
    open.axes = {static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(y),
                 static_cast<std::uint32_t>(z)};
    open.slope_x = static_cast<float>(direction[x] * inverse[z]);
    open.slope_y = static_cast<float>(direction[y] * inverse[z]);
    open.inverse_z = open.inverse[static_cast<std::size_t>(z)];
    const auto off = static_cast<float>(moved);
    const float growth = 1 + off / (8 * float_roundoff);
    open.error = growth * growth;
    open.t_error = 40 * float_roundoff + 2 * off;
    open.slack = 0;
    if (distance > far) {
        const auto [a, b, c] = open.inverse;
        open.slack = 4 * off * std::max({std::abs(a), std::abs(b), std::abs(c)});
    }
    open.least = rounded_down(least - shift) - 4 * open.t_error;
    open.most = rounded_up(most - shift) + 4 * open.t_error;
    open.sure_least = rounded_up(ray.t_min * rate - shift) + open.t_error;
    open.sure_most = rounded_down(ray.t_max * rate - shift) - open.t_error;
    // Weights are positive where direction . normal has the sign of the direction's z.
    const bool forward = direction[z] > 0;
    open.refuses_positive =
        (faces == Faces::front && forward) || (faces == Faces::back && !forward);
    open.refuses_negative =
        (faces == Faces::front && !forward) || (faces == Faces::back && forward);
    open.best_least = std::numeric_limits<float>::infinity();
    open.best_row = OpenRay::no_row;
    open.found = false;
    open.ray = &ray;
    open.faces = faces;
    open.rate = rate;
    open.shift = shift;
    open.references[0] = OpenRay::end;
    open.nearness[0] = -std::numeric_limits<float>::infinity();
    open.at = {index.root(), 1};
    return RayStart::ready;
}

namespace {

template <class Scalar>
std::optional<RayHit> ask_triangle(const RayRow<Scalar>& row, const Ray& ray, Faces faces) noexcept
{
    const auto hit = intersect(ray, row.triangle(), faces);
    if (!hit) return std::nullopt;
    return RayHit{hit->t, TriangleId{row.id}, hit->u, hit->v};
}

} // namespace

std::optional<RayHit> ask_row(const RayIndex& index, std::uint32_t row, const Ray& ray,
                              Faces faces) noexcept
{
    return index.double_rows().empty() ? ask_triangle(index.float_rows()[row], ray, faces)
                                       : ask_triangle(index.double_rows()[row], ray, faces);
}

} // namespace proxima
