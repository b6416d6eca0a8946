// Feeds files with right checksums and any content to the octree loader, and walks through what it
// accepts. Seeds are made by: proxima octree cube --depth 2 --save fuzz/corpus/octree/cube.pxo
#include "base/binary_file.h"
#include "exact_copy.h"
#include "proxima/octree.h"
#include "proxima/octree_io.h"

#include <cstddef>
#include <cstdint>
#include <cstdlib>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
    const auto copy = proxima::testing::exact_copy(data, size);
    proxima::reseal_binary_file({copy.get(), size});
    const auto octree = proxima::load_octree({copy.get(), size}, copy, "fuzz");
    if (octree) {
        const auto statistics = proxima::octree_statistics(*octree);
        if (statistics.references != octree->references().size()) std::abort();
    }
    return 0;
}
