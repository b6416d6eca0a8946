#include "geometry/closest_point.h"

#include "geometry/exact_predicates.h"

#include <algorithm>
#include <limits>

namespace proxima {
namespace {

/// The parameter of the foot of v along a direction, in multiples of the direction.
double foot(const Vec3& v, const Vec3& direction, double squared_length)
{
    return squared_length > 0 ? v.dot(direction) / squared_length : 0;
}

/// Below this share of its longest side, squared, a height may be nothing but rounding.
constexpr double least_height = 0x1p-90;

} // namespace

Vec3 Segment::at(double t) const noexcept
{
    // Computes from the nearer end, so that both ends are exact.
    if (t <= 0.5) return from + t * (to - from);
    return to + (1 - t) * (from - to);
}

SegmentPoint closest_point(const Segment& segment, const Vec3& p) noexcept
{
    const Vec3 along = segment.to - segment.from;
    const double t = std::clamp(foot(p - segment.from, along, along.squaredNorm()), 0.0, 1.0);
    return {segment.at(t), t};
}

std::optional<TrianglePoint> closest_point_inside(const Triangle& triangle, const Vec3& p) noexcept
{
    // The longest side u is the base and h the height on it, so that a sliver's height is computed
    // without cancellation.
    const auto& v = triangle.vertices;
    const std::array<Vec3, 3> sides = {v[1] - v[0], v[2] - v[1], v[0] - v[2]};
    std::size_t base = 0;
    for (std::size_t i = 1; i < 3; ++i) {
        if (sides[i].squaredNorm() > sides[base].squaredNorm()) base = i;
    }
    const std::size_t next = (base + 1) % 3;
    const std::size_t apex = (base + 2) % 3;
    const Vec3& u = sides[base];
    const double u_squared = u.squaredNorm();
    const Vec3 to_apex = v[apex] - v[base];
    const double apex_foot = foot(to_apex, u, u_squared);
    const Vec3 h = to_apex - apex_foot * u;
    const Vec3 x = p - v[base];
    const double x_foot = foot(x, u, u_squared);
    const Vec3 off_base = x - x_foot * u;
    const double h_squared = h.squaredNorm();
    const double at_apex = foot(off_base, h, h_squared);
    const double at_next = x_foot - at_apex * apex_foot;
    const double at_base = 1 - at_apex - at_next;

    if (!(h_squared > 0 && at_apex > 0 && at_next > 0 && at_base > 0)) return std::nullopt;
    if (h_squared < least_height * u_squared && is_degenerate(triangle)) return std::nullopt;
    TrianglePoint result;
    result.weights[base] = at_base;
    result.weights[next] = at_next;
    result.weights[apex] = at_apex;
    // Computes from the corner with the largest weight, which keeps rounding small.
    const auto heaviest =
        static_cast<std::size_t>(std::ranges::max_element(result.weights) - result.weights.begin());
    const std::size_t second = (heaviest + 1) % 3;
    const std::size_t third = (heaviest + 2) % 3;
    result.point = v[heaviest] + result.weights[second] * sides[heaviest] -
                   result.weights[third] * sides[third];
    result.part = TrianglePart::inside;
    return result;
}

TrianglePoint point_of_side(std::size_t side, const SegmentPoint& point) noexcept
{
    const std::size_t next = (side + 1) % 3;
    TrianglePoint result;
    result.point = point.point;
    result.weights[side] = 1 - point.t;
    result.weights[next] = point.t;
    constexpr auto first_side = static_cast<std::size_t>(TrianglePart::side_0);
    const std::size_t part = point.t == 0 ? side : point.t == 1 ? next : first_side + side;
    result.part = static_cast<TrianglePart>(part);
    return result;
}

TrianglePoint closest_point(const Triangle& triangle, const Vec3& p) noexcept
{
    if (const auto inside = closest_point_inside(triangle, p)) return *inside;
    const auto& v = triangle.vertices;
    TrianglePoint result;
    double best = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < 3; ++i) {
        const SegmentPoint candidate = closest_point(Segment{v[i], v[(i + 1) % 3]}, p);
        const double squared_distance = (candidate.point - p).squaredNorm();
        if (!(squared_distance < best)) continue;
        best = squared_distance;
        result = point_of_side(i, candidate);
    }
    return result;
}

SegmentPair closest_points(const Segment& first, const Segment& second) noexcept
{
    SegmentPair best;
    double best_squared = std::numeric_limits<double>::infinity();
    const auto offer = [&](const SegmentPoint& one, const SegmentPoint& two) {
        const double squared = (one.point - two.point).squaredNorm();
        if (!(squared < best_squared)) return;
        best_squared = squared;
        best = {one, two};
    };

    // Closest points inside both segments. Splitting along and across the longer one, u, keeps the
    // small part across u at full precision for nearly parallel segments.
    const Vec3 along_first = first.to - first.from;
    const Vec3 along_second = second.to - second.from;
    const bool second_is_longer = along_second.squaredNorm() > along_first.squaredNorm();
    const Segment& longer = second_is_longer ? second : first;
    const Segment& shorter = second_is_longer ? first : second;
    const Vec3& u = second_is_longer ? along_second : along_first;
    const Vec3& w = second_is_longer ? along_first : along_second;
    const double u_squared = u.squaredNorm();
    const Vec3 across = w - foot(w, u, u_squared) * u;
    const Vec3 gap = shorter.from - longer.from;
    const Vec3 gap_across = gap - foot(gap, u, u_squared) * u;
    const double across_squared = across.squaredNorm();
    if (across_squared > 0) {
        const double t = -foot(gap_across, across, across_squared);
        if (t > 0 && t < 1) {
            const SegmentPoint on_shorter = {shorter.at(t), t};
            const SegmentPoint on_longer = closest_point(longer, on_shorter.point);
            if (second_is_longer) {
                offer(on_shorter, on_longer);
            } else {
                offer(on_longer, on_shorter);
            }
        }
    }
    // Otherwise an end of one segment is closest.
    offer({first.from, 0}, closest_point(second, first.from));
    offer({first.to, 1}, closest_point(second, first.to));
    offer(closest_point(first, second.from), {second.from, 0});
    offer(closest_point(first, second.to), {second.to, 1});
    return best;
}

} // namespace proxima
