#include "thesis/minkowski_sums/planar_sum.h"

#include "base/text.h"
#include "geometry/exact_predicates.h"
#include "proxima/convex_polyhedron.h"
#include "thesis/minkowski_sums/geometric_method.h"

#include <algorithm>
#include <cmath>

namespace proxima {
namespace {

constexpr std::size_t max_sum_points = std::size_t{1} << 22U;

Displacement reversed(const Displacement& d)
{
    return {d.to, d.from};
}

/// The sign of u x v.
int turn(const Displacement& u, const Displacement& v)
{
    return cross_component_sign(u, v, 2);
}

bool same_way(const Displacement& u, const Displacement& v)
{
    return turn(u, v) == 0 && point_same_way(u, v);
}

/// Whether a direction's angle to the x axis is below 180 degrees, 0 included.
bool is_in_upper_half(const Displacement& d)
{
    return d.to.y() > d.from.y() || (d.to.y() == d.from.y() && d.to.x() > d.from.x());
}

/// Whether u comes before v counter-clockwise from the x axis.
bool angle_less(const Displacement& u, const Displacement& v)
{
    const bool upper = is_in_upper_half(u);
    if (upper != is_in_upper_half(v)) return upper;
    return turn(u, v) > 0;
}

/// The part of a polygon farthest along the normal to the right of a direction: a corner or an
/// edge. Indices of the cut polygon.
struct ExtremeFace {
    int from = -1;
    int to = -1;
    int last_real = -1; ///< `to`, or where that is at infinity the last corner before it
    bool from_infinity = false;
    bool to_infinity = false;
};

} // namespace

/// Finds one sum, step by step.
class PlanarSummation {
public:
    PlanarSummation(const ConvexPolygon& a, const ConvexPolygon& b, double cut_length)
        : whole_a_(a), whole_b_(b)
    {
        sum_.a_ = cut_polygon(a, cut_length);
        sum_.b_ = cut_polygon(b, cut_length);
    }

    [[nodiscard]] std::size_t point_count() const
    {
        return sum_.a_.corners.size() * sum_.b_.corners.size();
    }

    [[nodiscard]] PlanarSum run()
    {
        sum_.points_.resize(point_count());
        form_sum_vertices<double, 2>(sum_.a_.corners, sum_.b_.corners, sum_.points_);
        add_candidates(whole_b_, sum_.b_, FacetOrigin::b);
        add_candidates(whole_a_, sum_.a_, FacetOrigin::a);
        push_lines();
        keep_edges();
        return std::move(sum_);
    }

private:
    /// An edge whose line is pushed: of the real polygon, or the cut's own.
    struct Source {
        FacetOrigin origin;
        int edge; ///< of the cut polygon
        Displacement direction;
        bool is_cut;
    };

    void add_candidates(const ConvexPolygon& whole, const CutPolygon& cut, FacetOrigin origin)
    {
        for (int e = 0; e < cut.edge_count(); ++e) {
            Source source = {origin, e, {}, e == cut.closing};
            if (source.is_cut) {
                const auto next = static_cast<std::size_t>(e) + 1;
                const Vec2& from = cut.corners[next - 1];
                const Vec2& to = cut.corners[next];
                source.direction = {{from.x(), from.y(), 0}, {to.x(), to.y(), 0}};
            } else {
                const bool is_last = e + 1 == cut.edge_count();
                source.direction = whole.direction(is_last ? whole.edge_count() - 1 : e);
            }
            const Vec3 along = source.direction.rounded();
            const Vec2 normal(along.y(), -along.x());
            sources_.push_back(source);
            candidates_.push_back(
                {normal, normal.cwiseAbs(), NormalSource::face, PushedSides::outward});
        }
    }

    void push_lines()
    {
        const SumVertices<double, 2> vertices = {sum_.a_.corners, sum_.b_.corners, sum_.points_};
        std::vector<int> scratch(2 * sum_.points_.size());
        push_each_plane<double, 2>(
            vertices, candidates_, scratch, [&](const PushedPlane<double, 2>& pushed) {
                const Source& source = sources_[pushed.candidate];
                PushedLine line;
                line.origin = source.origin;
                line.source_edge = source.edge;
                line.normal = candidates_[pushed.candidate].direction.stableNormalized();
                line.support = pushed.support;
                line.offset =
                    line.normal.dot(sum_.points_[static_cast<std::size_t>(pushed.support)]);
                line.spans_edge = spans_facet(vertices, pushed.supports);
                line.first_touched = static_cast<int>(sum_.touched_.size());
                line.touched_count = static_cast<int>(pushed.supports.size());
                sum_.touched_.insert(sum_.touched_.end(), pushed.supports.begin(),
                                     pushed.supports.end());
                sum_.lines_.push_back(line);
                pushed_sources_.push_back(source);
            });
    }

    /// Whether a line's normal has a positive product with a ray (4.12). The cut's own edge always
    /// has, unless it is rounded to nothing.
    [[nodiscard]] bool obstructs(const Source& source) const
    {
        if (source.is_cut) return true;
        const auto goes_beyond = [&](const Vec2& ray) {
            return turn(source.direction, {Vec3::Zero(), {ray.x(), ray.y(), 0}}) < 0;
        };
        return std::ranges::any_of(whole_a_.rays(), goes_beyond) ||
               std::ranges::any_of(whole_b_.rays(), goes_beyond);
    }

    /// Which of the corners touched are the farthest. `corner_of` gives the corner of a point k.
    template <class CornerOf>
    [[nodiscard]] static ExtremeFace extreme_face(const ConvexPolygon& whole, const CutPolygon& cut,
                                                  const Displacement& direction,
                                                  std::span<const int> touched, CornerOf corner_of)
    {
        const auto step = [&](int from, int to) {
            const Vec2& p = cut.corners[static_cast<std::size_t>(from)];
            const Vec2& q = cut.corners[static_cast<std::size_t>(to)];
            return Displacement{{p.x(), p.y(), 0}, {q.x(), q.y(), 0}};
        };
        ExtremeFace face;
        for (const int k : touched) {
            const int corner = corner_of(k);
            if (corner >= cut.real || corner == face.from || corner == face.to) continue;
            const int side = face.to < 0 ? -1 : turn(direction, step(face.to, corner));
            if (side < 0) {
                face.from = face.to = corner;
            } else if (side == 0) {
                if (point_same_way(direction, step(face.to, corner))) {
                    face.to = corner;
                } else if (!point_same_way(direction, step(face.from, corner))) {
                    face.from = corner;
                }
            }
        }
        face.last_real = face.to;
        if (whole.is_bounded()) return face;
        const auto ray = [&](std::size_t i) {
            return Displacement{Vec3::Zero(), {whole.rays()[i].x(), whole.rays()[i].y(), 0}};
        };
        if (same_way(direction, ray(0))) {
            face.to = cut.real;
            face.to_infinity = true;
        }
        if (same_way(reversed(direction), ray(1))) {
            face.from = static_cast<int>(cut.corners.size()) - 1;
            face.from_infinity = true;
        }
        return face;
    }

    [[nodiscard]] PlanarEdge edge_on(const PushedLine& line, const Displacement& direction) const
    {
        const auto touched = sum_.touched(line);
        const ExtremeFace a = extreme_face(whole_a_, sum_.a_, direction, touched,
                                           [&](int k) { return sum_.pair(k).a; });
        const ExtremeFace b = extreme_face(whole_b_, sum_.b_, direction, touched,
                                           [&](int k) { return sum_.pair(k).b; });
        PlanarEdge edge;
        edge.origin = line.origin;
        edge.normal = line.normal;
        edge.support = sum_.index({a.last_real, b.last_real});
        edge.offset = edge.normal.dot(sum_.points_[static_cast<std::size_t>(edge.support)]);
        edge.from = sum_.index({a.from, b.from});
        edge.to = sum_.index({a.to, b.to});
        edge.from_infinity = a.from_infinity || b.from_infinity;
        edge.to_infinity = a.to_infinity || b.to_infinity;
        return edge;
    }

    void keep_edges()
    {
        std::vector<std::size_t> kept;
        for (std::size_t i = 0; i < sum_.lines_.size(); ++i) {
            if (!obstructs(pushed_sources_[i])) kept.push_back(i);
        }
        const auto direction = [&](std::size_t i) -> const Displacement& {
            return pushed_sources_[i].direction;
        };
        std::ranges::stable_sort(kept, [&](std::size_t i, std::size_t j) {
            return angle_less(direction(i), direction(j));
        });
        std::vector<std::vector<std::size_t>> lines_of_edge;
        for (const std::size_t i : kept) {
            const bool is_parallel = !lines_of_edge.empty() &&
                                     same_way(direction(lines_of_edge.back()[0]), direction(i));
            if (is_parallel) {
                sum_.edges_.back().origin = FacetOrigin::both;
                lines_of_edge.back().push_back(i);
            } else {
                sum_.edges_.push_back(edge_on(sum_.lines_[i], direction(i)));
                lines_of_edge.push_back({i});
            }
        }
        const auto first = std::ranges::find_if(
            sum_.edges_, [](const PlanarEdge& edge) { return edge.from_infinity; });
        const auto start = first == sum_.edges_.end() ? 0 : first - sum_.edges_.begin();
        std::rotate(sum_.edges_.begin(), sum_.edges_.begin() + start, sum_.edges_.end());
        std::rotate(lines_of_edge.begin(), lines_of_edge.begin() + start, lines_of_edge.end());
        for (std::size_t e = 0; e < lines_of_edge.size(); ++e) {
            for (const std::size_t i : lines_of_edge[e]) sum_.lines_[i].edge = static_cast<int>(e);
        }
    }

    const ConvexPolygon& whole_a_;
    const ConvexPolygon& whole_b_;
    PlanarSum sum_;
    std::vector<Source> sources_;
    std::vector<CandidateNormal<double, 2>> candidates_;
    std::vector<Source> pushed_sources_; ///< one per line
};

Vec2 PlanarSum::point(int k, const PlanarScales& scales) const noexcept
{
    const CornerPair corners = pair(k);
    return scales.a * a_.corners[static_cast<std::size_t>(corners.a)] +
           scales.b * b_.corners[static_cast<std::size_t>(corners.b)];
}

Result<PlanarSum> planar_sum(const ConvexPolygon& a, const ConvexPolygon& b,
                             const PlanarSumOptions& options)
{
    if (!(options.cut_length > 0) || !(options.cut_length <= max_polyhedron_coordinate)) {
        return fail(
            ErrorCode::invalid_argument,
            concat("Rays can be cut at a positive length up to ", max_polyhedron_coordinate, "."),
            "cut_length");
    }
    PlanarSummation summation(a, b, options.cut_length);
    if (summation.point_count() > max_sum_points) {
        return fail(ErrorCode::limit_exceeded,
                    concat("The sum would have ", summation.point_count(), " points, more than ",
                           max_sum_points, "."));
    }
    return summation.run();
}

} // namespace proxima
