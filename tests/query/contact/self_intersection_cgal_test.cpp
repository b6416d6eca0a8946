// Self-intersections against CGAL: of two triangles by its exact intersections, of whole meshes by
// Polygon Mesh Processing.
#include "geometry/exact_predicates.h"
#include "octree/small_meshes.h"
#include "proxima/intersect_meshes.h"
#include "proxima/mesh_index.h"
#include "proxima/sample_meshes.h"
#include "query/contact/self_intersection.h"

#include <gtest/gtest.h>

#include <CGAL/Exact_predicates_exact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/self_intersections.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/intersections.h>

#include <algorithm>
#include <random>
#include <vector>

namespace proxima::self_intersection_cgal_test {
namespace {

using namespace testing;
using Kernel = CGAL::Exact_predicates_exact_constructions_kernel;
using Point = Kernel::Point_3;

Point exact(const Vec3& p)
{
    return {p.x(), p.y(), p.z()};
}

Kernel::Triangle_3 exact(const Triangle& t)
{
    return {exact(t[0]), exact(t[1]), exact(t[2])};
}

/// Whether what two triangles have in common is more than corners of both and the side between.
struct Beyond {
    const Kernel::Triangle_3& a;
    const Kernel::Triangle_3& b;

    static bool has(const Kernel::Triangle_3& t, const Point& p)
    {
        return t[0] == p || t[1] == p || t[2] == p;
    }
    [[nodiscard]] bool is_free(const Point& p) const { return !has(a, p) || !has(b, p); }
    bool operator()(const Point& p) const { return is_free(p); }
    bool operator()(const Kernel::Segment_3& s) const
    {
        return is_free(s.source()) || is_free(s.target());
    }
    bool operator()(const Kernel::Triangle_3& /*t*/) const { return true; }
    bool operator()(const std::vector<Point>& /*polygon*/) const { return true; }
};

TEST(SelfIntersectionAndCgal, AgreeOnTwoTriangles)
{
    constexpr unsigned seed = 41;
    SCOPED_TRACE(::testing::Message() << "seed " << seed);
    std::mt19937 random(seed);
    std::array<std::array<int, 2>, 4> answers{};
    for (int i = 0; i < 30'000; ++i) {
        std::array<Triangle, 2> t;
        for (Triangle& triangle : t) {
            for (Vec3& corner : triangle.vertices) {
                for (double& x : corner) x = static_cast<double>(random() % 4);
            }
        }
        for (std::size_t k = 0, shared = random() % 4; k < shared; ++k)
            t[1].vertices[(k + i) % 3] = t[0].vertices[k];
        if (is_degenerate(t[0]) || is_degenerate(t[1])) continue;
        const Kernel::Triangle_3 a = exact(t[0]);
        const Kernel::Triangle_3 b = exact(t[1]);
        const auto common = CGAL::intersection(a, b);
        const bool expected = common && boost::apply_visitor(
                                            [&](const auto& part) {
                                                return Beyond{a, b}(part);
                                            },
                                            *common);
        ASSERT_EQ(meet_beyond_corners(t[0], t[1]), expected) << "case " << i;
        const auto shared =
            static_cast<std::size_t>(std::ranges::count_if(t[1].vertices, [&](const Vec3& corner) {
                return std::ranges::find(t[0].vertices, corner) != t[0].vertices.end();
            }));
        ++answers[shared][expected ? 1 : 0];
    }
    for (std::size_t shared = 0; shared < 3; ++shared) {
        EXPECT_GT(answers[shared][0], 100);
        EXPECT_GT(answers[shared][1], 100);
    }
    EXPECT_GT(answers[3][1], 100);
}

TEST(SelfIntersectionAndCgal, FindTheSamePairsInMeshes)
{
    constexpr unsigned seed = 42;
    SCOPED_TRACE(::testing::Message() << "seed " << seed);
    std::mt19937 random(seed);
    std::size_t found = 0;
    for (const double noise : {0.0, 0.01, 0.1, 0.3}) {
        // On a grid, so that many triangles only just meet.
        const TriangleMesh mesh = moved(torus_mesh(1, 0.4, 20, 14), [&](const Vec3& p) {
            const auto shift = [&] {
                return std::uniform_real_distribution(-noise, noise)(random);
            };
            const double x = shift();
            const double y = shift();
            return Vec3((64 * (p + Vec3(x, y, shift()))).array().round() / 64);
        });
        CGAL::Surface_mesh<Point> surface;
        for (const Vec3& p : mesh.positions()) surface.add_vertex(exact(p));
        using Vertex = CGAL::Surface_mesh<Point>::Vertex_index;
        for (const TriangleCorners& t : mesh.triangles())
            surface.add_face(Vertex(t[0]), Vertex(t[1]), Vertex(t[2]));
        ASSERT_EQ(surface.number_of_faces(), mesh.triangle_count());
        using Face = CGAL::Surface_mesh<Point>::Face_index;
        std::vector<std::pair<Face, Face>> theirs;
        CGAL::Polygon_mesh_processing::self_intersections(surface, std::back_inserter(theirs));
        std::vector<TrianglePair> truth;
        for (const auto& [f, g] : theirs) {
            const auto [low, high] = std::minmax(
                {static_cast<std::uint32_t>(f.idx()), static_cast<std::uint32_t>(g.idx())});
            if (low != high) truth.push_back({TriangleId{low}, TriangleId{high}});
        }
        std::ranges::sort(truth);
        const MeshIndex index = build_mesh_index(mesh).value();
        EXPECT_EQ(find_self_intersections(index)->pairs, truth) << "noise " << noise;
        found += truth.size();
    }
    EXPECT_GT(found, 100U);
}

} // namespace
} // namespace proxima::self_intersection_cgal_test
