#include "geometry/ray_triangle.h"

#include "geometry/exact_predicates.h"
#include "geometry/expansion.h"
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

/// Points and directions for sums whose size matters as well as their sign. Where expansions cannot
/// hold them they are in units of the largest coordinate, and coordinates that are negligible
/// beside it are dropped.
struct Conditioned {
    Ray ray;
    Triangle triangle;
    bool is_exact = true; ///< nothing was left out

    Conditioned(Ray given, Triangle corners) noexcept
        : ray(std::move(given)), triangle(std::move(corners))
    {
        condition(std::array<Vec3*, 4>{&ray.origin, &triangle.vertices[0], &triangle.vertices[1],
                                       &triangle.vertices[2]});
        condition(std::array<Vec3*, 1>{&ray.direction});
    }

private:
    template <std::size_t Count>
    void condition(const std::array<Vec3*, Count>& vectors) noexcept
    {
        double largest = 0;
        bool fits = true;
        for (const Vec3* vector : vectors) {
            for (const double value : *vector) {
                largest = std::max(largest, std::abs(value));
                fits = fits && detail::fits_expansion(value);
            }
        }
        if (fits) return;
        const int exponent = std::ilogb(largest);
        for (Vec3* vector : vectors) {
            for (double& value : *vector) {
                const double scaled = std::scalbn(value, -exponent);
                const bool fades = value != 0 && !(std::abs(scaled) >= detail::min_expansion_input);
                is_exact = is_exact && !fades;
                value = fades ? 0 : scaled;
            }
        }
    }
};

/// The decisions that rounding could change, and the cases in which a sign is zero.
class ExactMeeting {
public:
    ExactMeeting(const Ray& ray, const Triangle& triangle) noexcept
        : ray_(ray), triangle_(triangle), depths_(corner_depths(ray, triangle)),
          conditioned_(ray, triangle)
    {}

    [[nodiscard]] std::optional<RayTriangleHit> find(Faces faces) const noexcept
    {
        Three weights;
        int seen = 0; // bit 0: a positive sign, bit 1: a negative one
        std::size_t zeros = 0;
        for (std::size_t i = 0; i < 3; ++i) {
            weights[i] = weight((i + 1) % 3, (i + 2) % 3);
            if (weights[i] == 0) ++zeros;
            seen |= (weights[i] > 0 ? 1 : 0) | (weights[i] < 0 ? 2 : 0);
        }
        if (seen == 3) return std::nullopt;
        if (seen == 0) return faces == Faces::both ? find_in_plane() : std::nullopt;
        const double facing = seen == 1 ? 1.0 : -1.0;
        if (!is_wanted(facing, faces)) return std::nullopt;
        Meeting at = point_of(weights, zeros);
        if (std::abs(at.t) <= detail::doubt_of(depths_))
            at = detail::sign_start(ray_, triangle_, facing, at);
        return within_range(ray_, at);
    }

private:
    /// Where the line meets the triangle's plane, by weights of which so many are zero, not all.
    [[nodiscard]] Meeting point_of(const Three& weights, std::size_t zeros) const noexcept
    {
        if (zeros == 0) return inner_point(weights, depths_);
        std::size_t i = 0; // the corner, or the one opposite the edge
        while ((weights[i] == 0) == (zeros == 2)) ++i;
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
    /// The value, exact in sign and, where expansions hold it, in size.
    [[nodiscard]] double weight(std::size_t a, std::size_t b) const noexcept
    {
        const Vec3& o = conditioned_.ray.origin;
        const double value = exact_determinant({Vec3::Zero(), conditioned_.ray.direction},
                                               {o, conditioned_.triangle.vertices[a]},
                                               {o, conditioned_.triangle.vertices[b]});
        if (conditioned_.is_exact) return value;
        constexpr double least = 0x1p-1000;
        const int sign = determinant_sign(direction(), to_corner(a), to_corner(b));
        return sign * std::max(sign * value, least);
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

    /// Distance from the line in its plane, up to a factor that all corners share.
    [[nodiscard]] double distance(std::size_t corner, int axis) const noexcept
    {
        return std::abs(
            exact_determinant({Vec3::Zero(), conditioned_.ray.direction},
                              {conditioned_.ray.origin, conditioned_.triangle.vertices[corner]},
                              {Vec3::Zero(), Vec3::Unit(axis)}));
    }

    /// Where an edge crosses the line. The same bits whichever corner comes first.
    /// \pre the corners lie in a plane with the line, not both on it, nor both on one side
    [[nodiscard]] Meeting edge_point(std::size_t a, std::size_t b, int axis) const noexcept
    {
        const Vec3& p = triangle_.vertices[a];
        const Vec3& q = triangle_.vertices[b];
        if (std::lexicographical_compare(q.data(), q.data() + 3, p.data(), p.data() + 3))
            std::swap(a, b);
        const double from_a = distance(a, axis);
        const double from_b = distance(b, axis);
        const double sum = from_a + from_b;
        const double share = sum > 0 ? from_a / sum : 0.5;
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
    Conditioned conditioned_;
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
