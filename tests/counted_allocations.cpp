#include "counted_allocations.h"

#include <cstdlib>
#include <new>

namespace {

thread_local std::size_t allocations = 0;

} // namespace

#if defined(__has_feature)
#if __has_feature(thread_sanitizer)
#define PROXIMA_OPERATORS_ARE_TAKEN // by clang's thread sanitizer: nothing is counted beside it
#endif
#endif

#ifndef PROXIMA_OPERATORS_ARE_TAKEN
// NOLINTBEGIN(cppcoreguidelines-no-malloc,misc-new-delete-overloads): what they replace
void* operator new(std::size_t size)
{
    ++allocations;
    void* const memory = std::malloc(size > 0 ? size : 1);
    if (memory == nullptr) throw std::bad_alloc();
    return memory;
}

void* operator new(std::size_t size, const std::nothrow_t& /*tag*/) noexcept
{
    ++allocations;
    return std::malloc(size > 0 ? size : 1);
}

void operator delete(void* memory) noexcept
{
    std::free(memory);
}

void operator delete(void* memory, std::size_t /*size*/) noexcept
{
    std::free(memory);
}

void operator delete(void* memory, const std::nothrow_t& /*tag*/) noexcept
{
    std::free(memory);
}
// NOLINTEND(cppcoreguidelines-no-malloc,misc-new-delete-overloads)
#endif

std::size_t proxima::testing::allocation_count() noexcept
{
    return allocations;
}
