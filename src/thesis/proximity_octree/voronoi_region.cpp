#include "thesis/proximity_octree/voronoi_region.h"

#include "geometry/exact_predicates.h"
#include "proxima/convex_polyhedron.h"

#include <array>

namespace proxima {

Result<ConvexPolyhedron> voronoi_region_of_face(const Triangle& triangle)
{
    if (is_degenerate(triangle)) {
        return fail(ErrorCode::invalid_argument, "a triangle of no area has no normal");
    }
    const Vec3 normal = unit_normal({triangle[0], triangle[1]}, {triangle[0], triangle[2]});
    return convex_hull(triangle.vertices, std::array{normal});
}

Result<ConvexPolyhedron> voronoi_region_of_edge(const Vec3& p, const Vec3& q,
                                                const Vec3& left_normal, const Vec3& right_normal)
{
    return convex_hull(std::array{p, q}, std::array{left_normal, right_normal});
}

Result<ConvexPolyhedron> voronoi_region_of_vertex(const Vec3& vertex, std::span<const Vec3> normals)
{
    return convex_hull(std::array{vertex}, normals);
}

} // namespace proxima
