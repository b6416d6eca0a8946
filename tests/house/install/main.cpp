// Uses something of each layer from the installed package: header-only, compiled, in lanes,
// parallel.
#include "base/parallel.h"
#include "haptics/proxy/proxy.h"
#include "haptics/surface/contact_surface.h"
#include "index/build_mesh_index.h"
#include "index/lists/build_proximity_octree.h"
#include "mesh/sample_meshes.h"
#include "minkowski/make_polyhedron.h"
#include "minkowski/minkowski_sum.h"
#include "octree/build_octree.h"
#include "query/closest/closest_feature.h"
#include "query/rays/cast_ray.h"

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
    const auto rays = build_mesh_index(*mesh);
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
