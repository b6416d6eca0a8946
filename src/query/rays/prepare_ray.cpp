#include "query/rays/prepare_ray.h"

#include "geometry/expansion.h"
#include "geometry/ray_triangle-inl.h"
#include "index/index_parts.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace proxima {

namespace {

constexpr double too_far = 0x1p40;
constexpr std::uint64_t sign_bit = 0x8000000000000000U;

using Three = std::array<double, 3>;

/// The origin in the index's units, moved along the ray: to within little more than its own
/// rounding, however far that is.
double moved_origin(double origin, double center, double scale, double shift,
                    double direction) noexcept
{
    const auto about = detail::two_sum(origin, -center);
    const auto moved = detail::two_product(shift, direction, detail::split(direction));
    const auto sum = detail::two_sum(about.rounded * scale, moved.rounded);
    return sum.rounded + (sum.error + (about.error * scale + moved.error));
}

} // namespace

RayStart prepare_ray(const IndexParts& index, const Ray& ray, Faces faces,
                     RayTraversal& open) noexcept
{
    if (index.triangle_count() == 0 || !is_valid(ray)) return RayStart::misses;
    open.shear = RayShear(ray.direction);
    const auto [x, y, z] = std::array{open.shear.x, open.shear.y, open.shear.z};
    const RayUnit unit(index, std::abs(ray.direction.data()[z]));
    if (!unit.is_ordinary()) return RayStart::too_far;
    Three origin;
    Three direction;
    Three inverse; // infinite where a component is zero
    double distance = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const double center = index.center().data()[axis];
        origin[axis] = (ray.origin.data()[axis] - center) * index.scale();
        direction[axis] = ray.direction.data()[axis] * unit.scale;
        inverse[axis] = 1 / direction[axis];
        distance = std::max(distance, std::abs(origin[axis]));
    }
    double least = ray.t_min * unit.rate;
    double most = ray.t_max * unit.rate;
    double shift = 0;
    double moved = 0; // how far off the origin is for having been moved
    double t_off = 0; // and t
    if (distance > RayTraversal::root_reach) {
        if (!(distance < too_far)) return RayStart::too_far;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            // Infinite where the ray stays between the two planes, or never gets there.
            const double one = (-RayTraversal::root_reach - origin[axis]) * inverse[axis];
            const double other = (RayTraversal::root_reach - origin[axis]) * inverse[axis];
            least = std::max(least, std::min(one, other));
            most = std::min(most, std::max(one, other));
        }
        if (!(least <= most)) return RayStart::misses;
        shift = least;
        t_off = 0x1p-50 * distance;
        if (distance > RayTraversal::far) {
            for (std::size_t axis = 0; axis < 3; ++axis) {
                origin[axis] = moved_origin(ray.origin.data()[axis], index.center().data()[axis],
                                            index.scale(), shift, direction[axis]);
            }
        } else {
            for (std::size_t axis = 0; axis < 3; ++axis) origin[axis] += shift * direction[axis];
            moved = t_off;
        }
    }
    std::array<float, 3> floats;
    open.octant = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::uint64_t sign = std::bit_cast<std::uint64_t>(direction[axis]) & sign_bit;
        const double size = std::min(std::abs(inverse[axis]), RayTraversal::most_inverse);
        const auto own =
            static_cast<float>(std::bit_cast<double>(std::bit_cast<std::uint64_t>(size) | sign));
        floats[axis] = static_cast<float>(origin[axis]);
        const float start = -floats[axis] * own;
        open.inverse[axis] = {own, own, own, own};
        open.start[axis] = {start, start, start, start};
        open.octant |= static_cast<std::uint32_t>(sign >> (63 - axis));
    }
    open.axes = {x, y, z};
    open.origin = {floats[x], floats[y], floats[z]};
    open.slope_x = static_cast<float>(open.shear.slope_x);
    open.slope_y = static_cast<float>(open.shear.slope_y);
    open.inverse_z = open.inverse[z][0];
    open.set_range(index, ray, faces, {unit.rate, least, most, shift, moved, t_off});
    return RayStart::ready;
}

namespace {

bool ask(const Ray& ray, const RayShear& shear, const Triangle& triangle, TriangleId id,
         Faces faces, RayHit& hit) noexcept
{
    const auto met = intersect(ray, shear, triangle, faces);
    if (!met) return false;
    hit.t = met->t;
    hit.triangle = id;
    hit.u = met->u;
    hit.v = met->v;
    return true;
}

bool ask_row(const IndexParts& index, std::uint32_t row, const Ray& ray, const RayShear& shear,
             Faces faces, RayHit& hit) noexcept
{
    const TriangleId id = index.ids()[row];
    return ask(ray, shear, index.triangle(row), id, faces, hit);
}

} // namespace

bool intersect_exact(const IndexParts& index, RayTriangle triangle, const SearchedRay& searched,
                     RayHit& hit) noexcept
{
    const IndexLeaf& leaf = index.blocks()[triangle.leaf].leaf;
    const std::uint32_t row = leaf.first_row + triangle.lane;
    if (!index.has_exact_leaves())
        return ask_row(index, row, *searched.ray, searched.shear, searched.faces, hit);
    Triangle corners;
    const double unscale = index.unscale();
    for (std::size_t i = 0; i < 3; ++i) {
        const std::size_t vertex = leaf.corners[i][triangle.lane];
        for (std::size_t axis = 0; axis < 3; ++axis) {
            corners.vertices[i].data()[axis] =
                static_cast<double>(leaf.coordinates[axis][vertex]) * unscale +
                index.center().data()[axis];
        }
    }
    return ask(*searched.ray, searched.shear, corners, index.ids()[row], searched.faces, hit);
}

std::optional<RayHit> ask_row(const IndexParts& index, std::uint32_t row, const Ray& ray,
                              Faces faces) noexcept
{
    RayHit hit;
    if (!ask_row(index, row, ray, RayShear(ray.direction), faces, hit)) return std::nullopt;
    return hit;
}

} // namespace proxima
