#include <iostream>
#include <proxima/proxima.h>

int main(int argc, char** argv)
{
    using namespace proxima;
    const auto bunny =
        read_mesh(argc > 1 ? argv[1] : "/usr/share/glmark2/models/bunny.obj")
            .and_then([](const TriangleMesh& mesh) { return build_mesh_index(mesh); });
    if (!bunny) return std::cerr << describe(bunny.error()) << '\n', 1;
    // The mesh is not needed any more. Any number of threads may query the index.
    const Vec3 eye(0, 0.1, 2);
    if (const auto closest = closest_feature(*bunny, eye))
        std::cout << "closest point " << closest->point.transpose() << '\n';
    if (const auto hit = closest_hit(*bunny, {.origin = eye, .direction = Vec3(0, 0, -1)}))
        std::cout << "hit after " << hit->t << ", at triangle " << to_index(hit->triangle) << '\n';
}
