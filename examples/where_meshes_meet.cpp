#include <iostream>
#include <proxima/proxima.h>

int main()
{
    using namespace proxima;
    const auto ball = sample_mesh("sphere:30x30"); // the two of thesis section 5.2
    if (!ball) return std::cerr << describe(ball.error()) << '\n', 1;
    const auto index = build_mesh_index(*ball);
    if (!index) return std::cerr << describe(index.error()) << '\n', 1;

    // A mesh and another that moves, here the same one twice: the pose is all that changes.
    for (const double x : {1.5, 2.5}) {
        const RigidTransform pose{.translation = {x, 0.1, 0.2}};
        if (const auto pairs = intersecting_pairs(*index, *index, pose); !pairs.empty()) {
            const auto contour = intersection_contour(*index, *index, pose);
            std::cout << pairs.size() << " pairs of triangles meet, along " << contour.lines.size()
                      << " line of length " << contour.length() << '\n';
        } else if (const auto apart = mesh_distance(*index, *index, pose)) {
            std::cout << apart->distance << " apart, from " << apart->point_a.transpose() << " to "
                      << apart->point_b.transpose() << '\n';
        }
    }
}
