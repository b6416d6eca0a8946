// Feeds files with right checksums and any content to the octree loader, and walks through what it
// accepts. Seeds are made by: proxima octree cube --depth 2 --save fuzz/corpus/octree/cube.pxo
#include "proxima/octree/octree_file.h"
#include "proxima/octree/statistics.h"

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
    const auto octree = proxima::load_octree({copy.get(), size}, copy, "fuzz");
    if (octree) {
        const auto statistics = proxima::octree_statistics(*octree);
        if (statistics.references != octree->references().size()) std::abort();
    }
    return 0;
}
