// Bytes in memory of their own, so that a sanitizer sees the first one out of bounds.
#pragma once

#include <cstddef>
#include <cstring>
#include <memory>
#include <new>

namespace proxima::testing {

/// Aligned to 64 bytes, as mapped files are.
inline std::shared_ptr<std::byte> exact_copy(const void* bytes, std::size_t size)
{
    struct Free {
        void operator()(std::byte* p) const { ::operator delete[](p, std::align_val_t{64}); }
    };
    std::shared_ptr<std::byte> copy(
        static_cast<std::byte*>(::operator new[](size, std::align_val_t{64})), Free{});
    if (size > 0) std::memcpy(copy.get(), bytes, size);
    return copy;
}

} // namespace proxima::testing
