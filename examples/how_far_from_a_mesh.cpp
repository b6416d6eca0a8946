#include <iostream>
#include <proxima/proxima.h>

int main()
{
    using namespace proxima;
    const auto index =
        sample_mesh("torus:60x40")
            .and_then([](const TriangleMesh& mesh) { return build_mesh_index(mesh); })
            .and_then([](const MeshIndex& plain) { return with_signs(plain); });
    if (!index) return std::cerr << describe(index.error()) << '\n', 1;

    // Many points, on all cores. signed_distance() takes one: no lock, no allocation.
    const std::vector<Vec3> points{Vec3(0, 0, 0), Vec3(0.8, 0, 0), Vec3(2, 1, 0)};
    std::vector<SignedDistance> answers(points.size());
    const Status done = signed_distances(*index, points, {.answers = answers});
    if (!done) return std::cerr << describe(done.error()) << '\n', 1;
    for (const SignedDistance& found : answers) {
        std::cout << (found.distance < 0 ? "inside" : "outside") << ", " << found.distance
                  << " from triangle " << to_index(found.closest.triangle) << " at "
                  << found.closest.point.transpose() << '\n';
    }
}
