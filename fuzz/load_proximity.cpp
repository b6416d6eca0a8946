// Feeds files with right checksums and any content to the loader of proximity octrees, and queries
// what it accepts. Seeds are octrees of the cube, the octahedron (one leaf) and a torus of 96.
#include "proxima/proximity/closest_feature.h"
#include "proxima/proximity/proximity_file.h"

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <new>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
    struct Free {
        void operator()(std::byte* bytes) const
        {
            ::operator delete[](bytes, std::align_val_t{64});
        }
    };
    const std::shared_ptr<std::byte> copy(
        static_cast<std::byte*>(::operator new[](size, std::align_val_t{64})), Free{});
    if (size > 0) std::memcpy(copy.get(), data, size);
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
    return 0;
}
