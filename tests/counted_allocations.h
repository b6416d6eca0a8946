// How often a test program allocates, and what happens where memory runs out. Link counted_allocations.cpp into
// it, once.
#pragma once

#include <cstddef>

namespace proxima::testing {

/// Calls of operator new so far, by this thread; none where they are not counted.
[[nodiscard]] std::size_t allocation_count() noexcept;

/// Whether they are counted: not under clang's thread sanitizer, which has operators of its own.
[[nodiscard]] bool allocations_are_counted() noexcept;

/// Lets one call of operator new by this thread fail: the next one for 1, the one after it for 2; none for 0.
void fail_allocation(std::size_t number) noexcept;

} // namespace proxima::testing
