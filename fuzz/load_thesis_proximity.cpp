// Feeds files with right checksums and any content to the loader of the thesis's proximity octrees,
// and queries what it accepts that has the features of the octahedron. Seeds are made by:
// proxima closest octahedron --method thesis --depth 1 --point 2,2,2 --save octahedron.pxv
#include "base/binary_file.h"
#include "base/check.h"
#include "exact_copy.h"
#include "proxima/sample_meshes.h"
#include "proxima/topology.h"
#include "thesis/proximity_octree/thesis_closest.h"
#include "thesis/proximity_octree/thesis_proximity_file.h"

#include <cstddef>
#include <cstdint>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
    using namespace proxima;
    static const TriangleMesh mesh = *sample_mesh("octahedron");
    static const Topology topology = *build_topology(mesh);
    const auto copy = testing::exact_copy(data, size);
    reseal_binary_file({copy.get(), size});
    const auto octree = load_thesis_proximity_octree({copy.get(), size}, copy, "fuzz");
    if (!octree) {
        PROXIMA_CHECK(!octree.error().message.empty());
        PROXIMA_CHECK(!octree.error().where.empty());
        return 0;
    }
    const FeatureCounts& features = octree->features();
    if (features.vertices != mesh.vertex_count() || features.edges != topology.edge_count() ||
        features.faces != mesh.triangle_count())
        return 0;
    for (int i = 0; i < 125; ++i) {
        const int row = i / 5 % 5;
        const int layer = i / 25;
        const Vec3 point = 0.7 * Vec3(i % 5 - 2, row - 2, layer - 2);
        const auto closest = closest_feature(*octree, mesh, topology, point);
        if (closest) PROXIMA_CHECK_LT(to_index(closest->triangle), mesh.triangle_count());
    }
    return 0;
}
