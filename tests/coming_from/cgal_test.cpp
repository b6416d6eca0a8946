// The two programs of docs/coming_from.md for those who know CGAL's AABB tree.
#include "coming_from/arrays.h"
#include "proxima/closest_feature.h"
#include "proxima/signed_distance.h"

#include <CGAL/AABB_face_graph_triangle_primitive.h>
#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Side_of_triangle_mesh.h>
#include <CGAL/Surface_mesh.h>
#include <gtest/gtest.h>

#include <cmath>

namespace proxima::cgal_test {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Surface = CGAL::Surface_mesh<Kernel::Point_3>;

double by_cgal(const Surface& surface, double x, double y, double z)
{
    using Primitive = CGAL::AABB_face_graph_triangle_primitive<Surface>;
    using Tree = CGAL::AABB_tree<CGAL::AABB_traits<Kernel, Primitive>>;
    Tree tree(faces(surface).first, faces(surface).second, surface);
    tree.accelerate_distance_queries();
    const CGAL::Side_of_triangle_mesh<Surface, Kernel> side(surface);

    const Kernel::Point_3 point(x, y, z);
    const double distance = std::sqrt(tree.squared_distance(point));
    return side(point) == CGAL::ON_BOUNDED_SIDE ? -distance : distance;
}

double by_proxima(const TriangleMesh& mesh, double x, double y, double z)
{
    const MeshIndex index = build_mesh_index(mesh)
                                .and_then([](const MeshIndex& plain) { return with_signs(plain); })
                                .value();

    const auto answer = signed_distance(index, Vec3(x, y, z)); // negative inside
    return answer->distance;
}

TEST(ComingFromCgal, TheSamePointsAreAsFarAndOnTheSameSide)
{
    const TriangleMesh mesh = *sample_mesh("torus:20x10");
    Surface surface;
    for (const Vec3& p : mesh.positions()) surface.add_vertex({p.x(), p.y(), p.z()});
    for (const TriangleCorners& t : mesh.triangles()) {
        surface.add_face(Surface::Vertex_index(t[0]), Surface::Vertex_index(t[1]),
                         Surface::Vertex_index(t[2]));
    }
    const Box box = bounding_box(mesh);
    int inside = 0;
    for (int i = 0; i < 27; ++i) {
        const Vec3 share(i % 3 / 2.0, i / 3 % 3 / 2.0, i / 9 / 2.0);
        const Vec3 p = box.lower + share.cwiseProduct(box.extent()) + Vec3(0.01, 0.02, 0.03);
        const double ours = by_proxima(mesh, p.x(), p.y(), p.z());
        inside += ours < 0 ? 1 : 0;
        EXPECT_NEAR(ours, by_cgal(surface, p.x(), p.y(), p.z()), 1e-12) << p.transpose();
    }
    EXPECT_GT(inside, 0);
    EXPECT_LT(inside, 27);
}

} // namespace
} // namespace proxima::cgal_test
