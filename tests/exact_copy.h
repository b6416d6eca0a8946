// Bytes in memory of their own, so that a sanitizer sees the first one out of bounds.
#pragma once

#include <cstddef>
#include <cstring>
#include <memory>
#include <new>

namespace proxima::testing {

/// Aligned to 128 bytes, as files that are read are.
inline std::shared_ptr<std::byte> exact_copy(const void* bytes, std::size_t size)
{
    constexpr std::align_val_t alignment{128};
    struct Free {
        void operator()(std::byte* p) const { ::operator delete[](p, alignment); }
    };
    std::shared_ptr<std::byte> copy(static_cast<std::byte*>(::operator new[](size, alignment)),
                                    Free{});
    if (size > 0) std::memcpy(copy.get(), bytes, size);
    return copy;
}

} // namespace proxima::testing
