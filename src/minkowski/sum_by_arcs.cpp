#include "minkowski/sum_by_arcs.h"

#include "base/progress.h"
#include "geometry/exact_predicates.h"
#include "minkowski/arc_walk.h"
#include "minkowski/facet_maker.h"
#include "minkowski/facet_sign.h"
#include "minkowski/gaussian_map.h"
#include "minkowski/operation_counts.h"
#include "minkowski/span_a_line.h"
#include "minkowski/sum_assembler.h"
#include "proxima/convex_polyhedron.h"

#include <utility>
#include <vector>

namespace proxima::detail {
namespace {

/// More corners than this, of all facets together, are refused: about 10 GB.
constexpr std::size_t max_sum_corners = std::size_t{1} << 28U;

using Kind = SumCorner::Kind;

/// The sum of polygons or bodies.
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
        begin_stage(progress_, "summing polyhedra",
                    sum_.a().facet_count() + sum_.b().facet_count());
        const bool bodies = sum_.a().dimension() == 3 && sum_.b().dimension() == 3;
        const bool done = bodies && sum_.b().is_bounded()   ? walk_arcs_of_a()
                          : bodies && sum_.a().is_bounded() ? walk_arcs_of_b()
                                                            : compare_all_arcs();
        if (sum_.corners().size() > max_sum_corners) {
            return fail(ErrorCode::limit_exceeded,
                        "the sum's facets have more than 2^28 corners together: sum coarser "
                        "polyhedra");
        }
        if (!done) return cancelled("the Minkowski sum");
        return holds_line ? std::move(sum_).finish_with_line() : std::move(sum_).finish();
    }

private:
    [[nodiscard]] bool go_on()
    {
        advance_stage(progress_, 1);
        return may_continue();
    }

    /// False where the sum has grown too large, or the work is to stop.
    [[nodiscard]] bool may_continue()
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
            std::size_t position = 0;
            for (const std::uint32_t e : graph.edges(visit.facet)) {
                if (is_walked[e]) continue;
                is_walked[e] = true;
                const PolyhedronEdge& edge = ours.edges()[e];
                const typename ArcWalk<Scalar>::Arc arc = walk.arc(edge, visit.facet);
                const int from_left = visit.facet == edge.left ? 1 : -1;
                const std::uint32_t end =
                    walk.walk(arc, visit.theirs, position, [&](std::uint32_t their_edge, int out) {
                        crossing(e, their_edge, -out * from_left);
                        return may_continue();
                    });
                if (!may_continue()) return false;
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
                return normal_sign<Scalar>(theirs, f, d);
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
            if (!may_continue()) return false;
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

/// The sum where one operand is a segment or a half-line.
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
            const int sign = normal_sign<Scalar>(body, f, along);
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
            const int left = normal_sign<Scalar>(body, edge.left, along);
            if (left == 0 || normal_sign<Scalar>(body, edge.right, along) != -left) continue;
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

/// The sum of two segments or half-lines.
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
    // From the rear ends to the front ends, in A's direction.
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

/// The sum where one operand is a point: the other one, moved.
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
