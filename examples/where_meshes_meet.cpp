#include <geometry/rigid_transform.h>
#include <index/build_mesh_index.h>
#include <index/slabs/build_distance_index.h>
#include <iostream>
#include <mesh/sample_meshes.h>
#include <query/contact/intersect_meshes.h>
#include <query/contact/intersection_contour.h>
#include <query/distance/mesh_distance.h>

namespace {

int failed(const proxima::Error& error)
{
    std::cerr << describe(error) << '\n';
    return 1;
}

} // namespace

int main()
{
    using namespace proxima;
    const auto ball = sample_mesh("sphere:30x30"); // the two of thesis section 5.2
    if (!ball) return failed(ball.error());
    const auto triangles = build_mesh_index(*ball);
    if (!triangles) return failed(triangles.error());
    const auto distances = build_distance_index(*triangles);
    if (!distances) return failed(distances.error());

    // A mesh and another that moves, here the same one twice: the pose is all that changes.
    for (const double x : {1.5, 2.5}) {
        const RigidTransform pose{.translation = {x, 0.1, 0.2}};
        if (meshes_intersect(*triangles, *triangles, pose)) {
            const auto pairs = intersecting_pairs(*triangles, *triangles, pose);
            const auto contour = intersection_contour(*ball, *ball, pose, pairs);
            std::cout << pairs.size() << " pairs of triangles meet, along " << contour.lines.size()
                      << " line of length " << contour.length() << '\n';
        } else {
            const MeshDistance apart = mesh_distance(*distances, *distances, pose);
            std::cout << apart.distance << " apart, from " << apart.point_a.transpose() << " to "
                      << apart.point_b.transpose() << '\n';
        }
    }
}
