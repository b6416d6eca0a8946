// Counts this thread's allocations: the real-time contract of queries is that they make none.
#pragma once

#include <cstdint>

namespace proxima::testing {

/// How often this thread has called any operator new.
[[nodiscard]] std::uint64_t allocation_count() noexcept;

} // namespace proxima::testing
