#include <iostream>
#include <proxima/proxima.h>

int main(int argc, char** argv)
{
    const auto leaves =
        proxima::read_mesh(argc > 1 ? argv[1] : "/usr/share/glmark2/models/bunny.obj")
            .and_then([](const proxima::TriangleMesh& mesh) {
                return proxima::build_octree(mesh, {.max_depth = 8, .threshold = 8});
            })
            .map(proxima::octree_statistics);
    if (!leaves) {
        std::cerr << describe(leaves.error()) << '\n';
        return 1;
    }
    std::cout << leaves->boundary << " boundary leaves, " << leaves->inner << " inside\n";
}
