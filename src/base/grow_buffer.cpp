#include "base/grow_buffer.h"

#include <cstdlib>
#include <cstring>
#include <new>

#ifdef __linux__
#include <sys/mman.h>
#endif

namespace proxima::detail {

namespace {

#ifdef __linux__

/// From here on a block is pages of its own: a few huge pages' worth.
constexpr std::size_t page_block = std::size_t{4} << 20U;

void* map_pages(std::size_t bytes)
{
    void* const memory =
        mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (memory == MAP_FAILED) throw std::bad_alloc();
    // A wish: without huge pages everything works the same, only slower.
    (void)madvise(memory, bytes, MADV_HUGEPAGE);
    return memory;
}

#endif

void* resize_heap(void* memory, std::size_t bytes)
{
    void* const moved = std::realloc(memory, bytes);
    if (moved == nullptr) throw std::bad_alloc();
    return moved;
}

} // namespace

#ifdef __linux__

void* resize_memory(void* memory, std::size_t old_bytes, std::size_t bytes)
{
    const bool was_pages = memory != nullptr && old_bytes >= page_block;
    const bool is_pages = bytes >= page_block;
    if (!was_pages && !is_pages) return resize_heap(memory, bytes);
    if (was_pages && is_pages) {
        void* const moved = mremap(memory, old_bytes, bytes, MREMAP_MAYMOVE);
        if (moved == MAP_FAILED) throw std::bad_alloc();
        (void)madvise(moved, bytes, MADV_HUGEPAGE);
        return moved;
    }
    void* const moved = is_pages ? map_pages(bytes) : resize_heap(nullptr, bytes);
    if (memory != nullptr) {
        std::memcpy(moved, memory, old_bytes < bytes ? old_bytes : bytes);
        free_memory(memory, old_bytes);
    }
    return moved;
}

void free_memory(void* memory, std::size_t bytes) noexcept
{
    if (bytes >= page_block) {
        (void)munmap(memory, bytes);
    } else {
        std::free(memory);
    }
}

#else

void* resize_memory(void* memory, std::size_t, std::size_t bytes)
{
    return resize_heap(memory, bytes);
}

void free_memory(void* memory, std::size_t) noexcept
{
    std::free(memory);
}

#endif

} // namespace proxima::detail
