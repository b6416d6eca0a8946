// Uses something of each layer from the installed package: header-only, compiled, in lanes,
// parallel.
#include "proxima/base/parallel.h"
#include "proxima/haptics/contact_surface.h"
#include "proxima/haptics/proxy.h"
#include "proxima/mesh/sample_meshes.h"
#include "proxima/minkowski/make_polyhedron.h"
#include "proxima/minkowski/minkowski_sum.h"
#include "proxima/octree/build_octree.h"
#include "proxima/proximity/build_proximity_octree.h"
#include "proxima/proximity/closest_feature.h"
#include "proxima/query/build_ray_index.h"
#include "proxima/query/cast_ray.h"

#include <atomic>
#include <iostream>

int main()
{
    using namespace proxima;
    const auto mesh = sample_mesh("cube");
    const auto sum = minkowski_sum(*polyhedron_of_box({Vec3(0, 0, 0), Vec3(1, 1, 1)}),
                                   *polyhedron_of_box({Vec3(0, 0, 0), Vec3(1, 1, 1)}));
    const auto octree = build_octree(*mesh, {.max_depth = 3});
    const auto proximity = build_proximity_octree(*mesh, {.budget_bytes = 1'000'000});
    const auto rays = build_ray_index(*octree, *mesh);
    if (!sum || !octree || !proximity || !rays) return 1;
    const ClosestFeature closest = closest_feature(*proximity, Vec3(0, 0, 3));
    const auto hit = closest_hit(*rays, {Vec3(0.1, 0.2, 3), Vec3(0, 0, -1)});
    const OctreeContactSurface surface(*proximity);
    Proxy proxy(surface, {});
    proxy.place(Vec3(0.1, 0.2, 3));
    const double held = proxy.follow(Vec3(0.1, 0.2, 0.5)).held.z();
    std::atomic<int> calls{0};
    parallel_for(3, {2}, [&](std::size_t) { ++calls; });
    std::cout << mesh->triangle_count() << ' ' << sum->facet_count() << ' '
              << closest.squared_distance << ' ' << (hit ? hit->t : -1) << ' ' << held << ' '
              << calls << '\n';
    return 0;
}
