#include <iostream>
#include <proxima/proxima.h>

int main()
{
    using namespace proxima;
    // Where a cube's middle may be when it touches a triangle: their sum, for the cube is
    // symmetric.
    const auto triangle = polyhedron_of_triangle({{Vec3(0, 0, 0), Vec3(3, 0, 0), Vec3(0, 3, 0)}});
    const auto cube = polyhedron_of_box({Vec3(-1, -1, -1), Vec3(1, 1, 1)});
    if (!triangle || !cube) return 1;
    const auto sum = minkowski_sum(*triangle, *cube);
    if (!sum) {
        std::cerr << describe(sum.error()) << '\n';
        return 1;
    }
    std::cout << sum->facet_count() << " facets, " << sum->vertex_count() << " vertices\n";
    for (const Vec3& p : {Vec3(1, 1, 0.5), Vec3(1, 1, 4)}) {
        std::cout << (contains(*sum, p) ? "touches" : "apart") << " by "
                  << signed_distance(*sum, p).distance << '\n';
    }
}
