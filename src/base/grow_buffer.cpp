#include "base/grow_buffer.h"

#include <array>
#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <new>
#include <span>

#ifdef __linux__
#include <sys/mman.h>
#endif

namespace proxima {

namespace detail {

namespace {

#ifdef __linux__

/// From here on a block is pages of its own: a few huge pages' worth.
constexpr std::size_t page_block = std::size_t{4} << 20U;

/// What a block maps: whole huge pages.
std::size_t mapped_bytes(std::size_t bytes) noexcept
{
    constexpr std::size_t huge_page = std::size_t{2} << 20U;
    return (bytes + huge_page - 1) / huge_page * huge_page;
}

/// Blocks of pages that a PageReserve keeps.
class KeptPages {
public:
    void open() noexcept { is_open_ = true; }
    void close() noexcept
    {
        is_open_ = false;
        for (const Block& block : blocks()) (void)munmap(block.memory, block.bytes);
        count_ = 0;
    }

    /// False where the block is not kept.
    bool keep(void* memory, std::size_t bytes) noexcept
    {
        if (!is_open_ || bytes < page_block || count_ == kept_.size()) return false;
        kept_[count_++] = {static_cast<std::byte*>(memory), bytes};
        return true;
    }

    /// The smallest block that is large enough, without what it has too much, or the largest one,
    /// which the caller extends. Nothing where none is kept.
    [[nodiscard]] std::span<std::byte> take(std::size_t bytes) noexcept
    {
        Block* best = nullptr;
        for (Block& block : blocks()) {
            const bool fits = block.bytes >= bytes;
            if (best == nullptr || (best->bytes < bytes ? block.bytes > best->bytes
                                                        : fits && block.bytes < best->bytes))
                best = &block;
        }
        if (best == nullptr) return {};
        const Block taken = *best;
        *best = kept_[--count_];
        if (taken.bytes <= bytes) return {taken.memory, taken.bytes};
        if (!keep(taken.memory + bytes, taken.bytes - bytes))
            (void)munmap(taken.memory + bytes, taken.bytes - bytes);
        return {taken.memory, bytes};
    }

private:
    struct Block {
        std::byte* memory;
        std::size_t bytes;
    };
    [[nodiscard]] std::span<Block> blocks() noexcept { return {kept_.data(), count_}; }

    std::array<Block, 16> kept_{};
    std::size_t count_ = 0;
    bool is_open_ = false;
};

thread_local KeptPages kept_pages;

void* map_pages(std::size_t bytes)
{
    const std::size_t mapped = mapped_bytes(bytes);
    if (const std::span<std::byte> kept = kept_pages.take(mapped); !kept.empty())
        return resize_memory(kept.data(), kept.size(), bytes);
    void* const memory =
        mmap(nullptr, mapped, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (memory == MAP_FAILED) throw std::bad_alloc();
    // A wish: without huge pages everything works the same, only slower.
    (void)madvise(memory, mapped, MADV_HUGEPAGE);
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
        const std::size_t mapped = mapped_bytes(bytes);
        if (mapped == mapped_bytes(old_bytes)) return memory;
        void* const moved = mremap(memory, mapped_bytes(old_bytes), mapped, MREMAP_MAYMOVE);
        if (moved == MAP_FAILED) throw std::bad_alloc();
        (void)madvise(moved, mapped, MADV_HUGEPAGE);
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
        const std::size_t mapped = mapped_bytes(bytes);
        if (!kept_pages.keep(memory, mapped)) (void)munmap(memory, mapped);
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

} // namespace detail

PageReserve::PageReserve() noexcept
{
#ifdef __linux__
    detail::kept_pages.open();
#endif
}

PageReserve::~PageReserve()
{
#ifdef __linux__
    detail::kept_pages.close();
#endif
}

} // namespace proxima
