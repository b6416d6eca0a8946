#include "proxima/minkowski/sum_by_arcs.h"

#include "proxima/base/check.h"
#include "proxima/minkowski/convex_hull.h"
#include "proxima/minkowski/gaussian_map.h"
#include "proxima/minkowski/operation_counts.h"
#include "proxima/minkowski/sum_assembler.h"

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

namespace proxima::detail {
namespace {

/// More corners than this, of all facets together, are refused: about 10 GB.
constexpr std::size_t max_sum_corners = std::size_t{1} << 28U;

using Loop = std::span<const std::uint32_t>;
using Kind = SumCorner::Kind;

/// The vertices of a face, for FaceView.
class FaceVertices {
public:
    FaceVertices(const ConvexPolyhedron& polyhedron, const SupportFace& face)
        : polyhedron_(polyhedron), face_(face)
    {
        if (face.dimension == 0) ends_[0] = face.vertex;
        if (face.dimension == 1) {
            const PolyhedronEdge& edge = polyhedron.edges()[face.item];
            ends_ = {edge.from, edge.to};
        }
    }

    [[nodiscard]] FaceView view() const
    {
        const auto size = static_cast<std::size_t>(face_.dimension) + 1;
        return {&polyhedron_, face_.dimension == 2 ? polyhedron_.facet_loop(face_.item)
                                                   : std::span(ends_).first(size)};
    }

private:
    const ConvexPolyhedron& polyhedron_;
    SupportFace face_;
    std::array<std::uint32_t, 2> ends_{};
};

/// Sums facets and edges of A and B into the facets of the sum.
class FacetMaker {
public:
    FacetMaker(SumAssembler& sum, bool holds_line) : sum_(sum), holds_line_(holds_line) {}

    /// Facet `facet` of A and B's face along its normal.
    void add_facet_of_a(std::uint32_t facet, const SupportFace& face_b)
    {
        const SumFacet source = face_b.dimension == 2
                                    ? SumFacet{FacetOrigin::both, 1, facet, face_b.item}
                                    : SumFacet{FacetOrigin::a, 1, facet, no_facet};
        add(source, {2, first_point(sum_.a(), sum_.a().facet_loop(facet)), facet}, face_b);
    }

    /// Facet `facet` of B and A's face along its normal, which is no facet.
    void add_facet_of_b(std::uint32_t facet, const SupportFace& face_a)
    {
        add({FacetOrigin::b, 1, no_facet, facet}, face_a,
            {2, first_point(sum_.b(), sum_.b().facet_loop(facet)), facet});
    }

    /// An edge of A swept along one of B; the outward normal is turn (edge a x edge b).
    void add_swept(std::uint32_t edge_a, std::uint32_t edge_b, int turn)
    {
        const PolyhedronEdge& a = sum_.a().edges()[edge_a];
        const PolyhedronEdge& b = sum_.b().edges()[edge_b];
        const SumFacet source = {FacetOrigin::swept, static_cast<std::int8_t>(turn), edge_a,
                                 edge_b};
        if (holds_line_) {
            sum_.add_half_space(source, {Kind::point, a.from, b.from});
            return;
        }
        const bool a_ends = !sum_.a().is_ray(a.to);
        const bool b_ends = !sum_.b().is_ray(b.to);
        auto& corners = sum_.corners();
        const std::size_t begin = corners.size();
        corners.push_back({Kind::point, a.from, b.from});
        corners.push_back(a_ends ? SumCorner{Kind::point, a.to, b.from}
                                 : SumCorner{Kind::ray_of_a, a.to, 0});
        if (a_ends && b_ends) corners.push_back({Kind::point, a.to, b.to});
        corners.push_back(b_ends ? SumCorner{Kind::point, a.from, b.to}
                                 : SumCorner{Kind::ray_of_b, 0, b.to});
        if (turn < 0)
            std::reverse(corners.begin() + static_cast<std::ptrdiff_t>(begin), corners.end());
        sum_.add_facet(source);
    }

private:
    static std::uint32_t first_point(const ConvexPolyhedron& polyhedron, Loop loop)
    {
        for (const std::uint32_t vertex : loop) {
            if (!polyhedron.is_ray(vertex)) return vertex;
        }
        return 0;
    }

    void add(const SumFacet& source, const SupportFace& face_a, const SupportFace& face_b)
    {
        if (holds_line_) {
            sum_.add_half_space(source, {Kind::point, face_a.vertex, face_b.vertex});
            return;
        }
        auto& corners = sum_.corners();
        if (face_b.dimension == 0 || face_a.dimension == 0) {
            const bool moves_a = face_b.dimension == 0;
            const Loop loop =
                moves_a ? sum_.a().facet_loop(face_a.item) : sum_.b().facet_loop(face_b.item);
            for (const std::uint32_t vertex : loop) {
                if (moves_a) {
                    corners.push_back(sum_.a().is_ray(vertex)
                                          ? SumCorner{Kind::ray_of_a, vertex, 0}
                                          : SumCorner{Kind::point, vertex, face_b.vertex});
                } else {
                    corners.push_back(sum_.b().is_ray(vertex)
                                          ? SumCorner{Kind::ray_of_b, 0, vertex}
                                          : SumCorner{Kind::point, face_a.vertex, vertex});
                }
            }
        } else {
            const auto normal = source.origin == FacetOrigin::b ? sum_.b().normal_factors(source.b)
                                                                : sum_.a().normal_factors(source.a);
            const FaceVertices vertices_a(sum_.a(), face_a);
            const FaceVertices vertices_b(sum_.b(), face_b);
            PROXIMA_CHECK(append_face_sum(vertices_a.view(), vertices_b.view(), normal, corners));
        }
        sum_.add_facet(source);
    }

    SumAssembler& sum_;
    bool holds_line_;
};

/// Walks the arcs of one map ("ours") through the regions of another ("theirs").
template <class Scalar>
class ArcWalk {
public:
    ArcWalk(const ConvexPolyhedron& ours, const ConvexPolyhedron& theirs)
        : ours_(ours), theirs_(theirs)
    {}

    /// An edge with its facets as seen by one who goes from the facet `from` to the facet `to`.
    struct Arc {
        std::uint32_t from;
        std::uint32_t to;
        Displacement along; ///< the edge, with `from` at its left
    };
    [[nodiscard]] Arc arc(const PolyhedronEdge& edge, std::uint32_t from) const
    {
        Displacement along = ours_.direction(edge);
        if (from == edge.left) return {edge.left, edge.right, along};
        std::swap(along.from, along.to);
        return {edge.right, edge.left, along};
    }

    /// Goes along the arc from the face that theirs has at its start. crossing(edge, out) is called
    /// for every edge of theirs whose arc is crossed, until it returns false; out is +1 if the edge
    /// runs the way the walk goes, -1 if against it. Returns the vertex of theirs where the walk
    /// ends. `place` is where to look first in the loop of a facet at the start, and where to look
    /// next time: neighbouring arcs leave by neighbouring vertices.
    template <class Crossing>
    std::uint32_t walk(const Arc& arc, const SupportFace& start, std::size_t& place,
                       Crossing crossing) const
    {
        std::uint32_t at = foremost(arc.to, start, place);
        while (true) {
            const PolyhedronNeighbour* exit = nullptr;
            std::uint32_t through = no_facet;
            for (const PolyhedronNeighbour& next : theirs_.neighbours(at)) {
                const Displacement step = {theirs_.vertex(at), theirs_.vertex(next.vertex)};
                if (ours_.template normal_sign<Scalar>(arc.to, step) <= 0) continue;
                const PolyhedronEdge& edge = theirs_.edges()[next.edge];
                const bool forward = edge.from == at;
                const std::uint32_t left = forward ? edge.left : edge.right;
                const std::uint32_t right = forward ? edge.right : edge.left;
                const int left_sign = theirs_.template normal_sign<Scalar>(left, arc.along);
                if (left_sign < 0) continue;
                const int right_sign = theirs_.template normal_sign<Scalar>(right, arc.along);
                if (right_sign > 0) continue;
                if (left_sign > 0 && right_sign < 0) {
                    if (!crossing(next.edge, forward ? 1 : -1)) return at;
                    exit = &next;
                } else {
                    through = left_sign == 0 ? left : right;
                }
                break;
            }
            if (exit != nullptr) {
                at = exit->vertex;
            } else if (through != no_facet) {
                const auto loop = theirs_.facet_loop(through);
                auto here = static_cast<std::size_t>(std::ranges::find(loop, at) - loop.begin());
                at = foremost(arc.to, {2, at, through}, here);
            } else {
                return at;
            }
        }
    }

private:
    /// The vertex of a face of theirs that is farthest along the normal of our facet: uphill along
    /// the loop from a place in it.
    [[nodiscard]] std::uint32_t foremost(std::uint32_t our_facet, const SupportFace& face,
                                         std::size_t& place) const
    {
        if (face.dimension == 0) return face.vertex;
        const FaceVertices vertices(theirs_, face);
        const auto loop = vertices.view().vertices;
        const auto is_higher = [&](std::size_t from, std::size_t to) {
            const Displacement step = {theirs_.vertex(loop[from]), theirs_.vertex(loop[to])};
            return ours_.template normal_sign<Scalar>(our_facet, step) > 0;
        };
        place %= loop.size();
        const auto after = [&](std::size_t i) { return i + 1 == loop.size() ? 0 : i + 1; };
        const auto before = [&](std::size_t i) { return (i == 0 ? loop.size() : i) - 1; };
        while (is_higher(place, after(place))) place = after(place);
        while (is_higher(place, before(place))) place = before(place);
        return loop[place];
    }

    const ConvexPolyhedron& ours_;
    const ConvexPolyhedron& theirs_;
};

/// The edges around each facet, in the order of its loop.
class FacetGraph {
public:
    explicit FacetGraph(const ConvexPolyhedron& polyhedron)
        : first_(polyhedron.facet_count() + 1, 0), edges_(2 * polyhedron.edges().size())
    {
        for (const PolyhedronEdge& edge : polyhedron.edges()) {
            ++first_[edge.left + 1];
            ++first_[edge.right + 1];
        }
        for (std::size_t f = 0; f + 1 < first_.size(); ++f) first_[f + 1] += first_[f];
        std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
        for (std::uint32_t e = 0; e < polyhedron.edges().size(); ++e) {
            edges_[next[polyhedron.edges()[e].left]++] = e;
            edges_[next[polyhedron.edges()[e].right]++] = e;
        }
        std::vector<std::uint32_t> place(polyhedron.vertex_count(), 0);
        for (std::uint32_t f = 0; f < polyhedron.facet_count(); ++f) {
            const auto loop = polyhedron.facet_loop(f);
            if (loop.size() <= 4) continue; // no matter
            for (std::uint32_t i = 0; i < loop.size(); ++i) place[loop[i]] = i;
            const auto start_of = [&](std::uint32_t e) {
                const PolyhedronEdge& edge = polyhedron.edges()[e];
                return place[edge.left == f ? edge.from : edge.to];
            };
            std::ranges::sort(edges_.begin() + first_[f], edges_.begin() + first_[f + 1], {},
                              start_of);
        }
    }

    [[nodiscard]] std::span<const std::uint32_t> edges(std::uint32_t facet) const noexcept
    {
        return std::span(edges_).subspan(first_[facet], first_[facet + 1] - first_[facet]);
    }

private:
    std::vector<std::uint32_t> first_;
    std::vector<std::uint32_t> edges_;
};

/// Both are polygons or bodies.
template <class Scalar>
class Overlay {
public:
    Overlay(const ConvexPolyhedron& a, const ConvexPolyhedron& b, bool holds_line,
            Progress* progress)
        : sum_(a, b), facets_(sum_, holds_line), progress_(progress),
          is_taken_(b.facet_count(), false)
    {}

    Result<MinkowskiSum> build(bool holds_line)
    {
        if (progress_ != nullptr) {
            progress_->begin_stage("summing polyhedra",
                                   sum_.a().facet_count() + sum_.b().facet_count());
        }
        const bool bodies = sum_.a().dimension() == 3 && sum_.b().dimension() == 3;
        const bool done = bodies && sum_.b().is_bounded()   ? walk_arcs_of_a()
                          : bodies && sum_.a().is_bounded() ? walk_arcs_of_b()
                                                            : compare_all_arcs();
        if (sum_.corners().size() > max_sum_corners) {
            return fail(ErrorCode::limit_exceeded,
                        "the sum's facets have more than 2^28 corners together: sum coarser "
                        "polyhedra");
        }
        if (!done) return fail(ErrorCode::cancelled, "stopped on request");
        return holds_line ? std::move(sum_).finish_with_line() : std::move(sum_).finish();
    }

private:
    [[nodiscard]] bool go_on()
    {
        if (progress_ != nullptr) progress_->advance(1);
        return has_room();
    }

    /// Whether neither the sum has grown too large nor somebody asked to stop.
    [[nodiscard]] bool has_room()
    {
        return sum_.corners().size() <= max_sum_corners && !is_cancelled(progress_);
    }

    void add_facet_of_a(std::uint32_t facet, const SupportFace& face_b)
    {
        if (face_b.dimension == 2) is_taken_[face_b.item] = true;
        facets_.add_facet_of_a(facet, face_b);
    }

    /// Facet of B, unless A has one of that normal.
    void add_facet_of_b(std::uint32_t facet, const SupportFace& face_a)
    {
        if (face_a.dimension < 2) facets_.add_facet_of_b(facet, face_a);
    }

    /// Goes over all facets of `ours`, neighbour by neighbour, and over every edge once:
    /// facet_found (facet, face of theirs there), and crossing(our edge, their edge, turn) as
    /// add_swept has it with ours as A.
    template <class FacetFound, class Crossing>
    [[nodiscard]] bool walk_map(const ConvexPolyhedron& ours, const ConvexPolyhedron& theirs,
                                FacetFound facet_found, Crossing crossing)
    {
        const ArcWalk<Scalar> walk(ours, theirs);
        const FacetGraph graph(ours);
        struct Visit {
            std::uint32_t facet;
            SupportFace theirs;
        };
        std::vector<bool> is_met(ours.facet_count(), false);
        std::vector<bool> is_walked(ours.edges().size(), false);
        std::vector<Visit> to_do = {{0, support_face<Scalar>(theirs, ours, 0, 0)}};
        is_met[0] = true;
        while (!to_do.empty()) {
            const Visit visit = to_do.back();
            to_do.pop_back();
            if (!go_on()) return false;
            facet_found(visit.facet, visit.theirs);
            std::size_t place = 0;
            for (const std::uint32_t e : graph.edges(visit.facet)) {
                if (is_walked[e]) continue;
                is_walked[e] = true;
                const PolyhedronEdge& edge = ours.edges()[e];
                const typename ArcWalk<Scalar>::Arc arc = walk.arc(edge, visit.facet);
                const int from_left = visit.facet == edge.left ? 1 : -1;
                const std::uint32_t end =
                    walk.walk(arc, visit.theirs, place, [&](std::uint32_t their_edge, int out) {
                        crossing(e, their_edge, -out * from_left);
                        return has_room();
                    });
                if (!has_room()) return false;
                if (is_met[arc.to]) continue;
                is_met[arc.to] = true;
                to_do.push_back({arc.to, support_face<Scalar>(theirs, ours, arc.to, end)});
            }
        }
        return true;
    }

    /// The facets of `theirs`, each with the face of ours there, climbing from a neighbour's.
    template <class FacetFound>
    [[nodiscard]] bool visit_facets(const ConvexPolyhedron& theirs, const ConvexPolyhedron& ours,
                                    FacetFound facet_found)
    {
        const FacetGraph graph(theirs);
        struct Visit {
            std::uint32_t facet;
            std::uint32_t start;
        };
        std::vector<bool> is_met(theirs.facet_count(), false);
        std::vector<Visit> to_do = {{0, 0}};
        is_met[0] = true;
        std::uint32_t last = 0;
        while (!to_do.empty()) {
            auto [facet, start] = to_do.back();
            to_do.pop_back();
            if (!go_on()) return false;
            const auto sign_along = [&, f = facet](const Displacement& d) noexcept {
                return theirs.template normal_sign<Scalar>(f, d);
            };
            if (ends_along(ours, sign_along)) {
                if (sign_along({ours.vertex(start), ours.vertex(last)}) > 0) start = last;
                const SupportFace face = support_face<Scalar>(ours, theirs, facet, start);
                start = face.vertex;
                last = face.vertex;
                facet_found(facet, face);
            }
            for (const std::uint32_t e : graph.edges(facet)) {
                const PolyhedronEdge& edge = theirs.edges()[e];
                const std::uint32_t next = edge.left == facet ? edge.right : edge.left;
                if (is_met[next]) continue;
                is_met[next] = true;
                to_do.push_back({next, start});
            }
        }
        return true;
    }

    [[nodiscard]] bool walk_arcs_of_a()
    {
        return walk_map(
                   sum_.a(), sum_.b(),
                   [&](std::uint32_t facet, const SupportFace& face) {
                       add_facet_of_a(facet, face);
                   },
                   [&](std::uint32_t edge_a, std::uint32_t edge_b, int turn) {
                       facets_.add_swept(edge_a, edge_b, turn);
                   }) &&
               add_other_facets_of_b();
    }

    /// The same with the roles exchanged: edge b x edge a = -(edge a x edge b).
    [[nodiscard]] bool walk_arcs_of_b()
    {
        const bool walked = walk_map(
            sum_.b(), sum_.a(),
            [&](std::uint32_t facet, const SupportFace& face) { add_facet_of_b(facet, face); },
            [&](std::uint32_t edge_b, std::uint32_t edge_a, int turn) {
                facets_.add_swept(edge_a, edge_b, -turn);
            });
        return walked && add_facets_of_a();
    }

    [[nodiscard]] bool add_facets_of_a()
    {
        return visit_facets(sum_.a(), sum_.b(), [&](std::uint32_t facet, const SupportFace& face) {
            add_facet_of_a(facet, face);
        });
    }

    [[nodiscard]] bool add_other_facets_of_b()
    {
        return visit_facets(sum_.b(), sum_.a(), [&](std::uint32_t facet, const SupportFace& face) {
            if (!is_taken_[facet]) add_facet_of_b(facet, face);
        });
    }

    [[nodiscard]] bool compare_all_arcs()
    {
        if (!add_facets_of_a() || !add_other_facets_of_b()) return false;
        const ConvexPolyhedron& a = sum_.a();
        const ConvexPolyhedron& b = sum_.b();
        for (std::uint32_t e = 0; e < a.edges().size(); ++e) {
            if (!has_room()) return false;
            for (std::uint32_t g = 0; g < b.edges().size(); ++g) {
                const ArcCrossing crossing = arcs_cross<Scalar>(a, a.edges()[e], b, b.edges()[g]);
                if (crossing != ArcCrossing::none)
                    facets_.add_swept(e, g, static_cast<int>(crossing));
            }
        }
        return true;
    }

    SumAssembler sum_;
    FacetMaker facets_;
    Progress* progress_;
    std::vector<bool> is_taken_; ///< facets of B that are parallel to one of A
};

/// One of both is a segment or a half-line.
template <class Scalar>
class Sweep {
public:
    Sweep(const ConvexPolyhedron& a, const ConvexPolyhedron& b, bool holds_line)
        : sum_(a, b), facets_(sum_, holds_line), line_is_b_(b.dimension() == 1)
    {}

    MinkowskiSum build(bool holds_line)
    {
        const ConvexPolyhedron& body = line_is_b_ ? sum_.a() : sum_.b();
        const ConvexPolyhedron& line = line_is_b_ ? sum_.b() : sum_.a();
        const Displacement along = line.direction(line.edges()[0]);
        const bool ends = line.is_bounded();
        for (std::uint32_t f = 0; f < body.facet_count(); ++f) {
            const int sign = body.template normal_sign<Scalar>(f, along);
            if (sign > 0 && !ends) continue;
            const std::uint32_t end = sign > 0 ? 1 : 0;
            const SupportFace face = sign == 0 ? SupportFace{1, 0, 0} : SupportFace{0, end, end};
            if (line_is_b_) {
                facets_.add_facet_of_a(f, face);
            } else {
                facets_.add_facet_of_b(f, face);
            }
        }
        for (std::uint32_t e = 0; e < body.edges().size(); ++e) {
            const PolyhedronEdge& edge = body.edges()[e];
            const int left = body.template normal_sign<Scalar>(edge.left, along);
            if (left == 0 || body.template normal_sign<Scalar>(edge.right, along) != -left)
                continue;
            if (line_is_b_) {
                facets_.add_swept(e, 0, left);
            } else {
                facets_.add_swept(0, e, -left);
            }
        }
        return holds_line ? std::move(sum_).finish_with_line() : std::move(sum_).finish();
    }

private:
    SumAssembler sum_;
    FacetMaker facets_;
    bool line_is_b_;
};

/// Both are segments or half-lines.
MinkowskiSum sum_of_lines(const ConvexPolyhedron& a, const ConvexPolyhedron& b)
{
    SumAssembler sum(a, b);
    FacetMaker facets(sum, false);
    const Displacement along_a = a.direction(a.edges()[0]);
    const Displacement along_b = b.direction(b.edges()[0]);
    if (!are_parallel(along_a, along_b)) {
        facets.add_swept(0, 0, 1);
        facets.add_swept(0, 0, -1);
        return std::move(sum).finish();
    }
    // From the ends that lie back to those that lie ahead, as A points.
    const bool same = point_same_way(along_a, along_b);
    SumCorner back = {Kind::point, 0, same ? 0U : 1U};
    SumCorner ahead = {Kind::point, 1, same ? 1U : 0U};
    if (!b.is_bounded()) {
        back.b = 0;
        ahead = {Kind::ray_of_b, 0, 1};
        if (!same) back.a = 1;
    }
    if (!a.is_bounded()) ahead = {Kind::ray_of_a, 1, 0};
    return std::move(sum).finish_line({back, ahead});
}

/// One of both is a point: the other one, moved.
MinkowskiSum sum_with_point(const ConvexPolyhedron& a, const ConvexPolyhedron& b)
{
    SumAssembler sum(a, b);
    FacetMaker facets(sum, false);
    const bool point_is_b = b.dimension() == 0;
    const ConvexPolyhedron& moved = point_is_b ? a : b;
    if (moved.dimension() < 2) {
        std::vector<SumCorner> ends;
        for (std::uint32_t v = 0; v < moved.vertex_count(); ++v) {
            const Kind ray = point_is_b ? Kind::ray_of_a : Kind::ray_of_b;
            const std::uint32_t zero = 0;
            ends.push_back({moved.is_ray(v) ? ray : Kind::point, point_is_b ? v : zero,
                            point_is_b ? zero : v});
        }
        return std::move(sum).finish_line(ends);
    }
    for (std::uint32_t f = 0; f < moved.facet_count(); ++f) {
        if (point_is_b) {
            facets.add_facet_of_a(f, {});
        } else {
            facets.add_facet_of_b(f, {});
        }
    }
    return std::move(sum).finish();
}

bool rays_span_a_line(const ConvexPolyhedron& a, const ConvexPolyhedron& b)
{
    if (a.is_bounded() || b.is_bounded()) return false;
    std::vector<Vec3> rays(a.rays().begin(), a.rays().end());
    rays.insert(rays.end(), b.rays().begin(), b.rays().end());
    return span_a_line(rays);
}

} // namespace

template <class Scalar>
Result<MinkowskiSum> sum_by_arcs(const ConvexPolyhedron& a, const ConvexPolyhedron& b,
                                 Progress* progress)
{
    if (a.dimension() == 0 || b.dimension() == 0) return sum_with_point(a, b);
    const bool holds_line = rays_span_a_line(a, b);
    if (holds_line && a.dimension() < 3 && b.dimension() < 3) {
        return fail(ErrorCode::invalid_argument,
                    "the sum of these unbounded flat sets holds a whole line: cut one of them off");
    }
    if (a.dimension() == 1 && b.dimension() == 1) return sum_of_lines(a, b);
    if (a.dimension() == 1 || b.dimension() == 1)
        return Sweep<Scalar>(a, b, holds_line).build(holds_line);
    return Overlay<Scalar>(a, b, holds_line, progress).build(holds_line);
}

template Result<MinkowskiSum> sum_by_arcs<double>(const ConvexPolyhedron&, const ConvexPolyhedron&,
                                                  Progress*);
template Result<MinkowskiSum> sum_by_arcs<Counted>(const ConvexPolyhedron&, const ConvexPolyhedron&,
                                                   Progress*);

} // namespace proxima::detail
