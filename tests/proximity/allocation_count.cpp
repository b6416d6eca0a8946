#include "proximity/allocation_count.h"

#include <cstddef>
#include <cstdlib>
#include <new>

namespace {

thread_local std::uint64_t allocations = 0;

void* counted_allocation(std::size_t size, std::size_t alignment)
{
    ++allocations;
    const std::size_t rounded = (size + alignment - 1) / alignment * alignment;
    void* const place = std::aligned_alloc(alignment, rounded > 0 ? rounded : alignment);
    if (place == nullptr) throw std::bad_alloc();
    return place;
}

} // namespace

std::uint64_t proxima::testing::allocation_count() noexcept
{
    return allocations;
}

// The array and nothrow forms call these.
void* operator new(std::size_t size)
{
    return counted_allocation(size, alignof(std::max_align_t));
}
void* operator new(std::size_t size, std::align_val_t alignment)
{
    return counted_allocation(size, static_cast<std::size_t>(alignment));
}
void operator delete(void* place) noexcept
{
    std::free(place);
}
void operator delete(void* place, std::size_t /*size*/) noexcept
{
    std::free(place);
}
void operator delete(void* place, std::align_val_t /*alignment*/) noexcept
{
    std::free(place);
}
void operator delete(void* place, std::size_t /*size*/, std::align_val_t /*alignment*/) noexcept
{
    std::free(place);
}
