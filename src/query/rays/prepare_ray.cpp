#include "query/rays/prepare_ray.h"

#include "geometry/expansion.h"
#include "geometry/ray_triangle-inl.h"
#include "index/index_parts.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

namespace proxima {

namespace {

constexpr double too_far = 0x1p80;
constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr std::uint64_t sign_bit = 0x8000000000000000U;

using Three = std::array<double, 3>;

/// The origin in the index's units, moved along the ray by both shifts: to within little more than
/// its own rounding, however far that is.
double moved_origin(double origin, double center, double scale, double direction, double shift,
                    double shift_more) noexcept
{
    const auto split = detail::split(direction);
    const auto about = detail::two_sum(origin, -center);
    const auto moved = detail::two_product(shift, direction, split);
    const auto near = detail::two_sum(about.rounded * scale, moved.rounded);
    const auto moved_more = detail::two_product(shift_more, direction, split);
    const auto sum = detail::two_sum(near.rounded, moved_more.rounded);
    return sum.rounded +
           (sum.error + (near.error + (about.error * scale + (moved.error + moved_more.error))));
}

double largest(const Three& p) noexcept
{
    return std::max({std::abs(p[0]), std::abs(p[1]), std::abs(p[2])});
}

/// Where a point on its way in this direction is nearest to zero, to within 2^-50 of its distance.
double nearest_to_zero(const Three& p, const Three& direction) noexcept
{
    double along = 0;
    double square = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        along -= p[axis] * direction[axis];
        square += direction[axis] * direction[axis];
    }
    return along / square;
}

} // namespace

RayStart prepare_ray(const IndexParts& index, const Ray& ray, Faces faces,
                     RayTraversal& open) noexcept
{
    if (!is_valid(ray)) return RayStart::invalid;
    if (index.triangle_count() == 0) return RayStart::misses;
    open.shear = RayShear(ray.direction);
    const auto [x, y, z] = std::array{open.shear.x, open.shear.y, open.shear.z};
    const RayUnit unit(index, std::abs(ray.direction.data()[z]));
    if (!unit.is_ordinary()) return RayStart::too_far;
    Three origin;
    Three direction;
    Three inverse; // infinite where a component is zero
    for (std::size_t axis = 0; axis < 3; ++axis) {
        origin[axis] = (ray.origin.data()[axis] - index.center().data()[axis]) * index.scale();
        direction[axis] = ray.direction.data()[axis] * unit.scale;
        inverse[axis] = 1 / direction[axis];
    }
    const double distance = largest(origin);
    if (!(distance < too_far)) return RayStart::too_far;
    const auto move_both = [&](double shift, double shift_more) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            origin[axis] = moved_origin(ray.origin.data()[axis], index.center().data()[axis],
                                        index.scale(), direction[axis], shift, shift_more);
        }
    };
    // From far away in two steps, as t of the root's box is too coarse there.
    const bool is_far = distance > RayTraversal::far;
    const double first_shift = is_far ? nearest_to_zero(origin, direction) : 0;
    if (is_far) {
        move_both(first_shift, 0);
        if (largest(origin) > 0x1p-48 * distance + RayTraversal::far) return RayStart::misses;
    }
    const RootBox& box = index.root_box();
    double enters = -infinity;
    double leaves = infinity;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        // Infinite where the ray stays between the two planes, or never gets there.
        const double one = (box.lower[axis] - origin[axis]) * inverse[axis];
        const double other = (box.upper[axis] - origin[axis]) * inverse[axis];
        enters = std::max(enters, std::min(one, other));
        leaves = std::min(leaves, std::max(one, other));
    }
    RayTraversal::Range range;
    range.rate = unit.rate;
    range.t_off = 0x1p-50 * distance;
    if (!range.clip(ray.t_min * unit.rate - first_shift, ray.t_max * unit.rate - first_shift,
                    enters, leaves))
        return RayStart::misses;
    if (is_far) {
        move_both(first_shift, range.shift);
        range.move_by(first_shift);
    } else {
        range.moved = range.t_off;
        for (std::size_t axis = 0; axis < 3; ++axis) origin[axis] += range.shift * direction[axis];
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
        open.inverse[axis].fill(own);
        open.start[axis].fill(start);
        open.octant |= static_cast<std::uint32_t>(sign >> (63 - axis));
    }
    open.axes = {x, y, z};
    open.origin = {floats[x], floats[y], floats[z]};
    open.slope_x = static_cast<float>(open.shear.slope_x);
    open.slope_y = static_cast<float>(open.shear.slope_y);
    open.inverse_z = open.inverse[z].lanes[0];
    open.set_range(index, ray, faces, range);
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
