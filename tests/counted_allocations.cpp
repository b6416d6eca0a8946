#include "counted_allocations.h"

#include <cstddef>
#include <cstdlib>
#include <new>

namespace {

thread_local std::size_t allocations = 0;
thread_local std::size_t until_failure = 0;

} // namespace

#if defined(__has_feature)
#if __has_feature(thread_sanitizer)
#define PROXIMA_OPERATORS_ARE_TAKEN // by clang's thread sanitizer: nothing is counted beside it
#endif
#endif

#ifndef PROXIMA_OPERATORS_ARE_TAKEN
// NOLINTBEGIN(cppcoreguidelines-no-malloc,misc-new-delete-overloads): what they replace
namespace {

/// Null where it is to fail, or the system has none.
void* allocate(std::size_t size, std::size_t alignment) noexcept
{
    ++allocations;
    if (until_failure > 0 && --until_failure == 0) return nullptr;
    // A multiple of the alignment, and not 0.
    const std::size_t whole = (size / alignment + 1) * alignment;
    return alignment > alignof(std::max_align_t) ? std::aligned_alloc(alignment, whole)
                                                 : std::malloc(size > 0 ? size : 1);
}

void* allocate_or_throw(std::size_t size, std::size_t alignment)
{
    void* const memory = allocate(size, alignment);
    if (memory == nullptr) throw std::bad_alloc();
    return memory;
}

} // namespace

void* operator new(std::size_t size)
{
    return allocate_or_throw(size, 1);
}

void* operator new(std::size_t size, std::align_val_t alignment)
{
    return allocate_or_throw(size, static_cast<std::size_t>(alignment));
}

void* operator new(std::size_t size, const std::nothrow_t& /*tag*/) noexcept
{
    return allocate(size, 1);
}

void operator delete(void* memory) noexcept
{
    std::free(memory);
}

void operator delete(void* memory, std::size_t /*size*/) noexcept
{
    std::free(memory);
}

void operator delete(void* memory, std::align_val_t /*alignment*/) noexcept
{
    std::free(memory);
}

void operator delete(void* memory, std::size_t /*size*/, std::align_val_t /*alignment*/) noexcept
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

bool proxima::testing::allocations_are_counted() noexcept
{
#ifdef PROXIMA_OPERATORS_ARE_TAKEN
    return false;
#else
    return true;
#endif
}

void proxima::testing::fail_allocation(std::size_t number) noexcept
{
    until_failure = number;
}
