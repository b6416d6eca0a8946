// Feeds files with right checksums and any content to the loader of mesh indexes, queries what
// it accepts, and makes its mesh again. Seeds are indexes of the cube, the octahedron (one leaf)
// and torus:8x6 to depth 2.
#include "base/binary_file.h"
#include "base/simd.h"
#include "exact_copy.h"
#include "index/check_edges.h"
#include "index/index_parts.h"
#include "index/lists/proximity_lists.h"
#include "proxima/closest_feature.h"
#include "proxima/index_io.h"
#include "proxima/mesh_index.h"
#include "proxima/signed_distance.h"
#include "proxima/topology.h"
#include "query/ask_every_query.h"
#include "query/closest/find_closest.h"

#include <cstddef>
#include <cstdint>
#include <cstdlib>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
    const auto copy = proxima::testing::exact_copy(data, size);
    proxima::reseal_binary_file({copy.get(), size});
    const auto loaded = proxima::load_index({copy.get(), size}, copy, "fuzz");
    if (!loaded) return 0;
    // A lattice about the mesh, and points beyond it.
    for (int i = 0; i < 125; ++i) {
        const int row = i / 5 % 5;
        const int layer = i / 25;
        const proxima::Vec3 at(i % 5 - 2, row - 2, layer - 2);
        proxima::QuerySteps steps;
        const proxima::Vec3 p = loaded->parts().center() + 0.76 * loaded->parts().unscale() * at;
        const auto closest = closest_feature(*loaded, p, {}, steps);
        if (!closest || to_index(closest->triangle) >= loaded->triangle_count()) std::abort();
        if (signed_distance(*loaded, p).has_value() != loaded->has_signs()) std::abort();
        if (!loaded->has_lists()) continue;
        if (steps.steps > loaded->parts().lists()->statistics().worst_case_steps) std::abort();
        if (steps.blocks > loaded->parts().lists()->statistics().worst_case_blocks) std::abort();
    }
    for (const proxima::SimdTarget& target : proxima::simd_targets()) {
        proxima::force_simd_target(target);
        proxima::testing::EveryQuery(*loaded, size).ask();
    }
    if (const auto mesh = mesh_of(*loaded)) {
        const auto topology = build_topology(*mesh);
        if (topology) (void)check_edges(*loaded, *topology);
    }
    return 0;
}
