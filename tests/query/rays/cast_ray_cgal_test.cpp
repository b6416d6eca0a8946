// Hits against CGAL's exact kernel: which triangles a ray meets, and at which t.
#include "octree/nasty_meshes.h"
#include "octree/small_meshes.h"
#include "proxima/cast_ray.h"
#include "proxima/mesh_index.h"
#include "proxima/octree.h"
#include "query/rays/test_rays.h"

#include <CGAL/Exact_predicates_exact_constructions_kernel.h>
#include <gtest/gtest.h>
#include <map>

namespace proxima::cast_ray_cgal_test {
namespace {

using namespace testing;
using Exact = CGAL::Exact_predicates_exact_constructions_kernel;

Exact::Point_3 exact(const Vec3& p)
{
    return {p.x(), p.y(), p.z()};
}

Exact::FT place_on(const Exact::Line_3& line, const Exact::Point_3& origin, const Exact::Point_3& p)
{
    return ((p - origin) * line.to_vector()) / line.to_vector().squared_length();
}

/// The stretch of the line's t in the triangle, if they meet.
std::optional<std::pair<Exact::FT, Exact::FT>> stretch(const Ray& ray, const Triangle& triangle)
{
    const Exact::Point_3 origin = exact(ray.origin);
    const Exact::Line_3 line(
        origin, Exact::Vector_3(ray.direction.x(), ray.direction.y(), ray.direction.z()));
    const Exact::Triangle_3 other(exact(triangle[0]), exact(triangle[1]), exact(triangle[2]));
    if (other.is_degenerate()) return std::nullopt; // CGAL wants none
    const auto found = CGAL::intersection(line, other);
    if (!found) return std::nullopt;
    if (const auto* point = boost::get<Exact::Point_3>(&*found)) {
        const Exact::FT t = place_on(line, origin, *point);
        return std::pair(t, t);
    }
    const auto& segment = boost::get<Exact::Segment_3>(*found);
    const Exact::FT a = place_on(line, origin, segment.source());
    const Exact::FT b = place_on(line, origin, segment.target());
    return a < b ? std::pair(a, b) : std::pair(b, a);
}

/// What t may be off by: three weights, each rounded as a determinant, mix the t of the corners;
/// the flatter the ray lies to the plane, the less is left of their sum.
double rounding_of_t(const Ray& ray, const Triangle& triangle)
{
    constexpr double epsilon = 0x1p-53;
    const double length = ray.direction.norm();
    int axis = 0; // along which t of corners is measured
    ray.direction.cwiseAbs().maxCoeff(&axis);
    double reach = 0;
    double first = std::numeric_limits<double>::infinity();
    double last = -first;
    for (const Vec3& p : triangle.vertices) {
        const double along = (p - ray.origin)[axis] / ray.direction[axis];
        first = std::min(first, along);
        last = std::max(last, along);
        reach = std::max(reach, (p - ray.origin).norm());
    }
    const double sum = std::abs(scaled_normal(triangle).dot(ray.direction));
    // 28 u M R each, R up to 2 M: ray_triangle-inl.h.
    const double weights = 3 * 56 * epsilon * reach * reach * length;
    const double share = weights < sum ? weights / sum : 1;
    return 8 * epsilon * reach / length + share * (last - first);
}

void compare(const TriangleMesh& mesh, int rays, std::uint64_t seed, std::size_t& met)
{
    const MeshIndex index = build_mesh_index(mesh).value();
    RayGenerator generate(mesh, seed);
    for (int i = 0; i < rays; ++i) {
        Ray ray = generate();
        ray.t_min = i % 2 == 0 ? 0 : -std::numeric_limits<double>::infinity();
        ray.t_max = std::numeric_limits<double>::infinity();
        std::map<TriangleId, double> found;
        visit_hits(index, ray, Faces::both, [&](const RayHit& hit) {
            found[hit.triangle] = hit.t;
            return Flow::proceed;
        });
        for (std::uint32_t id = 0; id < mesh.triangle_count(); ++id) {
            const Triangle triangle = mesh.triangle(TriangleId{id});
            const auto truth = stretch(ray, triangle);
            const auto hit = found.find(TriangleId{id});
            if (!truth) {
                const Exact::Triangle_3 other(exact(triangle[0]), exact(triangle[1]),
                                              exact(triangle[2]));
                EXPECT_TRUE(hit == found.end() || other.is_degenerate()) << "ray " << i;
                continue;
            }
            double first = CGAL::to_double(CGAL::exact(truth->first));
            const double last = CGAL::to_double(CGAL::exact(truth->second));
            const double slack = rounding_of_t(ray, triangle);
            if (first < ray.t_min && ray.t_min <= last) first = ray.t_min;
            if (!(std::abs(first - ray.t_min) <= slack)) { // there rounding decides
                ASSERT_EQ(hit != found.end(), first >= ray.t_min)
                    << "ray " << i << " triangle " << id;
            }
            if (hit == found.end()) continue;
            EXPECT_NEAR(hit->second, first, slack) << "ray " << i << " triangle " << id;
            ++met;
        }
        if (::testing::Test::HasFailure()) return;
    }
}

TEST(CastRayAndCgal, MeetTheSameTriangles)
{
    std::size_t met = 0;
    for (std::uint32_t seed = 0; seed < 60; ++seed) {
        SCOPED_TRACE(::testing::Message() << "seed " << seed);
        compare(nasty_mesh(seed), 20, seed, met);
        if (HasFailure()) return;
    }
    compare(torus_mesh(1.0, 0.4, 16, 12), 300, 7, met);
    EXPECT_GT(met, 2000U);
}

} // namespace
} // namespace proxima::cast_ray_cgal_test
