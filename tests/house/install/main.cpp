// Uses something of each layer from the installed package: header-only, compiled, in lanes,
// parallel.
#include <index/build_mesh_index.h>
#include <iostream>
#include <proxima/proxima.h>
#include <query/rays/cast_ray.h>

int main()
{
    using namespace proxima;
    const auto mesh = sample_mesh("cube");
    const auto sum = minkowski_sum(*polyhedron_of_box({Vec3(0, 0, 0), Vec3(1, 1, 1)}),
                                   *polyhedron_of_box({Vec3(0, 0, 0), Vec3(1, 1, 1)}));
    const auto octree = build_octree(*mesh, {.max_depth = 3, .execution = {.threads = {2}}});
    const auto view = make_perspective_volume({});
    const auto index = build_mesh_index(*mesh);
    if (!sum || !octree || !view || !index) return 1;
    const auto hit =
        closest_hit(*index, {.origin = Vec3(0.1, 0.2, 3), .direction = Vec3(0, 0, -1)});
    if (!hit) return 1;
    std::cout << mesh->triangle_count() << ' ' << sum->facet_count() << ' '
              << octree_statistics(*octree).inner << ' ' << view->planes().size() << '\n';
    return 0;
}
