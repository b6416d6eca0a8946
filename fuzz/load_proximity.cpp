// Feeds files with right checksums and any content to the loader of proximity octrees, queries what
// it accepts, and makes its mesh again. Seeds are octrees of the cube, the octahedron (one leaf)
// and torus:8x6 to depth 2.
#include "base/binary_file.h"
#include "exact_copy.h"
#include "index/file/proximity_file.h"
#include "index/lists/octree_mesh.h"
#include "proxima/topology.h"
#include "query/closest/closest_feature.h"

#include <cstddef>
#include <cstdint>
#include <cstdlib>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
    const auto copy = proxima::testing::exact_copy(data, size);
    proxima::reseal_binary_file({copy.get(), size});
    const auto octree = proxima::load_proximity_octree({copy.get(), size}, copy, "fuzz");
    if (!octree) return 0;
    // A lattice through the root, and points beyond it.
    const proxima::RootFrame& frame = octree->frame();
    for (int i = 0; i < 125; ++i) {
        const proxima::Vec3 at(i % 5 - 2, i / 5 % 5 - 2, i / 25 - 2);
        proxima::QuerySteps steps;
        const auto closest = closest_feature(*octree, frame.center + 0.51 * frame.half * at, steps);
        if (index(closest.triangle) >= octree->triangle_count()) std::abort();
        if (steps.steps > octree->statistics().worst_case_steps) std::abort();
        if (steps.blocks > octree->statistics().worst_case_blocks) std::abort();
    }
    if (const auto mesh = mesh_of(*octree)) {
        const auto topology = build_topology(*mesh);
        if (topology) (void)check_edges(*octree, *topology);
    }
    return 0;
}
