// How often a test program allocates. Link counted_allocations.cpp into it, once.
#pragma once

#include <cstddef>

namespace proxima::testing {

/// Calls of operator new so far, by this thread.
[[nodiscard]] std::size_t allocation_count() noexcept;

} // namespace proxima::testing
