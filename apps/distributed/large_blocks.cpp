// Large blocks of proxima-mpi lie in huge pages where the system offers them: arrays of a rank's
// triangles are made, sent and dropped one after the other, and clearing small pages for them would
// take a quarter of the time.
#include <cstddef>
#include <cstdlib>
#include <new>
#include <sys/mman.h>

namespace {

constexpr std::size_t huge_page = std::size_t{2} << 20U;
constexpr std::size_t large_block = 2 * huge_page;

/// Null where memory runs out.
void* allocate(std::size_t bytes) noexcept
{
    if (bytes < large_block) return std::malloc(bytes == 0 ? 1 : bytes);
    if (bytes > static_cast<std::size_t>(-1) - huge_page) return nullptr;
    const std::size_t pages = (bytes + huge_page - 1) / huge_page * huge_page;
    void* const memory = std::aligned_alloc(huge_page, pages);
    // A wish: without huge pages everything works the same, only slower.
    if (memory != nullptr) (void)madvise(memory, pages, MADV_HUGEPAGE);
    return memory;
}

} // namespace

void* operator new(std::size_t bytes)
{
    void* const memory = allocate(bytes);
    if (memory == nullptr) throw std::bad_alloc();
    return memory;
}

void operator delete(void* memory) noexcept
{
    std::free(memory);
}

void operator delete(void* memory, std::size_t /*bytes*/) noexcept
{
    std::free(memory);
}
