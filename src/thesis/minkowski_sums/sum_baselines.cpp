#include "thesis/minkowski_sums/sum_baselines.h"

#include "base/progress.h"
#include "geometry/length.h"
#include "minkowski/operation_counts.h"
#include "minkowski/scalar_vector.h"
#include "minkowski/sum_assembler.h"
#include "thesis/minkowski_sums/geometric_method.h"
#include "thesis/minkowski_sums/incremental_hull.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <vector>

namespace proxima::detail {
namespace {

/// Sums of vertices are numbered i + |A| j.
class PlanesToSum {
public:
    PlanesToSum(const ConvexPolyhedron& a, const ConvexPolyhedron& b, std::span<const Vec3> sums)
        : a_(a), b_(b), sums_(sums), assembler_(a, b)
    {
        for (const Vec3& sum : sums) reach_ = reach_.cwiseMax(sum.cwiseAbs());
    }

    /// A facet for each set of sums that is farthest along one of the normals.
    std::optional<MinkowskiSum> build(const std::vector<Vec3>& normals)
    {
        std::map<std::vector<int>, Vec3> planes;
        for (const Vec3& normal : normals) planes.emplace(farthest_along(normal), normal);
        if (planes.empty()) return std::nullopt;
        std::vector<int> facets_of(sums_.size(), 0);
        for (const auto& [pairs, normal] : planes) {
            for (const int pair : pairs) ++facets_of[static_cast<std::size_t>(pair)];
        }
        for (const auto& [pairs, normal] : planes) {
            std::vector<int> corners;
            std::ranges::copy_if(pairs, std::back_inserter(corners), [&](int pair) {
                return facets_of[static_cast<std::size_t>(pair)] >= 3;
            });
            const std::optional<SumFacet> source = source_of(pairs, normal);
            if (corners.size() < 3 || !source) return std::nullopt;
            sort_around(corners, normal);
            for (const int pair : corners)
                assembler_.corners().push_back({SumCorner::Kind::point, of_a(pair), of_b(pair)});
            assembler_.add_facet(*source);
        }
        return std::move(assembler_).finish();
    }

private:
    [[nodiscard]] std::uint32_t of_a(int pair) const
    {
        return static_cast<std::uint32_t>(static_cast<std::size_t>(pair) % a_.points().size());
    }
    [[nodiscard]] std::uint32_t of_b(int pair) const
    {
        return static_cast<std::uint32_t>(static_cast<std::size_t>(pair) / a_.points().size());
    }

    [[nodiscard]] std::vector<int> farthest_along(const Vec3& normal) const
    {
        const double tolerance = 64 * unit_roundoff * normal.cwiseAbs().dot(reach_);
        double farthest = -std::numeric_limits<double>::infinity();
        for (const Vec3& sum : sums_) farthest = std::max(farthest, normal.dot(sum));
        std::vector<int> pairs;
        for (std::size_t k = 0; k < sums_.size(); ++k) {
            if (normal.dot(sums_[k]) >= farthest - tolerance) pairs.push_back(static_cast<int>(k));
        }
        return pairs;
    }

    /// Counter-clockwise about the normal.
    void sort_around(std::vector<int>& corners, const Vec3& normal) const
    {
        Vec3 centre = Vec3::Zero();
        for (const int pair : corners) centre += sum(pair) / static_cast<double>(corners.size());
        const Vec3 u = unit_of(sum(corners[0]) - centre);
        const Vec3 v = unit_of(normal).cross(u);
        const auto angle = [&](int pair) {
            const Vec3 d = sum(pair) - centre;
            return std::atan2(v.dot(d), u.dot(d));
        };
        std::ranges::sort(corners, {}, angle);
    }
    [[nodiscard]] const Vec3& sum(int pair) const { return sums_[static_cast<std::size_t>(pair)]; }

    /// Finds the facet or edge of a polyhedron with these vertices; facets first.
    struct Part {
        int dimension;
        std::uint32_t item;
    };
    [[nodiscard]] static Part part_of(const ConvexPolyhedron& polyhedron,
                                      const std::set<std::uint32_t>& vertices, const Vec3& normal)
    {
        for (std::uint32_t f = 0; f < polyhedron.facet_count(); ++f) {
            const auto loop = polyhedron.facet_loop(f);
            const bool all_there = std::ranges::all_of(
                loop, [&](std::uint32_t vertex) { return vertices.count(vertex) == 1; });
            if (all_there && polyhedron.scaled_normal(f).dot(normal) > 0) return {2, f};
        }
        for (std::uint32_t e = 0; e < polyhedron.edges().size(); ++e) {
            const PolyhedronEdge& edge = polyhedron.edges()[e];
            if (vertices.count(edge.from) == 1 && vertices.count(edge.to) == 1) return {1, e};
        }
        return {0, *vertices.begin()};
    }

    [[nodiscard]] std::optional<SumFacet> source_of(const std::vector<int>& pairs,
                                                    const Vec3& normal) const
    {
        std::set<std::uint32_t> vertices_a;
        std::set<std::uint32_t> vertices_b;
        for (const int pair : pairs) {
            vertices_a.insert(of_a(pair));
            vertices_b.insert(of_b(pair));
        }
        const Part a = part_of(a_, vertices_a, normal);
        const Part b = part_of(b_, vertices_b, normal);
        if (a.dimension == 2 && b.dimension == 2)
            return SumFacet{FacetOrigin::both, 1, a.item, b.item};
        if (a.dimension == 2) return SumFacet{FacetOrigin::a, 1, a.item, no_facet};
        if (b.dimension == 2) return SumFacet{FacetOrigin::b, 1, no_facet, b.item};
        if (a.dimension != 1 || b.dimension != 1) return std::nullopt;
        const Vec3 along_a = a_.direction(a_.edges()[a.item]).rounded();
        const Vec3 along_b = b_.direction(b_.edges()[b.item]).rounded();
        const bool plus = along_a.cross(along_b).dot(normal) > 0;
        return SumFacet{FacetOrigin::swept, static_cast<std::int8_t>(plus ? 1 : -1), a.item,
                        b.item};
    }

    const ConvexPolyhedron& a_;
    const ConvexPolyhedron& b_;
    std::span<const Vec3> sums_;
    Vec3 reach_ = Vec3::Zero();
    SumAssembler assembler_;
};

Status check_operands(const ConvexPolyhedron& a, const ConvexPolyhedron& b)
{
    if (!a.is_bounded() || !b.is_bounded()) {
        return fail(ErrorCode::invalid_argument,
                    "this method sums bounded polyhedra only: use arcs, or cut them off first");
    }
    if (a.points().size() * b.points().size() > max_baseline_pairs) {
        return fail(ErrorCode::limit_exceeded,
                    "this method is a baseline for small polyhedra, at most 4,096 pairs of "
                    "vertices: use arcs");
    }
    return {};
}

template <class Scalar>
std::vector<Vector3<Scalar>> to_scalars(std::span<const Vec3> vectors)
{
    std::vector<Vector3<Scalar>> result;
    result.reserve(vectors.size());
    for (const Vec3& v : vectors) result.push_back(to_scalar<Scalar>(v));
    return result;
}

template <class Scalar>
Vec3 to_plain(const Vector3<Scalar>& v)
{
    return {to_double(v.x()), to_double(v.y()), to_double(v.z())};
}

/// The vertices of both, and their sums.
template <class Scalar>
struct Vertices {
    std::vector<Vector3<Scalar>> a;
    std::vector<Vector3<Scalar>> b;
    std::vector<Vector3<Scalar>> sums;
    std::vector<Vec3> plain_sums;

    Vertices(const ConvexPolyhedron& polyhedron_a, const ConvexPolyhedron& polyhedron_b)
        : a(to_scalars<Scalar>(polyhedron_a.points())),
          b(to_scalars<Scalar>(polyhedron_b.points())), sums(a.size() * b.size())
    {
        form_sum_vertices<Scalar>(a, b, sums);
        for (const Vector3<Scalar>& sum : sums) plain_sums.push_back(to_plain(sum));
    }
};

template <class Scalar>
CandidateNormal<Scalar> candidate(const Vec3& u, const Vec3& v)
{
    return {cross(to_scalar<Scalar>(u), to_scalar<Scalar>(v)), cross_magnitude(u, v),
            NormalSource::edge_pair};
}

/// N_A, N_B, and N_AB of the pairs of edges that are not parallel (thesis 3.7 to 3.9).
template <class Scalar>
std::vector<CandidateNormal<Scalar>> candidate_normals(const ConvexPolyhedron& a,
                                                       const ConvexPolyhedron& b)
{
    std::vector<CandidateNormal<Scalar>> normals;
    for (const ConvexPolyhedron* polyhedron : {&a, &b}) {
        for (std::uint32_t f = 0; f < polyhedron->facet_count(); ++f) {
            const auto factors = polyhedron->normal_factors(f);
            normals.push_back(candidate<Scalar>(factors.u.rounded(), factors.v.rounded()));
        }
    }
    for (const PolyhedronEdge& edge_a : a.edges()) {
        const Vec3 along_a = a.direction(edge_a).rounded();
        for (const PolyhedronEdge& edge_b : b.edges()) {
            const auto normal = candidate<Scalar>(along_a, b.direction(edge_b).rounded());
            if (!to_plain(normal.direction).isZero(0)) normals.push_back(normal);
        }
    }
    return normals;
}

/// Two facets at every edge, and V - E + F = 2: rounding may have lost or split facets.
bool is_closed_surface(const MinkowskiSum& sum)
{
    const bool has_border = std::ranges::any_of(sum.edges(), [](const SumEdge& edge) {
        return edge.left == no_facet || edge.right == no_facet;
    });
    return !has_border && sum.vertex_count() + sum.facet_count() == sum.edges().size() + 2;
}

Result<MinkowskiSum> sum_of_planes(const ConvexPolyhedron& a, const ConvexPolyhedron& b,
                                   std::span<const Vec3> sums, const std::vector<Vec3>& outward)
{
    auto sum = PlanesToSum(a, b, sums).build(outward);
    if (sum && is_closed_surface(*sum)) return std::move(*sum);
    return fail(ErrorCode::invalid_argument,
                "this method makes sums with a volume only, and needs facets wider than rounding: "
                "use arcs");
}

} // namespace

template <class Scalar>
Result<MinkowskiSum> sum_by_geometric_method(const ConvexPolyhedron& a, const ConvexPolyhedron& b,
                                             Progress* progress)
{
    if (Status status = check_operands(a, b); !status) return tl::unexpected(status.error());
    const Vertices<Scalar> vertices(a, b);
    const std::vector<CandidateNormal<Scalar>> normals = candidate_normals<Scalar>(a, b);

    // Works in batches and can be stopped between them.
    constexpr std::size_t batch = 256;
    std::vector<Vec3> outward;
    std::vector<SupportPlane<Scalar>> planes(2 * batch);
    begin_stage(progress, "pushing planes", normals.size());
    for (std::size_t first = 0; first < normals.size(); first += batch) {
        if (is_cancelled(progress)) return cancelled("the Minkowski sum");
        const auto some =
            std::span(normals).subspan(first, std::min(batch, normals.size() - first));
        const int count = push_planes<max_baseline_pairs, Scalar>(
            {vertices.a, vertices.b, vertices.sums}, some, planes);
        for (int i = 0; i < count; ++i)
            outward.push_back(to_plain(planes[static_cast<std::size_t>(i)].normal));
        advance_stage(progress, some.size());
    }
    return sum_of_planes(a, b, vertices.plain_sums, outward);
}

template <class Scalar>
Result<MinkowskiSum> sum_by_hull(const ConvexPolyhedron& a, const ConvexPolyhedron& b,
                                 Progress* progress)
{
    if (Status status = check_operands(a, b); !status) return tl::unexpected(status.error());
    if (is_cancelled(progress)) return cancelled("the Minkowski sum");
    const Vertices<Scalar> vertices(a, b);
    std::vector<Vec3> outward;
    if (const auto faces = incremental_hull<Scalar>(vertices.sums)) {
        for (const HullFace<Scalar>& face : *faces) outward.push_back(to_plain(face.normal));
    }
    return sum_of_planes(a, b, vertices.plain_sums, outward);
}

template Result<MinkowskiSum> sum_by_geometric_method<double>(const ConvexPolyhedron&,
                                                              const ConvexPolyhedron&, Progress*);
template Result<MinkowskiSum> sum_by_geometric_method<Counted>(const ConvexPolyhedron&,
                                                               const ConvexPolyhedron&, Progress*);
template Result<MinkowskiSum> sum_by_hull<double>(const ConvexPolyhedron&, const ConvexPolyhedron&,
                                                  Progress*);
template Result<MinkowskiSum> sum_by_hull<Counted>(const ConvexPolyhedron&, const ConvexPolyhedron&,
                                                   Progress*);

} // namespace proxima::detail
