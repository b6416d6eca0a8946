// Uses something of each layer from the installed package: header-only, compiled, in lanes,
// parallel.
#include <iostream>
#include <proxima/proxima.h>

int main()
{
    using namespace proxima;
    const auto mesh = sample_mesh("cube");
    const auto sum = minkowski_sum(*polyhedron_of_box({Vec3(0, 0, 0), Vec3(1, 1, 1)}),
                                   *polyhedron_of_box({Vec3(0, 0, 0), Vec3(1, 1, 1)}));
    const auto octree = build_octree(*mesh, {.max_depth = 3, .execution = {.threads = {2}}});
    const auto view = make_perspective_volume({});
    const auto index =
        build_mesh_index(*mesh).and_then([](const MeshIndex& plain) { return with_signs(plain); });
    if (!sum || !octree || !view || !index) return 1;
    const auto proximity = build_thesis_proximity(*mesh, {.max_depth = 3});
    if (!proximity) return 1;
    const Vec3 above(0.1, 0.2, 3);
    const auto hit = closest_hit(*index, {.origin = above, .direction = Vec3(0, 0, -1)});
    const auto closest = closest_feature(*index, above);
    if (!hit || !closest || !(signed_distance(*index, above)->distance > 0)) return 1;
    if (!meshes_intersect(*index, *index, {}) || !mesh_distance(*index, *index)) return 1;
    HapticRenderer renderer = make_haptic_renderer(*index, {}, *find_device("omni")).value();
    if (renderer.tick({}, 1e-3).fault != InputFault::none) return 1;
    std::cout << mesh->triangle_count() << ' ' << sum->facet_count() << ' '
              << octree_statistics(*octree).inner << ' ' << view->planes().size() << '\n';
    return 0;
}
