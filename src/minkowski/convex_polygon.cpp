#include "minkowski/convex_polygon.h"

#include "base/check.h"
#include "base/text.h"
#include "geometry/exact_predicates.h"
#include "proxima/convex_polyhedron.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace proxima {
namespace {

constexpr std::size_t max_points = std::size_t{1} << 20U;

Vec3 lifted(const Vec2& point)
{
    return {point.x(), point.y(), 0};
}

Displacement between(const Vec2& from, const Vec2& to)
{
    return {lifted(from), lifted(to)};
}

/// The sign of u x v for directions.
int turn(const Vec2& u, const Vec2& v)
{
    return orient2d(Vec2::Zero(), u, v);
}

/// The sign of direction x (b - a): +1 if b lies to the left of a, seen along the direction.
int side(const Vec2& direction, const Vec2& a, const Vec2& b)
{
    return cross_component_sign(between(Vec2::Zero(), direction), between(a, b), 2);
}

bool same_way(const Vec2& u, const Vec2& v)
{
    return turn(u, v) == 0 && point_same_way(between(Vec2::Zero(), u), between(Vec2::Zero(), v));
}

Status check_coordinates(std::span<const Vec2> vectors, const char* what)
{
    for (std::size_t i = 0; i < vectors.size(); ++i) {
        const std::string where = concat(what, " ", i);
        if (!vectors[i].allFinite()) {
            return fail(ErrorCode::invalid_argument, "A coordinate is not a finite number.", where);
        }
        if (vectors[i].cwiseAbs().maxCoeff() > max_polyhedron_coordinate) {
            return fail(ErrorCode::limit_exceeded,
                        concat("A coordinate is larger than ", max_polyhedron_coordinate, "."),
                        where);
        }
    }
    return {};
}

/// The outermost two of the rays, the clockwise one first; none if they span a line.
std::optional<std::vector<Vec2>> outermost(std::span<const Vec2> rays)
{
    Vec2 clockwise = rays[0];
    Vec2 counter_clockwise = rays[0];
    for (const Vec2& ray : rays) {
        if (turn(clockwise, ray) < 0) clockwise = ray;
        if (turn(counter_clockwise, ray) > 0) counter_clockwise = ray;
    }
    // In a cone of less than half a turn all rays lie between these two; in a wider one some do
    // not.
    const auto turns_left = [](const Vec2& u, const Vec2& v) {
        return turn(u, v) > 0 || same_way(u, v);
    };
    for (const Vec2& ray : rays) {
        if (!turns_left(clockwise, ray) || !turns_left(ray, counter_clockwise)) return std::nullopt;
    }
    if (!turns_left(clockwise, counter_clockwise)) return std::nullopt;
    return std::vector<Vec2>{clockwise, counter_clockwise};
}

/// Indices of the corners, counter-clockwise, each once: a monotone chain below, then one above.
std::vector<std::size_t> corner_loop(std::span<const Vec2> points)
{
    std::vector<std::size_t> order(points.size());
    for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
    std::ranges::sort(order, [&](std::size_t i, std::size_t j) {
        if (points[i].x() != points[j].x()) return points[i].x() < points[j].x();
        if (points[i].y() != points[j].y()) return points[i].y() < points[j].y();
        return i < j;
    });
    const auto equal = [&](std::size_t i, std::size_t j) { return points[i] == points[j]; };
    order.erase(std::unique(order.begin(), order.end(), equal), order.end());
    if (order.size() == 1) return order;

    std::vector<std::size_t> loop;
    const auto add_chain = [&](auto first, auto last) {
        const std::size_t base = loop.size();
        for (auto at = first; at != last; ++at) {
            while (loop.size() >= base + 2 &&
                   orient2d(points[loop[loop.size() - 2]], points[loop.back()], points[*at]) <= 0)
                loop.pop_back();
            loop.push_back(*at);
        }
        loop.pop_back(); // the next chain begins there
    };
    add_chain(order.begin(), order.end());
    add_chain(order.rbegin(), order.rend());
    std::rotate(loop.begin(), std::ranges::min_element(loop), loop.end());
    return loop;
}

/// The position in the loop of the corner that lies farthest to the right of the direction; of two,
/// the one less far along `back`.
std::size_t rightmost(std::span<const Vec2> points, std::span<const std::size_t> loop,
                      const Vec2& direction, const Vec2& back)
{
    const Vec2 across(-back.y(), back.x());
    std::size_t best = 0;
    for (std::size_t i = 1; i < loop.size(); ++i) {
        const Vec2& a = points[loop[best]];
        const Vec2& b = points[loop[i]];
        const int where = side(direction, a, b);
        // b is behind a along `back` if it lies to the left of a, seen across.
        if (where < 0 || (where == 0 && side(across, a, b) > 0)) best = i;
    }
    return best;
}

} // namespace

Displacement ConvexPolygon::direction(int edge) const noexcept
{
    const auto from = static_cast<std::size_t>(edge);
    if (from + 1 < points_.size()) return between(points_[from], points_[from + 1]);
    if (is_bounded()) return between(points_[from], points_[0]);
    if (from < points_.size()) return between(Vec2::Zero(), rays_[0]);
    return between(rays_[1], Vec2::Zero());
}

Result<ConvexPolygon> convex_polygon(std::span<const Vec2> points, std::span<const Vec2> rays)
{
    if (points.empty()) {
        return fail(ErrorCode::invalid_argument, "A polygon needs at least one point.");
    }
    if (points.size() > max_points || rays.size() > max_points) {
        return fail(ErrorCode::limit_exceeded, concat("More than ", max_points, " points."));
    }
    if (auto status = check_coordinates(points, "point"); !status) {
        return tl::unexpected(status.error());
    }
    if (auto status = check_coordinates(rays, "ray"); !status) {
        return tl::unexpected(status.error());
    }
    if (const auto zero = std::ranges::find(rays, Vec2::Zero().eval()); zero != rays.end()) {
        return fail(ErrorCode::invalid_argument, "A ray has no length.",
                    concat("ray ", zero - rays.begin()));
    }

    ConvexPolygon polygon;
    const std::vector<std::size_t> loop = corner_loop(points);
    std::size_t first = 0;
    std::size_t last = loop.size() - 1;
    if (!rays.empty()) {
        auto pair = outermost(rays);
        if (!pair) {
            return fail(ErrorCode::invalid_argument,
                        "The rays span a whole line, so that the polygon has no corner.");
        }
        polygon.rays_ = std::move(*pair);
        const Vec2& out = polygon.rays_[0];
        const Vec2& in = polygon.rays_[1];
        last = rightmost(points, loop, out, out);
        first = rightmost(points, loop, -in, in);
    }
    for (std::size_t at = first;; at = (at + 1) % loop.size()) {
        polygon.points_.push_back(points[loop[at]]);
        if (at == last) break;
    }
    return polygon;
}

CutPolygon cut_polygon(const ConvexPolygon& polygon, double length)
{
    PROXIMA_CHECK(length > 0 && std::isfinite(length));
    CutPolygon cut;
    cut.corners.assign(polygon.points().begin(), polygon.points().end());
    cut.real = static_cast<int>(cut.corners.size());
    if (polygon.is_bounded()) return cut;
    const Vec2& out = polygon.rays()[0];
    const Vec2& in = polygon.rays()[1];
    cut.corners.emplace_back(polygon.points().back() + length * out);
    const bool is_half_line = cut.real == 1 && same_way(out, in);
    if (!is_half_line) {
        cut.closing = cut.real;
        cut.corners.emplace_back(polygon.points().front() + length * in);
    }
    return cut;
}

} // namespace proxima
