#include "geometry/ray_triangle.h"

#include "geometry/exact_predicates.h"
#include "geometry/ray_triangle-inl.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

namespace proxima {
namespace {

using detail::inner_point;
using detail::is_wanted;
using detail::Meeting;
using detail::Three;
using detail::within_range;

/// Parameters of the corners along the ray, measured on the direction's largest component. They are
/// clamped so that differences stay finite for tiny directions.
Three corner_depths(const Ray& ray, const Triangle& triangle) noexcept
{
    int axis = 0;
    ray.direction.cwiseAbs().maxCoeff(&axis);
    Three depths;
    for (std::size_t i = 0; i < 3; ++i) {
        const double depth = (triangle.vertices[i][axis] - ray.origin[axis]) / ray.direction[axis];
        depths[i] = std::clamp(depth, -farthest_hit, farthest_hit) + 0.0; // no negative zero
    }
    return depths;
}

Meeting corner_point(std::size_t corner, const Three& depths) noexcept
{
    Meeting at;
    at.t = depths[corner];
    at.weights[corner] = 1;
    return at;
}

/// The decisions that rounding could change, and the cases in which a sign is zero.
class ExactMeeting {
public:
    ExactMeeting(const Ray& ray, const Triangle& triangle) noexcept
        : ray_(ray), triangle_(triangle), depths_(corner_depths(ray, triangle))
    {}

    [[nodiscard]] std::optional<RayTriangleHit> find(Faces faces) const noexcept
    {
        Weights weights;
        int seen = 0; // bit 0: a positive sign, bit 1: a negative one
        for (std::size_t i = 0; i < 3; ++i) {
            weights[i] = weight((i + 1) % 3, (i + 2) % 3);
            const double mantissa = weights[i].mantissa;
            seen |= (mantissa > 0 ? 1 : 0) | (mantissa < 0 ? 2 : 0);
        }
        if (seen == 3) return std::nullopt;
        if (seen == 0) return faces == Faces::both ? find_in_plane() : std::nullopt;
        const double facing = seen == 1 ? 1.0 : -1.0;
        if (!is_wanted(facing, faces)) return std::nullopt;
        Meeting at = point_of(weights);
        if (std::abs(at.t) <= detail::doubt_of(depths_))
            at = detail::sign_start(ray_, triangle_, facing, at);
        return within_range(ray_, at);
    }

private:
    using Weights = std::array<ScaledNumber, 3>;

    /// Where the line meets the triangle's plane. \pre not all weights are zero
    [[nodiscard]] Meeting point_of(const Weights& weights) const noexcept
    {
        const auto zeros = std::ranges::count(weights, 0.0, &ScaledNumber::mantissa);
        if (zeros == 0) return inner_point(in_common_units(weights), depths_);
        std::size_t i = 0; // the corner, or the one opposite the edge
        while ((weights[i].mantissa == 0) == (zeros == 2)) ++i;
        if (zeros == 2) return corner_point(i, depths_);
        const std::size_t a = (i + 1) % 3;
        const std::size_t b = (i + 2) % 3;
        return edge_point(a, b, side_axis(a, b));
    }

    [[nodiscard]] Displacement direction() const noexcept { return {Vec3::Zero(), ray_.direction}; }
    [[nodiscard]] Displacement to_corner(std::size_t corner) const noexcept
    {
        return {ray_.origin, triangle_.vertices[corner]};
    }
    [[nodiscard]] ScaledNumber weight(std::size_t a, std::size_t b) const noexcept
    {
        return exact_determinant(direction(), to_corner(a), to_corner(b));
    }
    [[nodiscard]] int side(std::size_t corner, int axis) const noexcept
    {
        return cross_component_sign(direction(), to_corner(corner), axis);
    }

    /// An axis along which direction x (corner - origin) is not zero for one of the two corners, so
    /// that it tells sides of the ray in its plane; -1 where both are on the ray's line. The choice
    /// depends on the two points alone, not on their order.
    [[nodiscard]] int side_axis(std::size_t a, std::size_t b) const noexcept
    {
        for (int axis = 0; axis < 3; ++axis)
            if (side(a, axis) != 0 || side(b, axis) != 0) return axis;
        return -1;
    }

    /// From the line, in its plane, with a sign, up to a factor that all corners share.
    [[nodiscard]] ScaledNumber distance(std::size_t corner, int axis) const noexcept
    {
        return exact_determinant(direction(), to_corner(corner), {Vec3::Zero(), Vec3::Unit(axis)});
    }

    /// Where an edge crosses the line. The same bits whichever corner comes first.
    /// \pre the corners lie in a plane with the line, not both on it, nor both on one side
    [[nodiscard]] Meeting edge_point(std::size_t a, std::size_t b, int axis) const noexcept
    {
        const Vec3& p = triangle_.vertices[a];
        const Vec3& q = triangle_.vertices[b];
        if (std::lexicographical_compare(q.data(), q.data() + 3, p.data(), p.data() + 3))
            std::swap(a, b);
        const auto [from_a, from_b] = in_common_units<2>({distance(a, axis), distance(b, axis)});
        const double share = std::abs(from_a) / (std::abs(from_a) + std::abs(from_b));
        Meeting at;
        at.weights[a] = 1 - share;
        at.weights[b] = share;
        const auto [least, most] = std::minmax(depths_[a], depths_[b]);
        at.t = std::clamp(depths_[a] + share * (depths_[b] - depths_[a]), least, most);
        return at;
    }

    /// Whether the ray begins on the line through two corners.
    [[nodiscard]] bool begins_on_edge(std::size_t a, std::size_t b) const noexcept
    {
        const Displacement along = {triangle_.vertices[a], triangle_.vertices[b]};
        const Displacement back = {triangle_.vertices[a], ray_.origin};
        for (int axis = 0; axis < 3; ++axis)
            if (cross_component_sign(along, back, axis) != 0) return false;
        return true;
    }

    /// The ray's line and the triangle lie in one plane: they share an interval or nothing.
    [[nodiscard]] std::optional<RayTriangleHit> find_in_plane() const noexcept
    {
        int axis = side_axis(0, 1);
        if (axis < 0) axis = side_axis(2, 2);
        std::array<int, 3> sides = {};
        if (axis >= 0)
            for (std::size_t i = 0; i < 3; ++i) sides[i] = side(i, axis);
        std::array<Meeting, 6> met;
        std::size_t count = 0;
        for (std::size_t i = 0; i < 3; ++i) {
            const std::size_t next = (i + 1) % 3;
            if (sides[i] == 0) met[count++] = corner_point(i, depths_);
            if (sides[i] * sides[next] < 0) {
                met[count] = edge_point(i, next, axis);
                if (begins_on_edge(i, next)) met[count].t = 0;
                ++count;
            }
        }
        if (count == 0) return std::nullopt;
        const auto by_t = [](const Meeting& one, const Meeting& other) { return one.t < other.t; };
        const auto [first, last] = std::minmax_element(met.begin(), met.begin() + count, by_t);
        if (first->t >= ray_.t_min || last->t < ray_.t_min) return within_range(ray_, *first);
        // The ray begins inside the interval.
        const double share = (ray_.t_min - first->t) / (last->t - first->t);
        Meeting start;
        start.t = ray_.t_min;
        for (std::size_t i = 0; i < 3; ++i)
            start.weights[i] = (1 - share) * first->weights[i] + share * last->weights[i];
        return within_range(ray_, start);
    }

    const Ray& ray_;
    const Triangle& triangle_;
    Three depths_;
};

} // namespace

Meeting detail::sign_start(const Ray& ray, const Triangle& triangle, double facing,
                           Meeting at) noexcept
{
    constexpr double least = std::numeric_limits<double>::denorm_min();
    // The ray goes towards the plane where it begins on the side that it does not face.
    const int side = orient3d(triangle[0], triangle[1], triangle[2], ray.origin);
    const int sign = facing > 0 ? -side : side;
    at.t = sign == 0 ? 0.0 : sign > 0 ? std::max(at.t, least) : std::min(at.t, -least);
    return at;
}

std::optional<RayTriangleHit> detail::intersect_exactly(const Ray& ray, const Triangle& triangle,
                                                        Faces faces) noexcept
{
    return ExactMeeting(ray, triangle).find(faces);
}

std::optional<RayTriangleHit> intersect(const Ray& ray, const Triangle& triangle,
                                        Faces faces) noexcept
{
    return intersect(ray, RayShear(ray.direction), triangle, faces);
}

} // namespace proxima
