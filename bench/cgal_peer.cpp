#include "cgal_peer.h"

#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/AABB_triangle_primitive.h>
#include <CGAL/Simple_cartesian.h>
#include <malloc.h>

#include <vector>

namespace proxima::bench {
namespace {

using Kernel = CGAL::Simple_cartesian<double>;
using Triangles = std::vector<Kernel::Triangle_3>;
using Primitive = CGAL::AABB_triangle_primitive<Kernel, Triangles::const_iterator>;
using Tree = CGAL::AABB_tree<CGAL::AABB_traits<Kernel, Primitive>>;

std::size_t heap_bytes()
{
    const auto heap = mallinfo2();
    return heap.uordblks + heap.hblkhd;
}

} // namespace

struct CgalPeer::Built {
    explicit Built(const TriangleMesh& mesh)
    {
        const auto point = [](const Vec3& p) { return Kernel::Point_3(p.x(), p.y(), p.z()); };
        for (std::uint32_t i = 0; i < mesh.triangle_count(); ++i) {
            const Triangle triangle = mesh.triangle(TriangleId{i});
            const Kernel::Triangle_3 given(point(triangle[0]), point(triangle[1]),
                                           point(triangle[2]));
            if (given.is_degenerate()) continue;
            triangles.push_back(given);
            ids.push_back(TriangleId{i});
        }
        tree.insert(triangles.cbegin(), triangles.cend());
        tree.build();
        tree.accelerate_distance_queries();
    }

    Triangles triangles;
    std::vector<TriangleId> ids;
    Tree tree;
    std::size_t bytes = 0;
};

CgalPeer::CgalPeer(const TriangleMesh& mesh)
{
    const std::size_t before = heap_bytes();
    built_ = std::make_unique<Built>(mesh);
    // Its tree of points is built by the first query.
    static_cast<void>(closest(Vec3::Zero()));
    built_->bytes = heap_bytes() - before;
}

CgalPeer::~CgalPeer() = default;

PeerAnswer CgalPeer::closest(const Vec3& point)
{
    const Kernel::Point_3 query(point.x(), point.y(), point.z());
    const auto [found, primitive] = built_->tree.closest_point_and_primitive(query);
    const auto place = primitive - built_->triangles.cbegin();
    return {CGAL::squared_distance(query, found), built_->ids[static_cast<std::size_t>(place)]};
}

std::size_t CgalPeer::bytes() const
{
    return built_->bytes;
}

} // namespace proxima::bench
