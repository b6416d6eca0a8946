#include "minkowski/quickhull.h"

#include "base/check.h"
#include "base/progress.h"
#include "geometry/exact_predicates.h"
#include "geometry/length.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace proxima::detail {
namespace {

constexpr std::uint32_t none = std::numeric_limits<std::uint32_t>::max();
constexpr double unit_roundoff = std::numeric_limits<double>::epsilon() / 2;

Displacement displacement(const HullVertices& vertices, std::uint32_t from,
                          std::uint32_t to) noexcept
{
    return vertices.is_ray(to) ? Displacement{Vec3::Zero(), vertices.coordinates[to]}
                               : Displacement{vertices.coordinates[from], vertices.coordinates[to]};
}

/// The vertex of the largest measure that also passes the exact test; none if no vertex does.
template <class Measure, class Test>
std::uint32_t best_vertex(const HullVertices& vertices, Measure measure, Test passes)
{
    const auto count = static_cast<std::uint32_t>(vertices.coordinates.size());
    std::uint32_t best = 0;
    double largest = -1;
    for (std::uint32_t v = 0; v < count; ++v) {
        const double value = measure(v);
        if (value > largest) {
            largest = value;
            best = v;
        }
    }
    if (passes(best)) return best;
    for (std::uint32_t v = 0; v < count; ++v) {
        if (passes(v)) return v;
    }
    return none;
}

struct Face {
    HullTriangle triangle; ///< its first vertex is a point, unless all are rays
    Vec3 normal = Vec3::Zero();
    double tolerance = 0;
    std::uint32_t farthest = none;
    std::pair<bool, double> farthest_rank; ///< whether it is a ray, and its height
    std::uint32_t first_waiting = none;    ///< list of the vertices that wait, by Quickhull::next_
    bool at_infinity = false;
    bool gone = false;
    std::uint32_t seen_by = none; ///< the last vertex that was found to see it
};

class Quickhull {
public:
    Quickhull(const HullVertices& vertices, Progress* progress)
        : vertices_(vertices), progress_(progress), next_(vertices.coordinates.size(), none),
          face_from_(vertices.coordinates.size(), none)
    {}

    Result<std::vector<HullTriangle>> build(const AffineSpan& span)
    {
        start(span.vertices);
        std::uint64_t rounds = 0;
        while (!to_do_.empty()) {
            const std::uint32_t face = to_do_.back();
            to_do_.pop_back();
            if (faces_[face].gone || faces_[face].first_waiting == none) continue;
            if (++rounds % 64 == 0 && is_cancelled(progress_)) {
                return cancelled("the convex hull");
            }
            add(faces_[face].farthest, face);
        }
        return take_triangles();
    }

    /// How often a vertex that waits was held against a face.
    [[nodiscard]] std::uint64_t trials() const noexcept { return trials_; }

private:
    [[nodiscard]] Face make_face(std::uint32_t a, std::uint32_t b, std::uint32_t c) const
    {
        Face face;
        while (vertices_.is_ray(a) && (!vertices_.is_ray(b) || !vertices_.is_ray(c))) {
            const std::uint32_t first = a;
            a = b;
            b = c;
            c = first;
        }
        face.triangle.vertices = {a, b, c};
        face.at_infinity = vertices_.is_ray(a);
        if (face.at_infinity) return face;
        const Vec3 u = displacement(vertices_, a, b).rounded();
        const Vec3 v = displacement(vertices_, a, c).rounded();
        face.normal = u.cross(v);
        face.tolerance = normal_tolerance(u, v);
        return face;
    }

    /// The approximate height of vertex v above the face, and its exact side.
    struct Height {
        double value;
        int side;
    };
    [[nodiscard]] Height height(const Face& face, std::uint32_t v) const noexcept
    {
        if (face.at_infinity) return {-1, vertices_.is_ray(v) ? 0 : -1};
        const Displacement to_v = displacement(vertices_, face.triangle.vertices[0], v);
        const Vec3 d = to_v.rounded();
        const double value = face.normal.dot(d);
        const double error = face.tolerance * d.lpNorm<1>() + std::numeric_limits<double>::min();
        if (value > error) return {value, 1};
        if (value < -error) return {value, -1};
        return {value, hull_side(vertices_, face.triangle.vertices, v)};
    }

    /// Adds vertex v to the face's waiting list if v sees the face.
    bool wait_with(std::uint32_t face_index, std::uint32_t v)
    {
        Face& face = faces_[face_index];
        ++trials_;
        const Height above = height(face, v);
        if (above.side <= 0) return false;
        next_[v] = face.first_waiting;
        face.first_waiting = v;
        // Rays first, the steepest of them, however long: they reach farther than any point.
        const bool is_ray = vertices_.is_ray(v);
        const double length = is_ray ? vertices_.coordinates[v].stableNorm() : 1;
        const std::pair rank(is_ray, above.value / length);
        if (face.farthest == none || rank > face.farthest_rank) {
            face.farthest = v;
            face.farthest_rank = rank;
        }
        return true;
    }

    void start(std::array<std::uint32_t, 4> corners)
    {
        if (hull_side(vertices_, {corners[0], corners[1], corners[2]}, corners[3]) > 0)
            std::swap(corners[1], corners[2]);
        const auto [a, b, c, d] = corners;
        const std::array<std::array<std::uint32_t, 3>, 4> sides = {
            {{a, b, c}, {a, d, b}, {b, d, c}, {c, d, a}}};
        for (const auto& side : sides) faces_.push_back(make_face(side[0], side[1], side[2]));
        for (std::uint32_t f = 0; f < 4; ++f) {
            for (std::size_t i = 0; i < 3; ++i) {
                const auto& corner = faces_[f].triangle.vertices;
                const std::uint32_t from = corner[i];
                const std::uint32_t to = corner[(i + 1) % 3];
                for (std::uint32_t g = 0; g < 4; ++g) {
                    const auto& other = faces_[g].triangle.vertices;
                    for (std::size_t k = 0; k < 3; ++k) {
                        if (other[k] == to && other[(k + 1) % 3] == from)
                            faces_[f].triangle.neighbours[i] = g;
                    }
                }
            }
        }
        const auto count = static_cast<std::uint32_t>(vertices_.coordinates.size());
        for (std::uint32_t v = 0; v < count; ++v) {
            if (v == a || v == b || v == c || v == d) continue;
            for (std::uint32_t f = 0; f < 4; ++f) {
                if (wait_with(f, v)) break;
            }
        }
        to_do_ = {0, 1, 2, 3};
    }

    /// An edge of the outline of what a vertex sees: from -> to as the visible face has it, and the
    /// hidden face beyond.
    struct OutlineEdge {
        std::uint32_t from;
        std::uint32_t to;
        std::uint32_t beyond;
    };

    void add(std::uint32_t v, std::uint32_t first_face)
    {
        visible_ = {first_face};
        faces_[first_face].seen_by = v;
        outline_.clear();
        for (std::size_t i = 0; i < visible_.size(); ++i) { // grows as it goes
            const HullTriangle triangle = faces_[visible_[i]].triangle;
            for (std::size_t k = 0; k < 3; ++k) {
                const std::uint32_t beyond = triangle.neighbours[k];
                if (faces_[beyond].seen_by == v) continue;
                if (height(faces_[beyond], v).side > 0) {
                    faces_[beyond].seen_by = v;
                    visible_.push_back(beyond);
                } else {
                    outline_.push_back(
                        {triangle.vertices[k], triangle.vertices[(k + 1) % 3], beyond});
                }
            }
        }
        const auto first_new = static_cast<std::uint32_t>(faces_.size());
        for (const OutlineEdge& edge : outline_) {
            face_from_[edge.from] = static_cast<std::uint32_t>(faces_.size());
            faces_.push_back(make_face(edge.from, edge.to, v));
        }
        for (std::size_t i = 0; i < outline_.size(); ++i) {
            join(first_new + static_cast<std::uint32_t>(i), outline_[i], v);
        }
        hand_over_waiting(v, first_new);
    }

    /// Links a new face with the hidden one beyond its edge and with the new face after it.
    void join(std::uint32_t face, const OutlineEdge& edge, std::uint32_t v)
    {
        const std::uint32_t after = face_from_[edge.to];
        set_neighbour(face, edge.from, edge.beyond);
        set_neighbour(face, edge.to, after);
        set_neighbour(after, v, face);
        set_neighbour(edge.beyond, edge.to, face);
    }

    /// The neighbour across the edge that starts at vertex `from`.
    void set_neighbour(std::uint32_t face, std::uint32_t from, std::uint32_t neighbour)
    {
        HullTriangle& triangle = faces_[face].triangle;
        for (std::size_t i = 0; i < 3; ++i) {
            if (triangle.vertices[i] == from) triangle.neighbours[i] = neighbour;
        }
    }

    void hand_over_waiting(std::uint32_t v, std::uint32_t first_new)
    {
        const auto last_new = static_cast<std::uint32_t>(faces_.size());
        std::uint32_t hint = first_new;
        for (const std::uint32_t old : visible_) {
            faces_[old].gone = true;
            std::uint32_t waiting = faces_[old].first_waiting;
            while (waiting != none) {
                const std::uint32_t after = next_[waiting];
                if (waiting != v) {
                    std::uint32_t f = hint; // what waited side by side mostly goes on so
                    for (std::uint32_t tried = first_new; tried < last_new; ++tried) {
                        if (wait_with(f, waiting)) {
                            hint = f;
                            break;
                        }
                        if (++f == last_new) f = first_new;
                    }
                }
                waiting = after;
            }
        }
        for (std::uint32_t f = first_new; f < last_new; ++f) {
            if (faces_[f].first_waiting != none) to_do_.push_back(f);
        }
    }

    [[nodiscard]] std::vector<HullTriangle> take_triangles() const
    {
        std::vector<std::uint32_t> number(faces_.size(), none);
        std::uint32_t count = 0;
        for (std::size_t f = 0; f < faces_.size(); ++f) {
            if (!faces_[f].gone) number[f] = count++;
        }
        std::vector<HullTriangle> triangles;
        triangles.reserve(count);
        for (const Face& face : faces_) {
            if (face.gone) continue;
            HullTriangle triangle = face.triangle;
            for (std::uint32_t& neighbour : triangle.neighbours) neighbour = number[neighbour];
            triangles.push_back(triangle);
        }
        return triangles;
    }

    HullVertices vertices_;
    Progress* progress_;
    std::vector<Face> faces_;
    std::vector<std::uint32_t> next_;      ///< lists of waiting vertices
    std::vector<std::uint32_t> face_from_; ///< the new face whose outline edge starts at a vertex
    std::vector<std::uint32_t> to_do_;
    std::vector<std::uint32_t> visible_;
    std::vector<OutlineEdge> outline_;
    std::uint64_t trials_ = 0;
};

} // namespace

double normal_tolerance(const Vec3& u, const Vec3& v) noexcept
{
    // Of a component of u x v: the factors' own rounding 2, product and difference 2 more; of the
    // product with d: d's rounding 1, product 1, sums 2: 8 roundings of the sum of sizes, and less
    // than 9 with those of the second order. What underflows is a few 2^-1074 per component.
    const Vec3 p = u.cwiseAbs();
    const Vec3 q = v.cwiseAbs();
    const double size = std::max({p.y() * q.z() + p.z() * q.y(), p.z() * q.x() + p.x() * q.z(),
                                  p.x() * q.y() + p.y() * q.x()});
    return 10 * unit_roundoff * size + 0x1p-1068;
}

AffineSpan affine_span(const HullVertices& vertices)
{
    PROXIMA_CHECK_LT(0U, vertices.point_count);
    AffineSpan span;
    const auto before = [](const Vec3& p, const Vec3& q) {
        return std::lexicographical_compare(p.begin(), p.end(), q.begin(), q.end());
    };
    const auto points = vertices.coordinates.first(vertices.point_count);
    const auto first =
        static_cast<std::uint32_t>(std::ranges::min_element(points, before) - points.begin());
    span.vertices[0] = first;
    const auto to = [&](std::uint32_t v) { return displacement(vertices, first, v); };
    /// Rays have no length of their own.
    const auto rounded = [&](std::uint32_t v) {
        const Vec3 d = to(v).rounded();
        return vertices.is_ray(v) ? unit_of(d) : d;
    };

    const std::uint32_t second = best_vertex(
        vertices, [&](std::uint32_t v) { return rounded(v).cwiseAbs().maxCoeff(); },
        [&](std::uint32_t v) { return to(v).from != to(v).to; });
    if (second == none) return span;
    span.dimension = 1;
    span.vertices[1] = second;

    const Vec3 line = unit_of(rounded(second));
    const std::uint32_t third = best_vertex(
        vertices, [&](std::uint32_t v) { return line.cross(rounded(v)).cwiseAbs().maxCoeff(); },
        [&](std::uint32_t v) { return !are_parallel(to(second), to(v)); });
    if (third == none) return span;
    span.dimension = 2;
    span.vertices[2] = third;

    const Vec3 normal = unit_of(line.cross(unit_of(rounded(third))));
    const std::uint32_t fourth = best_vertex(
        vertices, [&](std::uint32_t v) { return std::abs(normal.dot(rounded(v))); },
        [&](std::uint32_t v) { return determinant_sign(to(second), to(third), to(v)) != 0; });
    if (fourth == none) return span;
    span.dimension = 3;
    span.vertices[3] = fourth;
    return span;
}

Result<std::vector<HullTriangle>> quickhull(const HullVertices& vertices, const AffineSpan& span,
                                            Progress* progress, std::uint64_t* trials)
{
    PROXIMA_CHECK_EQ(span.dimension, 3);
    Quickhull hull(vertices, progress);
    auto triangles = hull.build(span);
    if (trials != nullptr) *trials = hull.trials();
    return triangles;
}

int hull_side(const HullVertices& vertices, const std::array<std::uint32_t, 3>& corners,
              std::uint32_t v) noexcept
{
    auto [a, b, c] = corners;
    for (int turn = 0; turn < 2 && vertices.is_ray(a); ++turn) {
        const std::uint32_t first = a;
        a = b;
        b = c;
        c = first;
    }
    const auto to = [&, a = a](std::uint32_t other) { return displacement(vertices, a, other); };
    if (!vertices.is_ray(a)) return determinant_sign(to(b), to(c), to(v));
    if (vertices.is_ray(v)) return 0;
    return -determinant_sign(to(a), to(b), to(c));
}

} // namespace proxima::detail
