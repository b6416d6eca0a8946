// Convex hulls and Minkowski sums of any points, by exact signs: every plane through three corners with
// nothing beyond it is a facet, no other one is, and no pair of corners is beyond a facet of a sum.
#include "base/check.h"
#include "decoded_mesh.h"
#include "geometry/exact_predicates.h"
#include "proxima/convex_polyhedron.h"
#include "proxima/minkowski_sum.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <set>
#include <vector>

namespace {

using namespace proxima;

using Vertices = std::vector<std::uint32_t>;

/// Points and edges less the edges of a body, which are two less than its facets.
template <class Body>
void check_euler(const Body& body)
{
    if (body.dimension() == 3)
        PROXIMA_CHECK_EQ(body.vertex_count() + body.facet_count(), body.edges().size() + 2);
}

/// Every three corners whose plane has all others on one side are in a facet, with all corners of that plane.
void check_facets(const ConvexPolyhedron& hull)
{
    if (hull.dimension() < 3) return; // a polygon has two facets
    std::set<Vertices> facets;
    for (std::uint32_t facet = 0; facet < hull.facet_count(); ++facet) {
        const auto loop = hull.facet_loop(facet);
        Vertices sorted(loop.begin(), loop.end());
        std::ranges::sort(sorted);
        PROXIMA_CHECK(facets.insert(std::move(sorted)).second);
    }
    const auto corners = hull.points();
    std::set<Vertices> planes;
    for (std::uint32_t a = 0; a < corners.size(); ++a) {
        for (std::uint32_t b = a + 1; b < corners.size(); ++b) {
            for (std::uint32_t c = b + 1; c < corners.size(); ++c) {
                bool is_any_below = false;
                bool is_any_above = false;
                Vertices on;
                for (std::uint32_t d = 0; d < corners.size(); ++d) {
                    const int side = orient3d(corners[a], corners[b], corners[c], corners[d]);
                    is_any_below = is_any_below || side < 0;
                    is_any_above = is_any_above || side > 0;
                    if (side == 0) on.push_back(d);
                }
                PROXIMA_CHECK(is_any_below || is_any_above);
                if (is_any_below != is_any_above) planes.insert(on);
            }
        }
    }
    PROXIMA_CHECK(facets == planes);
}

void check_hull(const ConvexPolyhedron& hull, const std::vector<Vec3>& points)
{
    for (const Vec3& corner : hull.points())
        PROXIMA_CHECK(std::ranges::find(points, corner) != points.end());
    for (std::uint32_t facet = 0; facet < hull.facet_count(); ++facet) {
        const auto [u, v] = hull.normal_factors(facet);
        const Vec3& corner = hull.vertex(hull.facet_loop(facet)[0]);
        for (const Vec3& p : points)
            PROXIMA_CHECK(determinant_sign(u, v, Displacement{corner, p}) <= 0);
        PROXIMA_CHECK_LE(std::abs(hull.half_space(facet).normal.norm() - 1), 1e-14);
    }
    check_euler(hull);
    check_facets(hull);
}

void check_sum(const MinkowskiSum& sum, const ConvexPolyhedron& a, const ConvexPolyhedron& b)
{
    for (std::uint32_t facet = 0; facet < sum.facet_count(); ++facet) {
        const auto [u, v] = sum.normal_factors(facet);
        const auto support = sum.support(facet);
        for (const Vec3& p : a.points())
            PROXIMA_CHECK(determinant_sign(u, v, Displacement{a.vertex(support.a), p}) <= 0);
        for (const Vec3& p : b.points())
            PROXIMA_CHECK(determinant_sign(u, v, Displacement{b.vertex(support.b), p}) <= 0);
    }
    check_euler(sum);
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
    fuzz::Bytes bytes({data, size});
    const fuzz::PositionCode code(bytes);
    std::vector<Vec3> points_a(1 + bytes.next() % 12);
    std::vector<Vec3> points_b(1 + bytes.next() % 7);
    for (Vec3& p : points_a) p = code.next(bytes);
    for (Vec3& p : points_b) p = code.next(bytes);
    const ConvexPolyhedron a = convex_hull(points_a).value();
    const ConvexPolyhedron b = convex_hull(points_b).value();
    check_hull(a, points_a);
    check_hull(b, points_b);
    const MinkowskiSum sum = minkowski_sum(a, b).value();
    const MinkowskiSum other_way = minkowski_sum(b, a).value();
    check_sum(sum, a, b);
    PROXIMA_CHECK_EQ(sum.facet_count(), other_way.facet_count());
    PROXIMA_CHECK_EQ(sum.vertex_count(), other_way.vertex_count());
    PROXIMA_CHECK_EQ(sum.edges().size(), other_way.edges().size());
    // The hull of all sums of two corners, where these are exact, has as many corners and facets.
    std::vector<Vec3> pairs;
    bool is_exact = true;
    for (const Vec3& p : a.points()) {
        for (const Vec3& q : b.points()) {
            pairs.emplace_back(p + q);
            is_exact = is_exact && pairs.back() - p == q && pairs.back() - q == p;
        }
    }
    if (is_exact) {
        const ConvexPolyhedron whole = convex_hull(pairs).value();
        PROXIMA_CHECK_EQ(whole.dimension(), sum.dimension());
        PROXIMA_CHECK_EQ(whole.facet_count(), sum.facet_count());
        PROXIMA_CHECK_EQ(whole.vertex_count(), sum.vertex_count());
    }
    const SurfacePoint nearest = signed_distance(sum, points_a[0] + points_b[0]);
    PROXIMA_CHECK(!std::isnan(nearest.distance) && nearest.direction.allFinite());
    return 0;
}
