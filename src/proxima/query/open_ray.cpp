#include "proxima/query/open_ray.h"

#include "proxima/geometry/expansion.h"
#include "proxima/geometry/ray_triangle.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace proxima {

namespace {

constexpr double root_reach = 1.01; // the mesh is within 1, its boxes within 1 + 2^-19
constexpr double too_far = 0x1p40;
constexpr double far = 0x1p26; // moving an origin from nearer costs at most a float's half ulp
constexpr std::uint64_t exponent_bits = 0x7FF0000000000000U;
constexpr std::uint64_t sign_bit = 0x8000000000000000U;

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

using Three = std::array<double, 3>;

/// The origin in the index's units, moved along the ray: to within little more than its own
/// rounding, however far that is.
double moved_origin(double origin, double center, double scale, double shift,
                    double direction) noexcept
{
    const auto about = detail::two_sum(origin, -center);
    const auto way = detail::two_product(shift, direction, detail::split(direction));
    const auto sum = detail::two_sum(about.rounded * scale, way.rounded);
    return sum.rounded + (sum.error + (about.error * scale + way.error));
}

} // namespace

RayStart open_ray(const RayIndex& index, const Ray& ray, Faces faces, OpenRay& open) noexcept
{
    if (index.triangle_count() == 0 || !is_valid(ray)) return RayStart::misses;
    open.shear = RayShear(ray.direction);
    const auto [x, y, z] = std::array{open.shear.x, open.shear.y, open.shear.z};
    const double largest = std::abs(ray.direction.data()[z]);
    const std::uint64_t exponent = std::bit_cast<std::uint64_t>(largest) & exponent_bits;
    // 1 / k by the bits of an exponent.
    const auto unscale = std::bit_cast<double>(exponent);
    const auto scale = std::bit_cast<double>(0x7FE0000000000000U - exponent);
    const double rate = index.scale() * unscale;
    if (!(unscale > 0x1p-1000 && unscale < 0x1p1000 && rate > 0x1p-1000 && rate < 0x1p1000))
        return RayStart::too_far;
    Three origin;
    Three direction;
    Three inverse; // infinite where a component is zero
    double distance = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const double center = index.center().data()[axis];
        origin[axis] = (ray.origin.data()[axis] - center) * index.scale();
        direction[axis] = ray.direction.data()[axis] * scale;
        inverse[axis] = 1 / direction[axis];
        distance = std::max(distance, std::abs(origin[axis]));
    }
    double least = ray.t_min * rate;
    double most = ray.t_max * rate;
    double shift = 0;
    double moved = 0; // how far off the origin is for having been moved
    double t_off = 0; // and t
    if (distance > root_reach) {
        if (!(distance < too_far)) return RayStart::too_far;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            // Infinite where the ray stays between the two planes, or never gets there.
            const double one = (-root_reach - origin[axis]) * inverse[axis];
            const double other = (root_reach - origin[axis]) * inverse[axis];
            least = std::max(least, std::min(one, other));
            most = std::min(most, std::max(one, other));
        }
        if (!(least <= most)) return RayStart::misses;
        shift = least;
        t_off = 0x1p-50 * distance;
        if (distance > far) {
            for (std::size_t axis = 0; axis < 3; ++axis)
                origin[axis] = moved_origin(ray.origin.data()[axis], index.center().data()[axis],
                                            index.scale(), shift, direction[axis]);
        } else {
            for (std::size_t axis = 0; axis < 3; ++axis) origin[axis] += shift * direction[axis];
            moved = t_off;
        }
    }
    std::array<float, 3> places;
    open.octant = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        // A component below 2^-40 moves the ray by less than 2^-37 within the root.
        constexpr double most_inverse = 0x1p40;
        const std::uint64_t sign = std::bit_cast<std::uint64_t>(direction[axis]) & sign_bit;
        const double size = std::min(std::abs(inverse[axis]), most_inverse);
        const auto own =
            static_cast<float>(std::bit_cast<double>(std::bit_cast<std::uint64_t>(size) | sign));
        places[axis] = static_cast<float>(origin[axis]);
        const float start = -places[axis] * own;
        open.inverse[axis] = {own, own, own, own};
        open.start[axis] = {start, start, start, start};
        open.octant |= static_cast<std::uint32_t>(sign >> (63 - axis));
    }
    open.axes = {x, y, z};
    open.origin = {places[x], places[y], places[z]};
    open.slope_x = static_cast<float>(open.shear.slope_x);
    open.slope_y = static_cast<float>(open.shear.slope_y);
    open.inverse_z = open.inverse[z][0];
    const float growth = 1 + static_cast<float>(moved) / (8 * float_roundoff);
    open.error = growth * growth;
    open.t_error = 40 * float_roundoff + 2 * static_cast<float>(t_off);
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
    open.found = false;
    open.best_least = std::numeric_limits<float>::infinity();
    open.best_noted = {OpenRay::no_leaf, 0};
    open.ray = &ray;
    open.faces = faces;
    open.rate = rate;
    open.shift = shift;
    for (std::size_t i = 0; i < OpenRay::bottom; ++i) {
        open.references[i] = OpenRay::end;
        open.nearness[i] = -std::numeric_limits<float>::infinity();
    }
    open.at = {index.root(), OpenRay::bottom};
    return RayStart::ready;
}

namespace {

std::optional<RayHit> named(const std::optional<RayTriangleHit>& hit, TriangleId id) noexcept
{
    if (!hit) return std::nullopt;
    return RayHit{hit->t, id, hit->u, hit->v};
}

template <class Scalar>
std::optional<RayHit> ask(const RayRow<Scalar>& row, const Ray& ray, const RayShear& shear,
                          Faces faces) noexcept
{
    return named(intersect(ray, shear, row.triangle(), faces), TriangleId{row.id});
}

std::optional<RayHit> ask_row(const RayIndex& index, std::uint32_t row, const Ray& ray,
                              const RayShear& shear, Faces faces) noexcept
{
    return index.double_rows().empty() ? ask(index.float_rows()[row], ray, shear, faces)
                                       : ask(index.double_rows()[row], ray, shear, faces);
}

} // namespace

std::optional<RayHit> ask_triangle(const RayIndex& index, RayTriangle triangle,
                                   const OpenRay& open) noexcept
{
    const RayLeaf& leaf = index.blocks()[triangle.leaf].leaf;
    const std::uint32_t row = leaf.first_row + triangle.lane;
    if (!index.has_exact_leaves()) return ask_row(index, row, *open.ray, open.shear, open.faces);
    Triangle corners;
    const double unscale = 1 / index.scale();
    for (std::size_t i = 0; i < 3; ++i) {
        const std::size_t vertex = leaf.corners[i][triangle.lane];
        for (std::size_t axis = 0; axis < 3; ++axis) {
            corners.vertices[i].data()[axis] =
                static_cast<double>(leaf.coordinates[axis][vertex]) * unscale +
                index.center().data()[axis];
        }
    }
    return named(intersect(*open.ray, open.shear, corners, open.faces), index.ids()[row]);
}

std::optional<RayHit> ask_row(const RayIndex& index, std::uint32_t row, const Ray& ray,
                              Faces faces) noexcept
{
    return ask_row(index, row, ray, RayShear(ray.direction), faces);
}

} // namespace proxima
