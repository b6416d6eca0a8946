#include "geometry/triangle_intersection.h"

#include "geometry/exact_predicates.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <utility>

namespace proxima {
namespace {

TrianglePart corner_part(int corner) noexcept
{
    return static_cast<TrianglePart>(corner);
}

TrianglePart side_part(int from, int to) noexcept
{
    const int first = to == (from + 1) % 3 ? from : to;
    return static_cast<TrianglePart>(3 + first);
}

} // namespace

// Not in an unnamed namespace: the class that the header befriends has members of this type.
namespace detail {

/// A triangle as a simplex of three, two or one of its corners.
struct Simplex {
    Triangle triangle;
    std::array<int, 3> corners = {0, 1, 2};
    int dimension = 2;

    explicit Simplex(const Triangle& t) noexcept : triangle(t)
    {
        if (!is_degenerate(t)) return;
        // Along a line every coordinate that changes keeps the order of the points.
        for (int axis = 0; axis < 3; ++axis) {
            const auto less = [&](int i, int j) { return t[i][axis] < t[j][axis]; };
            const int low = std::min({0, 1, 2}, less);
            const int high = std::max({0, 1, 2}, less);
            if (t[low][axis] == t[high][axis]) continue;
            dimension = 1;
            corners = {std::min(low, high), std::max(low, high), 0};
            return;
        }
        dimension = 0;
    }

    [[nodiscard]] const Vec3& point(int vertex) const noexcept
    {
        return triangle[corners[static_cast<std::size_t>(vertex)]];
    }
    [[nodiscard]] int vertex_count() const noexcept { return dimension + 1; }
    [[nodiscard]] int edge_count() const noexcept { return dimension == 2 ? 3 : dimension; }
    /// The next vertex round the triangle.
    [[nodiscard]] int after(int vertex) const noexcept { return (vertex + 1) % vertex_count(); }
    [[nodiscard]] TrianglePart vertex_part(int vertex) const noexcept
    {
        return corner_part(corners[static_cast<std::size_t>(vertex)]);
    }
    /// Edge k joins vertex k and the next one.
    [[nodiscard]] TrianglePart part_of_edge(int edge) const noexcept
    {
        return side_part(corners[static_cast<std::size_t>(edge)],
                         corners[static_cast<std::size_t>(after(edge))]);
    }
};

} // namespace detail

namespace {

using detail::Simplex;

/// The point without one coordinate.
Vec2 shadow(const Vec3& point, int axis) noexcept
{
    return {point[(axis + 1) % 3], point[(axis + 2) % 3]};
}

/// The part of a segment in whose interior the point lies.
std::optional<TrianglePart> part_at(const Vec3& point, const Simplex& segment) noexcept
{
    const Vec3& from = segment.point(0);
    const Vec3& to = segment.point(1);
    if (point == from) return segment.vertex_part(0);
    if (point == to) return segment.vertex_part(1);
    const bool in_box = (point.array() >= from.array().min(to.array())).all() &&
                        (point.array() <= from.array().max(to.array())).all();
    if (!in_box || !are_parallel({from, to}, {from, point})) return std::nullopt;
    return segment.part_of_edge(0);
}

/// The part of a triangle in whose interior the point lies. \pre the point lies in its plane
std::optional<TrianglePart> part_in_plane(const Vec3& point, const Triangle& triangle) noexcept
{
    // Seen along an axis that keeps the triangle's area.
    std::array<Vec2, 3> corners;
    int axis = 0;
    int turn = 0;
    for (; turn == 0; ++axis) {
        for (std::size_t i = 0; i < 3; ++i) corners[i] = shadow(triangle.vertices[i], axis);
        turn = orient2d(corners[0], corners[1], corners[2]);
    }
    const Vec2 seen = shadow(point, axis - 1);
    int on_edges = 0;
    int edge_sum = 0;
    for (std::size_t i = 0; i < 3; ++i) {
        const int side = turn * orient2d(corners[i], corners[(i + 1) % 3], seen);
        if (side < 0) return std::nullopt;
        if (side == 0) {
            ++on_edges;
            edge_sum += static_cast<int>(i);
        }
    }
    if (on_edges == 0) return TrianglePart::inside;
    if (on_edges == 1) return side_part(edge_sum, (edge_sum + 1) % 3);
    // Edges 0 and 1 share corner 1, 1 and 2 corner 2, 2 and 0 corner 0.
    return corner_part(edge_sum == 1 ? 1 : edge_sum == 3 ? 2 : 0);
}

/// Whether two segments have one point in common, inside of both.
bool cross_inside(const Vec3& p, const Vec3& q, const Vec3& r, const Vec3& s) noexcept
{
    if (orient3d(p, q, r, s) != 0) return false;
    for (int axis = 0; axis < 3; ++axis) {
        if (cross_component_sign({p, q}, Displacement{r, s}, axis) == 0) continue;
        const std::array<Vec2, 4> seen = {shadow(p, axis), shadow(q, axis), shadow(r, axis),
                                          shadow(s, axis)};
        return orient2d(seen[0], seen[1], seen[2]) * orient2d(seen[0], seen[1], seen[3]) < 0 &&
               orient2d(seen[2], seen[3], seen[0]) * orient2d(seen[2], seen[3], seen[1]) < 0;
    }
    return false; // parallel
}

/// Whether the line from p to q passes the inside of the triangle. \pre p, q are on either side
bool passes_inside(const Vec3& p, const Vec3& q, const Triangle& triangle) noexcept
{
    const int turn = orient3d(p, q, triangle[0], triangle[1]);
    return turn != 0 && orient3d(p, q, triangle[1], triangle[2]) == turn &&
           orient3d(p, q, triangle[2], triangle[0]) == turn;
}

} // namespace

/// Tries all pairs of parts that can have a single point in common.
class IntersectionFinder {
public:
    IntersectionFinder(const Triangle& a, const Triangle& b) noexcept : a_(a), b_(b) {}

    [[nodiscard]] TriangleIntersection find() noexcept
    {
        if (!find_sides(a_, b_, sides_of_a_) || !find_sides(b_, a_, sides_of_b_)) return found_;
        corners_of_a();
        corners_of_b();
        edges_and_edges();
        for (int edge = 0; edge < a_.edge_count(); ++edge) {
            if (meets_face(a_, edge, b_, sides_of_a_))
                add(a_.part_of_edge(edge), TrianglePart::inside);
        }
        for (int edge = 0; edge < b_.edge_count(); ++edge) {
            if (meets_face(b_, edge, a_, sides_of_b_))
                add(TrianglePart::inside, b_.part_of_edge(edge));
        }
        if (found_.count_ > 2) put_in_order();
        return found_;
    }

private:
    using Sides = std::array<int, 3>;

    /// Finds the sides of the simplex's vertices over the other's plane, if it has one. Returns
    /// false where all are on one side.
    static bool find_sides(const Simplex& simplex, const Simplex& other, Sides& sides) noexcept
    {
        sides = {};
        if (other.dimension < 2) return true;
        int sum = 0;
        for (int i = 0; i < simplex.vertex_count(); ++i) {
            sides[static_cast<std::size_t>(i)] =
                orient3d(other.point(0), other.point(1), other.point(2), simplex.point(i));
            sum += sides[static_cast<std::size_t>(i)];
        }
        return std::abs(sum) < simplex.vertex_count();
    }

    static std::optional<TrianglePart> part_at_vertex(const Vec3& point, int side,
                                                      const Simplex& other) noexcept
    {
        switch (other.dimension) {
        case 0:
            return point == other.point(0) ? std::optional(other.vertex_part(0)) : std::nullopt;
        case 1:
            return part_at(point, other);
        default:
            return side == 0 ? part_in_plane(point, other.triangle) : std::nullopt;
        }
    }

    void corners_of_a() noexcept
    {
        for (int i = 0; i < a_.vertex_count(); ++i) {
            const auto part =
                part_at_vertex(a_.point(i), sides_of_a_[static_cast<std::size_t>(i)], b_);
            if (part) add(a_.vertex_part(i), *part);
        }
    }

    void corners_of_b() noexcept
    {
        for (int i = 0; i < b_.vertex_count(); ++i) {
            const auto part =
                part_at_vertex(b_.point(i), sides_of_b_[static_cast<std::size_t>(i)], a_);
            if (part && !is_corner(*part)) add(*part, b_.vertex_part(i));
        }
    }

    void edges_and_edges() noexcept
    {
        for (int i = 0; i < a_.edge_count(); ++i) {
            if (!reaches_plane(a_, i, sides_of_a_)) continue;
            for (int j = 0; j < b_.edge_count(); ++j) {
                if (reaches_plane(b_, j, sides_of_b_) &&
                    cross_inside(a_.point(i), a_.point(a_.after(i)), b_.point(j),
                                 b_.point(b_.after(j))))
                    add(a_.part_of_edge(i), b_.part_of_edge(j));
            }
        }
    }

    /// \pre the sides are nought where there is no plane
    static int side_product(const Simplex& simplex, int edge, const Sides& sides) noexcept
    {
        return sides[static_cast<std::size_t>(edge)] *
               sides[static_cast<std::size_t>(simplex.after(edge))];
    }

    static bool reaches_plane(const Simplex& simplex, int edge, const Sides& sides) noexcept
    {
        return side_product(simplex, edge, sides) <= 0;
    }

    static bool meets_face(const Simplex& simplex, int edge, const Simplex& other,
                           const Sides& sides) noexcept
    {
        return side_product(simplex, edge, sides) < 0 &&
               passes_inside(simplex.point(edge), simplex.point(simplex.after(edge)),
                             other.triangle);
    }

    void add(TrianglePart of_a, TrianglePart of_b) noexcept
    {
        found_.ends_[found_.count_++] = {of_a, of_b};
    }

    /// Whether a part belongs to an edge, ends included.
    static bool is_on(TrianglePart part, int edge) noexcept
    {
        if (part == TrianglePart::inside) return false;
        const int number = number_of(part);
        return number == edge || (is_corner(part) && number == (edge + 1) % 3);
    }

    /// All ends are corners of the polygon, so that no three of them lie on one line: two of them
    /// are neighbours if and only if they lie on the same edge of a or of b.
    void put_in_order() noexcept
    {
        const auto are_neighbours = [](const MeetingParts& one, const MeetingParts& other) {
            for (int edge = 0; edge < 3; ++edge) {
                if ((is_on(one.of_a, edge) && is_on(other.of_a, edge)) ||
                    (is_on(one.of_b, edge) && is_on(other.of_b, edge)))
                    return true;
            }
            return false;
        };
        const auto ends = std::span(found_.ends_).first(found_.count_);
        for (std::size_t i = 0; i + 2 < ends.size(); ++i) {
            const auto rest = ends.subspan(i + 1);
            std::iter_swap(rest.begin(), std::ranges::find_if(rest, [&](const MeetingParts& other) {
                               return are_neighbours(ends[i], other);
                           }));
        }
    }

    Simplex a_;
    Simplex b_;
    Sides sides_of_a_{};
    Sides sides_of_b_{};
    TriangleIntersection found_;
};

TriangleIntersection intersect(const Triangle& a, const Triangle& b) noexcept
{
    return IntersectionFinder(a, b).find();
}

namespace {

struct Edge {
    Vec3 from;
    Vec3 to;

    /// The corners of a triangle in an order that does not depend on the triangle's own order.
    Edge(const Triangle& triangle, TrianglePart part) noexcept
        : from(triangle[number_of(part)]), to(triangle[(number_of(part) + 1) % 3])
    {
        if (comes_before(to, from)) std::swap(from, to);
    }

    static bool comes_before(const Vec3& p, const Vec3& q) noexcept
    {
        return std::lexicographical_compare(p.begin(), p.end(), q.begin(), q.end());
    }
    [[nodiscard]] bool comes_before(const Edge& other) const noexcept
    {
        return from == other.from ? comes_before(to, other.to) : comes_before(from, other.from);
    }
};

/// The point between the ends, whose distances from the crossed plane or line are `ahead` and
/// `behind`.
Vec3 position_between(const Edge& edge, double ahead, double behind) noexcept
{
    const double sum = std::abs(ahead) + std::abs(behind);
    if (sum == 0) return edge.from;
    const Vec3 along = edge.to - edge.from;
    const double from_share = std::abs(ahead) / sum;
    const Vec3 position = from_share <= 0.5 ? Vec3(edge.from + from_share * along)
                                            : Vec3(edge.to - std::abs(behind) / sum * along);
    return position.cwiseMax(edge.from.cwiseMin(edge.to)).cwiseMin(edge.from.cwiseMax(edge.to));
}

Vec3 edge_on_face(const Edge& edge, const Triangle& face) noexcept
{
    const Displacement u = {face[0], face[1]};
    const Displacement v = {face[0], face[2]};
    const auto [ahead, behind] = in_common_units<2>({exact_determinant(u, v, {face[0], edge.from}),
                                                     exact_determinant(u, v, {face[0], edge.to})});
    return position_between(edge, ahead, behind);
}

Vec3 edge_on_edge(const Edge& edge, const Edge& other) noexcept
{
    const Displacement along = {other.from, other.to};
    std::array<ScaledNumber, 6> seen; // along each axis: the edge's ends
    for (int axis = 0; axis < 3; ++axis) {
        const Displacement view = {Vec3::Zero(), Vec3::Unit(axis)};
        const std::size_t at = 2 * static_cast<std::size_t>(axis);
        seen[at] = exact_determinant(along, {other.from, edge.from}, view);
        seen[at + 1] = exact_determinant(along, {other.from, edge.to}, view);
    }
    // The axis along which they cross at the widest angle.
    const std::array<double, 6> sizes = in_common_units(seen);
    const auto width = [&](std::size_t at) {
        return std::abs(sizes[at]) + std::abs(sizes[at + 1]);
    };
    std::size_t widest = 0;
    for (const std::size_t at : {2, 4})
        if (width(at) > width(widest)) widest = at;
    return position_between(edge, sizes[widest], sizes[widest + 1]);
}

} // namespace

Vec3 meeting_point(const Triangle& a, const Triangle& b, const MeetingParts& parts) noexcept
{
    if (is_corner(parts.of_a)) return a[number_of(parts.of_a)];
    if (is_corner(parts.of_b)) return b[number_of(parts.of_b)];
    if (parts.of_b == TrianglePart::inside) return edge_on_face(Edge(a, parts.of_a), b);
    if (parts.of_a == TrianglePart::inside) return edge_on_face(Edge(b, parts.of_b), a);
    const Edge one(a, parts.of_a);
    const Edge other(b, parts.of_b);
    return one.comes_before(other) ? edge_on_edge(one, other) : edge_on_edge(other, one);
}

} // namespace proxima
